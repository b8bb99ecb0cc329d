# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths of a tool as text: a table with a row for each point, or polylines of an .obj file."""

import numpy as np

from ..extract.lines.isolines import Isolines
from .digits import DIGITS, number_format


def table_of(
    lines: Isolines,
    layers: np.ndarray,
    points: np.ndarray,
    normals: np.ndarray,
    heights: np.ndarray,
    widths: np.ndarray,
    above: np.ndarray,
) -> str:
    """Text of a .csv file, a row for each point.

    Parameters
    ----------
    layers : (l,) the layer of each line
    points, normals : (n, 3)
    heights, widths, above : (n,) height and width of the bead, and how far the nozzle is above the layer
    """
    rows = ["layer,path,x,y,z,nx,ny,nz,height,width,above"]
    form = ",".join(3 * [number_format(points)] + 6 * [f"%.{DIGITS}g"])
    for number, (layer, run) in enumerate(zip(layers, lines.runs, strict=True)):
        for values in np.column_stack([points[run], normals[run], heights[run], widths[run], above[run]]):
            rows.append(f"{layer},{number}," + form % tuple(values))
    return "\n".join(rows) + "\n"


def polylines_of(lines: Isolines, layers: np.ndarray, points: np.ndarray, *_: np.ndarray) -> str:
    """Text of an .obj file, an object for each layer; parameters as :func:`table_of`, the rest is left out."""
    form, before = "v " + " ".join(3 * [number_format(points)]), None
    rows = [form % tuple(point) for point in points]
    for layer, run in zip(layers, lines.runs, strict=True):
        if layer != before:
            rows.append(f"o layer_{layer:03d}")
            before = layer
        rows.append("l " + " ".join(map(str, run + 1)))
    return "\n".join(rows) + "\n"


WRITERS = {".csv": table_of, ".obj": polylines_of}
