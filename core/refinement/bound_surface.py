# SPDX-License-Identifier: GPL-3.0-or-later
"""A finer copy of a mesh, with the places of its vertices, faces and corners on the original."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..errors import AsymmetryError, SettingError, round_up
from ..geometry.mesh_input import ObjectMesh
from ..geometry.nearest import nearest_in_triangles
from ..geometry.polygons import Polygons
from ..geometry.triangle_mesh import TriangleMesh
from ..geometry.welding import boundary_splits, find_slivers, welded_vertices
from ..graphs import find, pair_keys, ragged_arange
from .division import Division, divide, split_at, whole_division
from .mirroring import Reflection, add_reflection, cut_at_plane, snap_to_planes

# Most triangles of a finer copy: solves on more would take minutes and gigabytes.
MOST_TRIANGLES = 1_000_000
# Factor between the edge lengths that are tried if the given one makes too many triangles.
_COARSER = 1.25


class TooFineError(SettingError):
    """A finer copy would have too many triangles.

    Attributes
    ----------
    longest : the given edge length
    factor : multiple of it that is long enough
    """

    def __init__(self, longest: float, factor: float) -> None:
        super().__init__(
            f"edges of at most {longest:.3g} would make more than {MOST_TRIANGLES} triangles of this mesh: "
            f"ask for edges of {round_up(factor * longest)}"
        )
        self.longest, self.factor = longest, factor

    def __reduce__(self) -> tuple[type["TooFineError"], tuple[float, float]]:
        return TooFineError, (self.longest, self.factor)


@dataclass(frozen=True)
class BoundSurface:
    """A mesh that lies on the surface of another one, the object.

    Attributes
    ----------
    vertices : (v, 3) in the object's space
    starts : (f,) first corner of each face; the corners of a face are consecutive
    corner_vertices : (c,) vertex of each corner
    parents, weights : (v, 3) vertices of the object, and their weights, which sum to 1
    face_source : (f,) face of the object, ascending
    corner_parents, corner_weights : (c, 3) corners of that face, and their weights, which sum to 1
    edge_vertices, edge_source : (e, 2) edges on edges of the object, and (e,) these, one row for each that was joined
    welded : number of vertices of the object that were joined with others, or with edges that they are on
    apart : for the positive side of a mirror and its image, the largest distance from them to the object's vertices on
        the other side; None for the object's own surface
    """

    vertices: np.ndarray
    starts: np.ndarray
    corner_vertices: np.ndarray
    parents: np.ndarray
    weights: np.ndarray
    face_source: np.ndarray
    corner_parents: np.ndarray
    corner_weights: np.ndarray
    edge_vertices: np.ndarray
    edge_source: np.ndarray
    welded: int
    apart: float | None = None


def refine(
    read: ObjectMesh, edges: ArrayLike, longest: float, axes: Sequence[int] = (), may_replace: bool = False
) -> BoundSurface:
    """Refine a mesh until no edge is longer than a limit, after joining boundary vertices with others at the same place
    and with edges that they are on.

    Faces without longer edges are kept. Faces without finite coordinates, triangles whose corners were joined, and
    loose elements are left out. Raises TooFineError if there would be too many triangles; AsymmetryError for a mesh
    that is not its own mirror image; SettingError where there is nothing on the positive side to replace the other.

    Parameters
    ----------
    edges : (e, 2) vertices of the object's edges
    longest : longest edge in the measured space
    axes : 0, 1 or 2, in which the mesh is symmetric and the surface is to be
    may_replace : where the mesh is not symmetric, use its positive side and the mirror image of that
    """
    vertices, places, starts = read.vertices, read.places, read.polygons.starts
    corner_vertices, triangle_corners = read.polygons.corner_vertices, read.polygons.triangle_corners
    edges = np.asarray(edges, int).reshape(-1, 2)
    own = welded_vertices(places, corner_vertices[triangle_corners])
    triangles = own[corner_vertices[triangle_corners]]
    usable = _find_usable(places, triangles) & ~find_slivers(places, triangles)
    corners = triangle_corners[usable]
    sides = _label_sides(edges, corner_vertices[corners], len(vertices))
    faces = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(corner_vertices)))
    whole, own, split = _close_edges(whole_division(places, own[corner_vertices[corners]], sides), own)
    joined, apart = own[corner_vertices], None
    if not axes or len(corners) == 0:
        division = _divide(whole, longest)
        parents = corners[division.source]
    else:
        mesh = TriangleMesh(places, joined[corners])
        polygons = _make_polygons(starts, joined, faces, corners)
        try:
            reflections = [Reflection.of(mesh, polygons, own[edges], axis) for axis in axes]
            division, parents = _divide_symmetrically(whole, corners, reflections, longest)
        except AsymmetryError:
            if not may_replace:
                raise
            division, parents, apart = _replace_by_images(whole, corners, len(edges), longest, axes)
    kept = _find_kept(division, parents, faces, triangle_corners, usable)
    joins = int((own != np.arange(len(own))).sum()) + split
    if apart is None:
        return _build_surface(vertices, starts, joined, faces, parents, division, kept, joins)
    surface = _build_surface(vertices, starts, joined, faces, parents, division, np.zeros_like(kept), joins)
    moved = division.vertices[np.unique(division.triangles)] @ np.linalg.inv(read.stretch).T
    return replace(surface, vertices=moved, apart=apart)


def _close_edges(whole: Division, own: np.ndarray) -> tuple[Division, np.ndarray, int]:
    """Join boundary edges with the vertices that are on them.

    Also returns (n,) ``own``, the vertex that represents each given one, and the number of points at which edges were
    split.
    """
    halves, vertices, shares = boundary_splits(whole.vertices, whole.triangles)
    if len(halves) == 0:
        return whole, own, 0
    whole = split_at(whole, halves, whole.vertices[vertices], shares)
    joined = welded_vertices(whole.vertices, whole.triangles)
    triangles = joined[whole.triangles]
    whole = replace(whole, triangles=triangles)[_find_usable(whole.vertices, triangles)]
    return whole, joined[own], len(halves)


def _make_polygons(starts: np.ndarray, corner_vertices: np.ndarray, faces: np.ndarray, corners: np.ndarray) -> Polygons:
    """Build the Polygons of faces from their usable triangles."""
    sizes = np.bincount(faces, minlength=len(starts))
    return Polygons(corner_vertices, starts, sizes, corners, faces[corners[:, 0]])


def _divide_symmetrically(
    whole: Division, corners: np.ndarray, reflections: Sequence[Reflection], longest: float
) -> tuple[Division, np.ndarray]:
    """Divide triangles symmetrically; also returns the (t, 3) corners that the weights refer to."""
    cut = snap_to_planes(whole, reflections)
    for reflection in reflections:
        cut = cut_at_plane(cut, reflection)
        cut = cut[(cut.vertices[cut.triangles, reflection.axis] >= 0).all(axis=1)]
    division = _divide(cut, longest, 2 ** len(reflections))
    parents = corners[division.source]
    for reflection in reflections:
        division, parents = add_reflection(division, parents, reflection)
    return division, parents


def _replace_by_images(
    whole: Division, corners: np.ndarray, edge_count: int, longest: float, axes: Sequence[int]
) -> tuple[Division, np.ndarray, float]:
    """Divide the positive side of mirrors and add its images, as :func:`_divide_symmetrically`.

    Parents and weights of a mirrored triangle are those of the nearest triangle of the side that is replaced. Also
    returns the largest distance of that side's vertices from the new surface.
    """
    mesh, of_axes = TriangleMesh(whole.vertices, whole.triangles), list(axes)
    reflections = [Reflection.of_half(mesh, int(corners.max()) + 1, edge_count, axis) for axis in axes]
    heights = snap_to_planes(whole, reflections).vertices[:, of_axes]
    for axis, positive in zip(axes, (heights[whole.triangles] > 0).any(axis=(0, 1)), strict=True):
        if not positive:
            raise SettingError(
                f"nothing of the mesh is on the positive side of the mirror in {'XYZ'[axis]}, which is mirrored: move "
                "its origin (Object > Set Origin), or switch the mirror off"
            )
    division, parents = _divide_symmetrically(whole, corners, reflections, longest)
    heights_of = division.vertices[division.triangles][:, :, of_axes]
    # A wall in the plane would be between both sides.
    outside = (heights_of != 0).any(axis=1).all(axis=1)
    division, parents, images = division[outside], parents[outside], (heights_of[outside] < 0).any(axis=(1, 2))
    places = division.vertices[division.triangles[images]]
    nearest = mesh.finder.nearest(places.mean(axis=1))[1]
    own = nearest_in_triangles(places, mesh.vertices[mesh.triangles[nearest].T][:, :, None])
    weights, source = division.weights.copy(), division.source.copy()
    weights[images] = own @ whole.weights[nearest]
    source[images] = whole.source[nearest]
    parents[images] = corners[source[images]]
    division = replace(division, weights=weights, source=source)
    replaced = mesh.vertices[mesh.used_vertices[(heights[mesh.used_vertices] < 0).any(axis=1)]]
    found = TriangleMesh(division.vertices, division.triangles).finder.nearest(replaced)[0]
    return division, parents, float(np.linalg.norm(found - replaced, axis=1).max(initial=0.0))


def _find_usable(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Find triangles with three distinct vertices at finite places, (t,) bool."""
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return distinct & np.isfinite(places).all(axis=1)[triangles].all(axis=1)


