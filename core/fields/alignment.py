# SPDX-License-Identifier: GPL-3.0-or-later
"""Align direction fields that neither constraints nor guides align."""

import numpy as np

from ..graphs import sum_by
from .directions import DirectionField
from .guidance.curvature import principal_directions


def along_curvature(field: DirectionField) -> DirectionField:
    """The field with its free pieces turned to agree best with the principal directions.

    Without constraints a turn of all phases by the same angle costs no energy. Edges along the principal directions
    bend least, and so do faces between them.
    """
    assert field.problem is not None
    mesh, problem = field.mesh, field.problem
    is_free = np.ones(mesh.pieces.max() + 1, bool)
    for nodes in (problem.fixed.nodes, problem.drawn.nodes, problem.merged.nodes):
        is_free[mesh.pieces[nodes]] = False
    values, weights = principal_directions(mesh, field.symmetry)
    wanted = weights * values * np.exp(-1j * field.symmetry * field.angles)
    totals = sum_by(mesh.pieces, wanted)
    turns = np.where(is_free, np.angle(totals), 0.0) / field.symmetry
    return field.turned(turns[mesh.pieces])
