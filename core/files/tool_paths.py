# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths of a tool as text: a table with a row for each point, or polylines as .obj files have them.

Closed paths come back to their first point.
"""

import numpy as np


def table_of(lines, layers, points, normals, heights, widths):
    """Text of a .csv file: layer, path, place and normal of each point, the layer's height and the bead's width there.

    Parameters
    ----------
    lines : Isolines
    layers : (l,) the layer of each line
    points, normals : (n, 3) of the lines' points
    heights, widths : (n,) there
    """
    rows = ["layer,path,x,y,z,nx,ny,nz,height,width"]
    for number, (layer, run) in enumerate(zip(layers, lines.runs, strict=True)):
        for values in np.column_stack([points[run], normals[run], heights[run], widths[run]]):
            rows.append(f"{layer},{number}," + ",".join(f"{value:.9g}" for value in values))
    return "\n".join(rows) + "\n"


def polylines_of(lines, layers, points, *_):
    """Text of an .obj file, an object for each layer; parameters as :func:`table_of`, what has no place is left out."""
    rows, before = [], None
    rows += ["v " + " ".join(f"{value:.9g}" for value in point) for point in points]
    for layer, run in zip(layers, lines.runs, strict=True):
        if layer != before:
            rows.append(f"o layer_{layer:03d}")
            before = layer
        rows.append("l " + " ".join(map(str, run + 1)))
    return "\n".join(rows) + "\n"


WRITERS = {".csv": table_of, ".obj": polylines_of}
