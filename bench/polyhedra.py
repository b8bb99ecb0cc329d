# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids and sheets with plane faces, cut into small even triangles that keep every edge."""

from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, cKDTree

from synch_fields.core.geometry import TriangleMesh

# Points inside a face keep this far from the vertices of its rim, in sides of triangles: that is outside the circles
# over the rim's edges, which are then edges of the Delaunay triangulation.
FROM_RIM = 0.75
# The lattice inside a face is turned by this against the face's first edge (radians): no edge of the shape is favoured.
LATTICE_TURN = 0.4
# Triangles of less than this share of a side squared are points in a row.
FLAT = 1e-6


class Polyhedron:
    """Corners and plane faces, added one after the other.

    Attributes
    ----------
    corners : list of points
    faces : list of faces, each a list of rings of corners: first the outer one, counterclockwise seen from outside,
        then its holes, clockwise
    """

    def __init__(self):
        self.corners, self.faces = [], []

    def ring(self, outline, height=0.0):
        """Numbers of new corners at (k, 2) points, all at one height."""
        first = len(self.corners)
        self.corners += [(x, y, height) for x, y in outline]
        return list(range(first, len(self.corners)))

    def wall(self, lower, upper):
        """Faces from a ring to the one above it; outside is to the right of their sense."""
        after = np.roll(np.arange(len(lower)), -1)
        self.faces += [[[lower[k], lower[n], upper[n], upper[k]]] for k, n in enumerate(after)]

    def top(self, *rings):
        """A face upwards: a counterclockwise ring and its clockwise holes."""
        self.faces.append(list(rings))

    def bottom(self, *rings):
        """A face downwards, from the same rings."""
        self.faces.append([ring[::-1] for ring in rings])

    def triangulated(self, size):
        """The :class:`TriangleMesh` with sides of about a length, none of its edges longer on the faces' rims."""
        points, cuts = [np.array(self.corners, float)], {}
        count = len(self.corners)
        for ring in (ring for face in self.faces for ring in face):
            for a, b in pairwise([*ring, ring[0]]):
                if (a, b) not in cuts:
                    way = points[0][b] - points[0][a]
                    pieces = max(int(np.ceil(np.linalg.norm(way) / size)), 1)
                    points.append(points[0][a] + np.arange(1, pieces)[:, None] / pieces * way)
                    cuts[a, b] = list(range(count, count + pieces - 1))
                    cuts[b, a] = cuts[a, b][::-1]
                    count += pieces - 1
        points, triangles = np.concatenate(points), []
        for face in self.faces:
            rings = [[v for a, b in pairwise([*ring, ring[0]]) for v in (a, *cuts[a, b])] for ring in face]
            inside, found = _face(points, rings, count, size)
            points, count = np.concatenate([points, inside]), count + len(inside)
            triangles.append(found)
        return TriangleMesh(points, np.concatenate(triangles))


def prism(outline, height, holes=()):
    """The :class:`Polyhedron` over a counterclockwise (k, 2) outline with clockwise holes."""
    solid = Polyhedron()
    lower, upper = ([solid.ring(ring, z) for ring in (outline, *holes)] for z in (0.0, height))
    for below, above in zip(lower, upper, strict=True):
        solid.wall(below, above)
    solid.top(*upper)
    solid.bottom(*lower)
    return solid


def convex(points):
    """The :class:`Polyhedron` of all of (n, 3) points, which are corners of their convex hull."""
    solid = Polyhedron()
    solid.corners = [tuple(point) for point in points]
    hull = ConvexHull(points)
    _, first = np.unique(np.round(hull.equations, 9), axis=0, return_index=True)
    for *normal, offset in hull.equations[np.sort(first)]:
        (on,) = np.nonzero(np.abs(points @ normal + offset) < 1e-9)
        flat = points[on] @ _plane(np.array(normal)).T
        x, y = (flat - flat.mean(axis=0)).T
        solid.faces.append([on[np.argsort(np.arctan2(y, x))].tolist()])
    return solid


def circle(radius, size, centre=(0.0, 0.0), clockwise=False):
    """(k, 2) corners of a regular polygon with sides of about a length."""
    count = max(int(np.round(2 * np.pi * radius / size)), 3)
    turns = 2 * np.pi * np.arange(count) / count * (-1 if clockwise else 1)
    return np.asarray(centre) + radius * np.column_stack([np.cos(turns), np.sin(turns)])


def _plane(normal):
    """(2, 3) orthonormal directions of a plane, counterclockwise around its normal."""
    x = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(normal / np.linalg.norm(normal), x)])


def _face(points, rings, count, size):
    """(k, 3) new points inside a plane face, whose numbers start at a count, and (t, 3) its triangles."""
    rim = np.concatenate(rings)
    after = np.concatenate([np.roll(ring, -1) for ring in rings])
    outer = points[rings[0]]
    plane = _plane(np.cross(outer, np.roll(outer, -1, axis=0)).sum(axis=0))
    flat = points @ plane.T
    tails, heads = flat[rim], flat[after]
    lattice = _lattice(tails, size, heads[0] - tails[0])
    lattice = lattice[cKDTree(tails).query(lattice)[0] > FROM_RIM * size]
    lattice = lattice[_within(lattice, tails, heads)]
    places = np.concatenate([tails, lattice])
    found = Delaunay(places).simplices
    u, v = places[found[:, 1]] - places[found[:, 0]], places[found[:, 2]] - places[found[:, 0]]
    turn = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    found[turn < 0] = found[turn < 0][:, ::-1]
    found = found[(np.abs(turn) > FLAT * size**2) & _within(places[found].mean(axis=1), tails, heads)]
    origin = points[rim[0]] - plane.T @ tails[0]
    numbers = np.concatenate([rim, np.arange(count, count + len(lattice))])
    return origin + lattice @ plane, numbers[found]


def _lattice(rim, size, along):
    """(k, 2) points of equal triangles over the box of a rim, turned against a direction."""
    angle = np.arctan2(along[1], along[0]) + LATTICE_TURN
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    low, high = rim.min(axis=0), rim.max(axis=0)
    reach = int(np.linalg.norm(high - low) / size) + 1
    j, i = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    points = size * np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=-1).reshape(-1, 2) @ turned + (low + high) / 2
    return points[((points > low) & (points < high)).all(axis=1)]


def _within(places, tails, heads):
    """(k,) bool: whether a line to the right crosses the rim an odd number of times."""
    x, y = places.T[:, :, None]
    (ax, ay), (bx, by) = tails.T[:, None], heads.T[:, None]
    crosses = (ay > y) != (by > y)
    at = ax + (y - ay) * (bx - ax) / np.where(by == ay, 1, by - ay)
    return ((at > x) & crosses).sum(axis=1) % 2 == 1
