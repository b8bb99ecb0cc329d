# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed grid lines: the changes across a walk around a limb or a handle add up to zero.

A grid line that comes back k quads beside its beginning spirals, since the target changes c across it add up to about
k pi around the walk: r . c, with r the row of the sum. That the sum is 0 is one linear condition. The nearest changes
without curl that meet conditions R c = 0 are

    c + D^T mu,    (R D^T) mu = -R c,    d = G (r - C^T y),    C G C^T y = C G r,

where C sums changes around the faces, G has the inverse weights of the edges (:mod:`.curl_removal`), and the rows d of
D are the projections of the rows r of R to changes without curl. The cost of the conditions is the sum of the squares
of the added changes, each divided by G; it equals v^T (R D^T)^-1 v with v = R c. With mirrors, d is averaged with its
images.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix, diags_array
from scipy.sparse.csgraph import dijkstra

from ..algebra.factorization import factorize
from ..geometry.triangle_mesh import TriangleMesh
from ..matchings import after_turns
from .curl_removal import SHIFT, SMALLEST_WEIGHT, known_turns, removable_rows, surface_circulation
from .mirror import Mirror, Reflection
from .patterns import Pattern
from .target_one_form import TargetOneForm

if TYPE_CHECKING:
    from ..extract.quads.trace.quad_mesh import QuadMesh

# A condition counts as new where at least this share of it is independent of the conditions before it.
INDEPENDENT = 1e-2
# A projection smaller than this share of its row is a rounding error: constraints fix all changes across the walk.
FREE = 1e-6
# The largest difference between sums along the mesh's edges and the quads that the walk passes, in quads.
SAME_WALK = 0.4


@dataclass(frozen=True)
class Condition:
    """The condition that a walk closes.

    Attributes
    ----------
    row : (2 e,) r
    change : (2 e,) d
    """

    row: np.ndarray
    change: np.ndarray


def _gram(conditions: Sequence[Condition]) -> np.ndarray:
    """(k, k) R D^T of the conditions."""
    return np.array([[a.row @ b.change for b in conditions] for a in conditions]).reshape(2 * (len(conditions),))


def cosines(conditions: Sequence[Condition]) -> np.ndarray:
    """(k, k) cosines of the angles between the changes of conditions, weighted by 1 / G."""
    gram = _gram(conditions)
    lengths = np.sqrt(gram.diagonal())
    return gram / np.outer(lengths, lengths)


