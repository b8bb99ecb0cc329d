# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror symmetry: fields and patterns that are exactly their own mirror image."""

import numpy as np
import pytest

from synch_fields.core.errors import AsymmetryError, ContradictionError
from synch_fields.core.fields import DirectionWishes, Row, direction_field, line_of_edges, stripe_pattern
from synch_fields.core.fields.constraints.lines import line_of_group
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.mirror import Mirror
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.cut import cut_open
from synch_fields.core.geometry.mirror import mirrored_vertices, symmetric_axes
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.solve import Options

from ..direction_wishes import boundary_row
from ..meshes import grid_quads, split_quads, square_points, torus_points

NO_FACES = np.empty((0, 3))


def polygons_of(quads):
    """Quads as faces, drawn by triangles along alternating diagonals."""
    starts = 4 * np.arange(len(quads))
    corners = split_quads(np.arange(4 * len(quads)).reshape(-1, 4))
    return Polygons(quads.ravel(), starts, np.full(len(quads), 4), corners, np.arange(len(quads)).repeat(2))


def quads_of(points, quads):
    polygons = polygons_of(quads)
    return TriangleMesh(points, polygons.triangles), polygons


def sheet():
    """A bent rectangle, symmetric in X and Y; its diagonals are not."""
    points = square_points(12, 10, 2.0, 1.6) - [1.0, 0.8, 0]
    points[:, 2] = 0.4 * np.cos(2 * points[:, 0]) * np.cos(3 * points[:, 1] ** 2)
    return quads_of(points, grid_quads(12, 10))


def ring():
    """A torus with a bump, symmetric in Y and Z."""
    points = torus_points(1.0, 0.4, 36, 16)
    points[:, 0] += 0.3 * np.exp(-((points[:, 0] - 1) ** 2) - points[:, 1] ** 2)
    return quads_of(points, grid_quads(36, 16, wrap_columns=True, wrap_rows=True))


def mirrors_of(mesh, polygons, axes):
    return tuple(Mirror.of(mesh, mirrored_vertices(mesh, polygons, axis), axis) for axis in axes)


# Diagonals that are not mirrored let tangent planes lean, by this many radians on our coarse sheets.
LEAN = 0.05
CASES = [
    pytest.param(build, axes, id=f"{build.__name__}-{''.join('xyz'[a] for a in axes)}")
    for build, axes in [(sheet, (0,)), (sheet, (1,)), (sheet, (0, 1)), (ring, (1,)), (ring, (2,)), (ring, (1, 2))]
]


def asymmetry(field, mesh, partner, axis):
    """(n,) difference of a field's power from that of its mirror image, in the vertices' tangent planes."""
    sign = np.ones(3)
    sign[axis] = -1
    x, y = mesh.tangent_frames
    image = field.vectors[partner] * sign
    angles = np.arctan2(np.einsum("ij,ij->i", image, y), np.einsum("ij,ij->i", image, x))
    return np.abs(np.exp(1j * field.symmetry * (angles - field.angles)) - 1)


@pytest.mark.parametrize(
    ("build", "axes", "symmetry"),
    [(*case.values, 4) for case in CASES] + [(*case.values, symmetry) for case in CASES[2::3] for symmetry in (1, 2)],
)
def test_directions_are_their_own_mirror_image(build, axes, symmetry):
    mesh, polygons = build()
    mirrors = mirrors_of(mesh, polygons, axes)
    free = direction_field(mesh, symmetry, options=Options(seed=1))
    field = direction_field(mesh, symmetry, DirectionWishes(mirrors=mirrors), Options(seed=1))
    on_both = len(axes) == 2 and symmetry == 1  # where two mirrors meet no vector is its own image in both
    crossing = on_both & np.all([m.partner == np.arange(mesh.vertex_count) for m in mirrors], axis=0)
    for mirror, axis in zip(mirrors, axes, strict=True):
        assert asymmetry(field, mesh, mirror.partner, axis)[~crossing].max() < LEAN * symmetry
    assert field.solution.lower_bound <= field.solution.energy * (1 + 1e-9)
    assert field.solution.energy >= free.solution.lower_bound


