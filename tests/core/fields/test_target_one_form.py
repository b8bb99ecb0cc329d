# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a cross field and a spacing ask of two phases at every vertex."""

from cmath import exp, phase

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import direction_field, given_directions
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh

from ..flat_crosses import plane_crosses, plane_waves, random_turns, turned_crosses, turned_phases
from ..meshes import annulus, bent_square, double_torus, icosphere, square, together, torus

A = np.array([[0, 1], [-1, 0]])  # of Eq. (7), conjugation being the sign of a phase
SURFACES = [
    pytest.param(lambda: icosphere(2), id="icosphere"),
    pytest.param(torus, id="torus"),
    pytest.param(double_torus, id="double-torus"),
    pytest.param(bent_square, id="bent-square"),
]


@pytest.mark.parametrize("degrees", [0, 33])
def test_asked_changes_are_those_of_two_plane_waves(degrees):
    mesh = square(6)
    field, angles = plane_crosses(mesh, degrees)
    growth = TargetOneForm.of(mesh, field, 0.3)
    assert growth.phase_count == 2 and len(np.unique(growth.matchings)) == 4
    i, j = mesh.edges.T
    # For the phases of the lower vertex: its own waves, seen from both ends.
    expected = plane_waves(angles[i], 0.3, mesh.vertices[j]) - plane_waves(angles[i], 0.3, mesh.vertices[i])
    np.testing.assert_allclose(growth.changes, expected, atol=1e-9)
    phases = np.exp(1j * (plane_waves(angles, 0.3, mesh.vertices - [0.2, 0.7, 0])))
    assert growth.connection.energy(phases.ravel()) < 1e-12
    assert growth.connection.energy(phases[:, ::-1].ravel()) > 1


@pytest.mark.parametrize("build", SURFACES)
def test_the_energy_is_that_of_matched_phases_edge_by_edge(build):
    """Node 2 v + l is phase l of vertex v: both phases of every edge count with its weight."""
    mesh = build()
    field = turned_crosses(direction_field(mesh, 4), random_turns(mesh))
    growth = TargetOneForm.of(mesh, field, np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 5)
    arguments = np.random.default_rng(0).uniform(-np.pi, np.pi, (mesh.vertex_count, 2))
    total = 0.0
    edges = zip(mesh.edges, mesh.weights, growth.changes, growth.matchings, strict=True)
    for (i, j), weight, change, matching in edges:
        # Direction m of i is direction 0 of j: the phases of j are A^m of what those of i have become.
        misses = arguments[j] - np.linalg.matrix_power(A, matching) @ (arguments[i] + change)
        total += weight * sum(abs(exp(1j * miss) - 1) ** 2 for miss in misses)
    assert growth.connection.energy(np.exp(1j * arguments).ravel()) == pytest.approx(total, rel=1e-10)
    assert len(growth.masses) == 2 * mesh.vertex_count
    assert growth.masses.sum() == pytest.approx(2 * mesh.areas.sum(), rel=1e-6)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("build", SURFACES)
def test_other_representatives_ask_the_same_of_turned_phases(build, seed):
    mesh = build()
    field, turns = direction_field(mesh, 4), random_turns(mesh, seed)
    spacing = np.random.default_rng(1).uniform(0.1, 1, mesh.vertex_count)
    first, second = (
        TargetOneForm.of(mesh, field, spacing),
        TargetOneForm.of(mesh, turned_crosses(field, turns), spacing),
    )
    phases = np.exp(1j * np.random.default_rng(seed).uniform(-np.pi, np.pi, (mesh.vertex_count, 2)))
    energies = [first.connection.energy(phases.ravel()), second.connection.energy(turned_phases(phases, turns).ravel())]
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)
    assert second.coarse_share == first.coarse_share
    assert second.forced_dislocations == pytest.approx(first.forced_dislocations, rel=1e-9)


# Two spacings


def growth_axes(growth, angles):
    """(n, 2) spacing of each vertex's phases, and the (n, 2, 2) directions in the plane in which they grow."""
    growing = angles[:, None] + np.pi / 2 * np.array([1, 2])
    return 2 * np.pi / growth.rates, np.stack([np.cos(growing), np.sin(growing)], axis=-1)


