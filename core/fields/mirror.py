# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror symmetry, as links between each node and its mirror image.

A reflection reverses the orientation of tangent planes: a direction at angle a maps to c - a at the mirrored vertex. A
vertex on the mirror plane is linked to itself; its phase is one of two, imposed by a strong edge to itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..connection import Connection, as_matrices, circle_transports
from ..errors import ContradictionError, SettingError
from ..geometry.polygons import Polygons
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import components
from ..problem import SynchronizationProblem, Targets
from ..solution import Solution
from .constraints.groups import Links, OneForm, join_links
from .constraints.rows import Row

# Largest difference of mirrored constraints, in radians of direction: tangent planes lean, strokes are sampled.
LEAN = 0.1
# Strength of a node's edge to itself, in sums of the weights of its other edges.
STRENGTH = 4.0


class Reflection:
    """Pairs of vertices whose directions are mirror images, :class:`Mirror` or :class:`Seam`.

    Attributes
    ----------
    turns : (k,) a direction at angle a at the first of a pair maps to turns - a at the second
    name : for messages
    """

    turns: np.ndarray
    name: str

    def _pairs(self) -> tuple[np.ndarray, np.ndarray]:
        raise NotImplementedError

    def has_image_of_each(self, mesh: TriangleMesh, pins: Sequence[tuple[int, float]]) -> bool:
        """Whether pins of triangles with an index are their own mirror image."""
        return False

    def direction_links(self, symmetry: int) -> Links:
        """Links between the powers of a direction field."""
        first, second = self._pairs()
        return self._links(first, second, symmetry * self.turns, np.ones(len(first), bool))

    def mirrored_directions(self, one_form: OneForm) -> np.ndarray:
        """(k, p) direction at the second vertex, 0 to 2 p - 1, to which that of each of the first's p phases maps; from
        p on they are the reverses."""
        first, second = self._pairs()
        images = np.rint((self.turns - one_form.angles[first] - one_form.angles[second]) / one_form.turn).astype(int)
        # They count in the opposite sense.
        return (images[:, None] - np.arange(one_form.phase_count)) % (2 * one_form.phase_count)

    def phase_links(self, one_form: OneForm) -> Links:
        """Links between the phases of a one-form, which are exchanged or reversed."""
        (first, second), count, directions = self._pairs(), one_form.phase_count, self.mirrored_directions(one_form)
        nodes = (count * first[:, None] + np.arange(count)).ravel()
        partners = count * second[:, None] + directions % count
        return self._links(nodes, partners.ravel(), np.zeros(len(nodes)), directions.ravel() >= count)

    def _links(self, i: np.ndarray, j: np.ndarray, angles: np.ndarray, flips: np.ndarray) -> Links:
        once = i <= j
        return Links(i[once], j[once], angles[once], flips[once], np.full(once.sum(), self.name, object))


@dataclass(frozen=True)
class Mirror(Reflection):
    """A reflection of a mesh onto itself; ``partner`` are the (n,) mirror images of its vertices."""

    partner: np.ndarray
    turns: np.ndarray
    name: str

    @classmethod
    def of(cls, mesh: TriangleMesh, partner: np.ndarray, axis: int) -> "Mirror":
        """The reflection that changes the sign of coordinate ``axis`` (0, 1, 2), from the mirrored vertices."""
        image = mesh.tangent_frames[0].copy()
        image[:, axis] *= -1
        # At each vertex, the image of its partner's direction of angle 0; a reflection is its own inverse.
        turns = mesh.tangent_numbers(image[partner])
        # Diagonals of faces need not be mirrored, so that tangent planes may lean a little.
        return cls(partner, np.angle(turns + turns[partner]), f"the mirror in {'XYZ'[axis]}")

    def has_image_of_each(self, mesh: TriangleMesh, pins: Sequence[tuple[int, float]]) -> bool:
        """As of :class:`Reflection`; triangles of one face, which share two vertices, count as the same."""
        own = [(set(mesh.triangles[triangle].tolist()), index) for triangle, index in pins]
        images = [(set(self.partner[mesh.triangles[triangle]].tolist()), index) for triangle, index in pins]
        return all(any(len(first & second) > 1 and a == b for second, b in own) for first, a in images)

    def image_of_face(self, polygons: Polygons, face: int) -> int:
        """The face at the mirror image of a face."""
        corners = np.arange(polygons.sizes[face]) + polygons.starts[face]
        images = self.partner[polygons.corner_vertices[corners]]
        found = np.bincount(polygons.corner_faces[np.isin(polygons.corner_vertices, images)])
        (faces,) = np.nonzero((found == len(images)) & (polygons.sizes[: len(found)] == len(images)))
        return int(faces[0])

    def _pairs(self) -> tuple[np.ndarray, np.ndarray]:
        return np.arange(len(self.partner)), self.partner


