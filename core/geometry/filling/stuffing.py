# SPDX-License-Identifier: GPL-3.0-or-later
"""Tetrahedra inside a closed surface given by its signed distance.

Labelle and Shewchuk, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles", SIGGRAPH 2007, with one
size throughout: a body-centred cubic lattice whose vertices move to the surface where it passes close by, and whose
tetrahedra are cut by it elsewhere.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError, SettingError, round_up
from ...graphs import find, pair_keys
from ..tet_mesh import TET_EDGES, TetMesh
from ..vertex_splitting import merge_corners
from .lattice import Lattice, build_lattice
from .stencils import stencil

# A vertex moves to a cut point that is nearer than this share of the edge. A search by trial found that this pair gives
# the largest smallest angle over all possible cut points; the angles are those of the paper's abstract, "between 10.7
# and 164.8". (0.24999, 0.41189) gives 9.31 to 161.65.
WARP_LONG, WARP_SHORT = 0.28512, 0.39883
DIHEDRAL_BOUNDS = (10.78, 164.75)
# Cut points lie on the surface to this share of its size.
CUT_TOLERANCE = 1e-7
MOST_CUT_STEPS = 40
# Measured while distances to the lattice are computed.
BYTES_PER_CUBE = 35
MOST_CUBES = 50_000_000
# Tetrahedra beyond the volume's share per ``size`` squared of area; measured on balls, cubes and animals: 1.6 to 2.3.
TETS_PER_FACET = 2.0
# Measured, 50 000 to 560 000 tetrahedra: 610 to 705 while they are made and then connected (edges, faces, weights).
BYTES_PER_TET = 720
COARSEST_BLOCK = 8


class NothingInside(MeshError):
    """No vertex of the lattice is inside the surface."""


def fill_surface(signed_distance: Callable[[np.ndarray], np.ndarray], bounds: ArrayLike, size: float) -> TetMesh:
    """Fill a closed surface with tetrahedra whose boundary vertices lie on it.

    Sharp edges and corners of the surface are cut off within one ``size``. Thinner parts may be lost or severed, and
    narrower gaps closed; parts that would touch in a vertex or an edge are separated there. Returns mesh with dihedral
    angles within ``DIHEDRAL_BOUNDS`` degrees. Raises SettingError for a size that is not positive, or makes more than
    ``MOST_CUBES`` cubes; MeshError if the surface leaves the bounds; :class:`NothingInside` if no vertex of the lattice
    is inside.

    Parameters
    ----------
    signed_distance : (k, 3) points -> (k,) distances to the surface, negative inside; values may be too small but never
        too large, as blocks far from the surface are judged as a whole
    bounds : (2, 3) lowest and highest corner of a box around the surface
    size : longest edge of the lattice inside; its other edges are 0.87 of that
    """
    box = np.asarray(bounds, float)
    reach = float(np.linalg.norm(box[1] - box[0]))
    _refuse_size(box, size)
    lattice = build_lattice(box, size, COARSEST_BLOCK)
    distances = _compute_distances(signed_distance, lattice)
    sides = -np.sign(distances).astype(np.int8)
    _refuse_outside(lattice, sides)

    edges, are_long = lattice.edges_across(sides)
    shares = _find_cuts(signed_distance, lattice, edges, distances, CUT_TOLERANCE * reach)
    inner, outer = (lattice.points(ends) for ends in edges.T)
    places = inner + shares[:, None] * (outer - inner)
    warped, warped_places = _find_warps(edges, are_long, places, shares, size)
    sides[warped] = 0
    left = (sides[edges] != 0).all(axis=1)
    edges, places = edges[left], places[left]

    # Vertices of the lattice come first, in its numbering, and cut points after them.
    used, tets = np.unique(_build_tets(lattice, sides, edges), return_inverse=True)
    tets = tets.reshape(-1, 4)
    _refuse_nothing(lattice, len(tets) > 0)  # all that were inside may have moved onto the surface
    cuts = used >= lattice.vertex_count
    vertices = np.concatenate([lattice.points(used[~cuts]), places[used[cuts] - lattice.vertex_count]])
    moved = np.searchsorted(used, warped)
    there = used[np.minimum(moved, len(used) - 1)] == warped
    vertices[moved[there]] = warped_places[there]

    on_surface = cuts.copy()
    on_surface[~cuts] = sides[used[~cuts]] == 0
    touching = on_surface[tets].any(axis=1)
    vertices, tets[touching] = _split_solid_vertices(TetMesh(vertices, tets[touching]), on_surface)
    return TetMesh(vertices, tets)


def _split_solid_vertices(mesh: TetMesh, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split the vertices, among (n,) bool given ones, whose tetrahedra are not connected by faces.

    All tetrahedra of the given vertices have to be in the mesh. Returns the vertices, copies last, and the tetrahedra.
    """
    corners = mesh.tets.ravel()
    links = []
    for k in range(3):
        shared = (mesh.face_tets[:, 1] >= 0) & at[mesh.faces[:, k]]
        sides = mesh.face_tets[shared].T
        links.append([4 * t + (mesh.tets[t] == mesh.faces[shared, k, None]).argmax(axis=1) for t in sides])
    others = np.flatnonzero(~at[corners])
    representatives = np.zeros(mesh.vertex_count, int)
    representatives[corners[others]] = others
    links.append([others, representatives[corners[others]]])
    source, numbers = merge_corners(mesh.tets, np.concatenate([np.column_stack(ends) for ends in links]))
    is_copy = np.append(False, source[1:] == source[:-1])
    names = np.where(is_copy, mesh.vertex_count + np.cumsum(is_copy) - 1, source)
    return np.concatenate([mesh.vertices, mesh.vertices[source[is_copy]]]), names[numbers]


