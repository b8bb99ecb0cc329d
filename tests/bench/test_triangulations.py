# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad triangles are only bad triangulations: fields on them are those on the same surface without them."""

import numpy as np
import pytest

from synch_fields.bench.triangulations import NEEDLE, SLIVER, STRENGTH, asked, needles, slivers
from synch_fields.core.fields import DirectionWishes, direction_field, given_directions, quad_pattern, stripe_pattern
from synch_fields.core.fields.guidance.guides import vectors_guide
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh

from ..core.meshes import slivers as bad_slivers
from ..core.meshes import torus

EVEN = torus(around=48, across=24, split="AC")
KINDS = {"needles": needles, "slivers": slivers}


@pytest.fixture(params=KINDS)
def mesh(request):
    """The even torus with more vertices, after its own, beside them or beside edges."""
    return KINDS[request.param](EVEN, None, None)


def on_own_edges(monkeypatch):
    monkeypatch.setattr(TriangleMesh, "solver_mesh", property(lambda mesh: mesh))


def smooth_field(mesh, symmetry):
    guide = vectors_guide(mesh, asked(mesh.vertices / 3))
    return direction_field(mesh, symmetry, DirectionWishes(((guide, STRENGTH),)))


def degrees_apart(field, even):
    """Mean angle at the vertices of the even torus."""
    there = even.mesh.tangent_numbers(field.vectors[: even.mesh.vertex_count])
    turns = np.angle((there / np.exp(1j * even.angles)) ** field.symmetry) / field.symmetry
    return np.degrees(np.abs(turns).mean())


def test_the_surface_is_the_same_and_its_triangles_are_bad():
    for build in KINDS.values():
        made = build(EVEN, None, None)
        check_mesh(made)
        assert made.areas.sum() == pytest.approx(EVEN.areas.sum(), rel=1e-12)
        assert made.vertex_count > 1.3 * EVEN.vertex_count
    thin = needles(EVEN, None, None).edge_lengths.min() / EVEN.edge_lengths
    assert NEEDLE * 0.3 < thin.max() < NEEDLE * 3
    assert slivers(EVEN, None, None).areas.min() == pytest.approx(SLIVER * EVEN.areas.min(), rel=0.5)


@pytest.mark.parametrize("symmetry", [1, 2])
def test_directions_and_energies_are_those_of_the_even_triangulation(mesh, symmetry, monkeypatch):
    even, field = smooth_field(EVEN, symmetry), smooth_field(mesh, symmetry)
    assert degrees_apart(field, even) < 0.6
    assert field.energy == pytest.approx(even.energy, rel=0.05)
    on_own_edges(monkeypatch)
    assert degrees_apart(smooth_field(mesh, symmetry), even) > 1


def test_stripes_have_the_energy_of_the_even_triangulation(mesh, monkeypatch):
    def energy(mesh):
        vectors = np.cross(mesh.vertices, [0, 0, 1.0])  # around the axis
        return stripe_pattern(mesh, given_directions(mesh, 1, vectors), 0.296).energy

    even = energy(EVEN)
    assert energy(mesh) == pytest.approx(even, rel=0.05)
    on_own_edges(monkeypatch)
    assert energy(mesh) > 1.1 * even


def test_indices_sum_to_the_characteristic_on_slivers_whatever_is_calmed():
    """What is calmed is posed on the mesh's own edges, along which it is read."""
    mesh = bad_slivers()
    assert mesh.solver_mesh is not mesh
    for share, posed in ((1.0, mesh.solver_mesh), (0.3, mesh)):
        field = direction_field(mesh, 4, DirectionWishes(singularities=share))
        assert sum(round(4 * d.index) for d in field.disclinations) == 8
        assert TargetOneForm.of(mesh, field, 0.5).on_solver_edges.mesh is posed
        pattern = quad_pattern(mesh, field, 0.5, branching=share)
        assert pattern.solution.lower_bound <= pattern.energy
        torn = pattern.edge_phases.dislocations[1]
        assert set(np.flatnonzero(torn)) == {d.triangle for d in field.disclinations if round(4 * d.index) % 4}
