# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions across the layers of a solid: unit vectors at its vertices.

A source of guidance gives vectors. Where it has no direction (zero vectors, a vanishing gradient), the others are
extended smoothly. Where these cancel each other, and on pieces of the solid without any, directions are zero: the phase
is constant there.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ...errors import SettingError, name_elements
from ...geometry.polylines import check_length, polyline_length
from ...geometry.tet_mesh import TetMesh
from ...graphs import ragged_arange
from .guides import checked_axis
from .potentials import extend_harmonically

# Vectors shorter than this share of the longest have no direction.
ROUNDING = 1e-9


def gradient_vectors(mesh: TetMesh, values: ArrayLike) -> np.ndarray:
    """(n, 3) gradients of the tetrahedra, averaged by volume, from (n,) values, nan on pieces without values.

    Raises :class:`SettingError` for another shape, or the same value everywhere.
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
    # Relative to the values themselves: rounding errors of a constant are not a slope.
    if np.linalg.norm(means, axis=1).max(initial=0) * mesh.edge_lengths.mean() <= 1e-12 * np.nanmax(np.abs(values)):
        raise SettingError("the guiding values are the same all over the solid: give them a slope")
    return means


def axis_directions(mesh: TetMesh, axis: ArrayLike) -> np.ndarray:
    """A constant direction, (3,) of any length but zero."""
    axis = checked_axis(axis)
    return np.tile(axis / np.linalg.norm(axis), (mesh.vertex_count, 1))


def vector_directions(mesh: TetMesh, vectors: ArrayLike) -> np.ndarray:
    """The directions of given (n, 3) vectors, whose lengths do not count; as :func:`check_vectors`."""
    return extend_directions(mesh, check_vectors(mesh, vectors))


def check_vectors(mesh: TetMesh, vectors: ArrayLike) -> np.ndarray:
    """Given (n, 3) vectors; zero where the others are to be extended.

    Raises :class:`SettingError` for another shape, vectors that are not finite, or only zeros.
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


def curve_vectors(mesh: TetMesh, curves: Sequence[ArrayLike], across: bool = False) -> np.ndarray:
    """Directions along (k, 3) polylines, which layers then cross, or away from them, so that layers wrap around them.

    Every vertex gets the tangent at the nearest point of any curve, or the direction straight away from that point.

    Raises :class:`SettingError` for no curves, other shapes, and curves without length or far too long for the mesh.
    """
    points, tangents, lengths = _stations(curves, mesh.edge_lengths.mean() / 2)
    _, nearest = cKDTree(points).query(mesh.vertices)
    directions = tangents[nearest]
    if across:
        away, lengths = mesh.vertices - points[nearest], lengths[nearest]
        # Each station represents a piece of the curve.
        along = np.clip(np.einsum("nx,nx->n", away, directions), -lengths / 2, lengths / 2)
        directions = away - along[:, None] * directions
    return directions


def _stations(curves: Sequence[ArrayLike], step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Midpoints of pieces of curves of at most a step's length, with their unit tangents and lengths."""
    points, tangents, sizes = [], [], []
    polylines = [np.asarray(curve, float) for curve in curves]
    for number, curve in enumerate(polylines):
        if curve.ndim != 2 or curve.shape[1] != 3 or len(curve) < 2 or not np.isfinite(curve).all():
            raise SettingError(f"curve {number} has the shape {curve.shape}: give two or more points in space")
    check_length("the guiding curve", sum(polyline_length(curve) for curve in polylines), step)
    for curve in polylines:
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


def have_directions(mesh: TetMesh, vectors: np.ndarray) -> np.ndarray:
    """(n,) bool, which of (n, 3) vectors are long enough to have a direction."""
    lengths = np.linalg.norm(vectors, axis=1)
    known = lengths > ROUNDING * lengths.max()
    known[mesh.loose_vertices] = False
    return known


def extend_directions(mesh: TetMesh, vectors: np.ndarray) -> np.ndarray:
    """(n, 3) unit vectors, extended over vertices without a direction; zero on pieces without any."""
    known, lengths = have_directions(mesh, vectors), np.linalg.norm(vectors, axis=1)
    units = np.divide(vectors, lengths[:, None], out=np.zeros_like(vectors), where=known[:, None])
    if known.all() or not known.any():
        return units
    spread = np.nan_to_num(extend_harmonically(mesh, known, units[known]))
    lengths = np.linalg.norm(spread, axis=1)
    return np.divide(spread, lengths[:, None], out=np.zeros_like(spread), where=lengths[:, None] > ROUNDING)
