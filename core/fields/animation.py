# SPDX-License-Identifier: GPL-3.0-or-later
"""From one frame of a moving surface to the next: a field carried along by the vertices, and settled again.

Descent from the frame before stays in its basin. It leaves open what costs no energy: a turn of all phases of a piece,
and which of the equal directions at a vertex is called the first. Both are taken from the frame before, so that nothing
jumps that need not. Where a basin ends, a pattern would slide far in one frame. Drawn to the phases before with weights
w, it takes the implicit step of its gradient flow over a time 1 / w instead, and slides for several frames.
"""

from dataclasses import replace

import numpy as np

from ..errors import SettingError
from ..problem import SynchronizationProblem, Targets, join_targets
from ..solution import DESCENT
from ..solve import Options, solve


def is_moved(mesh, other):
    """Whether a mesh has the triangles of another, so that it can be that one moved."""
    return mesh.vertex_count == other.vertex_count and np.array_equal(mesh.triangles, other.triangles)


def carry_angles(angles, mesh, moved):
    """Directions that go along with a moving surface.

    At each vertex they turn as its edges do on average, weighted by their lengths before and after: not at all in a
    rigid motion, and otherwise by the rotation nearest to what happens to the tangent plane.

    Parameters
    ----------
    angles : (n,) radians in the tangent planes of ``mesh``
    mesh, moved : TriangleMesh of the same triangles

    Returns
    -------
    (n,) radians in the tangent planes of ``moved``
    """
    if not is_moved(mesh, moved):
        raise SettingError("a field is carried between meshes of different triangles: solve it afresh")
    before, after = (m.edge_lengths[:, None] * np.exp(1j * m.edge_directions) for m in (mesh, moved))
    turns = (after * before.conj()).ravel()
    ends = mesh.edges.ravel()
    sums = np.bincount(ends, turns.real, len(angles)) + 1j * np.bincount(ends, turns.imag, len(angles))
    return angles + np.angle(sums)


def in_sheets_of(angles, wanted, symmetry):
    """Of the equal directions at each vertex the one nearest to a wanted angle, radians."""
    turn = 2 * np.pi / symmetry
    return angles + turn * np.rint((wanted - angles) / turn)


def next_solution(problem, phases, options=None, callback=None, hold=None, follower=None):
    """The local optimum that descent reaches from the frame before, without a bound.

    Parameters
    ----------
    problem : SynchronizationProblem
    phases : (n,) complex, of the frame before
    options, callback : see :func:`core.solve.solve`; the method and the time limit do not count
    hold : (n,) weights that draw the nodes to these phases, optional
    follower : Follower that goes some steps only, optional
    """
    if follower is not None and follower.suits(problem):
        solution = follower.solve(problem, phases, callback)
        return _align_pieces(problem, solution, phases) if problem.is_complex else solution
    options = replace(Options() if options is None else options, method=DESCENT, time_limit=None)
    if hold is not None and np.any(hold):
        solution = solve(_add_phase_wishes(problem, phases, hold), options, callback, phases)
        return replace(solution, energy=problem.energy(solution.phases))
    solution = solve(problem, options, callback, phases)
    return _align_pieces(problem, solution, phases) if problem.is_complex else solution


def _add_phase_wishes(problem, phases, weights):
    """The problem with soft wishes for phases at all nodes that are not fixed."""
    weights = np.array(weights, float)
    weights[problem.fixed.nodes] = 0
    drawn = join_targets([Targets(np.arange(len(phases)), phases, weights), problem.drawn])
    return SynchronizationProblem(problem.connection, problem.mass, problem.merged, problem.fixed, drawn)


def _align_pieces(problem, solution, phases):
    """The solution with each free piece turned as a whole to be nearest to phases."""
    turned, wanted = problem.coordinates(solution.phases), problem.coordinates(phases)
    pieces = problem.pieces
    for number in np.flatnonzero(pieces.grounds < 0):
        rows = pieces.rows([number])
        product = np.vdot(turned[rows], pieces.masses([number]) * wanted[rows])
        if product != 0:
            turned[rows] *= product / abs(product)
    phases = problem.expand(turned)
    return replace(solution, phases=phases, variations=phases[None])
