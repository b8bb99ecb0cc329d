# SPDX-License-Identifier: GPL-3.0-or-later
"""A finer copy of a mesh whose vertices, faces and corners know where they lie on the mesh that it was made of."""

from dataclasses import dataclass

import numpy as np

from ..errors import SettingError
from ..geometry.polygons import Polygons
from ..geometry.triangle_mesh import TriangleMesh
from ..geometry.welding import welded_vertices
from .division import divided, undivided
from .mirroring import Reflection, cut_at_plane, on_planes, on_positive_side, with_reflection

# Triangles of a finer copy: more would take minutes and gigabytes to solve on.
MOST_TRIANGLES = 1_000_000
# How much longer the edges are that are tried where those that were asked for make too many triangles.
_COARSER = 1.25


class TooFineError(SettingError):
    """A finer copy would have too many triangles.

    Attributes
    ----------
    factor : how many times as long the edges of a copy are that was made instead
    """

    def __init__(self, longest, factor):
        super().__init__(
            f"edges of at most {longest:.3g} would make more than {MOST_TRIANGLES} triangles of this mesh: "
            f"ask for edges of {factor * longest:.3g}"
        )
        self.longest, self.factor = longest, factor

    def __reduce__(self):
        return TooFineError, (self.longest, self.factor)


