# SPDX-License-Identifier: GPL-3.0-or-later
"""Mends corners of a quad mesh that moving vertices cannot mend.

Where a line, the boundary or a disclination forces a vertex with one face too few on a side, that face has a straight
corner there; where it forces one face too many, a narrow one. The faces around are reconnected in several ways, each is
smoothed, and the best one is taken.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ....geometry import TriangleMesh
from ..features.chains import Chains
from ..measure.quality import corner_angles
from ..smooth.fitting import fit_quads
from ..smooth.patches import Ground
from ..smooth.worst_corners import move_worst_corners
from ..trace.quad_mesh import QuadMesh
from .reconnections import Patch

# Corners that deviate more than this from a right angle are bad, and those that deviate less than this are good, in
# degrees.
BAD, GOOD = 60.0, 45.0
# What an irregular vertex costs, and by how much a patch must improve, in degrees beyond good corners.
IRREGULAR, GAIN = 7.0, 10.0
# Rings of faces around a bad one that are smoothed with it, and rounds of smoothing.
RINGS, SMOOTHING = 2, 8
# Ways to reconnect faces that are tried: those that leave the most regular vertices.
MOST = 4
# Rounds over all bad faces.
ROUNDS = 4


def mend_bad_corners(
    quads: QuadMesh, mesh: TriangleMesh, free: np.ndarray, chains: Chains | None = None, apart: ArrayLike = ()
) -> tuple[QuadMesh, np.ndarray]:
    """The quad mesh with faces reconnected around bad corners, and (k,) the vertices that were kept, in their order.

    Edges between vertices that are held or on lines stay.

    Parameters
    ----------
    mesh : the surface
    free : (n,) bool, vertices that may move
    chains : on whose lines vertices slide
    apart : vertices that no new edge may join to one another
    """
    held = ~free if chains is None else ~free | chains.fixed
    lines = np.full(len(free), -1) if chains is None else np.where(free, chains.lines, -1)
    alone = np.zeros(len(free), bool)
    alone[np.asarray(apart, int)] = True
    given, tried = quads, set[tuple[int, bytes, bytes]]()
    for _ in range(ROUNDS):
        offs = worst_deviations(quads)
        bad = np.flatnonzero((offs > BAD) & (quads.sizes == 4))
        if len(bad) == 0:
            break
        places, changed = _Places(quads, mesh, Ground.of(mesh, quads)), np.zeros(len(quads.vertices), bool)
        new: list[tuple[np.ndarray, QuadMesh]] = []
        for number in bad[np.argsort(-offs[bad], kind="stable")].tolist():
            part = places.around(number)
            if part is None or changed[part.vertices].any() or part.key in tried:
                continue
            own = part.vertices
            sliding = None if chains is None else chains.of_vertices(own)
            patch = Patch(part.corners, *(of[own] for of in (places.valences, places.on_rim, lines, held, alone)))
            better = _best(part, patch, mesh, free[own] & ~part.on_border, sliding)
            if better is None:
                tried.add(part.key)
            else:
                changed[own] = True
                new.append((part.faces, replace(better, corner_vertices=own[better.corner_vertices])))
                quads = _with_vertices(quads, own, better)
        if not new:
            break
        quads = _with_faces(quads, new)
    if quads is given:
        return quads, np.arange(len(free))
    return quads.with_faces(quads.corner_vertices, quads.sizes), np.unique(quads.corner_vertices)


def worst_deviations(quads: QuadMesh) -> np.ndarray:
    """(f,) the largest deviation of each face's corners from a right angle, in degrees."""
    return np.maximum.reduceat(np.abs(corner_angles(quads) - 90), quads.starts)


@dataclass(frozen=True)
class _Part:
    """Quads around a bad one as a mesh of their own.

    Attributes
    ----------
    faces, vertices : their numbers in the whole mesh
    on_border : (n,) bool, vertices of other faces, too
    bad : number of the bad face in the part
    ground : the surface below
    """

    quads: QuadMesh
    faces: np.ndarray
    vertices: np.ndarray
    on_border: np.ndarray
    bad: int
    ground: Ground

    @property
    def corners(self) -> np.ndarray:
        """(f, 4) vertices of the part."""
        return self.quads.corner_vertices.reshape(-1, 4)

    @property
    def key(self) -> tuple[int, bytes, bytes]:
        """Equal for equal parts."""
        return self.bad, self.vertices.tobytes(), self.quads.vertices.tobytes()


