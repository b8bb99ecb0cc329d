# SPDX-License-Identifier: GPL-3.0-or-later
"""Preconditioned Riemannian L-BFGS on a product of spheres, for one lifted field or many candidates.

Minimizes f = Re<X, L X> / 2 with the inverse metric as the first guess of the Hessian's inverse. Vectors
are carried to the new point without transport: the next projection makes them tangent.
"""

from dataclasses import dataclass

import numpy as np

MEMORY = 5
ARMIJO = 1e-4
LONGEST_BACKTRACK = 12


@dataclass(frozen=True)
class Descent:
    """Where the descent ended.

    ``values`` are (k,) energies Re<X, L X>; ``steps`` counts iterations, ``products`` columns
    multiplied by L, ``decrements`` the last predicted relative decrease.
    """

    point: np.ndarray
    image: np.ndarray
    values: np.ndarray
    steps: int
    products: int
    decrements: np.ndarray


def descend(matrix, spheres, start, metric, tolerance, max_steps, monitor):
    """Descend from ``start`` until every field's predicted relative decrease is below ``tolerance``.

    Parameters
    ----------
    matrix : (N, N) CSR
    spheres : Spheres
    start : (N, k) array
    metric : object with ``solve(columns)``
    tolerance : relative to the energy
    max_steps : int
    monitor : Monitor, asked once a step
    """
    point = spheres.normalize(start)
    image = matrix @ point
    values = spheres.inner(point, image)
    gradient = spheres.project(point, image)
    # Below this, values of Re<X, L X> are rounding noise.
    noise = 1e-15 * np.abs(matrix.diagonal()).sum()
    memory: list[tuple] = []
    products, step = point.shape[1], 0
    decrements = np.full(len(values), np.inf)
    for step in range(1, max_steps + 1):
        monitor.check()
        direction = -spheres.project(point, _two_loop(spheres, memory, gradient, metric))
        slopes = spheres.inner(gradient, direction)
        decrements = -slopes / np.maximum(values, noise)
        # The first predictions, made without a memory of the curvature, are too small.
        active = decrements > (tolerance if step > MEMORY else 0)
        if not active.any():
            break
        moved = _line_search(matrix, spheres, point, direction, values, slopes, active, noise)
        if moved is None:
            break
        new_point, new_image, new_values, trials = moved
        products += trials * point.shape[1]
        new_gradient = spheres.project(new_point, new_image)
        _remember(spheres, memory, new_point - point, new_gradient - gradient)
        point, image, values, gradient = new_point, new_image, new_values, new_gradient
    return Descent(point, image, values, step, products, decrements)


def _two_loop(spheres, memory, gradient, metric):
    """The L-BFGS product with the inverse Hessian (Nocedal and Wright, Algorithm 7.4), per field."""
    vector = gradient.copy()
    shares = []
    for move, change, inverse in reversed(memory):
        share = inverse * spheres.inner(move, vector)
        vector -= share * change
        shares.append(share)
    vector = metric.solve(vector)
    for (move, change, inverse), share in zip(memory, reversed(shares), strict=True):
        vector += (share - inverse * spheres.inner(change, vector)) * move
    return vector


def _remember(spheres, memory, move, change):
    curvature = spheres.inner(move, change)
    sizes = np.sqrt(spheres.inner(move, move) * spheres.inner(change, change))
    good = curvature > 1e-10 * sizes
    memory.append((move, change, np.where(good, 1 / np.where(good, curvature, 1), 0.0)))
    if len(memory) > MEMORY:
        memory.pop(0)


def _line_search(matrix, spheres, point, direction, values, slopes, active, noise):
    """Full step first, halved for the fields that do not decrease enough; None if none moves."""
    lengths = np.where(active & (slopes < 0), 1.0, 0.0)
    for trial in range(1, LONGEST_BACKTRACK + 1):
        new_point = spheres.normalize(point + lengths * direction)
        new_image = matrix @ new_point
        new_values = spheres.inner(new_point, new_image)
        failed = (lengths > 0) & (new_values > values + 2 * ARMIJO * lengths * slopes + noise)
        if not failed.any():
            return (new_point, new_image, new_values, trial) if (lengths > 0).any() else None
        lengths = np.where(failed, lengths / 2 if trial < LONGEST_BACKTRACK - 1 else 0.0, lengths)
    return None
