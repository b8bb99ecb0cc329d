# SPDX-License-Identifier: GPL-3.0-or-later
"""Curl removal: the nearest changes along the edges that add up to less around the faces.

A connection has a target change c along every edge. Around a face they add up to its holonomy C c, which no phases can
follow: the curvature for directions, the curl of the target one-form for patterns. Where it adds up to whole turns,
defects appear. The nearest changes with a part h of it removed,

    argmin sum of w_e (c'_e - c_e)^2 subject to C c' = C c - h,    c' = c - W^-1 C^T y,    C W^-1 C^T y = h,

give the same synchronization problem with fewer defects. C W^-1 C^T is a Laplacian between the sums, with signs.

Changes between nodes that are known from constraints stay as they are. Where no change is free, and on closed pieces,
the sum of C c is fixed (for directions by the topology): its mean over the area stays.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from numbers import Real

import numpy as np
from scipy.sparse import csr_matrix, diags_array
from scipy.sparse.linalg import SuperLU, cg

from ..algebra.factorization import factorize, near_order, solve_definite
from ..connection import Connection, are_flips, as_matrices
from ..defects import wrap
from ..errors import SettingError
from ..gauge import balance
from ..geometry.handles import handle_changes
from ..geometry.tet_mesh import TetMesh
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import components
from ..matchings import after_turns
from ..problem import Merged, Targets
from .constraints.groups import Links, walk_from_leads
from .guidance.potentials import potential

# The least weight, so that edges of needles change freely.
SMALLEST_WEIGHT = 1e-3
# Keeps the factorized Laplacian definite, as a share of its diagonal; the second solve corrects the first.
SHIFT, SOLVES = 1e-13, 2
# Residual relative to the right side, and most steps, where the changes only lead to candidates.
ROUGH, ROUGH_STEPS = 1e-1, 100


def check_share(share: object, name: str) -> None:
    """Refuse everything but a share from 0 to 1."""
    if isinstance(share, bool) or not isinstance(share, Real) or not 0 <= float(share) <= 1:
        raise SettingError(f"{name} is {share!r}: give a share from 0 to 1")


@dataclass(frozen=True)
class Circulation:
    """Sums of changes around faces.

    Attributes
    ----------
    matrix : (s, c) CSR of ones and minus ones, from changes to sums; every change is in two sums at most
    areas : (s,) of the face of each sum
    """

    matrix: csr_matrix
    areas: np.ndarray


def surface_circulation(mesh: TriangleMesh, matchings: np.ndarray, count: int = 1) -> tuple[Circulation, np.ndarray]:
    """The circulation of (count e,) changes, those of an edge consecutive, and the (f,) triangles that they go around.

    These are the triangles around which the sheet is kept. There are ``count`` phases at a vertex, and a sum for each
    phase of a triangle's first corner. For (e,) matchings see :mod:`core.matchings`.
    """
    units = np.broadcast_to(np.eye(count), (mesh.triangle_count, count, count))
    turns, steps = np.zeros(mesh.triangle_count, int), []
    for edges, signs in zip(mesh.triangle_edges.T, mesh.triangle_edge_signs.T, strict=True):
        forward, matched = signs > 0, matchings[edges]
        change = np.where(forward[:, None, None], units, -after_turns(units, matched[:, None]))
        steps.append(after_turns(change, -turns[:, None]))
        turns = turns + np.where(forward, matched, -matched)
    kept = np.flatnonzero(turns % (2 * count) == 0)
    # From (step, triangle, phase of the edge, phase of the corner) to a row for each phase of a corner.
    values = np.stack(steps)[:, kept].transpose(1, 3, 0, 2).reshape(-1, 3 * count)
    columns = (count * mesh.triangle_edges[kept, :, None] + np.arange(count)).reshape(-1, 3 * count)
    columns = np.repeat(columns, count, axis=0)
    starts = np.arange(0, columns.size + 1, 3 * count)
    shape = (len(columns), count * len(mesh.edges))
    matrix = csr_matrix((values.ravel(), columns.ravel(), starts), shape=shape)
    matrix.eliminate_zeros()
    return Circulation(matrix, np.repeat(mesh.areas[kept], count)), kept


@dataclass(frozen=True)
class CurlRemoval:
    """The least correction of changes that removes all holonomy that can be removed.

    Attributes
    ----------
    correction : (c,) to be added to the changes
    multipliers : (s,) y of the formula above
    """

    correction: np.ndarray
    multipliers: np.ndarray


def remove_holonomy(
    circulation: Circulation,
    holonomy: np.ndarray,
    weights: np.ndarray,
    known: np.ndarray | None = None,
    rough: bool = False,
) -> CurlRemoval:
    """The correction of changes with (c,) weights that makes their (s,) sums 0; an approximate one where ``rough``.

    ``known`` are (c,) changes known from constraints less the target changes, nan where unknown.
    """
    inverse_weights, correction = _inverse_weights(weights, known), np.zeros(len(weights))
    if known is not None:
        correction = np.nan_to_num(known)
        holonomy = holonomy + circulation.matrix @ correction
    flow = (diags_array(inverse_weights) @ circulation.matrix.T).tocsr()
    laplacian = (circulation.matrix @ flow).tocsr()
    removed, follows = _removable(circulation, inverse_weights > 0, holonomy)
    found = _solve_rows(laplacian, removed, ~follows & (laplacian.diagonal() > 0), rough)
    return CurlRemoval(correction - flow @ found, found)


def remove_varying(
    circulation: Circulation, holonomy: np.ndarray, weights: np.ndarray, length: float, known: np.ndarray | None = None
) -> np.ndarray:
    """(c,) correction that takes out of a holonomy h what varies over less than about a length.

    With L = C W^-1 C^T and the areas A that is h - A (A + length^2 L)^-1 h = L y with multipliers
    y = length^2 (A + length^2 L)^-1 h. Changes known from constraints stay; arguments as of :func:`remove_holonomy`.
    """
    flow = diags_array(_inverse_weights(weights, known)) @ circulation.matrix.T
    laplacian = (circulation.matrix @ flow).tocsr()
    smoothing = (diags_array(circulation.areas) + length**2 * laplacian).tocsr()
    # Where all changes are known the Laplacian is 0, and areas may be 0, too: the shift keeps the matrix definite.
    shift = SHIFT * (smoothing.diagonal().max(initial=0.0) or 1.0)
    smoothing = smoothing + diags_array(np.full(len(circulation.areas), shift)).tocsr()
    return -(length**2) * (flow @ solve_definite(smoothing, holonomy))


def _inverse_weights(weights: np.ndarray, known: np.ndarray | None) -> np.ndarray:
    """(c,) inverse weights of the changes: 0 for known ones, which do not vary."""
    inverse_weights = 1 / np.maximum(weights, SMALLEST_WEIGHT)
    if known is not None:
        inverse_weights[~np.isnan(known)] = 0
    return inverse_weights


def removable_rows(circulation: Circulation, free: np.ndarray, laplacian: csr_matrix) -> np.ndarray:
    """Indices of an independent set of the sums around faces that (c,) bool free changes can alter.

    ``laplacian`` is C W^-1 C^T, (s, s).
    """
    _, follows = _removable(circulation, free, np.zeros(laplacian.shape[0]))
    return np.flatnonzero(~follows & (laplacian.diagonal() > 0))


def _removable(circulation: Circulation, free: np.ndarray, holonomy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The holonomy less its means over the pieces on which free changes cannot alter the sum, and (s,) bool: one sum
    of each such piece, which follows from the others."""
    count, by_change = circulation.matrix.shape[0], circulation.matrix.tocsc()
    rows, starts, sums = by_change.indices, by_change.indptr[:-1], np.diff(by_change.indptr)
    twice = starts[free & (sums == 2), None] + [0, 1]
    pieces = components(count, rows[twice])
    is_open = np.bincount(pieces[rows[starts[free & (sums == 1)]]], minlength=pieces.max(initial=-1) + 1) > 0
    # Sums that no change alters: both places of every change have opposite signs.
    turned, balanced = balance(count, rows[twice], by_change.data[twice].prod(axis=1) > 0)
    sealed = balanced & ~is_open[pieces]
    sides = np.where(turned, -1.0, 1.0) * sealed
    # In a piece of needles, without area, all sums have the same weight.
    areas = np.where(np.bincount(pieces, circulation.areas)[pieces] > 0, circulation.areas, 1.0)
    totals = np.bincount(pieces, sides * holonomy) / np.bincount(pieces, areas)
    follows = np.zeros(count, bool)
    follows[np.unique(np.where(sealed, pieces, -1), return_index=True)[1]] = True
    return holonomy - sides * areas * totals[pieces], follows & sealed