@pytest.mark.parametrize("degrees", [0, 30, 60, -20, 130])
def test_the_first_of_two_spacings_lies_along_the_axis_nearer_to_x(degrees):
    mesh = square(5)
    field, angles = plane_crosses(mesh, degrees)
    spacings, axes = growth_axes(TargetOneForm.of(mesh, field, np.array([[0.2, 0.5]])), angles)
    np.testing.assert_allclose(spacings, np.where(np.abs(axes[:, :, 0]) > np.sqrt(0.5), 0.2, 0.5), rtol=1e-12)


def test_at_45_degrees_either_axis_is_the_first_but_everywhere_the_same():
    mesh = square(5)
    field, angles = plane_crosses(mesh, 45)
    spacings, axes = growth_axes(TargetOneForm.of(mesh, field, np.array([[0.2, 0.5]])), angles)
    rising = axes.prod(axis=2) > 0
    assert len(np.unique(spacings[rising].round(12))) == len(np.unique(spacings[~rising].round(12))) == 1
    assert spacings[rising][0] != pytest.approx(spacings[~rising][0])


@pytest.mark.parametrize("seed", range(4))
def test_y_decides_where_x_is_out_of_reach(seed):
    flat = square(5)
    upright = TriangleMesh(flat.vertices[:, [2, 0, 1]], flat.triangles)  # the plane of Y and Z
    turns = (random_turns(upright) + seed) % 4
    vectors = np.array([[0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, -1.0]])
    growth = TargetOneForm.of(upright, given_directions(upright, 4, vectors[turns]), np.array([[0.2, 0.5]]))
    # A first phase grows a quarter turn further than the direction that its vertex knows.
    np.testing.assert_allclose(2 * np.pi / growth.rates[:, 0], np.where(turns % 2 == 1, 0.2, 0.5))
    np.testing.assert_allclose(2 * np.pi / growth.rates[:, 1], np.where(turns % 2 == 1, 0.5, 0.2))


def test_every_vertex_may_have_two_spacings_of_its_own():
    mesh = square(5)
    field, angles = plane_crosses(mesh)
    given = np.random.default_rng(2).uniform(0.1, 1, (mesh.vertex_count, 2))
    spacings, axes = growth_axes(TargetOneForm.of(mesh, field, given), angles)
    along_x = np.abs(axes[:, :, 0]) > 0.5
    np.testing.assert_allclose(spacings, np.where(along_x, given[:, :1], given[:, 1:]), rtol=1e-12)


def test_each_piece_has_its_own_first_axis():
    mesh = together(square(4), square(5))
    angles = np.radians(np.where(mesh.pieces == 0, 10, 80)) + np.pi / 2 * random_turns(mesh)
    field = given_directions(mesh, 4, np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]))
    spacings, axes = growth_axes(TargetOneForm.of(mesh, field, np.array([[0.2, 0.5]])), angles)
    np.testing.assert_allclose(spacings, np.where(np.abs(axes[:, :, 0]) > np.sqrt(0.5), 0.2, 0.5), rtol=1e-12)


def test_disclinations_that_exchange_the_axes_refuse_two_spacings():
    sphere, flat = icosphere(2), square(4)
    field = direction_field(sphere, 4)
    with pytest.raises(
        SettingError, match=r"two different spacings need .* disclinations on the piece of vertex 0: use"
    ):
        TargetOneForm.of(sphere, field, np.array([[0.2, 0.3]]))
    np.testing.assert_allclose(TargetOneForm.of(sphere, field, np.array([[0.2, 0.2]])).rates, 2 * np.pi / 0.2)
    both = together(flat, sphere)
    with pytest.raises(SettingError, match=f"on the piece of vertex {flat.vertex_count}: use the same"):
        TargetOneForm.of(both, direction_field(both, 4), np.array([[0.2, 0.3]]))


def test_a_ring_around_which_the_axes_change_places_refuses_two_spacings():
    mesh = annulus()
    x, y, _ = mesh.vertices.T
    for quarters, fits in ((0, True), (1, False), (2, True), (4, True)):
        angles = quarters / 4 * np.arctan2(y, x)
        field = given_directions(mesh, 4, np.column_stack([np.cos(angles), np.sin(angles), 0 * x]))
        if fits:
            assert len(np.unique(TargetOneForm.of(mesh, field, np.array([[0.2, 0.3]])).rates.round(9))) == 2
        else:
            with pytest.raises(SettingError, match="two different spacings"):
                TargetOneForm.of(mesh, field, np.array([[0.2, 0.3]]))


# What can be told before anything is solved


