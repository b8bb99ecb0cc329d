# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of solids: exact where the directions allow it, flush with chosen surfaces, split where they fan out."""

import numpy as np
import pytest

from synch_fields.core.defects import wrap
from synch_fields.core.errors import ContradictionError, SettingError
from synch_fields.core.extract.layers.defect_curves import defect_curves
from synch_fields.core.fields.guidance.potentials import harmonic_function
from synch_fields.core.fields.guidance.solid_distance import solid_distance
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import LayerGroup, SolidTargetOneForm, solve_layers
from synch_fields.core.interpolate_solid import evaluate_in_tets
from synch_fields.core.solve import Options

from ..layered_solids import bent_bar, block, gradient_directions, group_of, layer_problem, shell

TILTED = np.array([2, -1, 2]) / 3


def ends(mesh, phase=0.0):
    """Groups of the lowest and the highest vertices."""
    z = mesh.vertices[:, 2]
    low, high = group_of(mesh, z == z.min(), phase), group_of(mesh, z == z.max(), phase)
    return [low, high]


def unevenness(pattern):
    """Largest energy of a single edge: how far the phase is from what was asked."""
    phases, growth = pattern.solution.phases, pattern.edge_phases
    i, j = pattern.mesh.edges.T
    return np.abs(wrap(np.angle(phases[j] / phases[i]) - growth.changes[:, 0])).max()


# Closed forms


@pytest.mark.parametrize("method", ["sdp", "spectral"])
@pytest.mark.parametrize("spacing", [0.31, 0.08])
def test_a_constant_direction_has_exact_layers(spacing, method):
    mesh = block((5, 6, 7), jitter=0.2)
    pattern = solve_layers(mesh, axis_directions(mesh, TILTED), spacing, options=Options(method=method))
    assert pattern.solution.energy < 1e-12 and not pattern.face_numbers.any()
    assert unevenness(pattern) < 1e-9
    spacings = pattern.spacings
    assert [spacings.mean, spacings.thinnest, spacings.thickest] == pytest.approx([spacing] * 3, rel=1e-6)
    assert spacings.deviation < 1e-6 * spacing and spacings.counted == pytest.approx(1)
    heights = 2 * np.pi / spacing * mesh.vertices @ TILTED
    np.testing.assert_allclose(pattern.heights, heights - heights.min(), atol=1e-6)


def test_the_spacing_may_change_from_place_to_place():
    """Twice as far apart at the top: the phase is the integral, which the trapezoidal rule finds on each edge."""
    mesh = block((2, 2, 40), (0.2, 0.2, 1))
    z = mesh.vertices[:, 2]
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.1 * (1 + z))
    expected = 2 * np.pi / 0.1 * np.log(1 + z)
    off = pattern.solution.phases * np.exp(-1j * expected)
    assert np.abs(off / off[0] - 1).max() < 0.01
    spacings, middle = pattern.spacings, z[mesh.tets].mean(axis=1)
    np.testing.assert_allclose(spacings.distances, 0.1 * (1 + middle), rtol=0.03)
    assert spacings.mean == pytest.approx(0.15, rel=0.01)
    # The deviation of a uniform distribution over 0.1.
    assert spacings.deviation == pytest.approx(0.1 / np.sqrt(12), rel=0.02)


@pytest.mark.parametrize("count", [3, 5])
@pytest.mark.parametrize("guide", ["radius", "distance", "harmonic"])
def test_between_concentric_spheres_layers_are_spheres(guide, count):
    mesh = shell(np.linspace(1, 1.8, 7), 2, jitter=0.01)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    inner, outer = mesh.boundary_vertices & (radius < 1.01), mesh.boundary_vertices & (radius > 1.79)
    directions = {
        "radius": lambda: mesh.vertices / radius[:, None],
        "distance": lambda: gradient_directions(mesh, solid_distance(mesh, inner)),
        "harmonic": lambda: gradient_directions(mesh, harmonic_function(mesh, inner, outer)),
    }[guide]()
    spacing = 0.8 / count
    groups = [group_of(mesh, chosen, 0.0) for chosen in (inner, outer)]
    pattern = solve_layers(mesh, directions, spacing, groups)
    solution = pattern.solution
    assert solution.lower_bound <= solution.energy and solution.gap < 0.011
    np.testing.assert_allclose(wrap(np.angle(solution.phases[inner | outer])), 0, atol=1e-9)
    assert not pattern.face_numbers.any()
    assert pattern.spacings.mean == pytest.approx(spacing, rel=0.02)
    off = wrap(2 * np.pi * (radius - 1) / spacing - pattern.vertex_phases)
    # A fiftieth of the distance between two layers, in radians.
    assert np.abs(off).mean() < 2 * np.pi / 50 and np.abs(off).max() < 6 * 2 * np.pi / 50


