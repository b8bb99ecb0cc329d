# SPDX-License-Identifier: GPL-3.0-or-later
"""Adds and removes strips of quads until a quad mesh has about as many faces as wanted.

A strip (polychord) leads from quad to quad across opposite sides, its rungs, back to its beginning or from boundary to
boundary. Halving the rungs adds as many quads as it has, and merging the ends of each rung removes them (Daniels et al.
2008); neither makes regular vertices irregular.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....geometry import TriangleMesh
from ....geometry.barycentric import barycentric
from ..features.chains import Chains
from ..measure.loops import quad_loops, twins
from ..trace.quad_mesh import QuadMesh
from .all_quads import with_vertices
from .reconnections import FEWEST, FEWEST_ON_RIM

# Largest relative error of the number of faces that is left as it is, and largest for which strips are changed.
NEAR, REACH = 0.03, 0.3
# Most changes of strips, and strips that are tried for each.
CHANGES, TRIALS = 4, 3


@dataclass(frozen=True)
class Rules:
    """What holds for vertices of a quad mesh while its strips change.

    Attributes
    ----------
    follow : puts a quad mesh onto feature lines, with its chains on them
    smooth : smooths a quad mesh with such chains
    held : tells the (n,) bool vertices of a quad mesh that stay on lines without chains
    apart : tells the (n,) bool vertices of a quad mesh that no new edge may join to one another
    """

    follow: Callable[[QuadMesh], tuple[QuadMesh, Chains | None]]
    smooth: Callable[[QuadMesh, Chains | None], QuadMesh]
    held: Callable[[QuadMesh], np.ndarray]
    apart: Callable[[QuadMesh], np.ndarray]


def may_meet(quads: QuadMesh, missing: float, wanted: float) -> bool:
    """Whether strips may bring a quad mesh, in which a number of faces is missing, near the wanted number."""
    if abs(missing) <= NEAR * wanted:
        return True
    return abs(missing) <= REACH * wanted and len(_Strips(quads).fitting(missing, wanted)) > 0


def meet_count(
    quads: QuadMesh, mesh: TriangleMesh, chains: Chains | None, wanted: float, rules: Rules
) -> tuple[QuadMesh, Chains | None]:
    """The quad mesh with strips halved or removed until it has about as many faces as wanted, and its chains.

    All faces are quads. A change is kept if the topology stays, no more vertices are irregular, and all lines are
    followed that were.
    """
    for _ in range(CHANGES):
        missing = wanted - len(quads.sizes)
        if not NEAR * wanted < abs(missing) <= REACH * wanted:
            break
        strips = _Strips(quads)
        for number in strips.fitting(missing, wanted)[:TRIALS].tolist():
            found = _change(strips, number, missing > 0, mesh, chains, rules)
            if found is not None:
                quads, chains = found
                break
        else:
            break
    return quads, chains


def _change(
    strips: "_Strips", number: int, adds: bool, mesh: TriangleMesh, chains: Chains | None, rules: Rules
) -> tuple[QuadMesh, Chains | None] | None:
    """The quad mesh with a strip halved or removed, smoothed, and its chains; None where that may not be."""
    before = strips.quads
    held, apart = rules.held(before), rules.apart(before)
    quads = strips.halved(number, mesh, held, apart) if adds else strips.removed(number, mesh, held, apart, chains)
    if quads is None or quads.is_unsound.any() or quads.euler_characteristic != before.euler_characteristic:
        return None
    if _count_irregular(quads) > _count_irregular(before):
        return None
    quads, new = rules.follow(quads)
    if chains is not None and new is not None:
        if new.lost.sum() > (1 + 1e-9) * chains.lost.sum() or new.fixed.sum() < chains.fixed.sum():
            return None
    return rules.smooth(quads, new), new


def _count_irregular(quads: QuadMesh) -> int:
    """Number of vertices inside with other than four edges, and of those on the boundary with other than three."""
    wanted = np.where(quads.on_rim, 3, 4)
    return int(np.count_nonzero(np.bincount(quads.edges[0].ravel(), minlength=len(wanted)) != wanted))


@dataclass(frozen=True)
class _Strips:
    """The strips of a quad mesh."""

    quads: QuadMesh

    @cached_property
    def _rungs(self) -> np.ndarray:
        """(c,) strip of which the side from each corner to the next is a rung; -1 for a side without a quad."""
        return quad_loops(self.quads).corner_loops

    @cached_property
    def _faces(self) -> np.ndarray:
        """(f, 4) corners of the quads among the faces."""
        return self.quads.starts[self.quads.sizes == 4, None] + np.arange(4)

    def fitting(self, missing: float, wanted: float) -> np.ndarray:
        """(k,) strips whose change brings the number of faces nearer to the wanted one, the best first.

        ``missing`` is the wanted number less the present one. Strips that bring it near enough come first. Wide
        strips are halved, and narrow ones removed. A strip that crosses itself, or ends at a face that is not
        a quad, is left out.
        """
        strips = self._rungs[self._faces][:, :2]
        count = self._rungs.max(initial=-1) + 1
        crosses = np.bincount(strips[strips[:, 0] == strips[:, 1], 0], minlength=count) > 0
        beyond = twins(self.quads)
        ends = (self._rungs >= 0) & (beyond >= 0)
        ends[ends] = self.quads.sizes[self.quads.corner_faces[beyond[ends]]] != 4
        crosses[self._rungs[ends]] = True
        lengths = np.bincount(strips.ravel(), minlength=count)
        half_edges = self.quads.vertices[self.quads.half_edges]
        logs = np.log(np.maximum(np.linalg.norm(half_edges[:, 1] - half_edges[:, 0], axis=1), 1e-300))
        sides = logs[self._faces].reshape(-1, 2, 2).sum(axis=1)
        widths = np.bincount(strips.ravel(), (sides - sides[:, ::-1]).ravel(), minlength=count) / np.maximum(lengths, 1)
        rest = np.abs(abs(missing) - lengths)
        usable = np.flatnonzero(~crosses & (lengths > 0) & ((rest <= NEAR * wanted) | (lengths < abs(missing))))
        is_far = rest[usable] > NEAR * wanted
        return usable[np.lexsort((-np.sign(missing) * widths[usable], is_far))]

    def _passed(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """(k, 4) corners of the quads of a strip, of which the first two are the ends of a rung, and (r, 2) ends of the
        rungs, the lower first."""
        corners = self.quads.corner_vertices
        first = self._rungs[self._faces] == number
        which = first[:, :2].any(axis=1)
        places = np.where(first[which, :1], self._faces[which], np.roll(self._faces[which], -1, axis=1))
        quads = corners[places]
        return quads, np.unique(np.sort(quads.reshape(-1, 2), axis=1), axis=0)

    def _others(self, number: int) -> np.ndarray:
        """(f,) bool: faces that are not on a strip."""
        result = np.ones(len(self.quads.sizes), bool)
        result[self.quads.corner_faces[self._rungs == number]] = False
        return result

    def halved(self, number: int, mesh: TriangleMesh, held: np.ndarray, apart: np.ndarray) -> QuadMesh | None:
        """The quad mesh with a strip halved; None where a rung would leave a line, or join what must stay apart."""
        quads, (faces, rungs) = self.quads, self._passed(number)
        if held[rungs].all(axis=1).any() or apart[faces].all(axis=1).any():
            return None
        count = len(quads.vertices)
        normals = mesh.face_normals[quads.triangles[rungs]].sum(axis=1)
        places = quads.vertices[rungs]
        quads = with_vertices(quads, mesh, places.mean(axis=1), normals, places)
        names = np.sort(faces.reshape(-1, 2), axis=1) @ [count, 1]
        a, b, c, d = faces.T
        near, far = (count + np.searchsorted(rungs @ [count, 1], names)).reshape(-1, 2).T
        stays = self._others(number)
        new = np.concatenate([np.column_stack([a, near, far, d]), np.column_stack([near, b, c, far])])
        corners = quads.corner_vertices[stays[quads.corner_faces]]
        sizes = np.append(quads.sizes[stays], np.full(len(new), 4))
        return quads.with_faces(np.append(corners, new), sizes)

    def removed(
        self, number: int, mesh: TriangleMesh, held: np.ndarray, apart: np.ndarray, chains: Chains | None
    ) -> QuadMesh | None:
        """The quad mesh without a strip; None where vertices would meet that must not, or get too few edges.

        Of the ends of a rung one that lies on a line stays in place, otherwise both meet in the middle.
        """
        quads, (_, rungs) = self.quads, self._passed(number)
        edges, counts = quads.edges
        on_rim, size = quads.on_rim, len(quads.vertices)
        faces_at = counts[np.searchsorted(edges @ [size, 1], rungs @ [size, 1])]
        fixed = np.zeros(size, bool) if chains is None else chains.fixed
        on_lines = held if chains is None else held | fixed | (chains.lines >= 0)
        valences = np.bincount(edges.ravel(), minlength=size)[rungs].sum(axis=1) - 2 - faces_at
        wrong = (
            (len(np.unique(rungs)) < rungs.size)
            | (on_rim[rungs].all(axis=1) & (faces_at == 2))
            | fixed[rungs].all(axis=1)
            | held[rungs].all(axis=1)
            | (apart[rungs].any(axis=1) & (faces_at == 2))
            | (valences < np.where(on_rim[rungs].any(axis=1), FEWEST_ON_RIM, FEWEST))
        )
        if wrong.any():
            return None
        ranks = (4 * fixed + 2 * on_lines + 1 * on_rim)[rungs]
        order = np.argsort(-ranks, axis=1, kind="stable")
        kept, gone = np.take_along_axis(rungs, order, axis=1).T
        names = np.arange(size)
        names[gone] = kept
        equal = kept[ranks[:, 0] == ranks[:, 1]]
        middles = quads.vertices[rungs[ranks[:, 0] == ranks[:, 1]]].mean(axis=1)
        places, triangles = mesh.finder.nearest_facing(middles, mesh.face_normals[quads.triangles[equal]])
        quads = quads.moved(equal, places, triangles, barycentric(mesh, triangles, places))
        stays = self._others(number)
        return quads.with_faces(names[quads.corner_vertices[stays[quads.corner_faces]]], quads.sizes[stays])
