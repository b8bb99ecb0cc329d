# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow that changes: each frame is solved from the one before and turned to it.

What a map leaves free is turned so that it changes least: the phase of all nodes of a map to the circle, a unitary
matrix of a map to S^3, which is a rotation of its sphere. Colours of tubes and the point from which filaments are
seen then mean the same in every frame.
"""

import numpy as np

from ..solve.lifted import lifted_of_rank
from .clebsch import SphericalMap, clebsch_map


def following_map(before, integrals, options=None, callback=None):
    """The :class:`ClebschMap` of the next frame of a flow, near the one before.

    Parameters
    ----------
    before : ClebschMap of the method "sdp"
    integrals : (e,) of the velocity of the frame, on the same grid
    options, callback : see :func:`core.solve.solve`
    """
    found = clebsch_map(before.grid, integrals, before.quantum, options, callback, before.solution)
    turn = np.vdot(found.phases, before.phases)
    return found.showing(found.phases * (turn / abs(turn))) if turn != 0 else found


def following_sphere(before, found, callback=None):
    """The :class:`SphericalMap` of the next frame, near the one before.

    Parameters
    ----------
    before : SphericalMap
    found : ClebschMap of the frame
    callback : see :func:`core.solve.solve`
    """
    problem = found.problem
    lifted = lifted_of_rank(problem, found.solution, 2, callback, start=before.lifted)
    left, _, right = np.linalg.svd(lifted.conj().T @ before.lifted)
    lifted = lifted @ (left @ right)
    energy = sum(problem.connection.energy(column) for column in lifted.T)
    return SphericalMap(found, lifted, energy)