@pytest.mark.parametrize(("counts", "inner", "outer"), [((8, 27, 4), 6, 9), ((10, 40, 4), 12, 16), ((8, 27, 4), 9, 6)])
def test_layers_that_fan_out_split_as_often_as_the_circulation_demands(counts, inner, outer):
    """So many layers along the inner half of a bent bar and so many along the outer one, flush with both ends."""
    mesh, around = bent_bar(counts, 1, 2, np.pi / 2, 0.2)
    x, y, _ = mesh.vertices.T
    radius = np.hypot(x, y)
    spacing = radius * np.pi / 2 / np.where(radius < 1.49, inner, outer)
    groups = [group_of(mesh, end < 1e-9, 0.0) for end in (x, y)]
    pattern = solve_layers(mesh, around, spacing, groups)
    demand = outer - inner
    assert asked_circulation(mesh, around, spacing) == pytest.approx(demand, abs=0.1)
    section = _section(mesh, 0.1)
    assert section @ pattern.face_numbers == demand
    assert np.abs(section) @ np.abs(pattern.face_numbers) == abs(demand)
    curves = defect_curves(mesh, pattern.face_numbers)
    assert len(curves) == abs(demand)
    for curve in curves:
        assert curve.index == 1 and not curve.is_closed
        assert sorted([curve.points[0, 2], curve.points[-1, 2]]) == pytest.approx([0, 0.2])
        assert np.abs(np.hypot(curve.points[:, 0], curve.points[:, 1]) - 1.49).max() < 0.15


def test_layers_that_fan_out_have_as_many_dislocations_as_more_layers_outside():
    mesh, around = bent_bar((10, 30, 4), 1, 2, np.pi / 2, 0.4)
    pattern = solve_layers(mesh, around, 0.16)
    asked = asked_circulation(mesh, around, 0.16)
    assert asked == pytest.approx((2 - 1) * np.pi / 2 / 0.16, rel=0.01)
    growth, found = pattern.edge_phases, 0.0
    for chain in _rim(mesh):
        forward = np.where(chain[:-1] < chain[1:], 1, -1)
        found += (forward * growth.changes[mesh.edges_between(chain[:-1], chain[1:]), 0]).sum()
    number = _section(mesh, 0.2) @ pattern.face_numbers
    assert found == pytest.approx(2 * np.pi * number, abs=1e-6)
    # Layers bend a little before they split: fewer than asked for, but not many fewer.
    assert asked / 3 <= number <= asked


def _section(mesh, height):
    """(f,) +-1 for the faces at a height: counterclockwise from above or not."""
    corners = mesh.vertices[mesh.faces]
    inside = np.isclose(corners[:, :, 2], height).all(axis=1)
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    return np.where(inside, np.sign(up), 0).astype(int)


def _rim(mesh):
    """Chains of vertices around the section of a bent bar at half its depth, counterclockwise from above."""
    x, y, z = mesh.vertices.T
    inside = np.isclose(z, z.max() / 2)
    radius, turn = np.hypot(x, y), np.arctan2(y, x)
    sides = [(turn, 0, radius, 1), (radius, 2, turn, 1), (turn, np.pi / 2, radius, -1), (radius, 1, turn, -1)]
    chains = []
    for fixed, value, along, sign in sides:
        chain = np.flatnonzero(inside & np.isclose(fixed, value))
        chains.append(chain[np.argsort(sign * along[chain])])
    return chains


def asked_circulation(mesh, directions, spacing):
    """Turns asked for around the section of a bent bar."""
    changes = SolidTargetOneForm.of(mesh, directions, spacing).changes
    total = 0.0
    for chain in _rim(mesh):
        forward = np.where(chain[:-1] < chain[1:], 1, -1)
        total += (forward * changes[mesh.edges_between(chain[:-1], chain[1:])]).sum()
    return total / (2 * np.pi)


