# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls and skins of the beads that fill a solid, and lines farther apart between them."""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix, diags_array
from scipy.sparse.linalg import spsolve

from ..extract.layers.surfaces import LayerSurfaces
from ..extract.layers.toolpaths import toolpaths
from ..extract.lines.isolines import Isolines
from ..geometry import TriangleMesh
from ..geometry.tet_mesh import TetMesh
from .beads import Beads, cut_lines, distances_to_rims, join_lines, without_straight_points
from .flat import across, is_flat, ways_out
from .heights import ways_to_end
from .machine import Machine

# Kind of beads between walls and skins.
_SPARSE = 3
# Lines between walls reach so far into the innermost one, and their points are so far apart at first, in steps.
_OVERLAP, _APART = 0.35, 0.25
# Holds the mean of values on each piece of a layer, beside the weights of its edges.
_FREE = 1e-9
# Pieces of cut beads that are shorter are not printed, in steps.
_SHORT = 1.0


def sparse_beads(
    surfaces: LayerSurfaces, solid: TetMesh, beads: Beads, step: float, spacing: float, machine: Machine
) -> Beads:
    """Keep the walls and skins of :class:`Beads` that fill a solid, and put crossing lines into the rest.

    The machine has the number of walls, beads beside the rims of layers, and of skins, layers below and above which the
    solid ends. The lines in the rest run diagonally, one layer this and the next the other way, and
    have the machine's share of the volume. Beads are a step apart, layers a spacing on average.
    """
    rims = distances_to_rims(surfaces, step)

    def is_deep(lines: Isolines, layers: np.ndarray, least: float) -> np.ndarray:
        """(n,) bool: points farther from the rim than the least, and deeper than skins."""
        points, normals = lines.points, lines.normals
        deep = rims(points, layers[lines.numbers]) > least
        deep[deep] = _in_core(surfaces, solid, points[deep], normals[deep], spacing, machine.skins)
        return deep

    walls, of, points = cut_lines(beads.lines, ~is_deep(beads.lines, beads.layers, machine.walls * step), _SHORT * step)
    parts = [(walls, beads.layers[of], beads.kinds[of], beads.widths[points])]
    if machine.infill:
        lines, layers = _diagonals(surfaces, step / machine.infill)
        lines = lines.resampled(_APART * step)
        lines, of, _ = cut_lines(lines, is_deep(lines, layers, (machine.walls - _OVERLAP) * step), _SHORT * step)
        lines = without_straight_points(lines, np.inf)
        parts.append((lines, layers[of], np.full(len(of), _SPARSE), np.full(len(lines.triangles), step)))
    lines, layers, kinds, widths = join_lines(parts)
    return replace(beads, lines=lines, layers=layers, kinds=kinds, widths=widths)


def _in_core(
    surfaces: LayerSurfaces, solid: TetMesh, points: np.ndarray, normals: np.ndarray, spacing: float, skins: int
) -> np.ndarray:
    """(n,) bool: points with more than ``skins`` layers above and below them."""
    if is_flat(surfaces):
        up = surfaces.mesh.face_normals[0]
        ways = [ways_out(solid, points, side * up, across(up)) for side in (1, -1)]
    else:
        ways = [ways_to_end(solid, points, side * normals, spacing, skins + 0.5) for side in (1, -1)]
    return np.minimum(*ways) > skins * spacing


def _diagonals(surfaces: LayerSurfaces, apart: float) -> tuple[Isolines, np.ndarray]:
    """Lines at 45 degrees to two axes across the layers' mean normal, and (l,) their layers."""
    mesh = surfaces.mesh
    normal = mesh.areas @ mesh.face_normals
    size = np.linalg.norm(normal)
    normal = normal / size if size > 0 else np.array([0.0, 0.0, 1.0])
    first, second = across(normal)
    turned = np.zeros(len(surfaces.vertices), bool)
    turned[surfaces.triangles] = (surfaces.levels % 2 == 1)[surfaces.layers][:, None]
    along, other = surfaces.vertices @ first, surfaces.vertices @ second
    values = (along + np.where(turned, -other, other)) / np.sqrt(2)
    if not is_flat(surfaces):
        values = _even(mesh, values)
    return toolpaths(mesh, surfaces.layers, values, apart)


def _even(mesh: TriangleMesh, values: np.ndarray) -> np.ndarray:
    """(n,) values whose gradient on the layers has about the direction of that of (n,) given ones, and length 1.

    The least of the integral of |grad f - g|^2, where g is the unit vector along the given values' gradient; then f is
    scaled in each connected piece so that the mean of |grad f| is one, and lines at its multiples have the length that
    their distance asks for. The means of the given values stay.
    """
    corners, areas, count = mesh.vertices[mesh.triangles], mesh.areas, mesh.vertex_count
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    hats = np.cross(mesh.face_normals[:, None], opposite) / np.maximum(2 * areas, np.finfo(float).tiny)[:, None, None]
    rows = np.repeat(np.arange(3 * len(areas)).reshape(-1, 1, 3), 3, axis=1)
    columns = np.repeat(mesh.triangles[:, :, None], 3, axis=2)
    gradient = coo_matrix((hats.ravel(), (rows.ravel(), columns.ravel())), shape=(3 * len(areas), count)).tocsr()

    def lengths(of: np.ndarray) -> np.ndarray:
        return np.linalg.norm((gradient @ of).reshape(-1, 3), axis=1)

    wanted = gradient @ values / np.repeat(np.maximum(lengths(values), np.finfo(float).tiny), 3)
    weighted = gradient.T @ diags_array(np.repeat(areas, 3))
    matrix = (weighted @ gradient).tocsc()
    found = spsolve(matrix + diags_array(np.full(count, _FREE * matrix.diagonal().mean())), weighted @ wanted)
    piece, masses = mesh.pieces, mesh.vertex_masses
    of = piece[mesh.triangles[:, 0]]
    found *= (np.bincount(of, areas) / np.maximum(np.bincount(of, areas * lengths(found)), 1e-300))[piece]
    return found + (np.bincount(piece, masses * (values - found)) / np.bincount(piece, masses))[piece]