def _solve_rows(matrix: csr_matrix, right: np.ndarray, wanted: np.ndarray, rough: bool) -> np.ndarray:
    """Solution in the wanted rows, zero in the others."""
    result = np.zeros_like(right)
    rows = np.flatnonzero(wanted)
    if len(rows) == 0:
        return result
    matrix = matrix[rows][:, rows].tocsr()
    if rough:
        inverse = diags_array(1 / matrix.diagonal())
        result[rows] = cg(matrix, right[rows], rtol=ROUGH, maxiter=ROUGH_STEPS, M=inverse)[0]
        return result
    order = near_order(matrix)
    rows, matrix = rows[order], matrix[order][:, order]
    right = right[rows]
    factors = _factors(matrix)
    for _ in range(SOLVES):
        result[rows] += factors.solve(right - matrix @ result[rows])
    return result


# Matrices and factors that are kept, newest last; None where none are.
_kept: ContextVar[list[tuple[csr_matrix, SuperLU]] | None] = ContextVar("kept", default=None)
# How many are kept: those of directions and of patterns.
_KEPT = 2


@contextmanager
def keep_factors() -> Iterator[None]:
    """Keep the last factorizations until the end: other spacings lead to the same matrix."""
    token = _kept.set([])
    try:
        yield
    finally:
        _kept.reset(token)