class LoopClosing:
    """Conditions that loops close, on the changes of a quad pattern with a branching of 0 and its mirrors."""

    def __init__(self, pattern: Pattern, mirrors: Sequence[Reflection] = ()) -> None:
        self._one_form = one_form = pattern.one_form
        self._changes = one_form.changes.ravel()
        self._inverse_weights = 1 / np.maximum(np.repeat(one_form.mesh.weights, 2), SMALLEST_WEIGHT)
        assert pattern.problem is not None
        fixed, merged = pattern.problem.fixed, pattern.problem.merged
        # Changes that constraints fix cannot be corrected.
        self._inverse_weights[~np.isnan(known_turns(one_form.connection, fixed, merged))] = 0
        circulation, _ = surface_circulation(one_form.mesh, one_form.matchings, 2)
        self._flow = (diags_array(self._inverse_weights) @ circulation.matrix.T).tocsr()
        laplacian = (circulation.matrix @ self._flow).tocsr()
        self._rows = removable_rows(circulation, self._inverse_weights > 0, laplacian)
        self._circulation = circulation.matrix[self._rows]
        self._factor = None
        if len(self._rows):
            own = laplacian[self._rows][:, self._rows]
            self._factor = factorize(own + SHIFT * diags_array(own.diagonal()), single=False)
        self._mirrors = [_ChangeMirror(one_form, mirror) for mirror in mirrors if isinstance(mirror, Mirror)]

    def _project(self, row: np.ndarray) -> np.ndarray:
        """(2 e,) change d of a row r."""
        change = self._inverse_weights * row
        for mirror in self._mirrors:
            change = (change + mirror.reflect(change)) / 2
        if self._factor is None:
            return change
        around = np.zeros(self._flow.shape[1])
        around[self._rows] = self._factor.solve(self._circulation @ change)
        return change - self._flow @ around

    def condition(self, walk: np.ndarray, reached: np.ndarray, steps: int, aside: int) -> Condition | None:
        """The condition that a walk closes; None where it passes other quads on the mesh's edges, and where constraints
        fix all changes across it.

        Parameters
        ----------
        walk : (v,) vertices of the mesh, the last of which is the first
        reached : (e, 2) changes of the pattern
        steps, aside : quads that the walk passes straight on and sideways
        """
        rows = self._sums(walk)
        if rows is None:
            return None
        quads = np.abs(rows @ reached.ravel()) / np.pi
        across = int(np.argmin(np.abs(quads - aside) + np.abs(quads[::-1] - steps)))
        if abs(quads[across] - aside) > SAME_WALK or abs(quads[1 - across] - steps) > SAME_WALK:
            return None
        row = rows[across]
        change = self._project(row)
        return Condition(row, change) if row @ change > FREE * (row @ (self._inverse_weights * row)) else None

    def _sums(self, walk: np.ndarray) -> np.ndarray | None:
        """(2, 2 e) rows of the sums of changes along a closed walk, for both phases of its first vertex; None where
        the phases are exchanged or reversed around it."""
        mesh, matchings = self._one_form.mesh, self._one_form.matchings
        tails, heads = walk[:-1], walk[1:]
        edges, forward = mesh.edges_between(tails, heads), tails < heads
        matched = np.where(forward, 1, -1) * matchings[edges]
        turns = np.cumsum(matched)
        if len(turns) == 0 or turns[-1] % 4:
            return None
        before = np.where(forward, turns - matched, turns)
        parts = after_turns(np.broadcast_to(np.eye(2), (len(edges), 2, 2)), -before[:, None])
        parts = np.where(forward, 1.0, -1.0)[:, None, None] * parts
        rows = np.zeros((2, len(mesh.edges), 2))
        for phase in range(2):
            np.add.at(rows[phase], edges, parts[:, :, phase])
        return rows.reshape(2, -1)

    def correction(self, conditions: Sequence[Condition], sums: float | np.ndarray = 0.0) -> tuple[np.ndarray, float]:
        """The (e, 2) correction of the changes that meets all conditions, (k,) sums in place of 0, and its cost."""
        if not conditions:
            return np.zeros((len(self._one_form.mesh.edges), 2)), 0.0
        missing = sums - self._values(conditions)
        shares = np.linalg.lstsq(_gram(conditions), missing, rcond=1e-8)[0]
        changes = (share * condition.change for share, condition in zip(shares, conditions, strict=True))
        return sum(changes, np.zeros(len(self._changes))).reshape(-1, 2), float(missing @ shares)

    def _values(self, conditions: Sequence[Condition]) -> np.ndarray:
        """(k,) sums v of the target changes."""
        return np.array([condition.row @ self._changes for condition in conditions])

    def choose(
        self,
        held: Sequence[Condition],
        candidates: Sequence[Condition],
        gains: Sequence[float],
        price: float,
        most: float,
    ) -> list[int]:
        """Numbers of the (k,) candidates to add to the conditions that are held, in the order of their choice.

        Each time it is the candidate with the largest gain minus price times cost, as long as that is positive. All
        together cost at most ``most``.
        """
        both = [*held, *candidates]
        if not both:
            return []
        gram, values = _gram(both), self._values(both)
        own = gram.diagonal().copy()
        chosen: list[int] = []

        def hold(number: int) -> None:
            """Eliminate a condition from the others by a Gaussian step."""
            share = gram[:, number] / gram[number, number]
            values[:] -= share * values[number]
            gram[:] -= np.outer(share, gram[number])

        count = len(held)
        for number in range(count):
            if gram[number, number] > INDEPENDENT * own[number]:
                hold(number)
        left = set(range(count, len(both)))
        while left:
            free = [k for k in left if gains[k - count] > 0 and gram[k, k] > INDEPENDENT * own[k]]
            costs = [values[k] ** 2 / gram[k, k] for k in free]
            worth = [
                gains[k - count] - price * cost if cost <= most else 0.0 for k, cost in zip(free, costs, strict=True)
            ]
            if not free or max(worth) <= 0:
                break
            place = int(np.argmax(worth))
            number, most = free[place], most - costs[place]
            hold(number)
            left.remove(number)
            chosen.append(number - count)
        return chosen


