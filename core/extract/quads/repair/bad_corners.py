# SPDX-License-Identifier: GPL-3.0-or-later
"""Mends corners of a quad mesh that moving vertices cannot mend.

Where a line, the boundary or a disclination forces a vertex with one face too few on a side, that face has a straight
corner there; where it forces one face too many, a narrow one. The faces around are reconnected in several ways, each is
smoothed, and the best one is taken.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ....geometry import TriangleMesh
from ..features.chains import Chains
from ..measure.quality import corner_angles, worst_deviations
from ..smooth.fitting import fit_quads, sliding_lines
from ..smooth.patches import Ground, faces_near
from ..smooth.worst_corners import move_worst_corners
from ..trace.quad_mesh import QuadMesh
from .reconnections import Patch

# Deviation from a right angle, in degrees, above which a corner is bad, and below which it is good.
BAD, GOOD = 60.0, 45.0
# What an irregular vertex costs, and by how much a patch must improve, in degrees beyond good corners.
IRREGULAR, GAIN = 7.0, 10.0
# Rings of faces around a bad one that are smoothed with it, and rounds of smoothing.
RINGS, SMOOTHING = 2, 5
# Ways to reconnect faces that are tried: those that leave the most regular vertices.
MOST = 3
# Rounds over all bad faces.
ROUNDS = 6


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
    given, tried = quads, set[tuple[int, bytes, bytes]]()
    alone = np.isin(np.arange(len(free)), np.asarray(apart, int))
    for _ in range(ROUNDS):
        around, changed = _Surroundings.of(quads, mesh, free, chains, alone), np.zeros(len(quads.vertices), bool)
        parts: list[_Part] = []
        for number in _bad_faces(quads):
            part = around.part(number)
            if part is not None and part.key not in tried and not changed[part.vertices].any():
                changed[part.vertices] = True
                parts.append(part)
        if not parts:
            break
        better = _improve(parts, mesh, chains)
        tried |= {part.key for part, new in zip(parts, better, strict=True) if new is None}
        done = [(part, new) for part, new in zip(parts, better, strict=True) if new is not None]
        quads = _put_in(quads, done) if done else quads
    if quads is given:
        return quads, np.arange(len(free))
    return quads.with_faces(quads.corner_vertices, quads.sizes), np.unique(quads.corner_vertices)


def _bad_faces(quads: QuadMesh) -> list[int]:
    """Quads with bad corners, the worst first."""
    offs = worst_deviations(quads)
    bad = np.flatnonzero((offs > BAD) & (quads.sizes == 4))
    return bad[np.argsort(-offs[bad], kind="stable")].tolist()


@dataclass(frozen=True)
class _Part:
    """Quads around a bad one as a mesh of their own.

    Attributes
    ----------
    faces, vertices : their numbers in the whole mesh
    free : (n,) bool, vertices that may move
    bad : number of the bad face in the part
    below : (s, 3) points of the surface below
    """

    quads: QuadMesh
    patch: Patch
    faces: np.ndarray
    vertices: np.ndarray
    free: np.ndarray
    bad: int
    below: np.ndarray

    @property
    def key(self) -> tuple[int, bytes, bytes]:
        """Equal for equal parts."""
        return self.bad, self.vertices.tobytes(), self.quads.vertices.tobytes()

    def ways(self) -> list[Patch]:
        """Ways to reconnect the bad face that change the number of edges at its worst corner as it needs, or collapse
        it, and all where it is folded; those that leave the most regular vertices first."""
        angles = corner_angles(self.quads).reshape(-1, 4)[self.bad]
        place = int(np.abs(angles - 90).argmax())
        worst, wanted = self.patch.faces[self.bad, place], 1 if angles[place] > 90 else -1
        fitting = [
            way
            for way in self.patch.reconnected(self.bad)
            if angles[place] > 180
            or len(way.faces) < len(self.patch.faces)
            or way.valences[worst] == self.patch.valences[worst] + wanted
        ]
        return sorted(fitting, key=lambda way: int((way.surpluses**2).sum()))[:MOST]


@dataclass(frozen=True)
class _Surroundings:
    """A quad mesh on a surface, from which parts are taken.

    Attributes
    ----------
    ground : the surface below
    patch : what is known of all vertices, without faces
    free : (n,) bool, vertices that may move
    """

    quads: QuadMesh
    ground: Ground
    patch: Patch
    free: np.ndarray

    @classmethod
    def of(
        cls, quads: QuadMesh, mesh: TriangleMesh, free: np.ndarray, chains: Chains | None, apart: np.ndarray
    ) -> "_Surroundings":
        valences = np.bincount(quads.edges[0].ravel(), minlength=len(quads.vertices))
        held = ~free if chains is None else ~free | chains.fixed
        patch = Patch(np.empty((0, 4), int), valences, quads.on_rim, sliding_lines(free, chains), held, apart)
        return cls(quads, Ground.of(mesh, quads), patch, free)

    def part(self, number: int) -> _Part | None:
        """The faces around a bad one; None if some are no quads."""
        quads = self.quads
        of_corners, corners = quads.corner_faces, quads.corner_vertices
        inside = np.arange(len(quads.sizes)) == number
        near = np.zeros(len(quads.vertices), bool)
        for _ in range(RINGS):
            near[corners[inside[of_corners]]] = True
            inside[of_corners[near[corners]]] = True
        if (quads.sizes[inside] != 4).any():
            return None
        part, vertices, faces = quads.only(inside), np.unique(corners[inside[of_corners]]), np.flatnonzero(inside)
        patch = self.patch.of_vertices(part.corner_vertices.reshape(-1, 4), vertices)
        free = self.free.copy()
        free[corners[~inside[of_corners]]] = False
        below = self.ground.samples[inside[self.ground.near[:, 0]]]
        return _Part(part, patch, faces, vertices, free[vertices], int(np.searchsorted(faces, number)), below)


def _improve(parts: list[_Part], mesh: TriangleMesh, chains: Chains | None) -> list[QuadMesh | None]:
    """Each part, reconnected and smoothed, with the best corners; None if it does not improve enough."""
    before = [worst_deviations(part.quads) for part in parts]
    least = [_cost(offs, part.patch) - GAIN for offs, part in zip(before, parts, strict=True)]
    found: list[QuadMesh | None] = [None] * len(parts)
    trials = [(number, way) for number, part in enumerate(parts) for way in part.ways()]
    for (number, way), quads in zip(trials, _smooth([(parts[k], way) for k, way in trials], mesh, chains), strict=True):
        after = worst_deviations(quads)
        cost = _cost(after, way)
        if after.max() <= before[number].max() and cost < least[number]:
            least[number], found[number] = cost, quads
    return found


def _smooth(trials: list[tuple[_Part, Patch]], mesh: TriangleMesh, chains: Chains | None) -> list[QuadMesh]:
    """Parts with other faces, smoothed at once; none depends on another."""
    if not trials:
        return []
    parts, ways = zip(*trials, strict=True)
    sizes, faces = [len(part.vertices) for part in parts], [len(way.faces) for way in ways]
    starts = np.cumsum(sizes) - sizes
    together = QuadMesh(
        np.concatenate([part.quads.vertices for part in parts]),
        np.concatenate([part.quads.triangles for part in parts]),
        np.concatenate([part.quads.weights for part in parts]),
        np.concatenate([way.faces.ravel() + start for way, start in zip(ways, starts, strict=True)]),
        np.full(sum(faces), 4),
    )
    moving = np.concatenate([part.free & (way.valences > 0) for part, way in trials])
    groups = np.repeat(np.arange(len(parts)), sizes)
    own = None if chains is None else chains.of_vertices(np.concatenate([part.vertices for part in parts]), groups)
    together = fit_quads(together, mesh, moving, SMOOTHING, own)
    near = [
        faces_near(quads, part.below) + first
        for quads, part, first in zip(_split(together, sizes, ways), parts, np.cumsum(faces) - faces, strict=True)
    ]
    ground = Ground(mesh, np.concatenate([part.below for part in parts]), together, np.concatenate(near))
    return _split(move_worst_corners(together, mesh, moving, own, ground), sizes, ways)


def _split(together: QuadMesh, sizes: list[int], ways: Sequence[Patch]) -> list[QuadMesh]:
    """Parts that were put together, with these numbers of vertices and these faces."""
    ends = np.cumsum(sizes)[:-1]
    arrays = (np.split(values, ends) for values in (together.vertices, together.triangles, together.weights))
    return [
        QuadMesh(places, triangles, weights, way.faces.ravel(), np.full(len(way.faces), 4))
        for places, triangles, weights, way in zip(*arrays, ways, strict=True)
    ]


def _cost(offs: np.ndarray, patch: Patch) -> float:
    """Degrees by which faces are worse than good ones, and what irregular vertices cost."""
    return float(np.maximum(offs - GOOD, 0).sum()) + IRREGULAR * int((patch.surpluses != 0).sum())


def _put_in(quads: QuadMesh, parts: list[tuple[_Part, QuadMesh]]) -> QuadMesh:
    """The quad mesh on the same vertices, moved, with the faces of parts instead of those that they replace."""
    vertices, triangles, weights = quads.vertices.copy(), quads.triangles.copy(), quads.weights.copy()
    stays = np.ones(len(quads.sizes), bool)
    for part, new in parts:
        stays[part.faces] = False
        vertices[part.vertices], triangles[part.vertices] = new.vertices, new.triangles
        weights[part.vertices] = new.weights
    corners = [part.vertices[new.corner_vertices] for part, new in parts]
    sizes = [new.sizes for _, new in parts]
    return QuadMesh(
        vertices,
        triangles,
        weights,
        np.concatenate([quads.corner_vertices[stays[quads.corner_faces]], *corners]),
        np.concatenate([quads.sizes[stays], *sizes]),
    )
