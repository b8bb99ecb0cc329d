# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions that follow the boundary or the curvature, against closed forms on annulus, cylinder and torus."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import DirectionWishes, boundary_line, direction_field
from synch_fields.core.fields.constraints.rows import direction_targets
from synch_fields.core.fields.guidance import curvature
from synch_fields.core.fields.guidance.curvature import principal_directions
from synch_fields.core.geometry import TriangleMesh

from ..direction_wishes import along_curvature, boundary_row, on_boundary
from ..meshes import annulus, cylinder, disk, icosphere, square, torus


def agreement(vectors, expected):
    """|cosine| between vectors and expected unit directions."""
    return np.abs(np.einsum("ij,ij->i", vectors, expected))


def radial(mesh):
    flat = mesh.vertices * [1, 1, 0]
    return flat / np.linalg.norm(flat, axis=1)[:, None]


def circumferential(mesh):
    return np.cross([0, 0, 1], radial(mesh))


@pytest.mark.parametrize(("boundary", "expected"), [("along", circumferential), ("across", radial)])
def test_lines_follow_both_rims_of_an_annulus(boundary, expected):
    mesh = annulus(1.0, 2.0, rings=8, segments=64)
    field = direction_field(mesh, 2, on_boundary(mesh, boundary))
    rim = mesh.boundary_vertices
    np.testing.assert_allclose(agreement(field.vectors, expected(mesh))[rim], 1, atol=1e-9)
    assert agreement(field.vectors, expected(mesh)).min() > 0.999
    # The squared direction turns twice around: energy of the integral of (2 / r)^2 over the annulus.
    assert field.solution.energy == pytest.approx(4 * 2 * np.pi * np.log(2), rel=0.02)
    assert field.disclinations == []


def test_vectors_along_the_boundary_have_the_surface_on_their_left():
    mesh = annulus(1.0, 2.0, rings=6, segments=40)
    field = direction_field(mesh, 1, on_boundary(mesh))
    radius = np.linalg.norm(mesh.vertices, axis=1)
    along = np.einsum("ij,ij->i", field.vectors, circumferential(mesh))
    np.testing.assert_allclose(along[radius > 1.99], 1, atol=1e-9)
    np.testing.assert_allclose(along[radius < 1.01], -1, atol=1e-9)


def test_vectors_across_the_boundary_point_into_the_surface():
    mesh = disk(6, 32)
    field = direction_field(mesh, 1, on_boundary(mesh, "across"))
    inwards = -np.einsum("ij,ij->i", field.vectors, mesh.vertices)[mesh.boundary_vertices]
    np.testing.assert_allclose(inwards, 1, atol=1e-9)
    assert sum(d.index for d in field.disclinations) == 1


def test_corners_too_sharp_for_a_symmetry_are_left_free():
    mesh = square(5)
    fixed, *_ = direction_targets(mesh, 2, [boundary_row(mesh)])
    nodes, values = fixed.nodes, fixed.values
    corners = np.flatnonzero((np.abs(mesh.vertices[:, :2] - 0.5) > 0.49).all(axis=1))
    assert len(corners) == 4 and not np.isin(corners, nodes).any()
    assert len(nodes) == mesh.boundary_vertices.sum() - 4
    assert np.isin(corners, direction_targets(mesh, 4, [boundary_row(mesh)])[0].nodes).all()
    np.testing.assert_allclose(np.abs(values), 1)


def test_a_single_triangle_has_no_usable_boundary_and_still_solves():
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]], [[0, 1, 2]])
    for symmetry in (1, 2, 4):
        field = direction_field(mesh, symmetry, on_boundary(mesh))
        assert np.isfinite(field.angles).all()


def test_only_chosen_boundary_vertices_count():
    mesh = annulus(1.0, 2.0, rings=5, segments=40)
    outer = np.linalg.norm(mesh.vertices, axis=1) > 1.99
    assert len(boundary_line(mesh, outer).links) == 40
    field = direction_field(mesh, 1, on_boundary(mesh, "along", outer))
    along = np.einsum("ij,ij->i", field.vectors, circumferential(mesh))
    np.testing.assert_allclose(along[outer], 1, atol=1e-9)
    # The inner rim is free: nothing turns the field round there.
    assert along.min() > 0.9


def test_a_boundary_that_is_not_there_is_refused():
    with pytest.raises(SettingError, match="no boundary: set the boundary to free"):
        on_boundary(icosphere(1))
    nowhere = np.zeros(square(3).vertex_count, bool)
    with pytest.raises(SettingError, match="vertex group holds no boundary edge"):
        on_boundary(square(3), "across", nowhere)


