# SPDX-License-Identifier: GPL-3.0-or-later
"""Intrinsic Delaunay triangulation: the same surface and vertices, joined without negative cotangents.

Edges are straight on the unfolded surface, so that a triangulation is no more than corners and side lengths
(Bobenko and Springborn 2007, "A discrete Laplace-Beltrami operator for simplicial surfaces").
"""

import numpy as np

# Sides grow by the same amount until every triangle inequality holds by this share of the mean side
# (Sharp and Crane 2020, "intrinsic mollification"): needles get an area.
SLACK = 1e-6
# An edge is left as it is when the cosines of its opposite angles sum to this much below 0 or more.
TOLERANCE = 1e-9


def intrinsic_delaunay(mesh):
    """Flip edges until the two angles opposite each sum to at most pi.

    The result may join a vertex to itself, or two vertices twice.

    Parameters
    ----------
    mesh : TriangleMesh, checked

    Returns
    -------
    triangles : (m, 3) int
    lengths : (m, 3) float, the side from corner k to corner k + 1, scene units
    """
    sides = mesh.edge_lengths[mesh.triangle_edges]
    slack = sides.sum(axis=1, keepdims=True) - 2 * sides
    sides = sides + max(SLACK * sides.mean() - slack.min(), 0)
    twins = mesh.twins
    inner = np.flatnonzero(twins > np.arange(len(twins)))
    cosines = _opposite_cosines(sides).ravel()
    waiting = inner[cosines[inner] + cosines[twins[inner]] < -TOLERANCE].tolist()
    if not waiting:
        return mesh.triangles, sides
    # One flip changes what its four neighbours need: this is a loop by nature, over the few bad edges.
    surface = _Surface(mesh.triangles.ravel().tolist(), sides.ravel().tolist(), twins.tolist())
    while waiting:
        half = waiting.pop()
        if surface.should_flip(half):
            waiting += surface.flip(half)
    return np.array(surface.tails).reshape(-1, 3), np.array(surface.lengths).reshape(-1, 3)


def side_angles(lengths):
    """(m, 3) corner angles of triangles with (m, 3) side lengths, corner k before side k, radians."""
    after, opposite, before = lengths, np.roll(lengths, -1, axis=1), np.roll(lengths, 1, axis=1)
    half = 0.5 * lengths.sum(axis=1, keepdims=True)
    rise = np.maximum((half - after) * (half - before), 0)
    return 2 * np.arctan2(np.sqrt(rise), np.sqrt(np.maximum(half * (half - opposite), 0)))


def _opposite_cosines(sides):
    after, before = np.roll(sides, -1, axis=1), np.roll(sides, 1, axis=1)
    return (after**2 + before**2 - sides**2) / (2 * after * before)


class _Surface:
    """Half-edges as lists: tail, length and twin (-1 on the boundary) of each; 3 t + k as in TriangleMesh."""

    def __init__(self, tails, lengths, twins):
        self.tails, self.lengths, self.twins = tails, lengths, twins

    def _others(self, half):
        first = half - half % 3
        return first + (half + 1) % 3, first + (half + 2) % 3

    def _opposite_cosine(self, half):
        b, c = (self.lengths[h] for h in self._others(half))
        return (b * b + c * c - self.lengths[half] ** 2) / (2 * b * c)

    def should_flip(self, half):
        twin = self.twins[half]
        return twin >= 0 and self._opposite_cosine(half) + self._opposite_cosine(twin) < -TOLERANCE

    def flip(self, half):
        """Join the corners opposite an inner half-edge instead of its ends; return the four sides around it."""
        twin = self.twins[half]
        (after, before), (twin_after, twin_before) = self._others(half), self._others(twin)
        diagonal = self._diagonal(half, before, after, twin_after, twin_before)
        # Where each side goes: before and twin_after close one triangle with the diagonal, the other two the other.
        place = {before: after, twin_after: before, twin_before: twin_after, after: twin_before}
        moved = [(place[h], self.tails[h], self.lengths[h], place.get(self.twins[h], self.twins[h])) for h in place]
        self.tails[half], self.tails[twin] = self.tails[twin_before], self.tails[before]
        self.lengths[half] = self.lengths[twin] = diagonal
        for slot, tail, length, opposite in moved:
            self.tails[slot], self.lengths[slot], self.twins[slot] = tail, length, opposite
            if opposite >= 0:
                self.twins[opposite] = slot
        return list(place)

    def _diagonal(self, half, before, after, twin_after, twin_before):
        """Distance of the two opposite corners, with the half-edge laid from 0 along the x axis."""
        base = self.lengths[half]
        (x, y), (u, v) = (
            _apex(base, self.lengths[left], self.lengths[right])
            for left, right in ((before, after), (twin_after, twin_before))
        )
        return float(np.hypot(x - u, y + v))


def _apex(base, left, right):
    x = (base * base + left * left - right * right) / (2 * base)
    return x, max(left * left - x * x, 0.0) ** 0.5
