# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A family of surfaces of unit area, at random but the same on every run: bumps, handles, holes, spikes, needles.

It stands for the data set of the paper's Figure 9, whose triangles are as small as 1e-13 of the area and whose vertices
are curved by up to 5e8.
"""

from functools import partial

import numpy as np

from synch_fields.bench.surface_shapes import SurfaceShape, implicit_surface, ring_distance, union_of
from synch_fields.bench.turned import turned
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh

MEMBERS = 88
# Share of the area of the smallest triangle beside a needle, by turns up to 1e5 times as much, and how many needles and
# spikes there are.
SMALLEST, NEEDLES, SPIKES = 1e-13, 40, 12
STEPS = 6
# Of needles, the largest share; a needle's point is lifted off its edge by so many of its lengths.
LARGEST, LIFT = 1e-7, 0.5
# Faces with needles are at least so many times as large as the needles.
ROOM = 10
# Sides of spikes over those of the triangles that they stand on: the smallest, by turns up to 16 times as much, and the
# largest; their height over their side.
SPIKE_SIZE, LARGEST_SPIKE, SPIKE_HEIGHT = 3e-3, 1e-1, 2.0
SPIKE_STEPS = 5
BUMPS = 14
MOST_HANDLES, MOST_HOLES = 4, 3


def family(count=MEMBERS):
    """Tuple of :class:`SurfaceShape`: of each some topology, and by turns smooth, with spikes, with needles, both."""
    return tuple(map(_member, range(count)))


def _member(number):
    random = np.random.default_rng(number)
    handles, holes = int(random.integers(MOST_HANDLES + 1)), int(random.integers(MOST_HOLES + 1))
    spikes, needles = SPIKES * (number // 2 % 2), NEEDLES * (number % 2)
    words = [f"genus {handles}"]
    words += [f"{holes} hole" + "s" * (holes > 1)] * (holes > 0) + ["spikes"] * (spikes > 0)
    words += ["needles"] * (needles > 0)
    make = partial(_made, number, handles, holes, spikes, needles)
    return SurfaceShape(f"{number:02} {', '.join(words)}", make, 2 - 2 * handles - holes, holes)


def _made(number, handles, holes, spikes, needles):
    random = np.random.default_rng(number + 1000)
    mesh = bumpy(chain_of_rings(handles, random) if handles else egg(random), random)
    mesh = with_holes(mesh, holes, random)
    mesh = with_spikes(mesh, spikes, SPIKE_SIZE * 2.0 ** (number // 4 % SPIKE_STEPS), random)
    mesh = with_needles(mesh, needles, smallest(number), random)
    check_mesh(mesh)
    return TriangleMesh(mesh.vertices / np.sqrt(mesh.areas.sum()), mesh.triangles)


def smallest(number):
    """Share of the area that the smallest triangle beside a member's needles has."""
    return SMALLEST * 10.0 ** (number // 2 % STEPS)


def egg(random):
    """A closed surface of revolution."""
    turns = np.linspace(-np.pi / 2, np.pi / 2, 400)
    width = random.uniform(0.5, 1.2) * (1 + random.uniform(-0.3, 0.3) * np.sin(turns))
    profile = np.column_stack([width * np.cos(turns), np.sin(turns)])
    profile[[0, -1], 0] = 0
    return turned(profile, random.uniform(0.035, 0.1))


def chain_of_rings(count, random):
    """So many rings that have grown together in a winding row."""
    large, small = random.uniform(0.24, 0.32, count), random.uniform(0.09, 0.13, count)
    turns = np.cumsum(random.uniform(-0.9, 0.9, count))
    steps = np.append(0, large[1:] + large[:-1] + 0.15)
    centres = np.cumsum(steps[:, None] * np.column_stack([np.cos(turns), np.sin(turns)]), axis=0)
    centres -= (centres.min(axis=0) + centres.max(axis=0)) / 2
    scale = 1 / (np.abs(centres).max() + (large + small).max())

    def distance(points):
        rings = [ring_distance(points / scale, *ring) for ring in zip(centres, large, small, strict=True)]
        return scale * union_of(rings, 0.2)

    return implicit_surface(distance, int(random.integers(36, 56)))


def bumpy(mesh, random):
    """The surface moved along its normals, by round bumps and dents of several widths."""
    size = np.sqrt(mesh.areas.sum())
    centres = mesh.vertices[random.integers(mesh.vertex_count, size=BUMPS)]
    widths, heights = size * random.uniform(0.04, 0.2, BUMPS), random.uniform(-0.35, 0.35, BUMPS)
    squares = ((mesh.vertices[:, None] - centres) ** 2).sum(axis=2)
    rise = np.exp(-squares / (2 * widths**2)) @ (heights * widths)
    return TriangleMesh(mesh.vertices + rise[:, None] * mesh.vertex_normals, mesh.triangles)


def with_holes(mesh, count, random):
    """The surface without the faces near some vertices, each a disk and far from the others."""
    removed = np.zeros(mesh.triangle_count, bool)
    near = np.zeros(mesh.vertex_count, bool)
    for _ in range(count):
        centre = random.choice(np.flatnonzero(~near))
        ring = np.arange(mesh.vertex_count) == centre
        hole = np.zeros(mesh.triangle_count, bool)
        wanted = random.integers(1, 4)
        for step in range(wanted + 4):
            around = ring[mesh.triangles].any(axis=1)
            ring[mesh.triangles[around]] = True
            hole |= around & (step < wanted)
        removed |= hole
        near |= ring
    return _of(mesh.vertices, mesh.triangles[~removed])


def with_spikes(mesh, count, size, random):
    """The surface with thin pyramids on some faces, from a size on: their tips are curved by about one over the area
    around them."""
    chosen = random.choice(mesh.triangle_count, count, replace=False)
    corners = mesh.vertices[mesh.triangles[chosen]]
    sizes = np.geomspace(size, LARGEST_SPIKE, count)[:, None]
    centres = corners.mean(axis=1)
    heights = SPIKE_HEIGHT * sizes * np.sqrt(mesh.areas[chosen])[:, None]
    feet = centres[:, None] + sizes[:, None] * (corners - centres[:, None])
    tips = centres + heights * mesh.face_normals[chosen]
    a, b, c = mesh.triangles[chosen].T
    p, q, r, tip = mesh.vertex_count + np.arange(4)[:, None] + 4 * np.arange(count)
    around = ((a, b, q), (a, q, p), (b, c, r), (b, r, q), (c, a, p), (c, p, r), (p, q, tip), (q, r, tip), (r, p, tip))
    points = np.concatenate([feet, tips[:, None]], axis=1).reshape(-1, 3)
    return TriangleMesh(
        np.concatenate([mesh.vertices, points]),
        np.concatenate([np.delete(mesh.triangles, chosen, axis=0), *(np.column_stack(t) for t in around)]),
    )


def with_needles(mesh, count, least, random):
    """The surface with a point beside one end of some inner edges, so that the least face has a share of the area.

    The faces' areas are proportional to the distance of the point from the end, which is thus known.
    """
    shares = mesh.areas.sum() * np.geomspace(least, LARGEST, count)
    vertices, triangles = mesh.vertices, mesh.triangles
    kept, added = np.ones(len(triangles), bool), []
    for share, half in zip(shares, _apart(mesh, count, random), strict=True):
        sides = [_corners_from(triangles, side) for side in (half, mesh.twins[half])]
        (a, b, c), (_, _, d) = sides
        way = vertices[b] - vertices[a]
        normal = mesh.face_normals[half // 3]
        lifted = way + LIFT * np.linalg.norm(way) * normal
        area = min(np.linalg.norm(np.cross(lifted, vertices[other] - vertices[a])) / 2 for other in (c, d))
        p = len(vertices)
        vertices = np.vstack([vertices, vertices[a] + share / area * lifted])
        kept[[half // 3, mesh.twins[half] // 3]] = False
        added += [(a, p, c), (p, b, c), (b, p, d), (p, a, d)]
    return TriangleMesh(vertices, np.vstack([triangles[kept], np.reshape(added, (-1, 3)).astype(int)]))


def _apart(mesh, count, random):
    """Half-edges of inner edges between faces of some size, no two of which have faces with a vertex in common."""
    used, chosen = np.zeros(mesh.vertex_count, bool), []
    is_large = np.repeat(mesh.areas > ROOM * LARGEST * mesh.areas.sum(), 3)
    for half in random.permutation(np.flatnonzero((mesh.twins >= 0) & is_large & is_large[mesh.twins])):
        if len(chosen) == count:
            break
        corners = mesh.triangles[[half // 3, mesh.twins[half] // 3]]
        if not used[corners].any():
            used[corners] = True
            chosen.append(half)
    return chosen


def _corners_from(triangles, half):
    """Tail and head of a half-edge, and the corner opposite."""
    return np.roll(triangles[half // 3], -(half % 3))


def _of(vertices, triangles):
    """The mesh of the vertices that faces have."""
    used, numbers = np.unique(triangles, return_inverse=True)
    return TriangleMesh(vertices[used], numbers.reshape(-1, 3))