@pytest.mark.parametrize("symmetry", [2, 4])
@pytest.mark.parametrize("split", ["AC", "BD", "alternate"])
def test_curvature_of_a_cylinder_runs_around_it(symmetry, split):
    mesh = cylinder(radius=1.0, height=2.0, segments=32, rows=10, split=split)
    largest = direction_field(mesh, symmetry, along_curvature(mesh))
    smallest = direction_field(mesh, symmetry, along_curvature(mesh, largest=False))
    upright = np.tile([0.0, 0, 1], (mesh.vertex_count, 1))
    if symmetry == 2:
        assert agreement(largest.vectors, circumferential(mesh)).min() > 0.99
        assert agreement(smallest.vectors, upright).min() > 0.99
    else:
        for field in (largest, smallest):
            cosine = agreement(field.vectors, upright)
            assert (np.minimum(cosine, np.sqrt(1 - np.minimum(cosine, 1) ** 2)) < 0.15).all()


@pytest.mark.parametrize("radius", [0.5, 2.0])
def test_the_weight_is_mass_times_curvature_squared(radius):
    mesh = cylinder(radius=radius, height=4 * radius, segments=48, rows=24)
    _, weights = principal_directions(mesh, 2)
    inside = ~mesh.boundary_vertices
    np.testing.assert_allclose(weights[inside].sum(), mesh.vertex_masses[inside].sum() / radius**2, rtol=0.1)


@pytest.mark.parametrize(("detail", "steps"), [(0.2, 200), (0.5, 200), (0.5, 1)])
def test_details_of_curvature_fade_as_diffusion_says(detail, steps, monkeypatch):
    """Of a tube of radius 1 with ripples cos(k z) in its radius, whose curvature -k^2 cos(k z) is in the axis.

    Where conjugate gradients need more steps than are allowed for, the diffusion is factorized.
    """
    monkeypatch.setattr(curvature, "_STEPS", steps)
    height, size, number = 4.0, 0.002, 2 * np.pi / 0.8
    tube = cylinder(radius=1.0, height=height, segments=96, rows=80)
    heights = tube.vertices[:, 2]
    rippled = tube.vertices * np.column_stack([1 + size * np.cos(number * heights)] * 2 + [np.ones(len(heights))])
    mesh = TriangleMesh(rippled, tube.triangles)
    inside = np.abs(heights - heights.mean()) < height / 2 - 2 * detail - 0.1
    found = [np.sqrt(principal_directions(mesh, 2, detail=length)[1] / mesh.vertex_masses) for length in (0.0, detail)]
    shapes = np.column_stack([np.ones(inside.sum()), np.cos(number * heights[inside])])
    (mean, wave), (smooth_mean, smooth_wave) = (np.linalg.lstsq(shapes, part[inside], rcond=None)[0] for part in found)
    assert smooth_wave / wave == pytest.approx(1 / (1 + (detail * number) ** 2), rel=0.1)
    assert (mean, smooth_mean) == pytest.approx((1, 1), rel=0.02)


def test_curvature_of_a_torus():
    mesh = torus(large=1.0, small=0.35, around=48, across=24)
    centre = radial(mesh) * 1.0
    outwards = (mesh.vertices - centre) / 0.35
    meridian = np.cross(circumferential(mesh), outwards)
    largest = direction_field(mesh, 2, along_curvature(mesh))
    smallest = direction_field(mesh, 2, along_curvature(mesh, largest=False))
    assert agreement(largest.vectors, meridian).min() > 0.99
    assert agreement(smallest.vectors, circumferential(mesh)).min() > 0.99


def test_hollows_have_their_smallest_curvature_across():
    """A tube seen from inside: the surface bends towards its normal, so that the axis is largest."""
    tube = cylinder(segments=32, rows=10)
    inside_out = TriangleMesh(tube.vertices, tube.triangles[:, ::-1])
    field = direction_field(inside_out, 2, along_curvature(inside_out))
    assert agreement(field.vectors, np.tile([0.0, 0, 1], (tube.vertex_count, 1))).min() > 0.99


def test_flat_parts_ask_for_nothing():
    mesh = square(6)
    turn = np.linalg.qr(np.random.default_rng(2).standard_normal((3, 3)))[0]
    tilted = TriangleMesh(mesh.vertices @ turn.T + [3, 1, 2], mesh.triangles)
    assert not principal_directions(tilted, 2)[1].any()
    assert direction_field(tilted, 2, along_curvature(tilted)).solution.energy < 1e-12


def test_guidance_and_boundary_together_keep_the_boundary():
    mesh = cylinder(height=12.0, segments=24, rows=32)
    guides = along_curvature(mesh, largest=False).guides
    wishes = DirectionWishes(guides, rows=(boundary_row(mesh),))
    field = direction_field(mesh, 2, wishes)
    # As exactly as the normals of a polygonal tube allow vectors in space to be.
    np.testing.assert_allclose(agreement(field.vectors, circumferential(mesh))[mesh.boundary_vertices], 1, atol=1e-4)
    # Turning away from both rims pays on a tube longer than four radii.
    middle = np.abs(mesh.vertices[:, 2] - 6) < 2
    assert np.abs(field.vectors[middle, 2]).min() > 0.9
