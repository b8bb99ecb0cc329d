# SPDX-License-Identifier: GPL-3.0-or-later
"""Mends corners of a quad mesh that moving vertices cannot mend, and joins irregular vertices.

Where a line, the boundary or a disclination forces a vertex with one face too few on a side, that face has a straight
corner there; where it forces one face too many, a narrow one. The faces around are reconnected in several ways, each is
smoothed, and the best one is taken. Then the same is tried where a face has several irregular vertices, with ways that
leave fewer.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ....geometry import TriangleMesh
from ....graphs import ragged_arange
from ..features.chains import Chains
from ..measure.quality import corner_angles, worst_deviations
from ..smooth.fitting import fit_quads, sliding_lines
from ..smooth.patches import Ground, faces_near, squares_to_faces
from ..smooth.worst_corners import NEAR, move_worst_corners
from ..trace.quad_mesh import QuadMesh
from .reconnections import Patch

# Deviation from a right angle, in degrees, above which a corner is bad, and below which it is good.
BAD, GOOD = 60.0, 45.0
# What an irregular vertex costs, and by how much a patch must improve at bad corners, in degrees beyond good corners.
IRREGULAR, GAIN = 7.0, 10.0
# Rings of faces around a bad one that are smoothed with it, rounds of smoothing, and steps of descent.
RINGS, SMOOTHING, STEPS = 2, 5, 12
# Ways to reconnect faces that are tried: those that leave the most regular vertices.
MOST = 2
# Most rounds over all bad faces, and over all faces with several irregular vertices.
ROUNDS, IRREGULAR_ROUNDS = 6, 3


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
    given, alone = quads, np.isin(np.arange(len(free)), np.asarray(apart, int))
    at_corners, at_vertices = (
        (_bad_faces, _Part.ways, GAIN, ROUNDS),
        (_irregular_faces, _Part.regular_ways, 0.0, IRREGULAR_ROUNDS),
    )
    for find, ways_of, gain, rounds in (at_corners, at_vertices):
        tried = set[tuple[int, bytes, bytes]]()
        for _ in range(rounds):
            around, changed = _Surroundings.of(quads, mesh, free, chains, alone), np.zeros(len(quads.vertices), bool)
            parts: list[_Part] = []
            ways: list[list[Patch]] = []
            for number in find(quads):
                part = around.part(number)
                if part is None or part.key in tried or changed[part.vertices].any():
                    continue
                if not (found := ways_of(part)):
                    tried.add(part.key)
                    continue
                changed[part.vertices] = True
                parts.append(part)
                ways.append(found)
            if not parts:
                break
            better = _improve(parts, ways, gain, mesh, chains)
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


def _irregular_faces(quads: QuadMesh) -> list[int]:
    """Quads with several irregular vertices inside the mesh, those with most first."""
    numbers = np.bincount(quads.corner_faces, quads.is_irregular[quads.corner_vertices])
    several = np.flatnonzero((numbers > 1) & (quads.sizes == 4))
    return several[np.argsort(-numbers[several], kind="stable")].tolist()


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
        return _most_regular(fitting)

    def regular_ways(self) -> list[Patch]:
        """Ways to reconnect the face that leave fewer irregular vertices."""
        number = np.count_nonzero(self.patch.surpluses)
        ways = self.patch.reconnected(self.bad)
        return _most_regular([way for way in ways if np.count_nonzero(way.surpluses) < number])


def _most_regular(ways: list[Patch]) -> list[Patch]:
    """The :data:`MOST` patches with the most regular vertices, these first."""
    return sorted(ways, key=lambda way: int((way.surpluses**2).sum()))[:MOST]


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
        quads, corners = self.quads, self.quads.corner_vertices
        inside = np.array([number])
        for _ in range(RINGS):
            inside = self._at_vertices(np.unique(corners[self._corners_of(inside)]))
        if (quads.sizes[inside] != 4).any():
            return None
        vertices, own = np.unique(corners[self._corners_of(inside)], return_inverse=True)
        faces = own.reshape(-1, 4)
        part = QuadMesh(
            quads.vertices[vertices], quads.triangles[vertices], quads.weights[vertices], own, quads.sizes[inside]
        )
        patch = self.patch.of_vertices(faces, vertices)
        # Vertices with faces outside stay.
        free = self.free[vertices] & (np.bincount(own) == np.diff(self._starts)[vertices])
        rows, places = ragged_arange(np.diff(self._first_samples)[inside])
        below = self.ground.samples[self._samples[self._first_samples[inside][rows] + places]]
        return _Part(part, patch, inside, vertices, free, int(np.searchsorted(inside, number)), below)

    def _corners_of(self, faces: np.ndarray) -> np.ndarray:
        """(c,) corners of (f,) faces, face by face."""
        rows, places = ragged_arange(self.quads.sizes[faces])
        return self._first_corners[faces][rows] + places

    def _at_vertices(self, vertices: np.ndarray) -> np.ndarray:
        """(f,) ascending faces at some vertices."""
        rows, places = ragged_arange(np.diff(self._starts)[vertices])
        return np.unique(self._faces[self._starts[vertices][rows] + places])

    @cached_property
    def _first_corners(self) -> np.ndarray:
        """(f,) first corner of each face."""
        return self.quads.starts

    @cached_property
    def _faces(self) -> np.ndarray:
        """(c,) face of each corner, in the order of the corners' vertices."""
        return self.quads.corner_faces[np.argsort(self.quads.corner_vertices, kind="stable")]

    @cached_property
    def _starts(self) -> np.ndarray:
        """(n + 1,) where the faces of each vertex begin in :attr:`_faces`, and their number."""
        return np.cumsum([0, *np.bincount(self.quads.corner_vertices, minlength=len(self.quads.vertices))])

    @cached_property
    def _samples(self) -> np.ndarray:
        """(s,) samples of the surface in the order of the nearest faces."""
        return np.argsort(self.ground.near[:, 0], kind="stable")

    @cached_property
    def _first_samples(self) -> np.ndarray:
        """(f + 1,) where the samples of each face begin in :attr:`_samples`, and their number."""
        return np.cumsum([0, *np.bincount(self.ground.near[:, 0], minlength=len(self.quads.sizes))])