@pytest.mark.parametrize("symmetry", [1, 2])
@pytest.mark.parametrize(("build", "axes"), CASES)
def test_stripes_are_their_own_mirror_image(build, axes, symmetry):
    mesh, polygons = build()
    mirrors = mirrors_of(mesh, polygons, axes)
    if symmetry == 1 and len(axes) == 2:
        pytest.skip("no vector field is symmetric in two mirrors that meet")
    field = direction_field(mesh, symmetry, DirectionWishes(mirrors=mirrors), Options(seed=1))
    pattern = stripe_pattern(mesh, field, 0.35, mirrors=mirrors, options=Options(seed=1))
    cosines = np.cos(np.angle(pattern.solution.phases))
    for mirror in mirrors:
        np.testing.assert_allclose(cosines[mirror.partner], cosines, atol=1e-9)
    solution = pattern.solution
    assert solution.lower_bound <= solution.energy * (1 + 1e-9)
    free = pattern_problem(mesh, field, PatternWishes(0.35))
    assert free.energy(solution.phases) == pytest.approx(solution.energy, rel=1e-9)  # loops cost nothing when snapped


def test_the_bound_holds_for_every_symmetric_choice():
    """Brute force over what symmetric fields there are on two triangles beside the mirror plane."""
    points = np.array([[0, 0, 0], [0, 1, 0.0], [1, 0.4, 0.3], [-1, 0.4, 0.3]])
    mesh = TriangleMesh(points, [[0, 2, 1], [0, 1, 3]])
    mirrors = mirrors_of(mesh, Polygons.of_triangles(mesh), (0,))
    for symmetry in (1, 2, 4):
        problem = direction_problem(mesh, symmetry, DirectionWishes(mirrors=mirrors))
        field = direction_field(mesh, symmetry, DirectionWishes(mirrors=mirrors), Options(target_gap=1e-5))
        middle = np.exp(0.5j * symmetry * mirrors[0].turns)
        best = np.inf
        for first in (1, -1):
            for second in (1, -1):
                for angle in np.linspace(0, 2 * np.pi, 2001):
                    phases = np.array([first * middle[0], second * middle[1], np.exp(1j * angle), 0])
                    phases[3] = np.exp(1j * symmetry * mirrors[0].turns[2]) * np.conj(phases[2])
                    best = min(best, problem.energy(phases))
        assert field.solution.lower_bound <= best * (1 + 1e-9)
        assert field.solution.energy == pytest.approx(best, rel=1e-4, abs=1e-6)


def test_rows_on_one_side_hold_on_both():
    mesh, polygons = sheet()
    mirrors = mirrors_of(mesh, polygons, (0,))
    x, y, _ = mesh.vertices.T
    point = (np.abs(x - 0.5) < 1e-9) & (np.abs(y) < 1e-9)
    field = direction_field(mesh, 2, DirectionWishes(mirrors=mirrors))
    row = Row(line_of_group(mesh, point), "phase", 0.7)
    pattern = stripe_pattern(mesh, field, 0.35, [row], mirrors)
    cosines = np.cos(np.angle(pattern.solution.phases))
    np.testing.assert_allclose(cosines[point | point[mirrors[0].partner]], np.cos(0.7), atol=1e-9)


def test_a_slanting_row_across_the_mirror_is_refused():
    mesh, polygons = sheet()
    mirrors = mirrors_of(mesh, polygons, (0,))
    middle = np.flatnonzero((np.abs(mesh.vertices[:, 1]) < 1e-9)[mesh.edges].all(axis=1))
    row = Row(line_of_edges(mesh, middle), "angle", 0.5)
    with pytest.raises(ContradictionError, match="the mirror in X"):
        direction_field(mesh, 2, DirectionWishes(rows=(row,), mirrors=mirrors))