class _ChangeMirror:
    """Reflects changes of a target one-form of two phases."""

    def __init__(self, one_form: TargetOneForm, mirror: Mirror) -> None:
        # Phase l of a vertex is plus or minus phase phases[l] of its partner.
        directions = mirror.mirrored_directions(one_form)
        self._phases, self._signs = directions % 2, np.where(directions < 2, 1.0, -1.0)
        mesh = one_form.mesh
        ends = mirror.partner[mesh.edges]
        found = np.minimum(mesh.edges_between(*ends.T), len(mesh.edges) - 1)
        # Diagonals of faces need not be mirrored.
        self._rows = np.flatnonzero((mesh.edges[found] == np.sort(ends, axis=1)).all(axis=1))
        self._edges, self._tails = found[self._rows], mesh.edges[self._rows, 0]
        self._forward = (ends[:, 0] < ends[:, 1])[self._rows]
        self._matchings = one_form.matchings[self._edges]

    def reflect(self, changes: np.ndarray) -> np.ndarray:
        """The mirror image of (2 e,) changes; an edge that is not the image of an edge keeps its change."""
        result = changes.reshape(-1, 2).copy()
        moved, image = result[self._rows], np.zeros((len(self._rows), 2))
        phases, signs = self._phases[self._tails], self._signs[self._tails]
        np.put_along_axis(image, phases, signs * moved, axis=1)
        # Where the image of an edge runs backward, its change is given in the phases of the edge's end.
        backward = -after_turns(image, -self._matchings)
        result[self._edges] = np.where(self._forward[:, None], image, backward)
        return result.ravel()


class MeshWalks:
    """Walks along a mesh's edges near walks on a quad mesh."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh = mesh

    @cached_property
    def _graph(self) -> csr_matrix:
        i, j = self._mesh.edges.T
        count, lengths = self._mesh.vertex_count, self._mesh.edge_lengths
        graph = csr_matrix((lengths, (i, j)), shape=(count, count))
        return graph + graph.T

    def near(self, quads: "QuadMesh", walk: np.ndarray) -> np.ndarray:
        """(v,) vertices of the mesh along a closed walk over vertices of a quad mesh that lies on it."""
        corners = self._mesh.triangles[quads.triangles[walk]]
        nearest = corners[np.arange(len(walk)), quads.weights[walk].argmax(axis=1)]
        nearest = nearest[np.append(True, nearest[1:] != nearest[:-1])]
        result = [nearest[:1]]
        for tail, head in pairwise(nearest):
            result.append(self._walk_greedily(tail, head))
        return np.concatenate(result)

    def _walk_greedily(self, tail: int, head: int) -> np.ndarray:
        """The vertices of a walk after its first, always to the neighbour nearest to the end, or of a shortest walk."""
        vertices, graph = self._mesh.vertices, self._graph
        way = [tail]
        while way[-1] != head:
            near = graph.indices[graph.indptr[way[-1]] : graph.indptr[way[-1] + 1]]
            distances = np.linalg.norm(vertices[near] - vertices[head], axis=1)
            if distances.min() >= np.linalg.norm(vertices[way[-1]] - vertices[head]):
                return self._walk_shortest(tail, head)
            way.append(near[distances.argmin()])
        return np.array(way[1:], int)

    def _walk_shortest(self, tail: int, head: int) -> np.ndarray:
        _, before = dijkstra(self._graph, indices=head, return_predecessors=True)
        way = [tail]
        while way[-1] != head:
            way.append(before[way[-1]])
        return np.array(way[1:], int)
