# SPDX-License-Identifier: GPL-3.0-or-later
"""How direction fields are turned as a whole where neither constraints nor guides say."""

import numpy as np

from .guidance.curvature import principal_directions


def along_curvature(field):
    """A :class:`DirectionField` whose free pieces are turned to agree best with the principal directions.

    Without constraints, phases that are all turned by the same angle have the same energy, so that it is free to
    choose. Edges along the principal directions bend least, and so do faces between them.
    """
    mesh, problem = field.mesh, field.problem
    is_free = np.ones(mesh.pieces.max() + 1, bool)
    for nodes in (problem.fixed.nodes, problem.drawn.nodes, problem.merged.nodes):
        is_free[mesh.pieces[nodes]] = False
    values, weights = principal_directions(mesh, field.symmetry)
    wanted = weights * values * np.exp(-1j * field.symmetry * field.angles)
    totals = np.bincount(mesh.pieces, wanted.real) + 1j * np.bincount(mesh.pieces, wanted.imag)
    turns = np.where(is_free, np.angle(totals), 0.0) / field.symmetry
    return field.turned(turns[mesh.pieces])
