# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of objects: what they keep of an object's edges, their mirror images, and several pieces."""

import bpy  # isort: skip, bmesh is a part of it
from dataclasses import replace
from itertools import pairwise

import bmesh
import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import SettingError
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.reading.surface import gather

from ..quad_meshes import edited, made_from
from ..scenes import add_curve, set_numbers, sphere


def object_of(build):
    mesh = bpy.data.meshes.new("Shape")
    shape = bmesh.new()
    build(shape)
    shape.to_mesh(mesh)
    shape.free()
    obj = bpy.data.objects.new("Shape", mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def block(shape, cuts=14):
    bmesh.ops.create_cube(shape, size=2)
    bmesh.ops.subdivide_edges(shape, edges=shape.edges[:], cuts=cuts, use_grid_fill=True)


def bevelled(shape):
    bmesh.ops.create_cube(shape, size=2)
    bmesh.ops.bevel(shape, geom=shape.edges[:], offset=0.35, segments=1, profile=0.5, affect="EDGES")
    for _ in range(3):
        bmesh.ops.subdivide_edges(shape, edges=shape.edges[:], cuts=1, use_grid_fill=True)


def tori(shape):
    for k in range(2):
        ring = bpy.data.meshes.new("Ring")
        u, v = np.meshgrid(np.arange(36) * np.pi / 18, np.arange(18) * np.pi / 9, indexing="ij")
        reach = 1 + 0.4 * np.cos(v)
        points = np.stack([reach * np.cos(u), reach * np.sin(u), 0.4 * np.sin(v) + 3 * k], axis=-1).reshape(-1, 3)
        i, j = (a.ravel() for a in np.mgrid[:36, :18])
        faces = np.stack([i * 18 + j, (i + 1) % 36 * 18 + j, (i + 1) % 36 * 18 + (j + 1) % 18, i * 18 + (j + 1) % 18])
        ring.from_pydata(points.tolist(), [], faces.T.tolist())
        shape.from_mesh(ring)


def places(obj):
    return np.array([v.co[:] for v in obj.data.vertices])


def corners_found(made):
    """Vertices of the unit block's corners among those of a quad mesh."""
    corners = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    return (cKDTree(places(made)).query(corners)[0] < 1e-5).sum()


def assert_own_image(made, axis, tolerance=1e-5):
    points = places(made)
    image = points.copy()
    image[:, axis] *= -1
    apart, partner = cKDTree(points).query(image)
    assert apart.max() < tolerance * np.ptp(points, axis=0).max()
    assert len(np.unique(partner)) == len(points)
    faces = {frozenset(p.vertices) for p in made.data.polygons}
    assert {frozenset(partner[list(face)].tolist()) for face in faces} == faces


def test_a_block_keeps_its_edges_unless_they_are_let_go():
    obj = object_of(block)
    obj.rotation_euler = (0.3, 0.2, 0.1)
    made, report = made_from(obj, spacing=0.4)
    assert corners_found(made) == 8 and report["quad_mesh"]["quad_share"] == 1
    assert report["quad_mesh"]["worst_angle"] < 5
    free, _ = made_from(object_of(block), spacing=0.37, features=0)
    assert corners_found(free) == 0
    blunt, _ = made_from(object_of(block), spacing=0.37, features=np.radians(120))
    assert corners_found(blunt) == 0


@pytest.mark.parametrize("spacing", [0.05, 5.0, 90.0])
def test_features_are_those_of_the_spacing_that_a_number_of_faces_leads_to(spacing):
    """Whatever spacing stands beside the number: one that would be too large for the features, or for the object."""
    made, report = made_from(object_of(block), spacing=spacing, faces=600)
    assert corners_found(made) == 8 and len(made.data.polygons) == pytest.approx(600, rel=0.05)
    assert report["warnings"] == []


def test_features_are_long_enough_for_the_spacing_beside_them():
    """A fine part of a map of spacings makes no features of what is too short for the quads elsewhere."""
    obj = object_of(block)
    set_numbers(obj, "map", np.where(places(obj)[:, 0] < -0.5, 1.0, 12.0))
    plain = SurfaceSettings(symmetry="cross", constraints=(), spacing=0.4)
    for spacing_map, edges in (("", 12), ("map", 8)):
        (row,) = gather("quad_mesh", obj, replace(plain, spacing_map=spacing_map)).rows
        assert len(row.line.links) == edges * 15


def test_marked_edges_are_features():
    obj = object_of(block)
    for edge in obj.data.edges:
        a, b = (obj.data.vertices[v].co for v in edge.vertices)
        edge.use_edge_sharp = (
            sum(abs(abs(x) - 1) < 1e-6 and abs(abs(y) - 1) < 1e-6 for x, y in zip(a, b, strict=True)) > 1
        )
    made, _ = made_from(obj, spacing=0.37, features=np.radians(120))
    assert corners_found(made) == 8


def test_a_stroke_is_an_edge_loop_around_a_ball():
    """Of a circle that no edges of the mesh follow: its whole length, and each vertex on it has two edges along it."""
    ball = sphere(5)
    turns = np.linspace(0, 2 * np.pi, 90)
    ring = np.column_stack([0.9 * np.cos(turns), 0.9 * np.sin(turns), np.full(90, np.sqrt(1 - 0.9**2))])
    row = {"where": "curve", "what": "phase", "name": add_curve(ring).name}
    made, report = made_from(ball, faces=400, constraints=[row])
    assert report["warnings"] == [] and report["quad_mesh"]["quad_share"] == 1
    side = report["quad_mesh"]["edge_length"]
    line = np.concatenate([a + (b - a) * np.linspace(0, 1, 20)[:, None] for a, b in pairwise(ring)])
    away = cKDTree(line).query(places(made))[0] < 0.1 * side
    edges = np.array([edge.vertices[:] for edge in made.data.edges])
    along = edges[away[edges].all(axis=1)]
    assert (np.bincount(along.ravel())[np.flatnonzero(away)] == 2).all()
    length = np.linalg.norm(np.diff(places(made)[along], axis=1), axis=2).sum()
    assert length == pytest.approx(2 * np.pi * 0.9, rel=0.02)


def test_painted_density_keeps_the_number_of_faces():
    """Quads are smaller where a map is painted: not quite half as long, since no line branches where the map ends."""
    obj = object_of(block)
    group = obj.vertex_groups.new(name="dense")
    group.add([n for n, place in enumerate(places(obj)) if place[0] > 0], 1.0, "REPLACE")
    made, report = made_from(obj, faces=540, spacing_map="dense", spacing_range=0.5)
    assert len(made.data.polygons) == pytest.approx(540, rel=0.05) and report["warnings"] == []
    areas, at = (np.array([getattr(face, key) for face in made.data.polygons]) for key in ("area", "center"))
    sides = [np.sqrt(np.median(areas[chosen])) for chosen in (at[:, 0] > 0.3, at[:, 0] < -0.3)]
    assert 0.45 < sides[0] / sides[1] < 0.75


@pytest.mark.any_surface  # the plane crosses faces of the block
@pytest.mark.parametrize(("build", "axes"), [(block, "X"), (bevelled, "X"), (bevelled, "XYZ")])
def test_a_mirrored_mesh_is_its_own_image_face_by_face(build, axes):
    made, report = made_from(object_of(build), spacing=0.45, mirror=axes)
    for axis in axes:
        assert_own_image(made, "XYZ".index(axis))
    assert report["quad_mesh"]["euler_characteristic"] == 2 and report["quad_mesh"]["quad_share"] == 1


@pytest.mark.any_surface
@pytest.mark.parametrize("after", [None, "ARRAY"])
def test_what_a_modifier_mirrors_is_mirrored_unless_another_one_spoils_it(after):
    obj = object_of(bevelled)
    with edited(obj) as mesh:
        left = [face for face in mesh.faces if face.calc_center_median().x < 0]
        bmesh.ops.delete(mesh, geom=left, context="FACES")
    obj.modifiers.new("Mirror", "MIRROR")
    if after is not None:
        obj.modifiers.new("After", after).use_relative_offset = True
    made, report = made_from(obj, faces=300, surface="seen")
    assert report["settings"]["mirror"] == ("X" if after is None else "")
    if after is None:
        assert_own_image(made, 0)


@pytest.mark.parametrize("smoothing", [0, 10])
def test_rings_are_mirrored_where_the_plane_crosses_them_and_where_it_runs_along(smoothing):
    obj = object_of(tori)
    made, report = made_from(obj, spacing=0.45, mirror="XY", smoothing=smoothing)
    for axis in (0, 1):
        assert_own_image(made, axis)
    assert report["quad_mesh"]["closed"] and report["quad_mesh"]["euler_characteristic"] == 0


def test_every_piece_becomes_quads():
    def pieces(shape):
        block(shape)
        bmesh.ops.translate(shape, verts=shape.verts[:], vec=(0, 0, -4))
        tori(shape)

    made, report = made_from(object_of(pieces), spacing=0.4)
    figures = report["quad_mesh"]
    assert figures["quad_share"] == 1 and figures["closed"] and figures["euler_characteristic"] == 2
    heights = places(made)[:, 2]
    assert all(((heights > low) & (heights < low + 2.1)).any() for low in (-5.05, -1, 2))


def test_an_angle_of_features_that_is_none_is_refused():
    obj = object_of(block)
    for wrong in (-0.1, 4.0, "sharp"):
        with pytest.raises(SettingError, match=r"the (angle of )?features is"):
            api.quad_mesh(obj, features=wrong)
