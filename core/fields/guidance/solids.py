# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in which the layers of a solid follow one another: unit vectors at its vertices.

A source of guidance gives vectors. Where it has no direction (zero vectors, a gradient that vanishes), the others are
extended smoothly. Where these cancel each other, and on pieces of the solid without any, directions are zero: nothing
is to change there.
"""

import numpy as np
from scipy.spatial import cKDTree

from ...errors import SettingError, name_elements
from ...geometry.polylines import check_length, polyline_length
from ...graphs import ragged_arange
from .potentials import extend_harmonically, harmonic_function
from .solid_distance import solid_distance

# Vectors shorter than this share of the longest have no direction.
ROUNDING = 1e-9


def harmonic_directions(mesh, low, high):
    """From one set of vertices to another, (n,) bool each, along the gradient of :func:`harmonic_function`."""
    return gradient_directions(mesh, harmonic_function(mesh, low, high))


def distance_directions(mesh, sources):
    """Away from a set of vertices, (n,) bool, on the shortest way inside the solid (:func:`solid_distance`)."""
    return gradient_directions(mesh, solid_distance(mesh, sources))


def gradient_directions(mesh, values):
    """The direction in which a function grows fastest, (n, 3) unit vectors; as :func:`gradient_vectors`."""
    return extend_directions(mesh, gradient_vectors(mesh, values))


def gradient_vectors(mesh, values):
    """Gradients of the tetrahedra, averaged by volume.

    Parameters
    ----------
    mesh : TetMesh
    values : (n,); nan on pieces that have no values

    Returns
    -------
    (n, 3)

    Raises
    ------
    SettingError
        for another shape, or the same value everywhere
    """
    values = np.asarray(values, float)
    if values.shape != (mesh.vertex_count,):
        raise SettingError(
            f"the guiding values have the shape {values.shape}: give one to each of the solid's "
            f"{mesh.vertex_count} vertices"
        )
    gradients = mesh.gradients(np.nan_to_num(values)[mesh.tets])
    gradients[~np.isfinite(values[mesh.tets]).all(axis=1)] = 0
    means = mesh.at_vertices(gradients)
    # Against the values themselves: what rounding makes of a constant is no slope.
    if np.linalg.norm(means, axis=1).max(initial=0) * mesh.edge_lengths.mean() <= 1e-12 * np.nanmax(np.abs(values)):
        raise SettingError("the guiding values are the same all over the solid: give them a slope")
    return means


def axis_directions(mesh, axis):
    """The same direction everywhere, (3,) of any length but zero."""
    axis = np.asarray(axis, float)
    if axis.shape != (3,) or not np.isfinite(axis).all() or not axis.any():
        raise SettingError(f"the axis {axis.tolist()} has no direction: give three finite numbers, not all zero")
    return np.tile(axis / np.linalg.norm(axis), (mesh.vertex_count, 1))


def vector_directions(mesh, vectors):
    """The directions of given (n, 3) vectors, whose lengths do not count; as :func:`check_vectors`."""
    return extend_directions(mesh, check_vectors(mesh, vectors))


def check_vectors(mesh, vectors):
    """Given (n, 3) vectors; zero where the others are to be extended.

    Raises
    ------
    SettingError
        for another shape, vectors that are not finite, or none but zeros
    """
    vectors = np.asarray(vectors, float)
    if vectors.shape != mesh.vertices.shape:
        raise SettingError(
            f"the guidance vectors have the shape {vectors.shape}: give one to each of the solid's "
            f"{mesh.vertex_count} vertices"
        )
    bad = np.flatnonzero(~np.isfinite(vectors).all(axis=1))
    if len(bad):
        raise SettingError(f"the guidance vector of {name_elements('vertex', bad)} is not finite: set its numbers")
    if not vectors.any():
        raise SettingError("every guidance vector of the solid is zero: give at least one vertex a direction")
    return vectors


def curve_directions(mesh, curves, across=False):
    """Directions of :func:`curve_vectors`."""
    return extend_directions(mesh, curve_vectors(mesh, curves, across))


def curve_vectors(mesh, curves, across=False):
    """Along curves, so that layers cross them, or away from them, so that layers lie around them like skins.

    Every vertex takes the direction of the curve at the nearest place of any, or the one straight away from it.

    Parameters
    ----------
    mesh : TetMesh
    curves : sequence of (k, 3) polylines, k >= 2
    across : bool

    Raises
    ------
    SettingError
        for no curves, other shapes, and curves without length or far too long for the mesh
    """
    points, tangents, lengths = _stations(curves, mesh.edge_lengths.mean() / 2)
    _, nearest = cKDTree(points).query(mesh.vertices)
    if not across:
        return tangents[nearest]
    away = mesh.vertices - points[nearest]
    # Each station stands for a piece of the curve of its own length.
    along = np.einsum("nx,nx->n", away, tangents[nearest])
    along = np.clip(along, -lengths[nearest] / 2, lengths[nearest] / 2)
    return away - along[:, None] * tangents[nearest]


def _stations(curves, step):
    """Middles of pieces of at most a step's length into which curves are cut, their unit tangents and lengths."""
    points, tangents, sizes = [], [], []
    curves = [np.asarray(curve, float) for curve in curves]
    for number, curve in enumerate(curves):
        if curve.ndim != 2 or curve.shape[1] != 3 or len(curve) < 2 or not np.isfinite(curve).all():
            raise SettingError(f"curve {number} has the shape {curve.shape}: give two or more points in space")
    check_length("the guiding curve", sum(polyline_length(curve) for curve in curves), step)
    for curve in curves:
        along = np.diff(curve, axis=0)
        lengths = np.linalg.norm(along, axis=1)
        begins, along, lengths = curve[:-1][lengths > 0], along[lengths > 0], lengths[lengths > 0]
        counts = np.ceil(lengths / step).astype(int)
        which, place = ragged_arange(counts)
        points.append(begins[which] + ((place + 0.5) / counts[which])[:, None] * along[which])
        tangents.append((along / lengths[:, None])[which])
        sizes.append((lengths / counts)[which])
    if sum(map(len, points)) == 0:
        raise SettingError("the guiding curves have no length: draw at least one inside the solid")
    return np.concatenate(points), np.concatenate(tangents), np.concatenate(sizes)


def have_directions(mesh, vectors):
    """(n,) bool, which of (n, 3) vectors have a direction of their own."""
    lengths = np.linalg.norm(vectors, axis=1)
    known = lengths > ROUNDING * lengths.max()
    known[mesh.loose_vertices] = False
    return known


def extend_directions(mesh, vectors):
    """Unit vectors, extended over vertices where there are none; zero on pieces without any."""
    known, lengths = have_directions(mesh, vectors), np.linalg.norm(vectors, axis=1)
    units = np.divide(vectors, lengths[:, None], out=np.zeros_like(vectors), where=known[:, None])
    if known.all() or not known.any():
        return units
    spread = np.nan_to_num(extend_harmonically(mesh, known, units[known]))
    lengths = np.linalg.norm(spread, axis=1)
    return np.divide(spread, lengths[:, None], out=np.zeros_like(spread), where=lengths[:, None] > ROUNDING)
