# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffusion (MBO): solve (M + tau L) x' = M x and normalize, repeatedly (Viertel and Osting 2019)."""

from collections.abc import Iterable

import numpy as np

from ...algebra.columns import add_multiples, inner_products
from ...algebra.metric import Metric
from ...monitor import Monitor
from .stage import Stage

# Conjugate gradient steps for one diffusion step. With one, fields end at clearly higher energies, since rough parts of
# the error remain; with two they end at those of exact solves.
SOLVER_STEPS = 2


def diffuse(
    stage: Stage, columns: np.ndarray, metrics: Iterable[Metric], steps: int, monitor: Monitor, tolerance: float = 0.0
) -> np.ndarray:
    """(N, k) columns after diffusion steps, up to ``steps`` with each metric, whose shift is 1 / tau.

    With A = L + M / tau a step is x' = A^-1 M x / tau = x - A^-1 L x: only the change depends on the approximate
    inverse. Where no unit vector moves by more than ``tolerance``, the next metric follows early.
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


def _solve(stage: Stage, metric: Metric, right: np.ndarray) -> np.ndarray:
    """A^-1 right by a few preconditioned conjugate gradient steps from zero, for each column on its own.

    Real and imaginary parts are separate numbers here, which NumPy multiplies faster.
    """
    shape, dtype, real = right.shape, right.dtype, right.real.dtype
    right = right.reshape(len(stage.row_mass), -1)
    parts = 2 if np.iscomplexobj(right) else 1
    shift = np.multiply(stage.row_mass, metric.shift, dtype=real)[:, None]

    def inner(first: np.ndarray, second: np.ndarray) -> np.ndarray:
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


def _ratio(numbers: np.ndarray, divisors: np.ndarray) -> np.ndarray:
    """Quotients, 0 where the divisor is zero: that column is solved."""
    return np.where(divisors > 0, numbers / np.where(divisors > 0, divisors, 1), 0).astype(numbers.dtype)