@dataclass(frozen=True)
class BoundSurface:
    """A mesh that lies on the surface of another one, the object.

    Attributes
    ----------
    vertices : (v, 3) places, in the object's space
    starts : (f,) first corner of each face; the corners of a face follow one another
    corner_vertices : (c,) vertex of each corner
    parents : (v, 3) vertices of the object, with
    weights : (v, 3) that add up to one
    face_source : (f,) face of the object, ascending
    corner_parents : (c, 3) corners of that face, with
    corner_weights : (c, 3) that add up to one
    edge_vertices : (e, 2) edges that lie on an edge of the object; where edges were joined, one row for each of them
    edge_source : (e,) that edge of the object
    welded : vertices of the object that were joined with others
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


def refine(
    vertices, starts, corner_vertices, edges, longest, stretch=None, triangle_corners=None, axes=()
) -> BoundSurface:
    """The surface of a mesh with boundary vertices joined and without edges longer than a limit.

    Faces stay as they are where none of their triangles has a longer edge. Faces without a finite place, and triangles
    whose corners were joined, are left out, and so is what belongs to no face.

    Parameters
    ----------
    vertices : (n, 3) places, in the object's space
    starts : (p,) first corner of each face
    corner_vertices : (k,) vertex of each corner
    edges : (e, 2) vertices of the object's edges
    longest : length of the longest edge, as measured
    stretch : (3, 3) scale that lengths are measured with
    triangle_corners : (t, 3) corners of the triangles that faces consist of, face by face; by default each face is
        split from its first corner, which only suits convex ones
    axes : 0, 1 or 2, in which the surface is to be its own mirror image, as the mesh is

    Raises
    ------
    TooFineError
        where there would be too many triangles
    AsymmetryError
        for a mesh that is not its own mirror image
    """
    vertices, starts = np.asarray(vertices, float), np.asarray(starts, int)
    corner_vertices, edges = np.asarray(corner_vertices, int), np.asarray(edges, int).reshape(-1, 2)
    places = vertices if stretch is None else vertices @ np.asarray(stretch).T
    if triangle_corners is None:
        triangle_corners = fan_triangles(starts, len(corner_vertices))
    own = welded_vertices(places, corner_vertices[triangle_corners])
    joined = own[corner_vertices]
    usable = _usable(places, joined[triangle_corners])
    corners = triangle_corners[usable]
    sides = _labels(edges, corner_vertices[corners], len(vertices))
    faces = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(corner_vertices)))
    whole = undivided(places, joined[corners], sides)
    if not axes or len(corners) == 0:
        division = _divided(whole, longest)
        parents = corners[division.source]
    else:
        mesh = TriangleMesh(places, joined[corners])
        polygons = _polygons(starts, joined, faces, corners)
        reflections = [Reflection.of(mesh, polygons, own[edges], axis) for axis in axes]
        division, parents = _mirrored(whole, corners, reflections, longest)
    kept = _kept(division, parents, faces, corners, triangle_corners, usable)
    joins = int((own != np.arange(len(own))).sum())
    return _bound(vertices, starts, joined, faces, parents, division, kept, joins)


def _polygons(starts, corner_vertices, faces, corners):
    """The Polygons of faces, without what belongs to no usable triangle."""
    sizes = np.bincount(faces, minlength=len(starts))
    return Polygons(corner_vertices, starts, sizes, corners, faces[corners[:, 0]])


def _mirrored(whole, corners, reflections, longest):
    """The division of triangles that is its own mirror image, and (t, 3) the corners that its weights are for."""
    cut = on_planes(whole, reflections)
    for reflection in reflections:
        cut = cut_at_plane(cut, reflection)
        cut = cut[on_positive_side(cut, reflection)]
    division = _divided(cut, longest, 2 ** len(reflections))
    parents = corners[division.source]
    for reflection in reflections:
        division, parents = with_reflection(division, parents, reflection)
    return division, parents


def fan_triangles(starts, count):
    """(t, 3) corners of the triangles from the first corner of each face, of ``count`` corners in all."""
    sizes = np.diff(starts, append=count)
    first = np.repeat(starts, np.maximum(sizes - 2, 0))
    corners = np.arange(count)
    second = corners[(corners > np.repeat(starts, sizes)) & (corners < np.repeat(starts + sizes - 1, sizes))]
    return np.column_stack([first, second, second + 1])


def _usable(places, triangles):
    """(t,) bool: triangles with three vertices at finite places."""
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return distinct & np.isfinite(places).all(axis=1)[triangles].all(axis=1)


def _labels(edges, triangles, count):
    """(t, 3) the edge from corner k to corner k + 1 of each triangle, -1 where it is a diagonal of a face."""
    ends = np.sort(edges, axis=1)
    keys = ends[:, 0] * count + ends[:, 1]
    order = np.argsort(keys)
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    asked = ends[:, :, 0] * count + ends[:, :, 1]
    if len(edges) == 0:
        return np.full(asked.shape, -1)
    found = order[np.minimum(np.searchsorted(keys[order], asked), len(order) - 1)]
    return np.where(keys[found] == asked, found, -1)


def _divided(whole, longest, copies=1):
    """The division, of which there will be so many copies."""
    most = MOST_TRIANGLES // copies
    division = divided(whole, longest, most)
    if division is not None:
        return division
    factor = 1.0
    while division is None:
        factor *= _COARSER
        division = divided(whole, factor * longest, most)
    raise TooFineError(longest, factor)


def _kept(division, parents, faces, corners, triangle_corners, usable):
    """(p,) bool: faces that stay as they are: they have as many triangles as before, and all of them are whole."""
    count = faces[-1] + 1 if len(faces) else 0
    before, now = (np.bincount(faces[of[:, 0]], minlength=count) for of in (triangle_corners, parents))
    kept = (before > 0) & (before == now)
    kept[faces[triangle_corners[~usable, 0]]] = False
    whole = (division.weights.max(axis=2) == 1).all(axis=1)
    kept[faces[parents[~whole, 0]]] = False
    return kept


def _bound(vertices, starts, joined, faces, parents_of, division, kept, welded):
    """The surface of the divided triangles of faces that are not kept, and of the others."""
    rows = ~kept[faces[parents_of[:, 0]]]
    old = np.flatnonzero(kept[faces])
    sizes = np.concatenate([np.bincount(faces, minlength=len(starts))[kept], np.full(int(rows.sum()), 3)])
    source = np.concatenate([np.flatnonzero(kept), faces[parents_of[rows, 0]]])
    names = np.concatenate([joined[old], division.triangles[rows].ravel()])
    parents = np.concatenate([np.repeat(old[:, None], 3, axis=1), np.repeat(parents_of[rows], 3, axis=0)])
    weights = np.concatenate([np.broadcast_to([1.0, 0.0, 0.0], (len(old), 3)), division.weights[rows].reshape(-1, 3)])
    # Faces in the order of the object's, and vertices in that of the first that were there.
    order = np.argsort(source, kind="stable")
    first = np.cumsum(sizes) - sizes
    moved = np.repeat((first)[order], sizes[order]) + _within(sizes[order])
    names, parents, weights = names[moved], parents[moved], weights[moved]
    # A parent without weight may be anywhere, even at no finite place.
    heaviest = np.take_along_axis(parents, weights.argmax(axis=1)[:, None], axis=1)
    parents = np.where(weights > 0, parents, heaviest)
    used, where, numbers = np.unique(names, return_index=True, return_inverse=True)
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


def _within(sizes):
    """(sum,) 0, 1 ... size - 1 for each size."""
    return np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