@pytest.mark.parametrize("kind", ["along", "across", "phase", "constant"])
def test_rows_on_both_sides_of_the_mirror(kind):
    """Wishes that are symmetric but for what tangent planes lean are averaged, not refused."""
    mesh, polygons = sheet()
    mirrors = mirrors_of(mesh, polygons, (0, 1))
    row = boundary_row(mesh, kind)
    field = direction_field(mesh, 2, DirectionWishes(rows=(row,), mirrors=mirrors))
    pattern = stripe_pattern(mesh, field, 0.35, [row] if row.is_of_phases else [], mirrors)
    cosines = np.cos(np.angle(pattern.solution.phases))
    for mirror in mirrors:
        np.testing.assert_allclose(cosines[mirror.partner], cosines, atol=1e-9)
    if kind == "phase":
        np.testing.assert_allclose(cosines[mesh.boundary_vertices], 1, atol=1e-9)


def test_vertices_that_share_a_place_are_told_apart_by_their_faces():
    mesh, polygons = sheet()
    seam = np.flatnonzero((np.abs(mesh.vertices[:, 0]) < 1e-9)[mesh.edges].all(axis=1))
    cut, source = cut_open(mesh, seam)
    partner = mirrored_vertices(cut, polygons.with_triangles(cut.triangles), 0)
    np.testing.assert_array_equal(source[partner], mirrored_vertices(mesh, polygons, 0)[source])
    assert len(np.unique(partner)) == cut.vertex_count
    doubled = source[mesh.vertex_count :]
    assert (partner[doubled] >= mesh.vertex_count).all()  # each side of the seam mirrors the other


def test_every_variation_is_symmetric():
    mesh, polygons = sheet()
    mirrors = mirrors_of(mesh, polygons, (0,))
    field = direction_field(mesh, 2, DirectionWishes(mirrors=mirrors))
    solution = stripe_pattern(mesh, field, 0.2, mirrors=mirrors).solution
    np.testing.assert_array_equal(solution.variations[0], solution.phases)
    cosines = np.cos(np.angle(solution.variations))
    np.testing.assert_allclose(cosines[:, mirrors[0].partner], cosines, atol=1e-9)


def test_asymmetric_vertices_are_named():
    mesh, polygons = sheet()
    points = mesh.vertices.copy()
    points[7, 2] += 0.05
    other = TriangleMesh(points, mesh.triangles)
    partner = mirrored_vertices(mesh, polygons, 0)
    with pytest.raises(AsymmetryError, match="not symmetric in X: vertices") as error:
        mirrored_vertices(other, polygons, 0)
    np.testing.assert_array_equal(error.value.vertices, sorted((7, partner[7])))
    with pytest.raises(AsymmetryError, match="not symmetric in Z"):
        mirrored_vertices(mesh, polygons, 2)


def test_faces_that_are_not_mirrored_are_named():
    mesh, _ = sheet()
    triangles = Polygons.of_triangles(mesh)  # whose diagonals all lean one way or alternate
    with pytest.raises(AsymmetryError):
        mirrored_vertices(mesh, triangles, 0)


def test_axes_of_points_are_those_in_which_each_has_an_image():
    points = torus_points(1.0, 0.4, 24, 12)
    assert symmetric_axes(points, NO_FACES, 1e-6) == (0, 1, 2)
    assert symmetric_axes(points + [0.1, 0, 0], NO_FACES, 1e-6) == (1, 2)
    assert symmetric_axes(np.delete(points, 17, axis=0), NO_FACES, 1e-6) == ()
    bent = points + 0.1 * points[:, :1] ** 2 * [0, 1, 0]
    assert symmetric_axes(bent, NO_FACES, 1e-6) == (0, 2) and symmetric_axes(bent, NO_FACES, 0.5) == (0, 1, 2)


def test_axes_of_a_square_whose_diagonal_has_no_mirror_image():
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    halves = square[[[0, 1, 2], [0, 2, 3]]].mean(axis=1)
    assert symmetric_axes(square, square[None].mean(axis=1), 1e-6) == (0, 1)
    assert symmetric_axes(square, halves, 1e-6) == ()
