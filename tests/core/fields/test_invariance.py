# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What does not depend on numbering, position or size: energies, defects, bounds and spectra."""

import numpy as np
import pytest

from synch_fields.core.connection import Connection, circle_transports, levi_civita
from synch_fields.core.defects import wrap
from synch_fields.core.fields import DirectionField, direction_field, given_directions
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem, stripe_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import dislocation_numbers
from synch_fields.core.solve import Options, solve

from ..meshes import bent_square, cylinder, double_torus, icosphere, torus


class Change:
    """A mesh and what it became: vertex[v] and triangle[t] are the new names of v and t."""

    def __init__(self, mesh, kind, seed):
        random = np.random.default_rng(seed)
        self.old, self.scale = mesh, 1.0
        self.turn, shift = np.eye(3), np.zeros(3)
        self.vertex, self.triangle = np.arange(mesh.vertex_count), np.arange(mesh.triangle_count)
        triangles = mesh.triangles
        if kind == "numbering":
            self.vertex = random.permutation(mesh.vertex_count)
            self.triangle = random.permutation(mesh.triangle_count)
            rolled = (np.arange(3) + random.integers(0, 3, (mesh.triangle_count, 1))) % 3
            triangles = np.take_along_axis(self.vertex[mesh.triangles], rolled, axis=1)
        elif kind == "motion":
            self.turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
            self.turn *= np.sign(np.linalg.det(self.turn))
            shift = random.standard_normal(3)
        else:
            self.scale = 37.5
        vertices, new_triangles = np.empty_like(mesh.vertices), np.empty_like(mesh.triangles)
        vertices[self.vertex] = self.scale * (mesh.vertices @ self.turn.T + shift)
        new_triangles[self.triangle] = triangles
        self.new = TriangleMesh(vertices, new_triangles)

    def field(self, field):
        """The same directions on the changed mesh, at the same angles to the edges, whose zero may be another."""
        tails, heads = self.old.edges.T
        new_low = np.minimum(self.vertex[tails], self.vertex[heads])
        keys = self.new.edges @ [self.new.vertex_count, 1]
        high = np.maximum(self.vertex[tails], self.vertex[heads])
        edge = np.searchsorted(keys, new_low * self.new.vertex_count + high)
        kept = self.vertex[tails] == new_low
        new_directions = np.where(kept[:, None], self.new.edge_directions[edge], self.new.edge_directions[edge, ::-1])
        shift = np.empty(self.old.vertex_count)
        shift[self.old.edges] = new_directions - self.old.edge_directions
        angles = np.empty_like(field.angles)
        angles[self.vertex] = field.angles + shift
        return DirectionField(self.new, field.symmetry, angles)

    def vectors(self, vectors):
        """Vectors in space, carried along."""
        moved = np.empty_like(vectors)
        moved[self.vertex] = vectors @ self.turn.T
        return moved

    def phases(self, phases):
        moved = np.empty_like(phases)
        moved[self.vertex] = phases
        return moved

    def defects(self, defects):
        """Triangle and index of each defect, by the new names."""
        return sorted((int(self.triangle[d.triangle]), d.index) for d in defects)


def named(defects):
    return sorted((d.triangle, d.index) for d in defects)


def field_energy(field):
    mesh, n = field.mesh, field.symmetry
    connection = Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(levi_civita(mesh, n)))
    return connection.energy(np.exp(1j * n * field.angles))


SURFACES = [
    pytest.param(lambda: icosphere(2), id="icosphere"),
    pytest.param(lambda: torus(around=16, across=10), id="torus"),
    pytest.param(double_torus, id="double-torus"),
    pytest.param(bent_square, id="bent-square"),
    pytest.param(lambda: cylinder(segments=16, rows=6), id="cylinder"),
]


def changes(*symmetries):
    """Of each surface another numbering, with each symmetry; two are moved and scaled."""
    numbered = [(surface.values[0], "numbering", symmetry) for surface in SURFACES for symmetry in symmetries]
    moved = [(SURFACES[at].values[0], kind, symmetries[-1]) for at in (1, 3) for kind in ("motion", "size")]
    return pytest.mark.parametrize(("build", "kind", "symmetry"), numbered + moved)


@changes(1, 2, 4)
def test_a_direction_field_keeps_its_energy_and_defects(build, kind, symmetry):
    mesh = build()
    solved = direction_field(mesh, symmetry, options=Options(rounding="polish"))
    for seed in range(3):
        change = Change(mesh, kind, seed)
        vectors = np.random.default_rng(seed).standard_normal((mesh.vertex_count, 3))
        for field in (given_directions(mesh, symmetry, vectors), solved):
            moved = change.field(field)
            assert field_energy(moved) == pytest.approx(field_energy(field), rel=1e-9, abs=1e-9)
            assert named(moved.disclinations) == change.defects(field.disclinations)


