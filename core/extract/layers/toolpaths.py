# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths for a tool to follow on each layer: curves along which a function takes evenly spaced values."""

import numpy as np

from ...errors import SettingError, round_up
from ...fields.guidance.fronts import front_distance
from ...geometry import TriangleMesh
from ...interpolate import TURN, EdgePhases
from ..lines.isolines import Isolines, isolines

# Of all paths: half a kilobyte and ten microseconds each.
MOST_POINTS = 3_000_000


def toolpaths(mesh: TriangleMesh, layers: np.ndarray, values: np.ndarray, step: float) -> tuple[Isolines, np.ndarray]:
    """Curves on layers where a function is a multiple of a step, ordered by layer.

    They are as far apart as the step where the function changes by one per unit length along the layer. Raises
    SettingError for a step that is not positive, or so small that there would be more than MOST_POINTS points.

    Parameters
    ----------
    mesh : TriangleMesh of all layers
    layers : (t,) the layer of each triangle
    values : (p,) at the vertices, such as a coordinate or :func:`rim_distances`
    step : positive, in the values' unit

    Returns
    -------
    lines : Isolines over the mesh
    numbers : (l,) layer of each line
    """
    refuse_many_points(mesh, values, step)
    angles = TURN / step * np.asarray(values, float)
    i, j = mesh.edges.T
    changes = (angles[j] - angles[i])[:, None]
    lines = isolines(EdgePhases.of(mesh, np.exp(1j * angles)[:, None], changes, np.zeros(len(changes), int)))
    numbers = layers[lines.triangles[lines.starts]]
    order = np.argsort(numbers, kind="stable")
    return lines.chosen(order), numbers[order]


def refuse_many_points(mesh: TriangleMesh, values: np.ndarray, step: float) -> None:
    """Refuse a step of :func:`toolpaths` that is not positive, or makes too many points."""
    if not (np.isfinite(step) and step > 0):
        raise SettingError(f"the step between paths is {step:g}: give a positive number")
    i, j = mesh.edges.T
    points = np.abs(np.asarray(values, float)[j] - values[i]).sum() / step
    if points > MOST_POINTS:
        raise SettingError(
            f"paths {step:g} apart have {points:.1e} points, and {MOST_POINTS:.0e} is the most: "
            f"give a step of {round_up(1.05 * step * points / MOST_POINTS, 2)} or more"
        )


def rim_distances(mesh: TriangleMesh) -> np.ndarray:
    """(p,) way on its layer from each vertex to the nearest end of it: at the boundary, or at a dislocation curve."""
    return front_distance(mesh, rim_vertices(mesh))


def rim_vertices(mesh: TriangleMesh) -> np.ndarray:
    """(p,) bool, vertices at the ends of layers; of layers that close in themselves the lowest vertex along z."""
    sources = mesh.boundary_vertices.copy()
    piece = mesh.pieces
    whole = np.setdiff1d(piece, piece[sources])
    order = np.argsort(mesh.vertices[:, 2], kind="stable")
    _, first = np.unique(piece[order], return_index=True)
    lowest = order[first]
    sources[lowest[np.isin(piece[lowest], whole)]] = True
    return sources