def mirrored_moves(mirrors: Sequence[Reflection], polygons: Polygons, start: int, end: int) -> dict[int, int]:
    """The move from one face to another and its mirror images, ends by starts.

    Raises SettingError where the start is its own image and the end is not.
    """
    moves = {start: end}
    for mirror in mirrors:
        if isinstance(mirror, Mirror):
            for pair in list(moves.items()):
                first, second = (mirror.image_of_face(polygons, face) for face in pair)
                if first in moves and moves[first] != second:
                    raise SettingError(f"what lies on {mirror.name} stays there: choose a face on its plane")
                moves[first] = second
    return moves


@dataclass(frozen=True)
class Seam(Reflection):
    """The two sides of the cut along a one-sided surface, (k,) vertices ``first`` and ``second`` at the same places.

    Their normals are opposite, their field is the same.
    """

    first: np.ndarray
    second: np.ndarray
    turns: np.ndarray
    name: str = "the one-sided surface"

    @classmethod
    def of(cls, mesh: TriangleMesh, pairs: np.ndarray, rows: Sequence[Row] = ()) -> "Seam":
        """From (k, 2) pairs of vertices at the same places, without those fixed by hard rows on both sides: the ends of
        a seam, on a boundary that turns there."""
        is_fixed = np.zeros(mesh.vertex_count, bool)
        for row in rows:
            is_fixed[row.line.vertices] |= row.weight is None
        first, second = pairs[~is_fixed[pairs].all(axis=1)].T
        x, y = mesh.tangent_frames
        # The direction of angle 0 of the one in the tangent plane of the other, seen from both.
        turns = 2 * np.einsum("kx,kx->k", x[first], x[second]) + 1j * (
            np.einsum("kx,kx->k", y[first], x[second]) + np.einsum("kx,kx->k", y[second], x[first])
        )
        return cls(first, second, np.angle(turns))

    def _pairs(self) -> tuple[np.ndarray, np.ndarray]:
        return self.first, self.second


def split_links(count: int, parts: Sequence[Links]) -> tuple[Links, Links]:
    """Links of several mirrors between two of ``count`` nodes, and those of a node to itself that leave it two phases.

    Where several links join two nodes in different ways, one is kept: they agree only as well as the tangent planes
    are mirrored, which depend on diagonals of faces.
    """
    between, loops = join_links([]), []
    for links in parts:
        alone = links.i == links.j
        loops.append(links.chosen(alone & links.flips))
        labels = components(count, np.column_stack([between.i, between.j]))
        pairs = np.sort(np.column_stack([labels[links.i], labels[links.j]]), axis=1)
        first = np.zeros(len(pairs), bool)
        first[np.unique(pairs, axis=0, return_index=True)[1]] = True
        between = join_links([between, links.chosen(first & (pairs[:, 0] != pairs[:, 1]))])
    return between, join_links(loops)


def add_self_edges(connection: Connection, loops: Links) -> Connection:
    """The connection with a strong edge from every node with only two phases to itself."""
    if len(loops.i) == 0:
        return connection
    sums = np.bincount(connection.edges.ravel(), np.repeat(connection.weights, 2), connection.node_count)
    return Connection(
        connection.node_count,
        np.concatenate([connection.edges, np.column_stack([loops.i, loops.j])]),
        np.concatenate([connection.weights, STRENGTH * sums[loops.i]]),
        np.concatenate([as_matrices(connection.transports), circle_transports(loops.angles, loops.flips)]),
    )


def snap_targets(fixed: Targets, loops: Links, slack: float) -> Targets:
    """Fixed values, of which those on a mirror plane are moved to the nearer of their two phases.

    Refuses values that differ from it by more than the slack.
    """
    nodes, place, loop = np.intersect1d(fixed.nodes, loops.i, return_indices=True)
    middle = np.exp(0.5j * loops.angles[loop])
    middle = np.where((fixed.values[place] * middle.conj()).real < 0, -middle, middle)
    apart = np.abs(fixed.values[place] - middle) > slack
    if apart.any():
        raise ContradictionError(
            f"{loops.names[loop][apart][0]} and what is fixed at {{vertices}} contradict each other: "
            "change one of them",
            nodes[apart],
        )
    values = fixed.values.copy()
    values[place] = middle
    return replace(fixed, values=values)


def snap_to_plane(problem: SynchronizationProblem, solution: Solution, loops: Links) -> Solution:
    """The solution with the nodes on the mirror plane at the nearer of their two phases."""
    if len(loops.i) == 0:
        return solution
    middle = np.exp(0.5j * loops.angles)
    fields = solution.variations.copy()
    fields[:, loops.i] = np.where((fields[:, loops.i] * middle.conj()).real < 0, -middle, middle)
    return replace(solution, phases=fields[0], variations=fields, energy=problem.energy(fields[0]))
