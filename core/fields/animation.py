# SPDX-License-Identifier: GPL-3.0-or-later
"""From one frame of a moving surface to the next: a field is carried along by the vertices, and descends again.

Descent from the frame before stays in its basin. It leaves open what costs no energy: a turn of all phases of a piece,
and which of the equal directions at a vertex is the representative. Both are taken from the frame before, so that
nothing jumps without need. Where a basin ends, a pattern would slide far in one frame. Drawn to the phases before with
weights w, it takes an implicit step of its gradient flow over a time 1 / w instead, and slides for several frames.
"""

from dataclasses import replace

import numpy as np

from ..errors import SettingError
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import sum_by
from ..monitor import Callback
from ..problem import SynchronizationProblem, Targets, join_targets
from ..solution import DESCENT
from ..solve import Options, Solution, solve
from ..solve.warm_start import Follower


def has_same_triangles(mesh: TriangleMesh, other: TriangleMesh) -> bool:
    """Whether a mesh has the triangles of another, so that it may be the same one after a motion."""
    return mesh.vertex_count == other.vertex_count and np.array_equal(mesh.triangles, other.triangles)


def carry_angles(angles: np.ndarray, mesh: TriangleMesh, moved: TriangleMesh) -> np.ndarray:
    """(n,) angles in the tangent planes of ``mesh``, carried to those of the same mesh after a motion, radians.

    At each vertex they turn as its edges do on average, weighted by their lengths before and after: not at all in a
    rigid motion, and otherwise by the rotation nearest to the deformation of the tangent plane.
    """
    if not has_same_triangles(mesh, moved):
        raise SettingError("a field is carried between meshes of different triangles: solve it afresh")
    before, after = (m.edge_lengths[:, None] * np.exp(1j * m.edge_directions) for m in (mesh, moved))
    return angles + np.angle(sum_by(mesh.edges.ravel(), (after * before.conj()).ravel(), len(angles)))


def nearest_representatives(angles: np.ndarray, wanted: np.ndarray, symmetry: int) -> np.ndarray:
    """(n,) the representatives of directions at each vertex that are nearest to the wanted angles, radians."""
    turn = 2 * np.pi / symmetry
    return angles + turn * np.rint((wanted - angles) / turn)


def next_solution(
    problem: SynchronizationProblem,
    phases: np.ndarray,
    options: Options | None = None,
    callback: Callback | None = None,
    hold: np.ndarray | None = None,
    follower: Follower | None = None,
) -> Solution:
    """The local optimum that descent reaches from the frame before, without a bound.

    Parameters
    ----------
    phases : (n,) complex, of the frame before
    options, callback : see :func:`core.solve.solve`; method and time limit are ignored
    hold : (n,) weights that draw the nodes to these phases, optional
    follower : takes only some steps, optional
    """
    if follower is not None and follower.follow(problem):
        solution = follower.solve(problem, phases, callback)
        return _align_pieces(problem, solution, phases) if problem.is_complex else solution
    options = replace(Options() if options is None else options, method=DESCENT, time_limit=None)
    if hold is not None and np.any(hold):
        solution = solve(_add_soft_targets(problem, phases, hold), options, callback, phases)
        return replace(solution, energy=problem.energy(solution.phases))
    solution = solve(problem, options, callback, phases)
    return _align_pieces(problem, solution, phases) if problem.is_complex else solution


def _add_soft_targets(
    problem: SynchronizationProblem, phases: np.ndarray, weights: np.ndarray
) -> SynchronizationProblem:
    """The problem with soft targets at all nodes that are not fixed."""
    weights = np.array(weights, float)
    weights[problem.fixed.nodes] = 0
    drawn = join_targets([Targets(np.arange(len(phases)), phases, weights), problem.drawn])
    return SynchronizationProblem(problem.connection, problem.mass, problem.merged, problem.fixed, drawn)


def _align_pieces(problem: SynchronizationProblem, solution: Solution, phases: np.ndarray) -> Solution:
    """The solution with each free piece turned as a whole to be nearest to phases."""
    turned, wanted = problem.coordinates(solution.phases), problem.coordinates(phases)
    pieces = problem.layout
    for number in np.flatnonzero(pieces.grounds < 0):
        own = np.array([number])
        rows = pieces.rows(own)
        product = np.vdot(turned[rows], pieces.masses(own) * wanted[rows])
        if product != 0:
            turned[rows] *= product / abs(product)
    phases = problem.expand(turned)
    return replace(solution, phases=phases, variations=phases[None])