# Bounds, groups


def test_bounds_lie_below_every_energy_that_is_found():
    mesh = block((4, 4, 4), jitter=0.2)
    directions = np.random.default_rng(0).standard_normal(mesh.vertices.shape)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    best = solve_layers(mesh, directions, 0.5, ends(mesh)).solution
    assert best.certificate == "proved" and 0 < best.lower_bound <= best.sdp_value <= best.energy
    problem = layer_problem(mesh, directions, 0.5, ends(mesh))
    random = np.random.default_rng(1)
    free = mesh.vertices[:, 2] % 1 != 0
    for _ in range(20):
        phases = best.phases * np.exp(1j * free * random.normal(0, 0.5, len(free)))
        assert problem.energy(phases) > best.energy > best.lower_bound
    spectral = solve_layers(mesh, directions, 0.5, ends(mesh), Options(method="spectral")).solution
    assert spectral.energy > best.energy


@pytest.mark.parametrize("phase", [0.0, 1.1])
def test_fixed_phases_are_met_exactly_and_nothing_turns_along_their_surface(phase):
    """Even where the directions ask for turns along it: they lie at a slant of 60 degrees."""
    mesh = block((5, 5, 6), jitter=0.2)
    slant = axis_directions(mesh, (np.sqrt(3), 0, 1))
    groups = ends(mesh, phase)
    pattern = solve_layers(mesh, slant, 0.19, groups)
    for group in groups:
        np.testing.assert_allclose(wrap(pattern.vertex_phases[group.vertices] - phase), 0, atol=1e-9)
        assert np.abs(pattern.edge_phases.changes[mesh.edges_between(*group.sides.T)]).max() == 0
    asked = SolidTargetOneForm.of(mesh, slant, 0.19).changes[mesh.edges_between(*groups[0].sides.T)]
    assert np.abs(asked).max() > np.pi
    on_groups = np.isin(mesh.faces, groups[0].vertices).all(axis=1) | np.isin(mesh.faces, groups[1].vertices).all(
        axis=1
    )
    assert pattern.face_numbers.any() and not pattern.face_numbers[on_groups].any()
    tets, weights = np.repeat(mesh.face_tets[on_groups, 0], 3), np.zeros((3 * on_groups.sum(), 4))
    corners = (mesh.tets[tets, None, :] == np.repeat(mesh.faces[on_groups], 3, axis=0)[:, :, None]).argmax(axis=2)
    np.put_along_axis(weights, corners, np.random.default_rng(0).dirichlet(np.ones(3), len(tets)), axis=1)
    np.testing.assert_allclose(wrap(evaluate_in_tets(pattern.tet_phases, tets, weights) - phase), 0, atol=1e-9)


def test_a_constant_group_has_one_phase_in_each_of_its_pieces():
    mesh = block((5, 5, 6), jitter=0.2)
    z = mesh.vertices[:, 2]
    directions, spacing = axis_directions(mesh, (1, 0, 4)), 0.29
    free = solve_layers(mesh, directions, spacing)
    group = group_of(mesh, (z == 0) | (z == 1))
    pattern = solve_layers(mesh, directions, spacing, [group])
    phases = pattern.solution.phases
    for level in (0, 1):
        assert np.ptp(np.angle(free.solution.phases[z == level])) > 1
        np.testing.assert_array_equal(phases[z == level], phases[z == level][0])
    # Left to the solver: the two ends are not a whole number of layers apart, and need not be.
    assert np.abs(phases[z == 0][0] - phases[z == 1][0]) > 0.3
    fixed = solve_layers(mesh, directions, spacing, ends(mesh)).solution
    assert pattern.solution.energy < fixed.energy
    assert pattern.solution.lower_bound <= pattern.solution.energy