def _factors(matrix: csr_matrix) -> SuperLU:
    """Factorize a matrix, or return the factors that :func:`keep_factors` keeps of an equal one."""
    kept = _kept.get() or []
    for known, factors in kept:
        if known.shape == matrix.shape and known.nnz == matrix.nnz and abs(known - matrix).max() == 0:
            return factors
    factors = factorize(matrix + SHIFT * diags_array(matrix.diagonal()), single=False)
    if _kept.get() is not None:
        _kept.set([*kept[1 - _KEPT :], (matrix, factors)])
    return factors


def close_changes(mesh: TetMesh, changes: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(e,) changes nearest to given ones that add up to zero around every triangle of a solid.

    They are those of a function, and turns around the solid's handles.

    Parameters
    ----------
    changes : (e,) from the lower to the higher vertex
    known : (e,) changes known from constraints less the given ones, nan where unknown; turns around a handle, which no
        function has, are left to the solve
    """
    is_known = ~np.isnan(known)
    i, j = mesh.edges.T
    nothing = np.zeros(is_known.sum(), bool)
    links = Links(i[is_known], j[is_known], (changes + known)[is_known], nothing, nothing)
    lead, values, _ = walk_from_leads(mesh.vertex_count, links)
    names = np.unique(lead, return_inverse=True)[1]
    offsets = values[j] - values[i]

    def nearest(wanted: np.ndarray) -> np.ndarray:
        value = potential(mesh, wanted, names)
        return value[j] - value[i]

    closed = offsets + nearest(changes - offsets)
    boundary, _ = mesh.boundary_surface
    if boundary.euler_characteristic == 2 * (boundary.pieces.max() + 1):
        return closed
    handles = handle_changes(mesh, is_known)
    handles = handles - np.column_stack([nearest(column) for column in handles.T] or [handles])
    weighted = mesh.weights[:, None] * handles
    return closed + handles @ np.linalg.solve(handles.T @ weighted, weighted.T @ (changes - closed))


def known_turns(connection: Connection, fixed: Targets, merged: Merged) -> np.ndarray:
    """(c,) turns along the edges known from constraints, less those of the connection; nan where unknown.

    The value of a merged node is that of its root, turned and perhaps flipped by its transport; those of fixed nodes
    are given. So the turn along an edge is known where both ends have the same root, or are fixed. Radians in
    [-pi, pi), after a flip. The connection is on the circle, and ``fixed`` has no weights.
    """
    count = connection.node_count
    # The root of each node and its turn and flip from there; all fixed nodes have one beyond the last node.
    group = np.full(count, -1)
    turns, flips = np.zeros(count), np.zeros(count, bool)
    group[merged.roots] = merged.roots
    group[merged.nodes] = merged.roots
    turns[merged.nodes], flips[merged.nodes] = _turns_and_flips(merged.transports)
    group[fixed.nodes] = count
    turns[fixed.nodes] = np.angle(fixed.values)
    i, j = connection.edges.T
    asked, edge_flips = _turns_and_flips(connection.transports)
    is_known = (group[i] >= 0) & (group[i] == group[j])
    is_known &= (group[i] == count) | (flips[j] == flips[i] ^ edge_flips)
    turn = turns[j] - np.where(edge_flips, -turns[i], turns[i])
    return np.where(is_known, wrap(turn - asked), np.nan)


def _turns_and_flips(transports: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    matrices = as_matrices(transports)
    return np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0]), are_flips(matrices)
