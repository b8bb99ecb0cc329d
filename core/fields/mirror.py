# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror symmetry: what a node has to be when its mirror image is known, as links between nodes.

A reflection turns tangent planes over: a direction at angle a comes to c - a at the mirrored vertex. A vertex on the
mirror plane is linked to itself; its phase is then one of two, which a strong edge to itself asks for.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..connection import Connection, as_matrices, circle_transports
from ..errors import ContradictionError
from ..graphs import components
from .constraints.groups import Links, join_links

# How far, in radians of direction, mirrored wishes may differ: tangent planes lean, strokes are sampled.
LEAN = 0.1
# Strength of a node's edge to itself, in sums of the weights of its other edges.
STRENGTH = 4.0


@dataclass(frozen=True)
class Mirror:
    """A reflection of a mesh onto itself.

    Attributes
    ----------
    partner : (n,) vertex that mirrors each one
    turns : (n,) a direction at angle a at a vertex is at turns - a at its partner
    name : for messages
    """

    partner: np.ndarray
    turns: np.ndarray
    name: str

    @classmethod
    def of(cls, mesh, partner, axis):
        """The reflection that turns the sign of coordinate ``axis`` (0, 1, 2), from the mirrored vertices."""
        image = mesh.tangent_frames[0].copy()
        image[:, axis] *= -1
        # Where the direction of angle 0 of its partner comes to, at each vertex; a reflection is its own inverse.
        turns = mesh.tangent_numbers(image[partner])
        # Diagonals of faces need not be mirrored, so that tangent planes may lean a little.
        return cls(partner, np.angle(turns + turns[partner]), f"the mirror in {'XYZ'[axis]}")

    def direction_links(self, symmetry):
        """:class:`Links` between the powers of a direction field."""
        return _direction_links(np.arange(len(self.partner)), self.partner, self.turns, self.name, symmetry)

    def mirrored_directions(self, growth):
        """(n, k) direction of its partner, 0 to 2 k - 1, that the direction of each of a vertex's k phases comes to;
        from k on they are the reverses."""
        return _mirrored_directions(np.arange(len(self.partner)), self.partner, self.turns, growth)

    def phase_links(self, growth):
        """:class:`Links` between the phases of a :class:`Growth`, which come out exchanged or reversed."""
        return _phase_links(np.arange(len(self.partner)), self.partner, self.turns, self.name, growth)


@dataclass(frozen=True)
class Seam:
    """The two sides along which a one-sided surface is open: they look opposite ways and have the same field.

    Attributes
    ----------
    first, second : (k,) vertices at the same places
    turns : (k,) a direction at angle a at the first is at turns - a at the second
    """

    first: np.ndarray
    second: np.ndarray
    turns: np.ndarray
    name: str = "the one-sided surface"

    @classmethod
    def of(cls, mesh, pairs, rows=()):
        """Of (k, 2) pairs of vertices at the same places, but for those that hard Rows hold on both sides: the ends of
        a seam, on a boundary that turns there."""
        held = np.zeros(mesh.vertex_count, bool)
        for row in rows:
            held[row.line.vertices] |= row.weight is None
        first, second = pairs[~held[pairs].all(axis=1)].T
        x, y = mesh.tangent_frames
        # Where the direction of angle 0 of the one is in the tangent plane of the other, seen from either.
        turns = 2 * np.einsum("kx,kx->k", x[first], x[second]) + 1j * (
            np.einsum("kx,kx->k", y[first], x[second]) + np.einsum("kx,kx->k", y[second], x[first])
        )
        return cls(first, second, np.angle(turns))

    def direction_links(self, symmetry):
        """:class:`Links` between the powers of a direction field."""
        return _direction_links(self.first, self.second, self.turns, self.name, symmetry)

    def phase_links(self, growth):
        """:class:`Links` between the phases of a :class:`Growth`."""
        return _phase_links(self.first, self.second, self.turns, self.name, growth)


def _direction_links(first, second, turns, name, symmetry):
    return _links(first, second, symmetry * turns, np.ones(len(first), bool), name)


def _mirrored_directions(first, second, turns, growth):
    """(k, phases) the direction that each phase's direction comes to; mirrored ones are counted the other way round."""
    met = np.rint((turns - growth.angles[first] - growth.angles[second]) / growth.turn).astype(int)
    return (met[:, None] - np.arange(growth.phase_count)) % (2 * growth.phase_count)


def _phase_links(first, second, turns, name, growth):
    count, directions = growth.phase_count, _mirrored_directions(first, second, turns, growth)
    nodes = (count * first[:, None] + np.arange(count)).ravel()
    partners = count * second[:, None] + directions % count
    return _links(nodes, partners.ravel(), np.zeros(len(nodes)), directions.ravel() >= count, name)


def _links(i, j, angles, flips, name):
    once = i <= j
    names = np.full(once.sum(), name, object)
    return Links(i[once], j[once], angles[once], flips[once], names)


def split_links(count, parts):
    """Links of several mirrors between two of ``count`` nodes, and those of a node to itself that leave it two phases.

    Where two mirrors lead from one node to another on two ways, one is kept: they agree only as well as the
    tangent planes are mirrored, in which diagonals of faces play a part.
    """
    between, loops = join_links([]), []
    for links in parts:
        alone = links.i == links.j
        loops.append(_choose_phases(links, alone & links.flips))
        labels = components(count, np.column_stack([between.i, between.j]))
        pairs = np.sort(np.column_stack([labels[links.i], labels[links.j]]), axis=1)
        first = np.zeros(len(pairs), bool)
        first[np.unique(pairs, axis=0, return_index=True)[1]] = True
        between = join_links([between, _choose_phases(links, first & (pairs[:, 0] != pairs[:, 1]))])
    return between, join_links(loops)


def _choose_phases(links, mask):
    return Links(*(getattr(links, name)[mask] for name in Links.__dataclass_fields__))


def with_loops(connection, loops):
    """The connection with a strong edge to itself for every node that has only two phases."""
    if len(loops.i) == 0:
        return connection
    sums = np.bincount(connection.edges.ravel(), np.repeat(connection.weights, 2), connection.node_count)
    return Connection(
        connection.node_count,
        np.concatenate([connection.edges, np.column_stack([loops.i, loops.j])]),
        np.concatenate([connection.weights, STRENGTH * sums[loops.i]]),
        np.concatenate([as_matrices(connection.transports), circle_transports(loops.angles, loops.flips)]),
    )


def on_mirror(fixed, loops, slack):
    """Fixed values (Targets), those on a mirror plane moved to their own mirror image.

    Refuses what differs from that by more than the slack.
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


def snap_to_plane(problem, solution, loops):
    """The solution with the nodes on the mirror plane at the nearer of their two phases."""
    if len(loops.i) == 0:
        return solution
    middle = np.exp(0.5j * loops.angles)
    fields = solution.variations.copy()
    fields[:, loops.i] = np.where((fields[:, loops.i] * middle.conj()).real < 0, -middle, middle)
    return replace(solution, phases=fields[0], variations=fields, energy=problem.energy(fields[0]))
