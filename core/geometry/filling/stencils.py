# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of a tetrahedron of the body-centred lattice inside a surface that cuts it.

After Labelle and Shewchuk, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles", SIGGRAPH 2007. A
corner is inside (1), on the surface (0) or outside (-1); an edge whose ends lie on different sides has a cut point.
Corners 0 and 1 are the ends of one long edge, 2 and 3 of the other.

The rest of a cut triangle with two corners inside is a quadrilateral, and both tetrahedra beside it have to split it
along the same diagonal: if the cut edges are a long and a short one, the diagonal that ends at the long edge's cut
point; if both are short, by the parity rule, which picks one end of the inner long edge, alternating around that edge.
"""

from functools import cache
from itertools import combinations, permutations

import numpy as np

from ..tet_mesh import TET_EDGES

LONG_EDGES = ((0, 1), (2, 3))
# One positively oriented tetrahedron of the lattice, to orient the pieces by.
_CORNERS = np.array([(0, 0, 0), (2, 0, 0), (1, 1, -1), (1, 1, 1)], float)


def cut_point(i: int, j: int) -> int:
    """Number the cut point between corners i and j: corners are 0..3, and 4 + k is on edge k of TET_EDGES."""
    return 4 + TET_EDGES.index((min(i, j), max(i, j)))


@cache
def stencil(sides: tuple[int, ...], lower_at_2: bool, lower_at_0: bool) -> tuple[tuple[int, ...], ...]:
    """List the tetrahedra inside as tuples of corners and cut points, positively oriented if the whole one is.

    Parameters
    ----------
    sides : four of 1, 0 or -1, at least one of them 1
    lower_at_2 : whether the parity rule picks corner 0 rather than 1 in the face with corner 2 (and the other
        one in the face with corner 3)
    lower_at_0 : whether it picks corner 2 rather than 3 in the face with corner 0 (and the other one with 1)
    """
    inside = [k for k in range(4) if sides[k] > 0]
    outside = [k for k in range(4) if sides[k] < 0]
    if not outside:
        return ((0, 1, 2, 3),)
    if len(inside) == 1:
        return (_positive([k if sides[k] >= 0 else cut_point(inside[0], k) for k in range(4)]),)
    splits = {_diagonal(pair, corner, lower_at_2, lower_at_0) for pair in combinations(inside, 2) for corner in outside}
    if len(inside) == 3:
        return _prism(inside, [cut_point(k, outside[0]) for k in inside], splits)
    p, q = inside
    # With a corner on the surface, two of the prism's corners coincide there.
    ends = [[k if sides[k] == 0 else cut_point(end, k) for k in range(4) if sides[k] <= 0] for end in inside]
    return _prism([p, *ends[0]], [q, *ends[1]], splits)


def _diagonal(pair: tuple[int, int], corner: int, lower_at_2: bool, lower_at_0: bool) -> frozenset[int]:
    """Find the ends of the diagonal in the face of two corners inside and one outside."""
    is_long = [(min(k, corner), max(k, corner)) in LONG_EDGES for k in pair]
    if any(is_long):
        cut = pair[is_long.index(True)]
        return frozenset((pair[is_long.index(False)], cut_point(cut, corner)))
    picks_lower = lower_at_2 == (corner == 2) if pair == (0, 1) else lower_at_0 == (corner == 0)
    picked, other = pair if picks_lower else pair[::-1]
    return frozenset((picked, cut_point(other, corner)))


def _prism(bottom: list[int], top: list[int], splits: set[frozenset[int]]) -> tuple[tuple[int, ...], ...]:
    """Split a prism into three tetrahedra, or fewer if an edge between bottom and top has shrunk to a point."""
    # Replace bottom by top corners one by one: diagonals run from the tops reached to the remaining bottoms.
    order = next(
        order
        for order in permutations(range(3))
        if splits <= {frozenset((top[i], bottom[j])) for i, j in combinations(order, 2)}
    )
    tets, current = [], list(bottom)
    for side in order:
        if top[side] != bottom[side]:
            tets.append(_positive([*current, top[side]]))
        current[side] = top[side]
    return tuple(tets)


def _positive(tet: list[int]) -> tuple[int, ...]:
    points = np.vstack([_CORNERS, *(_CORNERS[list(edge)].mean(axis=0) for edge in TET_EDGES)])[tet]
    return tuple(tet) if np.linalg.det(points[1:] - points[0]) > 0 else (*tet[:2], tet[3], tet[2])
