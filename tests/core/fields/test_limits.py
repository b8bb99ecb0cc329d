# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers stay between limits where they can: in closed form, and as rays down to the next layer measure them."""

import numpy as np
import pytest

from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.fields.layers import SolidTargetOneForm, solve_one_form
from synch_fields.core.fields.limits import ENOUGH, Limits, solve_within
from synch_fields.core.printing.heights import below

from ..layered_solids import bent_bar, block, group_of


def ends_of(mesh, axis, low, high):
    """Groups of the two ends along an axis, with a layer on them."""
    places = mesh.vertices[:, axis]
    return [group_of(mesh, np.isclose(places, end), 0.0) for end in (low, high)]


def bar(outer, spacing=0.14):
    """A growth around a bent bar whose outer side is so much longer, and groups of its ends."""
    mesh, around = bent_bar((8, 28, 3), 1, outer, np.pi / 2, 0.4)
    groups = [group_of(mesh, np.isclose(mesh.vertices[:, axis], 0), 0.0) for axis in (0, 1)]
    return SolidTargetOneForm.of(mesh, around, spacing), groups


@pytest.mark.parametrize(("largest", "count"), [(0.34, 3), (0.3, 4), (0.24, 5)])
def test_between_two_groups_there_are_as_many_layers_as_the_limit_asks_for(largest, count):
    """Three layers of a third are nearest to 0.3: a lower limit takes the next whole numbers."""
    mesh = block((4, 4, 10))
    growth = SolidTargetOneForm.of(mesh, axis_directions(mesh, (0, 0, 1)), 0.3)
    pattern, _ = solve_within(growth, Limits(0.1, largest), ends_of(mesh, 2, 0, 1))
    np.testing.assert_allclose(pattern.spacings.distances, 1 / count, rtol=1e-4)
    assert Limits(0.1, largest).outside_share(pattern) == 0


def test_a_bar_that_fans_out_within_its_limits_has_no_layer_that_ends():
    limits = Limits(0.07, 0.21)
    growth, groups = bar(2.2)
    asked = solve_one_form(growth, groups)
    assert limits.outside_share(asked) > 0.005 and asked.face_numbers.any()
    pattern, _ = solve_within(growth, limits, groups)
    assert limits.outside_share(pattern) == 0 and not pattern.face_numbers.any()
    # Rays from each layer down to the next, which know nothing of phases.
    surfaces = layer_surfaces(pattern.edge_phases, pattern.heights)
    corners = surfaces.vertices[surfaces.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = below(surfaces, pattern.mesh, corners.mean(axis=1), normals, surfaces.layers, 0.14)
    heights = found.heights[found.layers >= 0]
    assert len(heights) > 0.8 * len(corners)
    assert heights.min() > limits.smallest and heights.max() < limits.largest
    # A bar around an angle: as far apart as they are from its axis.
    radius = np.hypot(*corners.mean(axis=1)[found.layers >= 0, :2].T)
    np.testing.assert_allclose(heights, radius * np.pi / 2 / (surfaces.count - 1), rtol=0.08)


@pytest.mark.parametrize(("limits", "share"), [(Limits(0.07, 0.21), 0.6), (Limits(largest=0.16), 1.0)])
def test_no_more_is_outside_than_without_limits(limits, share):
    growth, groups = bar(3)
    asked = limits.outside_share(solve_one_form(growth, groups))
    pattern, used = solve_within(growth, limits, groups)
    assert asked > ENOUGH and limits.outside_share(pattern) <= share * asked
    spacings = 2 * np.pi / np.linalg.norm(used.rates, axis=1)
    assert (spacings >= limits.smallest).all() and (spacings <= limits.largest).all()


def test_without_limits_nothing_changes():
    growth, groups = bar(2.2)
    pattern, used = solve_within(growth, Limits(), groups)
    np.testing.assert_array_equal(pattern.solution.phases, solve_one_form(growth, groups).solution.phases)
    assert used is growth and Limits().outside_share(pattern) == 0
    # Nor where they are kept as it is.
    mesh = block((3, 3, 6), jitter=0.2)
    even = SolidTargetOneForm.of(mesh, axis_directions(mesh, (1, 2, 2)), 0.3)
    pattern, used = solve_within(even, Limits(0.3, 0.31))
    assert used is even and Limits(0.3, 0.31).outside_share(pattern) == 0


def test_the_share_of_branches_is_not_exceeded():
    growth, groups = bar(3)
    pattern, _ = solve_within(growth, Limits(0.11, 0.17), groups, branching=0.0)
    assert not pattern.face_numbers.any()


def test_where_layers_end_counts_as_outside():
    growth, groups = bar(3)
    pattern = solve_one_form(growth, groups)
    punctured = pattern.mesh.volumes[pattern.tet_phases.punctured].sum() / pattern.mesh.volumes.sum()
    assert Limits(1e-6, 10.0).outside_share(pattern) == pytest.approx(punctured) and punctured > 0
