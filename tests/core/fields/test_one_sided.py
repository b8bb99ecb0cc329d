# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields on one-sided surfaces: the same on both sides of the seam, and those of the two-sided surface over them."""

import numpy as np
import pytest

from synch_fields.core.fields import DirectionWishes, direction_field, quad_pattern, stripe_pattern
from synch_fields.core.fields.mirror import Seam
from synch_fields.core.geometry.manifold_repair import find_seam_ends, repair_mesh
from synch_fields.core.geometry.mesh_input import MeshInput

from ...corpus.makers import klein_bottle, moebius_strip, projective_plane
from ..meshes import polygon_mesh

SURFACES = {"moebius strip": lambda: moebius_strip(60, 8), "klein bottle": lambda: klein_bottle(48, 24)}


@pytest.fixture(params=SURFACES)
def surface(request):
    """The surface, open at a seam, and the Seam."""
    found = repair_mesh(*polygon_mesh(*SURFACES[request.param]()))
    return found, Seam.of(found.mesh, find_seam_ends(found.mesh, found.across))


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_directions_are_the_same_on_both_sides(surface, symmetry):
    found, seam = surface
    mesh = found.mesh
    field = direction_field(mesh, symmetry, DirectionWishes(mirrors=(seam,)))
    x, y = mesh.tangent_frames
    turns = np.pi / 2 * np.arange(4) if symmetry == 4 else np.zeros(1)
    angles = field.angles[:, None] + turns
    arms = np.cos(angles)[..., None] * x[:, None] + np.sin(angles)[..., None] * y[:, None]
    here, there = arms[seam.first], arms[seam.second]
    agreement = np.einsum("kax,kbx->kab", here, there).max(axis=(1, 2))
    if symmetry == 2:
        agreement = np.abs(np.einsum("kax,kbx->kab", here, there)).max(axis=(1, 2))
    assert agreement.min() > 0.9 and np.median(agreement) > 0.99  # tangent planes lean a little, from fan to fan
    assert field.solution.certificate == "proved"
    assert field.energy > direction_field(mesh, symmetry).energy


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("build", "characteristic"), [(klein_bottle, 0), (projective_plane, 1)])
def test_sum_of_indices_is_the_euler_characteristic(build, characteristic, symmetry):
    mesh, polygons = polygon_mesh(*build())
    found = repair_mesh(mesh, polygons)
    assert mesh.euler_characteristic == characteristic
    given = MeshInput(
        *(found.mesh, found.polygons, np.eye(3), found.mesh, found.source, found.findings, found.own),
        *(found.across, found.across),
    )
    assert given.euler_characteristic == characteristic and given.is_closed
    field = direction_field(
        found.mesh, symmetry, DirectionWishes(mirrors=(Seam.of(found.mesh, find_seam_ends(found.mesh, found.across)),))
    )
    assert sum(round(symmetry * d.index) for d in field.disclinations) == symmetry * characteristic


@pytest.mark.parametrize("symmetry", [1, 4])
def test_the_pattern_is_the_same_on_both_sides(surface, symmetry):
    found, seam = surface
    mesh = found.mesh
    field = direction_field(mesh, symmetry, DirectionWishes(mirrors=(seam,)))
    pattern = (quad_pattern if symmetry == 4 else stripe_pattern)(mesh, field, 0.3, mirrors=(seam,))
    seen = np.sort(np.abs(np.cos(pattern.edge_phases.arguments)), axis=1)
    np.testing.assert_allclose(seen[seam.first], seen[seam.second], atol=1e-9)


def twice_around(around, across):
    """The torus over :func:`klein_bottle`, each of whose places it passes twice, once from either side."""
    number = np.arange(2 * around * across).reshape(2 * around, across)
    u, v = 2 * np.pi * (number // across) / around, 2 * np.pi * (number % across) / across
    reach = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), height], axis=-1).reshape(-1, 3)
    ahead = np.roll(number, -1, axis=0)
    quads = np.stack([number, ahead, np.roll(ahead, -1, axis=1), np.roll(number, -1, axis=1)], axis=-1)
    return polygon_mesh(points, quads.reshape(-1, 4).tolist())[0]


@pytest.mark.parametrize("symmetry", [1, 2])
def test_directions_have_half_the_energy_of_those_on_the_torus_over_a_klein_bottle(symmetry):
    found = repair_mesh(*polygon_mesh(*klein_bottle(48, 24)))
    seam = Seam.of(found.mesh, find_seam_ends(found.mesh, found.across))
    bottle = direction_field(found.mesh, symmetry, DirectionWishes(mirrors=(seam,)))
    cover = twice_around(48, 24)
    torus = direction_field(cover, symmetry)
    assert torus.mesh.areas.sum() == pytest.approx(2 * found.mesh.areas.sum())
    assert bottle.solution.lower_bound == pytest.approx(torus.solution.lower_bound / 2, rel=0.01)
    # Every field of the bottle is one of the torus, but its best ones need not be fields of the bottle.
    assert torus.solution.lower_bound / 2 <= bottle.energy < 1.5 * torus.energy / 2