def _label_sides(edges: np.ndarray, triangles: np.ndarray, count: int) -> np.ndarray:
    """Find the (t, 3) edge from corner k to corner k + 1 of each triangle, -1 for diagonals of faces."""
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
    return find(pair_keys(edges, count), pair_keys(sides, count))


def _divide(whole: Division, longest: float, copies: int = 1) -> Division:
    """Divide triangles, of which there will be ``copies``, or raise a TooFineError."""
    most = MOST_TRIANGLES // copies
    division = divide(whole, longest, most)
    if division is not None:
        return division
    factor = 1.0
    while division is None:
        factor *= _COARSER
        division = divide(whole, factor * longest, most)
    raise TooFineError(longest, factor)


def _find_kept(
    division: Division,
    parents: np.ndarray,
    faces: np.ndarray,
    triangle_corners: np.ndarray,
    usable: np.ndarray,
) -> np.ndarray:
    """Find the faces to keep, (p,) bool: those with as many triangles as before, all of them whole."""
    count = faces[-1] + 1 if len(faces) else 0
    before, now = (np.bincount(faces[of[:, 0]], minlength=count) for of in (triangle_corners, parents))
    kept = (before > 0) & (before == now)
    kept[faces[triangle_corners[~usable, 0]]] = False
    whole = (division.weights.max(axis=2) == 1).all(axis=1)
    kept[faces[parents[~whole, 0]]] = False
    return kept