def _compute_distances(signed_distance: Callable[[np.ndarray], np.ndarray], lattice: Lattice) -> np.ndarray:
    """Compute (v,) distances at the lattice's vertices; far from the surface only the signs are valid.

    Blocks of cubes are halved until each is inside, outside or a single cube.
    """
    block = COARSEST_BLOCK
    centres = np.zeros(lattice.cells // block)
    undecided = np.ones(centres.shape, bool)
    while block:
        at = np.argwhere(undecided)
        centres[undecided] = signed_distance(lattice.corner_points((at + 0.5) * block))
        is_near = np.abs(centres) <= block * lattice.size * np.sqrt(3) / 2
        block //= 2
        if block:
            centres, undecided = _split_blocks(centres), _split_blocks(is_near)
    corners = np.zeros(lattice.cells + 1)
    near = np.zeros(lattice.cells + 1, bool)
    nx, ny, nz = lattice.cells
    for i, j, k in np.ndindex(2, 2, 2):
        beside = (slice(i, i + nx), slice(j, j + ny), slice(k, k + nz))
        corners[beside] = centres
        near[beside] |= is_near
    corners[near] = signed_distance(lattice.corner_points(np.argwhere(near)))
    return np.concatenate([corners.ravel(), centres.ravel()])


def _split_blocks(blocks: np.ndarray) -> np.ndarray:
    """Repeat the values of blocks in their eight parts."""
    for axis in range(3):
        blocks = blocks.repeat(2, axis=axis)
    return blocks


def _find_cuts(
    signed_distance: Callable[[np.ndarray], np.ndarray],
    lattice: Lattice,
    edges: np.ndarray,
    distances: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Find the (k,) shares of the way from the inner to the outer end of each edge at which it crosses the surface.

    The secant method in a bracket, halving the value of an end that stays (the Illinois rule).
    """
    inner, outer = (lattice.points(ends) for ends in edges.T)
    low, high = np.zeros(len(edges)), np.ones(len(edges))
    at_low, at_high = distances[edges].T.copy()
    shares = np.zeros(len(edges))
    kept = np.zeros(len(edges), int)
    active = np.arange(len(edges))
    for _ in range(MOST_CUT_STEPS):
        if not len(active):
            break
        below, above = low[active], high[active]
        guess = below - at_low[active] * (above - below) / (at_high[active] - at_low[active])
        value = signed_distance(inner[active] + guess[:, None] * (outer[active] - inner[active]))
        shares[active] = guess
        inside = value < 0
        stays = np.where(inside, 1, -1)
        halve = np.where(kept[active] == stays, 0.5, 1.0)
        kept[active] = stays
        here, there = active[inside], active[~inside]
        low[here], at_low[here] = guess[inside], value[inside]
        at_high[here] *= halve[inside]
        high[there], at_high[there] = guess[~inside], value[~inside]
        at_low[there] *= halve[~inside]
        open_ones = (np.abs(value) > tolerance) & ((high - low)[active] * lattice.size > tolerance)
        active = active[open_ones]
    return shares


def _find_warps(
    edges: np.ndarray, are_long: np.ndarray, places: np.ndarray, shares: np.ndarray, size: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the vertices that move to a cut point, in increasing order, and the (k, 3) nearest cut points."""
    limits = np.where(are_long, WARP_LONG, WARP_SHORT)
    lengths = np.where(are_long, 1, np.sqrt(3) / 2) * size
    near_inner, near_outer = shares < limits, 1 - shares < limits
    vertices = np.concatenate([edges[near_inner, 0], edges[near_outer, 1]])
    ways = np.concatenate([(shares * lengths)[near_inner], ((1 - shares) * lengths)[near_outer]])
    to = np.concatenate([places[near_inner], places[near_outer]])
    order = np.lexsort((ways, vertices))
    vertices, first = np.unique(vertices[order], return_index=True)
    return vertices, to[order[first]]


def _build_tets(lattice: Lattice, sides: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Build (m, 4) tetrahedra inside, positively oriented; cut point e is numbered vertex_count + e."""
    tets, are_positive, at_2, at_0 = lattice.tets_inside(sides)
    codes = (sides[tets] + 1) @ np.array([27, 9, 3, 1])
    whole = (sides[tets] >= 0).all(axis=1)
    parts = [_orient(tets[whole], are_positive[whole])]
    tets, are_positive, codes, at_2, at_0 = (a[~whole] for a in (tets, are_positive, codes, at_2, at_0))
    choices = 4 * codes + 2 * at_2 + at_0
    corners = np.column_stack([tets, _number_cuts(lattice, tets, edges)])
    for choice in np.unique(choices):
        at = choices == choice
        code, picks = divmod(int(choice), 4)
        pattern = tuple(code // power % 3 - 1 for power in (27, 9, 3, 1))
        for tet in stencil(pattern, picks >= 2, picks % 2 == 1):
            parts.append(_orient(corners[at][:, tet], are_positive[at]))
    return np.concatenate(parts)


def _number_cuts(lattice: Lattice, tets: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Number the cut points on the edges of tetrahedra, (m, 6); arbitrary for edges that are not cut."""
    count = lattice.vertex_count
    return count + find(pair_keys(edges, count), pair_keys(tets[:, TET_EDGES], count))


def _orient(tets: np.ndarray, are_positive: np.ndarray) -> np.ndarray:
    return np.where(are_positive[:, None], tets, tets[:, [0, 1, 3, 2]])


def estimated_tets(volume: float, size: float, area: float) -> int:
    """Estimate the number of tetrahedra of a solid, to a few per cent, from its volume and the area of its surface.

    Cut tetrahedra are more for their volume than whole ones. ``size`` as for :func:`fill_surface`.
    """
    return round(12 * volume / size**3 + TETS_PER_FACET * area / size**2)


def estimated_bytes(tets: int, bounds: ArrayLike, size: float) -> int:
    """Estimate the peak memory of making tetrahedra in a box, without solves on them."""
    return round(BYTES_PER_TET * tets + BYTES_PER_CUBE * estimated_cubes(bounds, size))


def estimated_cubes(bounds: ArrayLike, size: float) -> float:
    """Estimate the number of cubes of the lattice around a box."""
    return float(np.prod(np.ptp(np.asarray(bounds, float), axis=0) / size + 2))


def _refuse_size(bounds: np.ndarray, size: float) -> None:
    if not (np.isfinite(size) and size > 0):
        raise SettingError(f"a size of {size} makes no tetrahedra: choose a positive length")
    cubes = estimated_cubes(bounds, size)
    if not cubes < MOST_CUBES:
        fitting = size * (cubes / MOST_CUBES) ** (1 / 3)
        while not estimated_cubes(bounds, fitting) < MOST_CUBES:
            fitting *= 1.01
        raise SettingError(f"a size of {size:g} makes {cubes:.1e} cubes: choose one from {round_up(fitting, 2)} on")


def _refuse_outside(lattice: Lattice, sides: np.ndarray) -> None:
    corners = sides[: lattice.corner_count].reshape(lattice.cells + 1)
    for axis in range(3):
        rim = np.take(corners, (0, -1), axis=axis)
        if (rim >= 0).any():
            raise MeshError("the surface leaves the bounds: make it closed, with its faces outwards, and give its box")
    _refuse_nothing(lattice, bool((sides > 0).any()))


def _refuse_nothing(lattice: Lattice, is_met: bool) -> None:
    if not is_met:
        raise NothingInside(
            f"no vertex of a lattice of size {lattice.size:g} is inside the surface: choose a size below its thickness"
        )
