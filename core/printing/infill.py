# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls and skins of the beads that fill a solid, and lines farther apart between them."""

from dataclasses import replace

import numpy as np

from ..extract.layers.surfaces import LayerSurfaces
from ..extract.layers.toolpaths import toolpaths
from ..extract.lines.isolines import End, Isolines
from ..geometry.tet_mesh import TetMesh
from .beads import Beads, distances_to_rims, join_lines, without_straight_points
from .flat import across, is_flat, ways_out
from .heights import ways_to_end
from .machine import Machine

# Kind of beads between walls and skins.
_SPARSE = 3
# Lines between walls reach so far into the innermost one, and their points are so far apart at first, in steps.
_OVERLAP, _APART = 0.35, 0.25
# Pieces of cut beads that are shorter are not printed, in steps.
_SHORT = 1.0


def sparse_beads(
    surfaces: LayerSurfaces, solid: TetMesh, beads: Beads, step: float, spacing: float, machine: Machine
) -> Beads:
    """Keep the walls and skins of :class:`Beads` that fill a solid, and put crossing lines into the rest.

    Walls lie beside the rims of layers. In skins the solid ends within a number of layers above or below. The lines in
    the rest lie in diagonal planes, one layer this and the next the other way, and have the machine's share of the
    volume; where layers are steep against the mean normal, less.

    Parameters
    ----------
    surfaces : LayerSurfaces
    solid : TetMesh
    beads : contours that fill the layers
    step, spacing : between beads, and mean distance of layers, scene units
    machine : Machine, whose ``walls``, ``skins`` and ``infill`` are used
    """
    rims = distances_to_rims(surfaces, step)

    def is_deep(lines: Isolines, layers: np.ndarray, least: float) -> np.ndarray:
        """(n,) bool: points farther from the rim than the least, and deeper than skins."""
        points, normals = lines.points, lines.normals
        deep = rims(points, layers[lines.numbers]) > least
        deep[deep] = _in_core(surfaces, solid, points[deep], normals[deep], spacing, machine.skins)
        return deep

    walls, of, points = _cut_lines(
        beads.lines, ~is_deep(beads.lines, beads.layers, machine.walls * step), _SHORT * step
    )
    parts = [(walls, beads.layers[of], beads.kinds[of], beads.widths[points])]
    if machine.infill:
        lines, layers = _diagonals(surfaces, spacing, step / machine.infill)
        lines = lines.resampled(_APART * step)
        lines, of, _ = _cut_lines(lines, is_deep(lines, layers, (machine.walls - _OVERLAP) * step), _SHORT * step)
        lines = without_straight_points(lines, np.inf)
        parts.append((lines, layers[of], np.full(len(of), _SPARSE), np.full(len(lines.triangles), step)))
    lines, layers, kinds, widths = join_lines(parts)
    return replace(beads, lines=lines, layers=layers, kinds=kinds, widths=widths)


def _in_core(
    surfaces: LayerSurfaces, solid: TetMesh, points: np.ndarray, normals: np.ndarray, spacing: float, skins: int
) -> np.ndarray:
    """(n,) bool: points with more than so many layers above and below them."""
    if is_flat(surfaces):
        up = surfaces.mesh.face_normals[0]
        ways = [ways_out(solid, points, side * up, across(up)) for side in (1, -1)]
    else:
        ways = [ways_to_end(solid, points, side * normals, spacing, skins + 0.5) for side in (1, -1)]
    return np.minimum(*ways) > skins * spacing


def _diagonals(surfaces: LayerSurfaces, spacing: float, apart: float) -> tuple[Isolines, np.ndarray]:
    """Lines at 45 degrees to two axes across the layers' mean normal, and (l,) their layers."""
    mesh = surfaces.mesh
    normal = mesh.areas @ mesh.face_normals
    size = np.linalg.norm(normal)
    normal = normal / size if size > 0 else np.array([0.0, 0.0, 1.0])
    first, second = across(normal)
    heights = mesh.areas * (mesh.vertices[mesh.triangles].mean(axis=1) @ normal)
    heights = np.bincount(surfaces.layers, heights) / np.bincount(surfaces.layers, mesh.areas)
    is_odd = np.rint(heights / spacing) % 2 == 1
    turned = np.zeros(len(surfaces.vertices), bool)
    turned[surfaces.triangles] = is_odd[surfaces.layers][:, None]
    along, other = surfaces.vertices @ first, surfaces.vertices @ second
    return toolpaths(mesh, surfaces.layers, (along + np.where(turned, -other, other)) / np.sqrt(2), apart)


def _cut_lines(lines: Isolines, kept: np.ndarray, shortest: float) -> tuple[Isolines, np.ndarray, np.ndarray]:
    """The parts of lines whose points are kept; cut ones no shorter than a length.

    Returns the parts, (k,) the line that each is of, and (m,) the point that each of theirs was.
    """
    numbers, starts, sizes = lines.numbers, lines.starts, lines.sizes
    whole = np.bincount(numbers[~kept], minlength=len(sizes)) == 0
    # Closed lines that are cut begin after a point that is left out.
    first = np.full(len(sizes), len(kept))
    np.minimum.at(first, numbers[~kept], np.flatnonzero(~kept))
    shift = np.where(lines.closed & ~whole, first - starts, 0)
    order = starts[numbers] + (np.arange(len(kept)) - starts[numbers] + shift[numbers]) % sizes[numbers]
    is_kept = kept[order]
    begins = is_kept & ~np.append(False, is_kept[:-1] & (numbers[1:] == numbers[:-1]))
    points = order[is_kept]
    part = np.cumsum(begins)[is_kept] - 1
    of = numbers[begins]
    ends = np.where(whole[of][:, None], lines.ends[of], End.BOUNDARY)
    made = replace(
        lines,
        triangles=lines.triangles[points],
        weights=lines.weights[points],
        sizes=np.bincount(part, minlength=len(of)),
        ends=ends,
    )
    long = whole[of] | (made.lengths >= shortest)
    return made.chosen(long), of[long], points[long[part]]
