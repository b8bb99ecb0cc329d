# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Line ends that are moved and added: where they lie afterwards, and that nothing else changes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import direction_field, quad_pattern, stripe_pattern
from synch_fields.core.fields.directions import DirectionWishes
from synch_fields.core.fields.local_defects import LENGTH, REACH, add_stripe, move_line_ends
from synch_fields.core.fields.mirror import Mirror
from synch_fields.core.fields.placement import with_line_ends
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.mirror import mirrored_vertices
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.problem import SynchronizationProblem

from ..direction_wishes import boundary_row
from ..meshes import annulus, bumpy_torus, icosphere, together

SPACING, SMALL = 0.5, 0.2
KINDS = {"vector": (1, stripe_pattern), "line": (2, stripe_pattern), "cross": (4, quad_pattern)}


def solved(kind, mesh=None, rows=()):
    mesh = bumpy_torus(24) if mesh is None else mesh
    symmetry, solve = KINDS[kind]
    return solve(mesh, direction_field(mesh, symmetry), SPACING, rows)


def sizes(pattern):
    """{triangle: sizes of the dislocations there}: their signs and phases belong to a sheet."""
    found = {}
    for defect in pattern.dislocations:
        found.setdefault(defect.triangle, []).append(abs(defect.index))
    return {triangle: sorted(own) for triangle, own in found.items()}


def centres(mesh):
    return mesh.vertices[mesh.triangles].mean(axis=1)


def free_triangles(pattern):
    """Triangles without any defect."""
    torn = pattern.edge_phases.around(pattern.mesh.triangles)[1] != 0
    return np.setdiff1d(np.flatnonzero(~torn), list(sizes(pattern)))


def are_near(mesh, triangles, others):
    """Whether each triangle is one of the others or shares a corner with one: weak line ends may slip by a face."""
    return np.isin(mesh.triangles[list(triangles)], mesh.triangles[list(others)]).any(axis=1).all()


@pytest.mark.parametrize("kind", ["line", "cross"])
def test_a_line_end_goes_where_it_is_moved_and_all_others_stay(kind):
    pattern = solved(kind)
    pattern = add_stripe(pattern, int(free_triangles(pattern)[700]))
    before, places, mesh = sizes(pattern), centres(pattern.mesh), pattern.mesh
    assert len(before) > 1
    for start in list(before)[:4]:
        near = free_triangles(pattern)
        apart = np.linalg.norm(places[near] - places[start], axis=1)
        end = int(near[np.abs(apart - 1.5 * SPACING).argmin()])
        found = move_line_ends(pattern, start, end)
        after, others = sizes(found), before.keys() - {start}
        assert after.pop(end) == before[start] and len(after) == len(others)
        assert are_near(mesh, after, others) and are_near(mesh, others, after)
        changed = np.flatnonzero((found.phases != pattern.phases).reshape(mesh.vertex_count, -1).any(axis=1))
        reach = 1.5 * SPACING + REACH * 2 * np.pi / pattern.one_form.rates.min()
        assert np.linalg.norm(mesh.vertices[changed] - places[start], axis=1).max() < 1.2 * reach
        assert found.energy >= pattern.solution.lower_bound
        back = move_line_ends(found, end, start)
        assert start in sizes(back) and back.energy < 1.05 * pattern.energy


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_stripe_has_two_ends(kind):
    pattern = solved(kind)
    before, places, mesh = sizes(pattern), centres(pattern.mesh), pattern.mesh
    for triangle in np.random.default_rng(1).choice(free_triangles(pattern), 4, replace=False).tolist():
        after = sizes(add_stripe(pattern, triangle))
        assert after[triangle] == [1]
        others = [end for end in after if end not in before and np.linalg.norm(places[end] - places[triangle]) > 1e-9]
        # The other end of the stripe; where an end was near it, these may have met.
        far = [end for end in others if not before or not are_near(mesh, [end], before)]
        assert len(far) <= 1 and len(after) <= len(before) + 2
        assert all(np.linalg.norm(places[end] - places[triangle]) < 2 * LENGTH * SPACING for end in far)


def test_a_line_end_that_is_there_is_one():
    pattern = add_stripe(solved("line"), 100)
    vertex = pattern.mesh.triangles[pattern.dislocations[0].triangle, 0]
    assert with_line_ends(pattern, [vertex]) is pattern