def _improve(
    parts: list[_Part], ways: list[list[Patch]], gain: float, mesh: TriangleMesh, chains: Chains | None
) -> list[QuadMesh | None]:
    """Each part, reconnected in one of some ways and smoothed, at the least cost.

    None if it gains too little, if its worst corner gets worse and is not good, or, with a gain of 0, if it gets
    farther from the surface.
    """
    before = [worst_deviations(part.quads) for part in parts]
    least = [_cost(offs, part.patch) - gain for offs, part in zip(before, parts, strict=True)]
    found: list[QuadMesh | None] = [None] * len(parts)
    trials = [(number, way) for number, own in enumerate(ways) for way in own]
    for (number, way), quads in zip(trials, _smooth([(parts[k], way) for k, way in trials], mesh, chains), strict=True):
        after = worst_deviations(quads)
        cost = _cost(after, way)
        is_good = after.max() <= max(before[number].max(), GOOD) and cost < least[number]
        if is_good and (gain > 0 or _keeps_shape(parts[number], quads, mesh)):
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
    return _split(move_worst_corners(together, mesh, moving, own, ground, STEPS), sizes, ways)


def _split(together: QuadMesh, sizes: list[int], ways: Sequence[Patch]) -> list[QuadMesh]:
    """Divide a mesh of several parts into these: their numbers of vertices, and their patches, which have the faces."""
    ends = np.cumsum(sizes)[:-1]
    arrays = (np.split(values, ends) for values in (together.vertices, together.triangles, together.weights))
    return [
        QuadMesh(places, triangles, weights, way.faces.ravel(), np.full(len(way.faces), 4))
        for places, triangles, weights, way in zip(*arrays, ways, strict=True)
    ]


def _keeps_shape(part: _Part, quads: QuadMesh, mesh: TriangleMesh) -> bool:
    """Whether a part is as near to the surface with other faces, or nearer than :data:`NEAR`."""
    before = _distance(part.quads, mesh, part.below)
    return _distance(quads, mesh, part.below) <= max(before, NEAR * part.quads.edge_lengths.mean())


def _distance(quads: QuadMesh, mesh: TriangleMesh, below: np.ndarray) -> float:
    """Hausdorff distance between quads and points of the surface below them, taken at middles of faces."""
    middles, near = quads.middles(quads.vertices), faces_near(quads, below)
    away = np.sqrt(squares_to_faces(quads, quads.vertices, middles, below, near).max(initial=0))
    return max(float(away), float(np.linalg.norm(mesh.finder.nearby(middles)[0] - middles, axis=1).max()))


def _cost(offs: np.ndarray, patch: Patch) -> float:
    """Degrees by which faces are worse than good ones, and what irregular vertices cost."""
    return float(np.maximum(offs - GOOD, 0).sum()) + IRREGULAR * np.count_nonzero(patch.surpluses)


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