def _build_surface(
    vertices: np.ndarray,
    starts: np.ndarray,
    joined: np.ndarray,
    faces: np.ndarray,
    parents_of: np.ndarray,
    division: Division,
    kept: np.ndarray,
    welded: int,
) -> BoundSurface:
    """Build the surface from kept faces and from the divided triangles of the others."""
    rows = ~kept[faces[parents_of[:, 0]]]
    old = np.flatnonzero(kept[faces])
    sizes = np.concatenate([np.bincount(faces, minlength=len(starts))[kept], np.full(int(rows.sum()), 3)])
    source = np.concatenate([np.flatnonzero(kept), faces[parents_of[rows, 0]]])
    names = np.concatenate([joined[old], division.triangles[rows].ravel()])
    parents = np.concatenate([np.repeat(old[:, None], 3, axis=1), np.repeat(parents_of[rows], 3, axis=0)])
    weights = np.concatenate([np.broadcast_to([1.0, 0.0, 0.0], (len(old), 3)), division.weights[rows].reshape(-1, 3)])
    # Faces are in the order of the object's, vertices in the order of their first names.
    order = np.argsort(source, kind="stable")
    first = np.cumsum(sizes) - sizes
    moved = np.repeat(first[order], sizes[order]) + ragged_arange(sizes[order])[1]
    names, parents, weights = names[moved], parents[moved], weights[moved]
    # A parent without weight may be anywhere, even not finite.
    heaviest = np.take_along_axis(parents, weights.argmax(axis=1)[:, None], axis=1)
    parents = np.where(weights > 0, parents, heaviest)
    used, numbers = np.unique(names, return_inverse=True)
    is_between = weights.max(axis=1) < 1  # a given vertex may also be on an edge that was split there
    where = np.lexsort((is_between, names))[np.searchsorted(np.sort(names), used)]
    vertex_parents = joined[parents[where]]
    ends = np.stack([division.triangles, np.roll(division.triangles, -1, axis=1)], axis=2)[division.sides >= 0]
    lines = np.unique(np.column_stack([np.sort(ends, axis=1), division.sides[division.sides >= 0]]), axis=0)
    return BoundSurface(
        vertices=np.einsum("vk,vkx->vx", weights[where], vertices[vertex_parents]),
        starts=np.cumsum(sizes[order]) - sizes[order],
        corner_vertices=numbers.reshape(-1),
        parents=vertex_parents,
        weights=weights[where],
        face_source=source[order],
        corner_parents=parents,
        corner_weights=weights,
        edge_vertices=np.searchsorted(used, lines[:, :2]),
        edge_source=lines[:, 2],
        welded=welded,
    )
