# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction fields: unit tangent vectors up to a turn by 2 pi / symmetry (paper, Sections 3.1 and 3.2).

A field of symmetry n (1 vectors, 2 lines, 4 crosses) is solved as its n-th power: the unit
phase exp(i n a) for a direction at angle a in the vertex's tangent plane.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..connection import Connection, circle_transports, levi_civita
from ..defects import disclination_numbers, list_defects
from ..errors import SettingError
from ..geometry import TriangleMesh
from ..problem import SynchronizationProblem, Targets, joined_targets
from ..solve import Solution, solve
from .constraints.groups import contracted
from .constraints.rows import Row, direction_targets
from .frames import carried_angles, in_sheets_of, next_solution
from .guidance.guides import Guide, blended
from .mirror import LEAN, Mirror, on_mirror, snapped, split_links, with_loops

SYMMETRIES = {"vector": 1, "line": 2, "cross": 4}


@dataclass(frozen=True)
class DirectionWishes:
    """What a direction field should follow.

    Attributes
    ----------
    guides : pairs of a Guide and the strength with which it is followed, against the field's own smoothness
    rows : Rows of the constraint list
    mirrors : reflections that leave the field as it is
    """

    guides: tuple[tuple[Guide, float], ...] = ()
    rows: tuple[Row, ...] = ()
    mirrors: tuple[Mirror, ...] = ()


@dataclass(frozen=True)
class DirectionField:
    """A direction at every vertex.

    Attributes
    ----------
    mesh : TriangleMesh
    symmetry : 1, 2 or 4
    angles : (n,) one representative, radians in the vertices' tangent planes
    solution : Solution, or None for directions that were given
    problem : SynchronizationProblem that it solves, or None
    turn : radians, one or (n,), by which all directions were turned after the solve
    """

    mesh: TriangleMesh
    symmetry: int
    angles: np.ndarray
    solution: Solution | None = None
    problem: SynchronizationProblem | None = None
    turn: float | np.ndarray = 0.0

    @property
    def vectors(self):
        """(n, 3) unit representatives in space."""
        x, y = self.mesh.tangent_frames
        return np.cos(self.angles)[:, None] * x + np.sin(self.angles)[:, None] * y

    def turned(self, angle):
        """The field with every direction turned counterclockwise by an angle in radians."""
        return replace(self, angles=self.angles + angle, turn=self.turn + angle)

    @property
    def energy(self):
        """Of the directions as they were before they were turned; None for given ones."""
        if self.problem is None:
            return None
        return self.problem.energy(np.exp(1j * self.symmetry * (self.angles - self.turn)))

    def showing(self, phases):
        """The field with other phases of the same problem: a variation."""
        return replace(self, angles=np.angle(phases) / self.symmetry + self.turn)

    @property
    def disclinations(self):
        """List of :class:`Defect`, index k / symmetry."""
        numbers = disclination_numbers(self.mesh, np.exp(1j * self.symmetry * self.angles), self.symmetry)
        return list_defects(self.mesh, "disclination", numbers, self.symmetry)


def direction_problem(mesh, symmetry, wishes=None):
    """The synchronization problem of a direction field; arguments as :func:`direction_field`."""
    wishes = DirectionWishes() if wishes is None else wishes
    if symmetry not in SYMMETRIES.values():
        raise SettingError(f"symmetry {symmetry!r} is unknown: use 1 (vector), 2 (line) or 4 (cross)")
    connection = Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(levi_civita(mesh, symmetry)))
    fixed, drawn = direction_targets(mesh, symmetry, wishes.rows)
    links, loops = split_links(mesh.vertex_count, [mirror.direction_links(symmetry) for mirror in wishes.mirrors])
    fixed, merged = contracted(mesh.vertex_count, links, on_mirror(fixed, loops, LEAN * symmetry), LEAN * symmetry)
    if wishes.guides:
        values, weights = blended([g for g, _ in wishes.guides], [strength for _, strength in wishes.guides], symmetry)
        weights[fixed.nodes] = 0
        nodes = np.flatnonzero(weights > 0)
        drawn.append(Targets(nodes, values[nodes], weights[nodes]))
    connection = with_loops(connection, loops)
    return SynchronizationProblem(connection, mesh.vertex_masses, merged, fixed, joined_targets(drawn))


def direction_field(mesh, symmetry, wishes=None, options=None, callback=None, before=None):
    """The smoothest direction field that follows the wishes.

    Parameters
    ----------
    mesh : TriangleMesh, checked
    symmetry : 1, 2 or 4
    wishes : DirectionWishes, optional
    options, callback : see :func:`core.solve.solve`
    before : DirectionField on another shape of the mesh, optional: the field is then the one that descent reaches
        from there, in its sheets (see :mod:`.frames`)
    """
    problem = direction_problem(mesh, symmetry, wishes)
    if before is None:
        solution = solve(problem, options, callback)
    else:
        carried = carried_angles(before.angles - before.turn, before.mesh, mesh)
        solution = next_solution(problem, np.exp(1j * symmetry * carried), options, callback)
    mirrors = () if wishes is None else wishes.mirrors
    _, loops = split_links(mesh.vertex_count, [mirror.direction_links(symmetry) for mirror in mirrors])
    solution = snapped(problem, solution, loops)
    angles = np.angle(solution.phases) / symmetry
    if before is not None:
        angles = in_sheets_of(angles, carried, symmetry)
    return DirectionField(mesh, symmetry, angles, solution, problem)


def given_directions(mesh, symmetry, vectors):
    """A field from (n, 3) vectors, projected to the tangent planes.

    Raises
    ------
    SettingError
        naming the first vertex whose vector has no tangential part
    """
    vectors = np.asarray(vectors, float)
    tangent = mesh.tangent_numbers(vectors)
    lengths = np.linalg.norm(vectors, axis=1)
    bad = ~(np.abs(tangent) > 1e-6 * lengths) | ~np.isfinite(lengths)
    bad[mesh.loose_vertices] = False
    if bad.any():
        raise SettingError(
            f"the guidance vector of vertex {np.flatnonzero(bad)[0]} ({bad.sum()} in all) is zero or "
            "points straight out of the surface: give it a tangential direction"
        )
    return DirectionField(mesh, symmetry, np.angle(tangent))
