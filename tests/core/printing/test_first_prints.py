# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What once kept parts from being printed, each by its name, without Blender."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from synch_fields.bench.solid_shapes import cup
from synch_fields.core.errors import SettingError
from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.filled import along_axis
from synch_fields.core.fields.layers import LayerPattern, SolidTargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.lengths import MOST_TETS, Lengths
from synch_fields.core.printing.machine import read_machine
from synch_fields.core.solve import Certificate, Options, Status
from synch_fields.core.tasks.layer_outputs import Layering, PathSettings
from synch_fields.core.tasks.solids import SolidGuide, SolidRequest

from ..layered_solids import block
from ..meshes import cube, icosphere
from ..tasks.test_layer_requests import closed, flattened

ALONG_Z = SolidGuide("axis:Z", partial(along_axis, np.array([0.0, 0.0, 1.0])), is_axis=True)


def request_along_z(mesh, spacing, size=None):
    """Layers in tetrahedra of a size, or of the automatic one."""
    surface = closed(mesh)
    return SolidRequest(surface, None, ALONG_Z, (), Lengths.of(surface.distance, spacing, size), None, Options())


def planned(result, step, machine):
    """The plan of beads of a result."""
    layering = Layering(result.pattern, result.surfaces, result.curves, np.eye(4))
    return layering.paths(PathSettings(step, machine=machine)).solve()


def test_a_cube_of_20_mm_is_solved_in_layers_of_a_fifth_of_a_millimetre():
    """It was refused for its 325 million tetrahedra."""
    mesh = cube(2)
    request = request_along_z(TriangleMesh(20 * mesh.vertices, mesh.triangles), 0.2)
    assert request.estimate.tets < MOST_TETS / 20 and request.lengths.divisions > 1
    result = request.solve()
    heights = result.surfaces.vertices[result.surfaces.triangles[:, 0], 2]
    assert result.surfaces.count == 100
    middles = 20 * mesh.vertices[:, 2].min() + 0.2 * (np.arange(100) + 0.5)
    assert np.abs(heights - middles[result.surfaces.layers]).max() < 1e-5


@pytest.mark.parametrize("mesh", [cube(2), icosphere(2), flattened(3, 1, 0.5)], ids=["cube", "ball", "bar"])
def test_fields_along_an_axis_are_proved_without_a_search(mesh):
    """Their energy is 0; they once took 301 iterations."""
    solution = request_along_z(mesh, 0.2, 0.1).solve().pattern.solution
    assert (solution.iterations, solution.products) == (0, 0) and solution.energy < 1e-12
    assert solution.certificate is Certificate.PROVED and solution.status is Status.CERTIFIED


def test_an_upright_cup_is_printed_whole():
    """A fifth of its volume once had no bead."""
    vertices, faces, *_ = cup()
    triangles = np.array([(face[0], *two) for face in faces for two in pairwise(face[1:])])
    mesh = TriangleMesh(20 / np.ptp(vertices, axis=0).max() * np.asarray(vertices), triangles)
    request = request_along_z(mesh, 1.2, 0.6)
    machine = replace(read_machine("marlin"), bore=0.0, largest_height=2.0)
    plan = planned(request.solve(), 1.5, machine)
    assert plan.printed_volume == pytest.approx(request.surface.distance.volume, rel=0.02)
    assert plan.covered_share > 0.99


def test_a_layer_without_height_is_refused_and_not_dragged_over_the_bed():
    """A layer that lies on the bed with nothing below it: the nozzle once moved along it at Z = 0."""
    mesh = cube(2)
    request = request_along_z(mesh, 0.45, 0.2)
    plan = planned(request.solve(), 0.3, read_machine("marlin"))
    assert plan.course.heights[np.concatenate(plan.course.runs)].min() > 0
    flat = replace(plan, down=0 * plan.down, up=0 * plan.up)
    with pytest.raises(SettingError, match=r"^no bead has a height: the layers lie on the bed"):
        _ = flat.course


def test_distances_that_are_told_hold_for_rays_from_layer_to_layer():
    """In a block with layers of which one ends along a line, for rays at random that are held against every triangle.

    Gradients of the phase once told limits that fewer rays keep: past the end of a layer they reach the next but one.
    """
    mesh = block((14, 3, 14), (1.0, 0.2, 1.0))
    x, _, z = (mesh.vertices - [0.47, 0, 0.52]).T
    one_form = SolidTargetOneForm.of(mesh, np.tile([0.0, 0, 1], (mesh.vertex_count, 1)), 0.2)
    edge_phases = one_form.edge_phases(np.exp(1j * (2 * np.pi * z / 0.2 + np.arctan2(z, x))))
    pattern = LayerPattern(mesh, None, edge_phases)
    surfaces = layer_surfaces(edge_phases, pattern.heights)
    told, by_phase = Layering(pattern, surfaces, (), np.eye(4)).spacings, pattern.spacings
    distances = ray_distances(surfaces, mesh.boundary_surface[0], 1200)
    shares = [((distances > one.thinnest) & (distances < one.thickest)).mean() for one in (told, by_phase)]
    assert told.counted * 0.98 == pytest.approx(shares[0], abs=0.01)
    assert distances.mean() == pytest.approx(told.mean, rel=0.01)
    assert shares[1] < by_phase.counted * 0.98 - 0.015


def test_distances_of_even_layers_are_told_by_the_phase():
    result = request_along_z(cube(2), 0.1, 0.2).solve()
    layering = Layering(result.pattern, result.surfaces, result.curves, np.eye(4))
    assert layering.spacings.thinnest == pytest.approx(0.1, rel=1e-9)
    assert ray_distances(result.surfaces, result.solid.boundary_surface[0], 50) == pytest.approx(0.1, rel=1e-6)


def ray_distances(surfaces, boundary, count):
    """(k,) distances from places on layers, at random, to the next layer along the normal on either side, of those that
    meet one before the boundary; what is nearer than 0.3 spacings on the same layer is not another one."""
    random, mesh = np.random.default_rng(0), surfaces.mesh
    triangles = random.choice(mesh.triangle_count, count, p=mesh.areas / mesh.areas.sum())
    weights = random.dirichlet(np.ones(3), count)
    corners = np.concatenate([mesh.vertices[mesh.triangles], boundary.vertices[boundary.triangles]])
    layers = np.append(surfaces.layers, np.full(boundary.triangle_count, -1))
    found = []
    for triangle, weight in zip(triangles, weights, strict=True):
        origin = weight @ corners[triangle]
        for side in (1, -1):
            ray = side * mesh.face_normals[triangle]
            # origin + t ray = a + u (b - a) + v (c - a), by Cramer's rule.
            ab, ac, away = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], origin - corners[:, 0]
            across, normal = np.cross(away, ray), np.cross(ab, ac)
            slope = -normal @ ray
            with np.errstate(all="ignore"):
                t = np.einsum("kx,kx->k", normal, away) / slope
                u = np.einsum("kx,kx->k", ac, across) / slope
                v = -np.einsum("kx,kx->k", ab, across) / slope
                hit = (np.minimum(u, v) >= 0) & (u + v <= 1) & (t > 1e-9)
            hit &= (layers != surfaces.layers[triangle]) | (t > 0.06)
            if hit.any():
                first = np.flatnonzero(hit)[t[hit].argmin()]
                if layers[first] >= 0:
                    found.append(t[first])
    return np.array(found)
