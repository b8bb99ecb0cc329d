# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes whose loops are to be short: on a torus where all can be, on limbs, mirrored, and what it may cost."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import Cancelled
from synch_fields.core.extract.quads.measure.loops import quad_loops
from synch_fields.core.fields import given_directions
from synch_fields.core.fields.curl_removal import SMALLEST_WEIGHT
from synch_fields.core.geometry import TriangleMesh

from ..meshes import bumpy_torus, icosphere, torus
from .test_quad_meshes import asked


def around_tube(mesh, degrees):
    """(n, 3) directions at an angle to the circles around a torus's axis."""
    x, y, _ = mesh.vertices.T
    field = given_directions(mesh, 4, np.column_stack([-y, x, 0 * x]))
    return field.turned(np.radians(degrees)).vectors


def with_settings(request, **changes):
    return replace(request, settings=replace(request.settings, **changes))


def test_spirals_of_a_torus_all_close():
    """Lines at a small angle to its circles wind around it; turned onto them, each is a loop."""
    mesh = torus(around=72, across=30)
    request = asked(mesh, directions=around_tube(mesh, 9.0), spacing=0.3)
    before, after = request.solve(), with_settings(request, loops=1.0).solve()
    given, found = quad_loops(before.quads), quad_loops(after.quads)
    assert given.short_share < 0.6 and found.short_share == 1.0
    assert after.loops_before == given.figures and before.loops_before is None
    assert (after.quads.sizes == 4).all() and not after.quads.is_irregular.any()


def test_nothing_closes_where_nothing_may_be_given_up():
    mesh = torus(around=72, across=30)
    request = asked(mesh, directions=around_tube(mesh, 9.0), spacing=0.3)
    before, after = request.solve(), with_settings(request, loops=1e-6).solve()
    np.testing.assert_array_equal(before.pattern.phases, after.pattern.phases)
    branching = with_settings(request, branching=1.0)
    np.testing.assert_array_equal(
        branching.solve().quads.sizes, with_settings(branching, loops=1.0).solve().quads.sizes
    )


def limbs(sides=(1, -0.7)):
    """A sphere with horns, around which lines spiral."""
    sphere = icosphere(4)
    x, y, z = sphere.vertices.T
    horns = sum(np.exp(-((x - 0.9 * side) ** 2 + (y - 0.3) ** 2 + (z - 0.3) ** 2) / 0.06) for side in sides)
    return TriangleMesh(sphere.vertices * (1 + 0.9 * horns[:, None]), sphere.triangles)


@cache
def quads_on_limbs(loops=None, **settings):
    request = asked(limbs(), **settings)
    return (request if loops is None else with_settings(request, loops=loops)).solve()


def test_limbs_get_more_short_loops():
    before, after = quads_on_limbs(faces=700), quads_on_limbs(0.5, faces=700)
    given, found = quad_loops(before.quads), quad_loops(after.quads)
    assert found.short_share > given.short_share + 0.05, (found.short_share, given.short_share)
    assert after.loops_before is not None
    assert (after.quads.sizes == 4).all() and after.quads.euler_characteristic == 2
    assert len(after.quads.sizes) == pytest.approx(len(before.quads.sizes), rel=0.065)
    assert after.quads.is_irregular.sum() <= 1.1 * before.quads.is_irregular.sum() + 2


def test_what_is_added_to_the_changes_costs_no_more_than_is_allowed():
    before, after = quads_on_limbs(spacing=0.2), quads_on_limbs(0.5, spacing=0.2)
    mesh, added = after.pattern.mesh, after.pattern.one_form.correction - before.pattern.one_form.correction
    cost = (np.maximum(mesh.weights, SMALLEST_WEIGHT)[:, None] * added**2).sum() / 2
    assert cost <= before.pattern.energy * (1 + 1e-6)  # as much again as the pattern costs
    again = quads_on_limbs.__wrapped__(0.5, spacing=0.2)
    np.testing.assert_array_equal(after.quads.vertices, again.quads.vertices)


def test_a_mirrored_mesh_stays_its_own_mirror_image():
    """With a mirror nearly all loops are closed as it is."""
    mesh = limbs((1, -1))
    request = asked(mesh, spacing=0.25, mirror="X")
    before, after = request.solve(), with_settings(request, loops=1.0).solve()
    given, found = quad_loops(before.quads), quad_loops(after.quads)
    assert found.short_share >= given.short_share
    places = after.quads.vertices
    assert cKDTree(places).query(places * [-1, 1, 1])[0].max() < 1e-6


def test_closing_can_be_cancelled():
    request = asked(bumpy_torus(20), spacing=0.25, loops=1.0)
    heard = []

    def stop(stage, fraction):
        heard.append((stage, fraction))
        return stage != "closing loops"

    with pytest.raises(Cancelled):
        request.solve(stop)
    fractions = [fraction for _, fraction in heard]
    assert heard[-1][0] == "closing loops" and max(fractions) == fractions[-1]