def test_a_vertex_has_its_line_end_beside_others():
    pattern = solved("cross")
    vertices = [40, 300, 700]
    found = with_line_ends(pattern, vertices)
    torn = found.edge_phases.around(found.mesh.triangles)[1] != 0
    defective = np.union1d(np.flatnonzero(torn), list(sizes(found))).astype(int)
    assert np.isin(vertices, found.mesh.triangles[defective]).all()


def test_fixed_phases_stay():
    mesh = annulus(0.5, 2.0, rings=20, segments=120)
    pattern = solved("line", mesh, [boundary_row(mesh, "phase")])
    rim = np.flatnonzero(mesh.boundary_vertices)
    triangle = int(np.abs(np.linalg.norm(centres(mesh), axis=1) - 1.6).argmin())
    found = add_stripe(pattern, triangle)
    np.testing.assert_array_equal(found.phases[rim], pattern.phases[rim])
    assert sizes(found)[triangle] == [1] and (found.phases != pattern.phases).any()
    on_rim = int(np.flatnonzero(np.isin(mesh.triangles, rim).sum(axis=1) == 2)[0])
    with pytest.raises(SettingError, match="fixed by a constraint"):
        add_stripe(pattern, on_rim)


@pytest.mark.parametrize("kind", ["line", "cross"])
def test_mirrored_line_ends_move_and_begin_on_both_sides(kind):
    mesh, (symmetry, solve) = icosphere(4), KINDS[kind]
    partner = mirrored_vertices(mesh, Polygons.of_triangles(mesh), 0)
    mirrors = [Mirror.of(mesh, partner, 0)]
    field = direction_field(mesh, symmetry, DirectionWishes(mirrors=mirrors))
    pattern = solve(mesh, field, SMALL, mirrors=mirrors)
    places = centres(mesh)
    image = cKDTree(places).query(places * [-1, 1, 1])[1]
    near = free_triangles(pattern)
    place = np.array([0.7, 0.5, 0.5])
    wanted = place, place + [0, SMALL, 0]
    start, end = (int(near[np.linalg.norm(places[near] - at, axis=1).argmin()]) for at in wanted)
    added = add_stripe(pattern, start)
    # As good as one stripe after the other in the same pattern without the mirror.
    free = replace(pattern, problem=SynchronizationProblem(pattern.problem.connection, pattern.problem.mass))
    assert added.energy < 1.3 * add_stripe(add_stripe(free, start), int(image[start])).energy
    moved = move_line_ends(added, start, end)
    far = np.min([np.linalg.norm(mesh.vertices * [side, 1, 1] - place, axis=1) for side in (1, -1)], axis=0)
    for found in (added, moved, with_line_ends(pattern, [mesh.triangles[start, 0]])):
        defects = {triangle for triangle in sizes(found) if abs(places[triangle, 0]) > 0.1}  # one is its own image
        assert {int(image[triangle]) for triangle in defects} == defects
        same = (found.phases == pattern.phases).reshape(mesh.vertex_count, -1).all(axis=1)
        assert same[far > 1.5 * REACH * SMALL + SMALL].all() and not same.all()
        seen = np.cos(np.angle(found.phases.reshape(mesh.vertex_count, -1))).prod(axis=1)
        np.testing.assert_allclose(seen[partner], seen, atol=1e-9)
    assert start in sizes(added) and end in sizes(moved)
    on_plane = int(np.abs(places[:, 0]).argmin())
    with pytest.raises(SettingError, match="mirror plane"):
        move_line_ends(added, start, on_plane)


def test_what_cannot_be_is_refused():
    mesh = together(icosphere(3), TriangleMesh(icosphere(3).vertices + [4, 0, 0], icosphere(3).triangles))
    pattern = solved("line", mesh)
    torn = pattern.edge_phases.around(mesh.triangles)[1] != 0
    start, half = next(iter(sizes(pattern))), mesh.triangle_count // 2
    with pytest.raises(SettingError, match="swirl point"):
        move_line_ends(pattern, start, int(np.flatnonzero(torn)[0]))
    free = free_triangles(pattern)
    other = free[free >= half] if start < half else free[free < half]
    with pytest.raises(SettingError, match="of the same part"):
        move_line_ends(pattern, start, int(other[0]))
    with pytest.raises(SettingError, match="not there any more"):
        move_line_ends(pattern, int(free[0]), start)
    assert move_line_ends(pattern, start, start) is pattern
