# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of vortex rings as files and curves, for tests in Blender."""

import bpy
import numpy as np

from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.geometry.grid import Grid
from synch_fields.synch_addon.blender import openvdb
from synch_fields.synch_addon.flows.sources import STRENGTH

# So coarse that a solve takes a second, and fine enough for half a cell to tell.
SHAPE, SPACING, RADIUS = (18, 18, 14), 0.1, 0.5
QUICK = {"quantum": 1.0, "target_gap": 0.05}


def ring_flow(height=0.0, circulation=2.0):
    """A grid and the velocity of a ring around the z axis at a height."""
    grid = Grid(SHAPE, SPACING, -0.5 * SPACING * (np.array(SHAPE) - 1))
    turn = np.linspace(0, 2 * np.pi, 121)
    ring = np.column_stack([RADIUS * np.cos(turn), RADIUS * np.sin(turn), height + 0 * turn])
    return grid, filament_velocity(grid.places, [(ring, circulation)], 0.11).reshape(*SHAPE, 3)


def write_npz(path, height=0.0, circulation=2.0):
    """A .npz file with such a flow; returns its path."""
    grid, velocity = ring_flow(height, circulation)
    np.savez(path, velocity=velocity, spacing=SPACING, origin=grid.origin)
    return path


def write_vdb(path, height=0.0, first=0, last=None, name="velocity", before=()):
    """A .vdb file with such a flow, or the slices ``first`` to ``last`` along x of it, behind grids of other vectors;
    returns its path."""
    grid, velocity = ring_flow(height)
    velocity = velocity[first:last]
    vdb = openvdb.openvdb_module()
    volume, *others = [vdb.Vec3SGrid() for _ in (name, *before)]
    volume.name = name
    for other, called in zip(others, before, strict=True):
        other.name = called
        other.fill((0, 0, 0), (20, 3, 3), (0.5, 0.2, 0.1))
    volume.copyFromArray(velocity.astype(np.float32))
    origin = grid.origin + [first * SPACING, 0, 0]
    rows = [[SPACING, 0, 0, 0], [0, SPACING, 0, 0], [0, 0, SPACING, 0], [*origin, 1]]
    volume.transform = vdb.createLinearTransform(rows)
    vdb.write(str(path), grids=[*others, volume])
    return path


def points_of(obj):
    """(p, 3) points of all splines."""
    places = [np.array([point.co[:3] for point in spline.points]) for spline in obj.data.splines]
    return np.concatenate(places) if places else np.empty((0, 3))


def circle(radius=1.0, location=(0, 0, 0), strength=1.0, segments=100):
    """A curve object, a circle about its local z axis, counterclockwise."""
    data = bpy.data.curves.new("Circle", "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    spline.points.add(segments - 1)
    turn = np.arange(segments) * 2 * np.pi / segments
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn, np.ones(segments)])
    spline.points.foreach_set("co", points.ravel())
    spline.use_cyclic_u = True
    obj = bpy.data.objects.new("Circle", data)
    obj.location = location
    obj[STRENGTH] = strength
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj
