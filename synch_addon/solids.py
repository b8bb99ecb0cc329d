# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids of mesh objects: a closed surface filled with tetrahedra, and what was solved in it."""

from dataclasses import dataclass

import numpy as np

from ..core.extract.defect_curves import DefectCurve
from ..core.extract.layer_surfaces import LayerSurfaces
from ..core.fields.layers import LayerPattern
from ..core.geometry.tet_mesh import TetMesh


@dataclass(frozen=True)
class Layering:
    """The last layers that were solved in an object (:func:`memory.recall_layers` gives them back).

    Attributes
    ----------
    solid : TetMesh in scene units, along the object's axes: its scale has been applied, its place and turn have not
    pattern : LayerPattern
    surfaces : LayerSurfaces in the solid's space
    curves : DefectCurves in the solid's space
    matrix : (4, 4) from the solid's space to the world: the place, turn and mirroring of the object, without its scale;
        it is the ``matrix_world`` of objects that are made of the solid's points
    """

    solid: TetMesh
    pattern: LayerPattern
    surfaces: LayerSurfaces
    curves: tuple[DefectCurve, ...]
    matrix: np.ndarray
