# SPDX-License-Identifier: GPL-3.0-or-later
"""Sources of guidance: directions that a field is drawn to, with a weight at each vertex.

A guide has no symmetry of its own. Directions given as lines or crosses (curvature, field files) are one
representative, for fields of that symmetry or a multiple of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...errors import SettingError, name_elements
from ...geometry.triangle_mesh import TriangleMesh
from .curvature import principal_directions
from .face_directions import face_gradients, sum_at_vertices
from .fronts import front_distance

# Where a gradient is weaker than this share of its mean over the surface, its direction has less weight.
FAINT = 0.1
# Differences below this share of the largest value are rounding, not a slope.
ROUNDING = 1e-12
# Vectors whose tangential part is less than this share of their length have no direction on the surface.
UPRIGHT = 1e-6


@dataclass(frozen=True)
class Guide:
    """A direction and a weight at every vertex.

    Attributes
    ----------
    angles : (n,) radians in the vertices' tangent planes
    weights : (n,) share of the whole area times a confidence in [0, 1] (for curvature, on another scale): free of units
        and independent of the resolution, exactly 0 where there is no direction
    """

    angles: np.ndarray
    weights: np.ndarray


def gradient_guide(mesh: TriangleMesh, values: ArrayLike, contour: bool = False) -> Guide:
    """The direction in which a scalar grows fastest, or along its level lines.

    Gradients of the faces are averaged by area. The confidence is the length of the mean over the mean length, so that
    it falls where the faces around a vertex disagree, times a smooth step from 0 to 1 while the gradient rises from
    zero to a tenth of its mean over the surface's sloping part.

    Raises :class:`SettingError` for another shape, values that are not finite, or the same value everywhere.

    Parameters
    ----------
    values : (n,) at vertices, or (m, 3) at the corners of triangles (one coordinate of a UV map)
    contour : turn a quarter counterclockwise, along the level lines with larger values on the right
    """
    values = np.asarray(values, float)
    if values.shape not in ((mesh.vertex_count,), mesh.triangles.shape):
        raise SettingError(
            f"the values have the shape {values.shape}: give one to each of the {mesh.vertex_count} vertices, "
            f"or three to each of the {mesh.triangle_count} triangles"
        )
    _refuse_infinite(values, "value", "vertex" if values.ndim == 1 else "triangle")
    guide = _slope_guide(mesh, values if values.ndim == 2 else values[mesh.triangles], contour)
    if not guide.weights.any():
        raise SettingError("the guiding values are the same all over: give them a slope, or leave this guide out")
    return guide


def axis_guide(mesh: TriangleMesh, axis: ArrayLike) -> Guide:
    """An axis in space, (3,) of any length but zero, projected to the surface.

    The confidence is the square of the tangential share of the axis.

    Raises :class:`SettingError` for another shape, an axis that is zero or not finite, or at right angles to the whole
    surface.
    """
    axis = checked_axis(axis)
    guide = _projected_guide(mesh, np.broadcast_to(axis, mesh.vertices.shape))
    if not guide.weights.any():
        raise SettingError(f"the axis {axis.tolist()} points straight out of the surface everywhere: tilt it")
    return guide


def checked_axis(axis: ArrayLike) -> np.ndarray:
    """(3,) an axis in space; refuses other shapes, zero, and numbers that are not finite."""
    axis = np.asarray(axis, float)
    if axis.shape != (3,) or not np.isfinite(axis).all() or not axis.any():
        raise SettingError(f"the axis {axis.tolist()} has no direction: give three finite numbers, not all zero")
    return axis


def vectors_guide(mesh: TriangleMesh, vectors: ArrayLike) -> Guide:
    """Given (n, 3) vectors of any length, projected to the surface; zero where there is no direction.

    The confidence is the square of the tangential share of the vector.

    Raises :class:`SettingError` for another shape, vectors that are not finite, or no vector with a tangential part.
    """
    vectors = np.asarray(vectors, float)
    if vectors.shape != mesh.vertices.shape:
        raise SettingError(
            f"the guidance vectors have the shape {vectors.shape} where {mesh.vertices.shape} is needed: "
            "give one vector to each vertex"
        )
    _refuse_infinite(vectors, "guidance vector", "vertex")
    guide = _projected_guide(mesh, vectors)
    if not guide.weights.any():
        raise SettingError(
            "every guidance vector is zero or points straight out of the surface: "
            "give at least one vertex a tangential direction"
        )
    return guide


def curvature_guide(mesh: TriangleMesh, largest: bool = True, detail: float = 0.0) -> Guide:
    """The line of largest or smallest principal curvature; arguments and weights as :func:`principal_directions`."""
    squares, weights = principal_directions(mesh, 2, largest, detail)
    return Guide(np.angle(squares) / 2, weights)


def distance_guide(mesh: TriangleMesh, sources: ArrayLike, contour: bool = False) -> Guide:
    """The direction away from (n,) bool sources on the shortest way, or along the curves of equal distance.

    Pieces without a source have no weight.

    Raises :class:`SettingError` for a set that is empty, of another length, or of all vertices. ``contour``: turn a
    quarter counterclockwise, along the curves with the sources on the left.
    """
    distances = np.nan_to_num(front_distance(mesh, sources))
    guide = _slope_guide(mesh, distances[mesh.triangles], contour)
    if not guide.weights.any():
        raise SettingError("every vertex is at distance 0: leave at least one out of the group of sources")
    return guide


def face_guide(mesh: TriangleMesh, face_values: np.ndarray, symmetry: int) -> Guide:
    """A guide from directions in faces, averaged to the vertices, with the confidence of :func:`gradient_guide`.

    ``face_values`` are (m,) complex in the faces' planes: area times confidence or slope, times the ``symmetry``-th
    power of the direction.
    """
    sizes = np.abs(face_values)
    sum_of_sizes = _sum_at_vertices(mesh, sizes)
    areas = _sum_at_vertices(mesh, mesh.areas)
    totals = sum_at_vertices(mesh, face_values, symmetry)
    typical = sizes.sum() / max(mesh.areas[sizes > 0].sum(), np.finfo(float).tiny)
    agreement = _ratio(np.abs(totals), sum_of_sizes)
    agreement[agreement < ROUNDING] = 0
    strength = np.minimum(_ratio(sum_of_sizes, FAINT * typical * areas), 1)
    confidence = np.minimum(agreement, 1) * strength**2 * (3 - 2 * strength)
    return Guide(np.angle(totals) / symmetry, _area_shares(mesh) * confidence)


def blend_guides(guides: Sequence[Guide], shares: ArrayLike, symmetry: int) -> tuple[np.ndarray, np.ndarray]:
    """One target equivalent to several guides, each with a share, not negative.

    On the unit circle ``sum_k w_k |phi - q_k|^2`` and ``|q| |phi - q / |q||^2`` with ``q = sum_k w_k q_k`` differ by
    the constant ``2 (sum_k w_k - |q|)``. Here ``w_k`` is share times weight and ``q_k`` the power of the direction.

    Raises :class:`SettingError` for no guides, guides of different meshes, or shares that are not one finite number >=
    0 for each.

    Returns
    -------
    values : (n,) complex, unit modulus; 1 where the weight is 0
    weights : (n,) modulus of q; 0 where the guides cancel each other
    """
    shares = np.asarray(shares, float)
    if len(guides) == 0:
        raise SettingError("there are no guides to blend: give at least one")
    if shares.shape != (len(guides),) or not (np.isfinite(shares) & (shares >= 0)).all():
        raise SettingError(
            f"the shares {shares.tolist()} do not fit {len(guides)} guides: give each a finite number, 0 or more"
        )
    if len({len(guide.angles) for guide in guides}) > 1:
        raise SettingError("the guides belong to meshes of different size: make them all on the same one")
    weights = [share * guide.weights for share, guide in zip(shares, guides, strict=True)]
    powers = [np.exp(1j * symmetry * guide.angles) for guide in guides]
    total = np.einsum("ki,ki->i", weights, powers)
    modulus = np.abs(total)
    modulus[modulus <= ROUNDING * np.sum(weights, axis=0)] = 0
    return np.divide(total, modulus, out=np.ones_like(total), where=modulus > 0), modulus


def _slope_guide(mesh: TriangleMesh, corner_values: np.ndarray, contour: bool) -> Guide:
    spans = np.ptp(corner_values, axis=1)
    flat = spans <= ROUNDING * np.abs(corner_values).max(initial=0)
    slopes = np.where(flat, 0, face_gradients(mesh.plane_half_edges, corner_values))
    return face_guide(mesh, 1j * slopes if contour else slopes, 1)


def _projected_guide(mesh: TriangleMesh, vectors: np.ndarray) -> Guide:
    lengths = np.linalg.norm(vectors, axis=1)
    tangent = mesh.tangent_numbers(vectors)
    shares = np.minimum(_ratio(np.abs(tangent), lengths), 1)
    shares[shares < UPRIGHT] = 0
    return Guide(np.angle(tangent), _area_shares(mesh) * shares**2)


def _area_shares(mesh: TriangleMesh) -> np.ndarray:
    return mesh.vertex_masses / mesh.areas.sum()


def _sum_at_vertices(mesh: TriangleMesh, face_values: np.ndarray) -> np.ndarray:
    return np.bincount(mesh.triangles.ravel(), np.repeat(face_values, 3), mesh.vertex_count)


def _ratio(numerators: np.ndarray, denominators: np.ndarray) -> np.ndarray:
    return np.divide(numerators, denominators, out=np.zeros_like(numerators), where=denominators > 0)


def _refuse_infinite(values: np.ndarray, what: str, element: str) -> None:
    bad = ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    if bad.any():
        where = name_elements(element, np.flatnonzero(bad))
        raise SettingError(f"the {what} of {where} is not a finite number: set it, or remove the attribute")
