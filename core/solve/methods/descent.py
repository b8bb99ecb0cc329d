# SPDX-License-Identifier: GPL-3.0-or-later
"""Preconditioned Riemannian L-BFGS on a product of spheres, for one lifted field or many candidates.

Minimizes f = Re<X, L X> / 2 with the inverse metric as the first guess of the Hessian's inverse. Tangent
vectors are carried to the new point as they are; the last projection makes them tangent.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ...algebra.products import Matrix
from ...algebra.reductions import HERE, Reductions
from ...monitor import Monitor, OutOfTime
from .manifolds import Manifold, Preconditioner

ARMIJO = 1e-4
# Moves along which the gradient changes by less than this share of the prediction say nothing about the curvature.
FLATTEST = 1e-6
LONGEST_BACKTRACK = 12
# Of each step: the move, the change of the gradient along it, and the inverse of their inner product.
Memory: TypeAlias = list[tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Descent:
    """The end of a descent.

    ``values`` are (k,) energies Re<X, L X>; ``steps`` counts iterations, ``products`` columns multiplied by L;
    ``out_of_time`` says whether the time limit ended it.
    """

    point: np.ndarray
    values: np.ndarray
    steps: int
    products: int
    out_of_time: bool


def descend(
    matrix: Matrix,
    spheres: Manifold,
    start: np.ndarray,
    metric: Preconditioner,
    tolerance: float,
    max_steps: int,
    monitor: Monitor,
    memory: Memory | None = None,
) -> Descent:
    """Descend from (N, k) columns until every field's predicted relative decrease is below ``tolerance``.

    A field that has ended stays as it is while others go on, so that it does not depend on them. Works in the precision
    of ``matrix`` and ``start``, which have to agree, on about twenty arrays of the start's size.
    ``memory`` is of an earlier descent that ended at ``start``, to go on with; it is changed.
    """
    memory = [] if memory is None else memory
    point = spheres.normalize(np.ascontiguousarray(start))
    image = matrix @ point
    values = spheres.energies(point, image)
    gradient = spheres.gradient(point, image)
    noise = rounding_noise(matrix, spheres.reductions)
    # Gradients show decreases that are lost in the rounding of values: worth using in double precision only.
    floor = noise if np.finfo(matrix.dtype).bits < 64 else 0.0
    products, steps, out_of_time = point.shape[1], 0, False
    # Fields that do not move any more; with others beside it, a field tries again until its memory is empty.
    ended, idle, patience = np.zeros(len(values), bool), np.zeros(len(values), int), spheres.memory
    patience = patience if len(values) > 1 else 0
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
        least = np.maximum((tolerance if len(memory) == spheres.memory else 0) * values, floor)
        active = ~ended & (-slopes > least)
        ended |= ~active & (slopes <= 0)
        moved = _line_search(matrix, spheres, point, image, direction, values, slopes, active, noise)
        idle = np.where(moved[3] > 0, 0, idle + 1)
        ended |= idle > patience
        if ended.all():
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


def rounding_noise(matrix: Matrix, reductions: Reductions = HERE) -> float:
    """Changes of the energy of unit vectors below this are rounding, in the matrix's precision."""
    return float(2 * np.finfo(matrix.dtype).eps * float(reductions.norm(matrix.diagonal())))


def _two_loop(
    spheres: Manifold, memory: Memory, gradient: np.ndarray, metric: Preconditioner, point: np.ndarray
) -> np.ndarray:
    """Gradient times the inverse Hessian by the two-loop recursion (Nocedal and Wright, Algorithm 7.4), per field."""
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


def _remember(spheres: Manifold, memory: Memory, move: np.ndarray, change: np.ndarray, predicted: np.ndarray) -> None:
    """Store a move and the change of the gradient along it, whose product is near the predicted decrease."""
    curvature = spheres.inner(move, change)
    good = curvature > FLATTEST * predicted
    memory.append((move, change, np.where(good, 1 / np.where(good, curvature, 1), 0.0)))
    if len(memory) > spheres.memory:
        memory.pop(0)


def _line_search(
    matrix: Matrix,
    spheres: Manifold,
    point: np.ndarray,
    image: np.ndarray,
    direction: np.ndarray,
    values: np.ndarray,
    slopes: np.ndarray,
    active: np.ndarray,
    noise: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
    """Full step first, halved for fields that do not decrease enough; those that do not move have the length 0."""
    lengths = np.where(active & (slopes < 0), 1.0, 0.0)
    for trial in range(1, LONGEST_BACKTRACK + 1):
        if not (lengths > 0).any():
            break
        new_point = spheres.move(point, direction, lengths)
        new_image = matrix @ new_point
        new_values = spheres.energies(new_point, new_image)
        failed = (lengths > 0) & (new_values > values + 2 * ARMIJO * lengths * slopes + noise)
        if not failed.any():
            still = lengths == 0
            if still.any():
                for new, old in ((new_point, point), (new_image, image), (new_values, values)):
                    np.copyto(new, old, where=still)
            return new_point, new_image, new_values, lengths, trial
        lengths = np.where(failed, lengths / 2 if trial < LONGEST_BACKTRACK - 1 else 0.0, lengths)
    return point, image, values, np.zeros(len(values)), 0