def test_nothing_is_forced_where_two_plane_waves_fit():
    mesh = square(8)
    for spacing in (0.3, np.array([[0.2, 0.7]])):
        assert TargetOneForm.of(mesh, plane_crosses(mesh, 20)[0], spacing).forced_dislocations < 1e-9


def test_spokes_at_even_distances_force_as_many_dislocations_as_the_rims_differ():
    """A phase that grows by 16 around at every radius r turns 16 r times; the one along the radii need not fork."""
    errors = []
    for fineness in (1, 2):
        mesh = annulus(0.25, 2.0, rings=18 * fineness, segments=108 * fineness)
        field = turned_crosses(given_directions(mesh, 4, mesh.vertices), random_turns(mesh))
        forced = TargetOneForm.of(mesh, field, 2 * np.pi / 16).forced_dislocations
        errors.append(forced / (16 * (2 - 0.25)) - 1)
        assert TargetOneForm.of(mesh, field, np.pi / 16).forced_dislocations == pytest.approx(2 * forced, rel=1e-9)
    # The trapezoidal rule is off by the length of an edge to the third power in each triangle.
    assert 0 < errors[0] < 0.03 and errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("build", SURFACES)
def test_triangles_around_which_phases_change_places_force_nothing(build):
    """The others by a walk with matrices around each."""
    mesh = build()
    growth = TargetOneForm.of(mesh, turned_crosses(direction_field(mesh, 4), random_turns(mesh)), 0.3)
    lookup = {tuple(edge): e for e, edge in enumerate(mesh.edges.tolist())}
    total = 0.0
    for triangle in mesh.triangles.tolist():
        walked, turns = np.zeros(2), 0
        for i, j in zip(triangle, np.roll(triangle, -1), strict=True):
            e = lookup[min(i, j), max(i, j)]
            change, matching = growth.changes[e], growth.matchings[e]
            if i > j:
                change, matching = -np.linalg.matrix_power(A, matching) @ change, -matching
            walked = walked + np.linalg.matrix_power(A, -turns % 4) @ change
            turns += matching
        total += np.abs(walked).sum() / (2 * np.pi) * (turns % 4 == 0)
    assert growth.forced_dislocations == pytest.approx(total, rel=1e-9)


def test_spacing_that_grows_along_the_lines_forces_dislocations():
    """Periods of 1 / (1 + y) along x: the phase along x has rate 2 pi (1 + y), which turns by the area in all."""
    mesh = square(10)
    y = mesh.vertices[:, 1]
    field, _ = plane_crosses(mesh)
    along_x = np.column_stack([1 / (1 + y), np.full(len(y), 0.5)])
    assert TargetOneForm.of(mesh, field, along_x).forced_dislocations == pytest.approx(1, rel=1e-9)
    across = np.column_stack([np.full(len(y), 0.5), 1 / (1 + y)])  # stretches without a fork
    assert TargetOneForm.of(mesh, field, across).forced_dislocations < 1e-9


def test_an_edge_is_coarse_where_either_phase_turns_too_far():
    mesh = square(10, split="AC")
    field, _ = plane_crosses(mesh)
    x, y, _ = np.abs(mesh.edge_vectors).T
    for spacing, coarse in (
        (np.array([[0.21, 0.21]]), x < 0),
        (np.array([[0.19, 0.21]]), x > 0.05),
        (np.array([[0.21, 0.19]]), y > 0.05),
        (np.array([[0.19, 0.19]]), x >= 0),
    ):
        assert TargetOneForm.of(mesh, field, spacing).coarse_share == pytest.approx(coarse.mean())


def test_edge_phases_keep_to_what_was_asked():
    mesh = torus()
    growth = TargetOneForm.of(mesh, direction_field(mesh, 4), 0.3)
    random = np.random.default_rng(3).uniform(-np.pi, np.pi, (mesh.vertex_count, 2))
    edge_phases = growth.edge_phases(np.exp(1j * random).ravel())
    np.testing.assert_allclose(edge_phases.arguments, random, atol=1e-12)
    for (i, j), change, asked, matching in zip(
        mesh.edges, edge_phases.changes, growth.changes, growth.matchings, strict=True
    ):
        assert (np.abs(change - asked) <= np.pi + 1e-9).all()
        reached = np.linalg.matrix_power(A, matching) @ (random[i] + change)
        assert all(abs(phase(exp(1j * miss))) < 1e-9 for miss in reached - random[j])
