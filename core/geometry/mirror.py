# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirror images of vertices on a surface that is symmetric about coordinate planes through the origin."""

import numpy as np
from scipy.spatial import cKDTree

from ..errors import AsymmetryError
from ..graphs import components, label_rows
from ..unit_vectors import unit_vectors
from .polygons import Polygons
from .triangle_mesh import TriangleMesh

# Largest distance of a vertex from its mirror image, in edge lengths.
TOLERANCE = 1e-3


def mirrored_vertices(mesh: TriangleMesh, polygons: Polygons, axis: int) -> np.ndarray:
    """Find the (n,) mirror images of the vertices: coordinate ``axis`` (0, 1, 2) changes its sign.

    Vertices at the same place, as on a mesh that was cut open, are distinguished by their faces. Loose vertices mirror
    themselves. Raises AsymmetryError with the vertices that have no counterpart, or whose faces have none.
    """
    return mirrored_corners(mesh, polygons, axis)[0]


def is_mirrored(mesh: TriangleMesh, polygons: Polygons, axes: str) -> bool:
    """Whether all vertices have mirror images in axes, as of :func:`mirrored_vertices`."""
    try:
        for axis in axes:
            mirrored_vertices(mesh, polygons, "XYZ".index(axis))
    except AsymmetryError:
        return False
    return True


def mirrored_corners(mesh: TriangleMesh, polygons: Polygons, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Find the (n,) mirror images of the vertices and (c,) of the corners, as :func:`mirrored_vertices`."""
    used = np.unique(mesh.triangles)
    places, image = _mirrored_places(mesh.vertices[used], axis, TOLERANCE * np.median(mesh.edge_lengths))
    lonely = used[image[places] < 0]
    partner, opposite = np.arange(mesh.vertex_count), np.arange(len(polygons.corner_vertices))
    if len(lonely) == 0:
        place_of = np.zeros(mesh.vertex_count, int)
        place_of[used] = places
        lonely = _match_by_faces(polygons, place_of, image, partner, opposite)
    if len(lonely):
        raise AsymmetryError("XYZ"[axis], lonely)
    return partner, opposite


def mirror_planes(stretch: np.ndarray, axes: str) -> np.ndarray:
    """Find the (k, 3) unit normals of planes through the origin across axes of an object, in the measured space."""
    return unit_vectors(np.linalg.inv(stretch)[["XYZ".index(axis) for axis in axes]])


def sides_of_planes(mesh: TriangleMesh, units: np.ndarray) -> np.ndarray:
    """Find the (n, k) side of each of (k, 3) planes that vertices are on: 1, -1, or 0 on the plane."""
    heights = mesh.vertices @ units.T
    return np.where(np.abs(heights) <= TOLERANCE * np.median(mesh.edge_lengths), 0, np.sign(heights))


def are_divided_by_edges(mesh: TriangleMesh, units: np.ndarray) -> bool:
    """Whether planes lead along edges of a mesh only, and no triangle lies in one."""
    sides = sides_of_planes(mesh, units)[mesh.triangles]
    low, high = sides.min(axis=1), sides.max(axis=1)
    return not (((low < 0) & (high > 0)) | ((low == 0) & (high == 0))).any()


def symmetric_axes(points: np.ndarray, centers: np.ndarray, near: float) -> tuple[int, ...]:
    """Find the axes in which (n, 3) vertices and (f, 3) centers of faces have mirror images within a distance, and the
    vertices do not all lie in the plane."""
    low, high = points.min(axis=0), points.max(axis=0)
    axes = np.flatnonzero((np.abs(low + high) <= near) & (high - low > near)).tolist()
    for places in (points, centers) if axes else ():
        tree, bound = cKDTree(places), np.nextafter(near, np.inf)  # beyond the bound the search takes long
        images = [places * (1 - 2 * np.eye(3)[axis]) for axis in axes]
        found = [np.isfinite(tree.query(image, distance_upper_bound=bound)[0]).all() for image in images]
        axes = [axis for axis, has_images in zip(axes, found, strict=True) if has_images]
    return tuple(axes)


def _mirrored_places(points: np.ndarray, axis: int, near: float) -> tuple[np.ndarray, np.ndarray]:
    """Label the places of points, (n,), and find the place at the mirror image of each, or -1."""
    tree = cKDTree(points)
    pairs = tree.query_pairs(near, output_type="ndarray")
    places = components(len(points), pairs)
    first = np.unique(places, return_index=True)[1]
    mirrored = points[first].copy()
    mirrored[:, axis] *= -1
    distances, nearest = tree.query(mirrored)
    image = np.where(distances <= near, places[nearest], -1)
    image[image[image] != np.arange(len(image))] = -1
    return places, image


def _match_by_faces(
    polygons: Polygons, places: np.ndarray, image: np.ndarray, partner: np.ndarray, opposite: np.ndarray
) -> np.ndarray:
    """Fill in the vertices ``partner`` and the corners ``opposite`` by matching mirrored faces; returns the vertices
    without a counterpart."""
    lonely = []
    for size in np.unique(polygons.sizes):
        corners = polygons.starts[polygons.drawn & (polygons.sizes == size), None] + np.arange(size)
        vertices = polygons.corner_vertices[corners]
        here, there = np.sort(places[vertices], axis=1), np.sort(image[places[vertices]], axis=1)
        labels = label_rows(np.concatenate([here, there]))
        face_of = np.full(labels.max() + 1, -1)
        face_of[labels[: len(vertices)]] = np.arange(len(vertices))
        face = face_of[labels[len(vertices) :]]
        lonely.append(vertices[face < 0].ravel())
        corner = (places[vertices[face]][:, None] == image[places[vertices]][:, :, None]).argmax(axis=2)
        partner[vertices] = np.take_along_axis(vertices[face], corner, axis=1)
        opposite[corners] = np.take_along_axis(corners[face], corner, axis=1)
    corners = polygons.corner_vertices[polygons.drawn[polygons.corner_faces]]
    lonely.append(corners[partner[partner[corners]] != corners])
    return np.concatenate(lonely)
