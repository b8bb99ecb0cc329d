# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffusion (MBO): solve (M + tau L) x' = M x and normalize, over and over (Viertel and Osting 2019)."""

import numpy as np

from ...algebra.columns import add_multiples, inner_products

# Conjugate gradient steps for one diffusion step. With one, whose rough parts of the error stay, fields end at
# clearly higher energies; with two they end where exact solves lead them.
SOLVER_STEPS = 2


def diffuse(stage, columns, metrics, steps, monitor, tolerance=0.0):
    """Carry columns through diffusion steps, whose times the metrics tell.

    With A = L + M / tau a step is x' = A^-1 M x / tau = x - A^-1 L x: only the change rests on the
    approximate inverse.

    Parameters
    ----------
    stage : Stage
    columns : (N, k) array
    metrics : the stage's metrics with the shifts 1 / tau, one after the other
    steps : most steps at each time
    monitor : Monitor
    tolerance : largest move of a unit vector below which a time is finished early
    """
    spheres, matrix = stage.candidates, stage.matrix
    columns = spheres.normalize(columns.astype(matrix.dtype, order="C"))
    for metric in metrics:
        for _ in range(steps):
            monitor.check()
            moved = spheres.normalize(columns - _solve(stage, metric, matrix @ columns))
            settled = tolerance > 0 and np.abs(moved - columns).max() <= tolerance
            columns = moved
            if settled:
                break
    return columns


def _solve(stage, metric, right):
    """A^-1 right by a few preconditioned conjugate gradient steps from zero, for each column on its own.

    Works on real and imaginary parts as separate numbers, which NumPy multiplies faster.
    """
    shape, dtype, real = right.shape, right.dtype, right.real.dtype
    right = right.reshape(len(stage.row_mass), -1)
    parts = 2 if np.iscomplexobj(right) else 1
    shift = np.multiply(stage.row_mass, metric.shift, dtype=real)[:, None]

    def inner(first, second):
        return np.repeat(inner_products(first, second).reshape(-1, parts).sum(axis=1), parts)

    residual = right.view(real)
    direction = metric.solve(right).view(real)
    size = inner(residual, direction)
    solution = np.zeros_like(residual)
    for step in range(SOLVER_STEPS):
        image = (stage.matrix @ direction.view(dtype)).view(real)
        image += shift * direction
        length = _ratio(size, inner(direction, image))
        add_multiples(solution, length, direction)
        if step == SOLVER_STEPS - 1:
            break
        add_multiples(residual, -length, image)
        steepest = metric.solve(residual.view(dtype)).view(real)
        new_size = inner(residual, steepest)
        add_multiples(steepest, _ratio(new_size, size), direction)
        direction = steepest
        size = new_size
    return solution.view(dtype).reshape(shape)


def _ratio(numbers, divisors):
    """Quotients, 0 where the divisor is: that column is solved."""
    return np.where(divisors > 0, numbers / np.where(divisors > 0, divisors, 1), 0).astype(numbers.dtype)
