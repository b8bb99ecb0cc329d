# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads cover their layers: no place is farther from one than half a step, as independent samples find."""

import numpy as np
import pytest

from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import solve_layers
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.printing.beads import contour_beads, plane_beads
from synch_fields.core.printing.coverage import NARROWEST, WIDEST
from synch_fields.core.printing.subdivision import subdivide

from ..layered_solids import block, group_of, shell

SPACING = 0.3


def planes(size, counts=(8, 8, 3)):
    """Layers across Z in a block, the lowest one its floor."""
    mesh = block(counts, size)
    floor = group_of(mesh, mesh.vertices[:, 2] == 0, 0.0)
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), SPACING, [floor])
    return mesh, layer_surfaces(pattern.edge_phases, pattern.heights)


def spheres():
    mesh = shell(np.linspace(1, 1.6, 4), 2)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    group = group_of(mesh, mesh.boundary_vertices, 0.0)
    pattern = solve_layers(mesh, mesh.vertices / radius[:, None], SPACING, [group])
    return mesh, layer_surfaces(pattern.edge_phases, pattern.heights)


def distances(surfaces, beads, count=3000):
    """From random places, evenly over the area, to the nearest bead of their layer, straight from the segments."""
    random = np.random.default_rng(0)
    a, b, c = np.moveaxis(surfaces.vertices[surfaces.triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(areas), count, p=areas / areas.sum())
    weights = random.dirichlet([1, 1, 1], count)
    places = np.einsum("kc,kcx->kx", weights, np.stack([a, b, c], axis=1)[chosen])
    begins, ends = beads.lines.points, beads.lines.points[beads.lines.next]
    of, found = beads.layers[beads.lines.numbers], np.full(count, np.inf)
    for k, (place, layer) in enumerate(zip(places, surfaces.layers[chosen], strict=True)):
        start, way = begins[of == layer], (ends - begins)[of == layer]
        if len(start):
            squares = np.maximum((way**2).sum(axis=1), 1e-30)
            along = np.clip(((place - start) * way).sum(axis=1) / squares, 0, 1)
            found[k] = np.linalg.norm(start + along[:, None] * way - place, axis=1).min()
    return found


def outside(surfaces, beads, count=3000):
    """(count, 3) places evenly over the area, and which are farther than 4 % of half a width outside the sides of all
    beads of their layer."""
    random = np.random.default_rng(0)
    a, b, c = np.moveaxis(surfaces.vertices[surfaces.triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(areas), count, p=areas / areas.sum())
    places = np.einsum("kc,kcx->kx", random.dirichlet([1, 1, 1], count), np.stack([a, b, c], axis=1)[chosen])
    begins, ends = beads.lines.points, beads.lines.points[beads.lines.next]
    of, found = beads.layers[beads.lines.numbers], np.ones(count, bool)
    for k, (place, layer) in enumerate(zip(places, surfaces.layers[chosen], strict=True)):
        start, way = begins[of == layer], (ends - begins)[of == layer]
        along = np.clip(((place - start) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-30), 0, 1)
        away = np.linalg.norm(start + along[:, None] * way - place, axis=1)
        found[k] = (away > 1.04 * beads.widths[of == layer] / 2).all()
    return places, found


@pytest.mark.parametrize("width", [0.04, 0.13, 0.21, 0.35, 0.47, 1.0])
def test_beads_cover_strips_of_any_width(width):
    """Of 0.2 to 5 steps; where half the width is no half step and some steps, a bead lies in the middle."""
    step = 0.2
    _, surfaces = planes((1.5, width, 0.7), (12, 6, 3))
    beads = contour_beads(surfaces, step)
    found = distances(surfaces, beads)
    # In the corners of the strip, 0.71 steps are left.
    assert np.quantile(found, 0.995) < 0.72 * step
    assert 1 - beads.covered_share == pytest.approx(outside(surfaces, beads)[1].mean(), abs=0.05)
    assert len(beads.covered) == surfaces.count and beads.covered.min() > (0.93 if width > NARROWEST * step else 0.8)
    # As wide as they are, the beads have the area of the layers, but where they are narrower than can be laid.
    area = (beads.lines.steps * (beads.widths + beads.widths[beads.lines.next]) / 2).sum()
    assert area == pytest.approx(surfaces.areas.sum(), rel=0.01 if width > NARROWEST * step else 0.15)
    assert (np.diff(beads.layers) >= 0).all()


@pytest.mark.parametrize("steps", [1.5, 2.6, 3.25, 3.7, 4.0, 5.6])
def test_no_gap_is_left_between_the_sides_of_beads(steps):
    """In the middle of 3.25 steps two contours would be a quarter of a step apart, and each half as wide as a bead."""
    step = 0.1
    _, surfaces = planes((1.5, steps * step, 0.7), (12, 6, 3))
    beads = contour_beads(surfaces, step)
    places, found = outside(surfaces, beads)
    # The ends of the strip are round.
    assert found[np.abs(places[:, 0] - 0.75) < 0.45].mean() < 0.01


def test_the_bead_of_a_narrow_strip_is_straight_and_as_wide_as_it():
    step, width = 0.2, 0.12
    _, surfaces = planes((1.5, width, 0.7), (12, 3, 3))
    beads = contour_beads(surfaces, step)
    np.testing.assert_array_equal(beads.layers, np.arange(surfaces.count))
    assert not beads.lines.closed.any()
    np.testing.assert_allclose(beads.lines.points[:, 1], width / 2, atol=0.01)
    assert (beads.lines.lengths > 1.5 - 1.5 * step).all()
    np.testing.assert_allclose(np.median(beads.widths), width, rtol=0.2)
    assert beads.widths.min() >= NARROWEST * step and beads.widths.max() <= WIDEST * step


def test_nothing_is_added_in_corners_of_squares():
    """A square of a whole number of contours: four closed ones, and no dash beside their corners."""
    step = 0.125
    _, surfaces = planes((1, 1, 0.7), (10, 10, 3))
    beads = contour_beads(surfaces, step)
    assert beads.lines.closed.all()
    np.testing.assert_allclose(beads.widths, step, rtol=0.2)
    np.testing.assert_array_equal(np.bincount(beads.layers), [4] * surfaces.count)
    assert beads.covered_share > 0.98  # corners of contours are round


def test_spheres_without_a_rim_are_covered():
    _, surfaces = spheres()
    beads = contour_beads(surfaces, 0.4)
    assert (distances(surfaces, beads) < 0.4).mean() > 0.995 and beads.covered_share > 0.97


def test_planes_say_what_they_leave():
    """Across the axis of the layers there is one height on each: no path, or one around the rim."""
    _, surfaces = planes((1, 1, 0.7))
    beads = plane_beads(surfaces, surfaces.vertices[:, 0] - 0.1, 0.2)
    assert beads.covered_share == pytest.approx(1, abs=1e-6)
    half = plane_beads(surfaces, surfaces.vertices[:, 0] - 0.1, 0.4)  # at 0.1, 0.5 and 0.9
    assert half.covered_share == pytest.approx(1, abs=1e-6)
    one = plane_beads(surfaces, surfaces.vertices[:, 0] - 0.5, 0.6)  # at 0.5 alone, 1.5 steps wide
    assert one.covered_share == pytest.approx(0.9, abs=0.05)


def test_refined_triangles_are_the_same_surface():
    _, surfaces = planes((1, 0.6, 0.4))
    mesh = surfaces.mesh
    fine, parents = subdivide(mesh, 0.05, 10**6)
    assert fine.edge_lengths.max() <= 0.05 and fine.euler_characteristic == mesh.euler_characteristic
    np.testing.assert_allclose(np.bincount(parents, fine.areas), mesh.areas, rtol=1e-9)
    np.testing.assert_array_equal(fine.vertices[: mesh.vertex_count], mesh.vertices)
    np.testing.assert_allclose(np.einsum("tx,tx->t", fine.face_normals, mesh.face_normals[parents]), 1, atol=1e-9)
    assert subdivide(mesh, 1e-6, 3000)[0].triangle_count <= 3000


def test_a_cut_triangle_has_two_to_four_parts():
    mesh = TriangleMesh([[0, 0, 0], [3, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for size, count in ((4, 1), (3.1, 2), (2.9, 3)):
        assert subdivide(mesh, size, 10)[0].triangle_count == count