class _Places:
    """Parts of a quad mesh on a surface."""

    def __init__(self, quads: QuadMesh, mesh: TriangleMesh, ground: Ground) -> None:
        self._quads, self._mesh, self._ground = quads, mesh, ground
        self.valences, self.on_rim = np.bincount(quads.edges[0].ravel(), minlength=len(quads.vertices)), quads.on_rim

    def around(self, number: int) -> _Part | None:
        """The faces around a bad one; None if some are no quads."""
        quads = self._quads
        of_corners, corners = quads.corner_faces, quads.corner_vertices
        inside = np.arange(len(quads.sizes)) == number
        near = np.zeros(len(quads.vertices), bool)
        for _ in range(RINGS):
            near[corners[inside[of_corners]]] = True
            inside[of_corners[near[corners]]] = True
        if (quads.sizes[inside] != 4).any():
            return None
        part, vertices = quads.only(inside), np.unique(corners[inside[of_corners]])
        on_border = np.zeros(len(quads.vertices), bool)
        on_border[corners[~inside[of_corners]]] = True
        below = self._ground.samples[inside[self._ground.near[:, 0]]]
        faces = np.flatnonzero(inside)
        bad = int(np.searchsorted(faces, number))
        return _Part(part, faces, vertices, on_border[vertices], bad, Ground(self._mesh, below, part))


def _best(part: _Part, patch: Patch, mesh: TriangleMesh, free: np.ndarray, chains: Chains | None) -> QuadMesh | None:
    """The part, reconnected and smoothed, with the best corners; None if it does not improve enough."""
    before = worst_deviations(part.quads)
    best, found = _cost(before, patch) - GAIN, None
    ways = sorted(_ways(part, patch), key=lambda way: int((way.surpluses**2).sum()))
    for way in ways[:MOST]:
        quads = replace(part.quads, corner_vertices=way.faces.ravel(), sizes=np.full(len(way.faces), 4))
        moving = free & (way.valences > 0)
        quads = fit_quads(quads, mesh, moving, SMOOTHING, chains)
        quads = move_worst_corners(quads, mesh, moving, chains, replace(part.ground, quads=quads))
        after = worst_deviations(quads)
        if after.max() <= before.max() and _cost(after, way) < best:
            best, found = _cost(after, way), quads
    return found


def _ways(part: _Part, patch: Patch) -> list[Patch]:
    """The patch reconnected in ways that change the number of edges at the worst corner as it needs, or collapsed."""
    angles = corner_angles(part.quads).reshape(-1, 4)[part.bad]
    place = int(np.abs(angles - 90).argmax())
    worst = int(part.corners[part.bad, place])
    ways = patch.reconnected(part.bad)
    wanted = 1 if angles[place] > 90 else -1
    return [
        way
        for way in ways
        if len(way.faces) < len(patch.faces) or way.valences[worst] - patch.valences[worst] == wanted
    ]


def _cost(offs: np.ndarray, patch: Patch) -> float:
    """Degrees by which faces are worse than good ones, and what irregular vertices cost."""
    return float(np.maximum(offs - GOOD, 0).sum()) + IRREGULAR * int((patch.surpluses != 0).sum())


def _with_vertices(quads: QuadMesh, which: np.ndarray, part: QuadMesh) -> QuadMesh:
    """The quad mesh with vertices where those of a part are."""
    vertices, triangles, weights = quads.vertices.copy(), quads.triangles.copy(), quads.weights.copy()
    vertices[which], triangles[which], weights[which] = part.vertices, part.triangles, part.weights
    return replace(quads, vertices=vertices, triangles=triangles, weights=weights)


def _with_faces(quads: QuadMesh, parts: list[tuple[np.ndarray, QuadMesh]]) -> QuadMesh:
    """The quad mesh on the same vertices with faces of parts instead of those that they replace."""
    stays = np.ones(len(quads.sizes), bool)
    for faces, _ in parts:
        stays[faces] = False
    corners = [quads.corner_vertices[stays[quads.corner_faces]], *(part.corner_vertices for _, part in parts)]
    sizes = [quads.sizes[stays], *(part.sizes for _, part in parts)]
    return replace(quads, corner_vertices=np.concatenate(corners), sizes=np.concatenate(sizes))