def test_groups_of_vertices_do_not_reach_through_the_solid():
    """One tetrahedron thick: the two sides are joined by inner edges, and the walls have all corners on them."""
    mesh = block((4, 4, 1), (1, 1, 0.25))
    z = mesh.vertices[:, 2]
    inner = (np.abs(mesh.vertices[:, :2] - 0.5) < 0.4).all(axis=1)
    group = group_of(mesh, inner)
    assert len(group.vertices) == 18 and len(group.triangles) == 16
    assert len(np.unique(group.links.i)) == 2
    sides = mesh.boundary_triangles[np.ptp(z[mesh.boundary_triangles], axis=1) == 0]
    both = LayerGroup(np.unique(sides), sides)
    assert len(np.unique(both.links.i)) == 2 < len(both.vertices)
    held = LayerGroup(both.vertices, sides, 0.0)
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.25, [held])
    assert pattern.solution.energy < 1e-12
    np.testing.assert_allclose(pattern.spacings.distances, 0.25)


def test_inner_surfaces_are_groups_too():
    mesh = block((4, 4, 6))
    z = mesh.vertices[:, 2]
    middle = np.isclose(z, 0.5)
    group = group_of(mesh, middle, 0.0)
    # All but two in corners, which reach from wall to wall.
    assert len(group.triangles) == 30
    pattern = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.3, [group])
    np.testing.assert_allclose(wrap(pattern.vertex_phases - 2 * np.pi * (z - 0.5) / 0.3), 0, atol=1e-6)


def test_a_fixed_group_settles_a_constant_one_that_it_touches():
    mesh = block((3, 3, 3))
    x, z = mesh.vertices[:, 0], mesh.vertices[:, 2]
    groups = [group_of(mesh, z == 0, name="floor"), group_of(mesh, x == 0, 0.7, "wall")]
    phases = solve_layers(mesh, axis_directions(mesh, (0, 0, 1)), 0.5, groups).solution.phases
    np.testing.assert_allclose(phases[(z == 0) | (x == 0)], np.exp(0.7j), atol=1e-9)
    contrary = [*groups, group_of(mesh, x == 1, 2.0, "other wall")]
    with pytest.raises(ContradictionError, match="floor joins") as caught:
        layer_problem(mesh, axis_directions(mesh, (0, 0, 1)), 0.5, contrary)
    assert set(caught.value.vertices) <= set(np.flatnonzero((x == 0) | (x == 1)))
    with pytest.raises(ContradictionError, match="wall and ceiling fix"):
        layer_problem(mesh, axis_directions(mesh, (0, 0, 1)), 0.5, [groups[1], group_of(mesh, z == 1, 0, "ceiling")])


@pytest.mark.parametrize(
    ("directions", "spacing", "words"),
    [
        (np.zeros((3, 3)), 0.5, "give 64 vectors"),
        (np.full((64, 3), np.nan), 0.5, "finite"),
        (np.ones((64, 3)), 0.0, "positive length"),
        (np.ones((64, 3)), np.inf, "positive length"),
        (np.ones((64, 3)), np.where(np.arange(64) == 7, -1, 0.5), "vertex 7"),
        (np.ones((64, 3)), np.ones(7), "7 spacings"),
        (np.ones((64, 3)), 5.0, "no layer would fit"),
    ],
)
def test_settings_that_do_not_fit_are_refused(directions, spacing, words):
    with pytest.raises(SettingError, match=words):
        layer_problem(block((3, 3, 3)), directions, spacing)


def test_what_does_not_count_for_the_spacing_is_said():
    """Random directions: punctured tetrahedra have no distance between layers."""
    mesh = block((4, 4, 4))
    directions = np.random.default_rng(0).standard_normal(mesh.vertices.shape)
    pattern = solve_layers(mesh, directions, 0.4)
    spacings, punctured = pattern.spacings, pattern.tet_phases.punctured
    assert punctured.any() and np.isnan(spacings.distances[punctured]).all()
    counted = np.isfinite(spacings.distances)
    assert spacings.counted == pytest.approx(mesh.volumes[counted].sum() / mesh.volumes.sum())
    met, volumes = spacings.distances[counted], mesh.volumes[counted]
    for extreme, beyond in ((spacings.thinnest, met < spacings.thinnest), (spacings.thickest, met > spacings.thickest)):
        heaviest = volumes[met == extreme].sum() / volumes.sum()
        assert 0.01 - heaviest <= volumes[beyond].sum() / volumes.sum() <= 0.01
    still = solve_layers(mesh, 0 * directions, 0.4).spacings
    assert still.counted == 0 and np.isnan(still.mean)
