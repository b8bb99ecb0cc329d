# SPDX-License-Identifier: GPL-3.0-or-later
"""Preconditioned Riemannian L-BFGS on a product of spheres, for one lifted field or many candidates.

Minimizes f = Re<X, L X> / 2 with the inverse metric as the first guess of the Hessian's inverse. Tangent
vectors are carried to the new point as they are; the last projection makes them tangent.
"""

from dataclasses import dataclass

import numpy as np

from ...algebra.reductions import HERE
from ...monitor import OutOfTime

ARMIJO = 1e-4
# Moves along which the gradient changed by less than this share of what was predicted tell nothing of the curvature.
FLATTEST = 1e-6
LONGEST_BACKTRACK = 12


@dataclass(frozen=True)
class Descent:
    """Where the descent ended.

    ``values`` are (k,) energies Re<X, L X>; ``steps`` counts iterations, ``products`` columns
    multiplied by L; ``out_of_time`` tells that the time limit ended it.
    """

    point: np.ndarray
    values: np.ndarray
    steps: int
    products: int
    out_of_time: bool


def descend(matrix, spheres, start, metric, tolerance, max_steps, monitor, memory=None):
    """Descend from ``start`` until every field's predicted relative decrease is below ``tolerance``.

    Works in the precision of ``matrix`` and ``start``, which have to agree, on about twenty arrays of
    the start's size.

    Parameters
    ----------
    matrix : (N, N) matrix with ``@``, ``dtype`` and ``diagonal()``
    spheres : Lifted, Circles or Columns
    start : (N, k) array
    metric : object with ``precondition``
    tolerance : relative to the energy
    max_steps : int
    monitor : Monitor, asked once a step
    memory : list from an earlier descent that ended at ``start``, to go on with; it is filled
    """
    memory = [] if memory is None else memory
    point = spheres.normalize(np.ascontiguousarray(start))
    image = matrix @ point
    values = spheres.energies(point, image)
    gradient = spheres.gradient(point, image)
    noise = rounding_noise(matrix, spheres.held)
    # Gradients tell of decreases that values no longer show. That is worth it in double precision only.
    floor = noise if np.finfo(matrix.dtype).bits < 64 else 0.0
    products, steps, out_of_time = point.shape[1], 0, False
    while steps < max_steps:
        try:
            monitor.check()
        except OutOfTime:
            out_of_time = True
            break
        steps += 1
        direction = spheres.tangent(point, _two_loop(spheres, memory, gradient, metric, point))
        np.negative(direction, out=direction)
        slopes = spheres.inner(gradient, direction)
        # The first predictions, made without a memory of the curvature, are too small.
        active = -slopes > np.maximum((tolerance if len(memory) == spheres.memory else 0) * values, floor)
        if not active.any():
            break
        moved = _line_search(matrix, spheres, point, direction, values, slopes, active, noise)
        if moved is None:
            break
        point, image, values, lengths, trials = moved
        products += trials * point.shape[1]
        new_gradient = spheres.gradient(point, image)
        direction *= lengths.astype(direction.dtype)
        _remember(spheres, memory, direction, new_gradient - gradient, -lengths * slopes)
        gradient = new_gradient
    # In single precision lengths drift over many steps.
    point = spheres.normalize(point)
    values = spheres.energies(point, matrix @ point)
    return Descent(point, values, steps, products, out_of_time)


def rounding_noise(matrix, held=HERE):
    """Changes of the energy of unit vectors below this are rounding, in the matrix's precision."""
    return 2 * np.finfo(matrix.dtype).eps * float(held.norm(matrix.diagonal()))


def _two_loop(spheres, memory, gradient, metric, point):
    """The L-BFGS product with the inverse Hessian (Nocedal and Wright, Algorithm 7.4), per field."""
    vector = gradient.copy()
    shares = []
    for move, change, inverse in reversed(memory):
        share = inverse * spheres.inner(move, vector)
        spheres.add(vector, -share, change)
        shares.append(share)
    vector = spheres.precondition(vector, metric, point)
    for (move, change, inverse), share in zip(memory, reversed(shares), strict=True):
        spheres.add(vector, share - inverse * spheres.inner(change, vector), move)
    return vector


def _remember(spheres, memory, move, change, predicted):
    """Keep a move and the change of the gradient along it, whose product is near the predicted decrease."""
    curvature = spheres.inner(move, change)
    good = curvature > FLATTEST * predicted
    memory.append((move, change, np.where(good, 1 / np.where(good, curvature, 1), 0.0)))
    if len(memory) > spheres.memory:
        memory.pop(0)


def _line_search(matrix, spheres, point, direction, values, slopes, active, noise):
    """Full step first, halved for the fields that do not decrease enough; None if none moves."""
    lengths = np.where(active & (slopes < 0), 1.0, 0.0)
    for trial in range(1, LONGEST_BACKTRACK + 1):
        new_point = spheres.move(point, direction, lengths)
        new_image = matrix @ new_point
        new_values = spheres.energies(new_point, new_image)
        failed = (lengths > 0) & (new_values > values + 2 * ARMIJO * lengths * slopes + noise)
        if not failed.any():
            return (new_point, new_image, new_values, lengths, trial) if (lengths > 0).any() else None
        lengths = np.where(failed, lengths / 2 if trial < LONGEST_BACKTRACK - 1 else 0.0, lengths)
    return None