@changes(1)
def test_vectors_in_space_are_the_same_directions_whatever_the_numbering(build, kind, symmetry):
    """An artist's guidance may not depend on which edge of a vertex happens to be its reference."""
    mesh = build()
    change = Change(mesh, kind, 1)
    vectors = np.random.default_rng(0).standard_normal((mesh.vertex_count, 3))
    old = given_directions(mesh, symmetry, vectors)
    new = given_directions(change.new, symmetry, change.vectors(vectors))
    assert field_energy(new) == pytest.approx(field_energy(old), rel=1e-9)
    np.testing.assert_allclose(wrap(new.angles - change.field(old).angles), 0, atol=1e-9)


@changes(1, 2)
def test_a_stripe_pattern_keeps_its_energy_and_defects(build, kind, symmetry):
    mesh = build()
    spacing = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 5
    field = direction_field(mesh, symmetry)
    pattern = stripe_pattern(mesh, field, spacing)
    numbers, torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    for seed in range(2):
        change = Change(mesh, kind, seed)
        moved_field, phases = change.field(field), change.phases(pattern.solution.phases)
        problem = pattern_problem(change.new, moved_field, PatternWishes(change.scale * spacing))
        assert problem.energy(phases) == pytest.approx(pattern.solution.energy, rel=1e-9)
        moved = TargetOneForm.of(change.new, moved_field, change.scale * spacing).edge_phases(phases)
        moved_numbers, moved_torn = dislocation_numbers(moved, change.new.triangles)
        np.testing.assert_array_equal(moved_torn[change.triangle], torn)
        # The sign of a line's index belongs to the sheet of the first corner, which may be another one.
        if symmetry == 1:
            np.testing.assert_array_equal(moved_numbers[change.triangle], numbers)
        else:
            np.testing.assert_array_equal(np.abs(moved_numbers[change.triangle]), np.abs(numbers))


@changes(1, 4)
def test_a_problem_keeps_its_spectrum_and_bounds(build, kind, symmetry):
    mesh = build()
    change = Change(mesh, kind, 7)
    old, new = direction_problem(mesh, symmetry), direction_problem(change.new, symmetry)
    spectra = [np.linalg.eigvalsh(p.pieces[0].matrix.toarray()) for p in (old, new)]
    np.testing.assert_allclose(spectra[1], spectra[0], atol=1e-9)
    bounds = [solve(p, Options(method="spectral")).spectral_bound for p in (old, new)]
    assert bounds[1] == pytest.approx(bounds[0], rel=1e-6, abs=1e-8)
    first, second = (solve(p, Options(target_gap=1e-4, rounding="svd")) for p in (old, new))
    assert second.sdp_value == pytest.approx(first.sdp_value, rel=1.1e-4, abs=1e-9)
    assert second.lower_bound == pytest.approx(first.lower_bound, rel=1.1e-4, abs=1e-9)


@pytest.mark.parametrize("symmetry", [1, 2])
@pytest.mark.parametrize("build", SURFACES)
def test_other_representatives_of_the_directions_give_the_same_stripes(build, symmetry):
    """Lines may point either way at every vertex: phases there are conjugated, and nothing else changes."""
    mesh = build()
    spacing = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / 5
    field = direction_field(mesh, symmetry)
    over = (
        np.random.default_rng(0).random(mesh.vertex_count) < 0.5 if symmetry == 2 else np.ones(mesh.vertex_count, bool)
    )
    other = given_directions(mesh, symmetry, np.where(over[:, None], -1, 1) * field.vectors)
    phases = np.exp(1j * np.random.default_rng(1).uniform(-np.pi, np.pi, mesh.vertex_count))
    turned = np.where(over, phases.conj(), phases)
    first, second = (pattern_problem(mesh, one, PatternWishes(spacing)) for one in (field, other))
    assert second.energy(turned) == pytest.approx(first.energy(phases), rel=1e-9)
    bounds = [solve(p, Options(target_gap=1e-4, rounding="svd")).lower_bound for p in (first, second)]
    assert bounds[1] == pytest.approx(bounds[0], rel=2e-4)


def test_size_scales_nothing_but_the_spacing():
    mesh = bent_square()
    vectors = np.tile([1.0, 0.3, 0], (mesh.vertex_count, 1))
    qualities = []
    for scale in (1e-5, 1.0, 1e5):
        scaled = TriangleMesh(scale * mesh.vertices, mesh.triangles)
        solution = stripe_pattern(scaled, given_directions(scaled, 1, vectors), scale * 0.2).solution
        qualities.append((solution.energy, solution.lower_bound, solution.sdp_value))
    assert qualities[1][1] > 0.1
    np.testing.assert_allclose(qualities[0], qualities[1], rtol=2e-3)
    np.testing.assert_allclose(qualities[2], qualities[1], rtol=2e-3)
