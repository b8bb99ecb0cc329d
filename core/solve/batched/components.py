# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces that are not relaxed one by one: fields that fit perfectly are found along a tree, and small pieces are solved
together."""

from typing import Any

import numpy as np

from ...monitor import Monitor, OutOfTime
from ...pieces import Pieces, Stack
from ...problem import SynchronizationProblem
from ...solution import DESCENT, Certificate, Clock, Options, Status
from ..methods.manifolds import candidates
from .parts import PartResult, Start
from .small import AT_ONCE, LARGEST, SmallResult, descend_stack, smallest_eigenpairs, solve_small


def solve_components(
    problem: SynchronizationProblem, options: Options, monitor: Monitor, clock: Clock, start: Start
) -> tuple[list[PartResult], np.ndarray]:
    """The results of all pieces that need not be solved one by one, and the (k,) numbers of the other pieces.

    With a start, a field that fits a piece perfectly but may be far from it is not used.
    """
    pieces = problem.pieces
    results, is_left = [], np.ones(len(pieces), bool)
    coordinates = None if start.column is None else start.column[:, 0]
    if coordinates is None:
        with clock("build"):
            coordinates = problem.along_trees()
            fitted = np.flatnonzero(pieces.fitted(coordinates, options.integrate))
        if len(fitted):
            results.append(_without_search(pieces, fitted, coordinates, options, True))
            is_left[fitted] = False
    small = np.flatnonzero(is_left & (pieces.sizes <= LARGEST) & (pieces.weights > 0) & (len(pieces) > 1))
    if problem.is_circle and options.method != "diffusion" and len(small):
        part = monitor.portion(0.0, pieces.sizes[small].sum() / pieces.sizes.sum())
        chunks = _split_by_size(pieces.sizes, small, problem.block, options.samples)
        with clock("small pieces"):
            for place, chunk in enumerate(chunks):
                try:
                    part.at("small pieces", place / len(chunks))
                except OutOfTime:
                    numbers = np.concatenate(chunks[place:])
                    results.append(_without_search(pieces, numbers, coordinates, options, False))
                    break
                results.extend(_solve_stack(pieces, chunk, options, part, start, coordinates))
        is_left[small] = False
    return results, np.flatnonzero(is_left)


def _without_search(
    pieces: Pieces, numbers: np.ndarray, coordinates: np.ndarray, options: Options, is_perfect: bool
) -> PartResult:
    """The result of (N,) coordinates that fit some pieces perfectly, or when time ran out."""
    rows, is_sdp = pieces.rows(numbers), options.method == "sdp"
    field = coordinates[rows].reshape(len(rows), -1)
    size = pieces.sizes[numbers].max()
    status = Status.CERTIFIED if is_sdp else Status.UNCERTIFIED
    return PartResult(
        rows,
        size,
        field.reshape(-1, 1),
        sdp_value=float(pieces.energies(coordinates)[numbers].sum()),
        certificate=Certificate.PROVED if is_perfect else Certificate.NONE,
        status=status if is_perfect else Status.TIME_LIMIT,
        lifted=field if is_sdp else None,
        singular_values=np.sqrt(np.full(field.shape[1], size)) if is_sdp else None,
    )


def _split_by_size(sizes: np.ndarray, numbers: np.ndarray, block: int, samples: int) -> list[np.ndarray]:
    """Parts of some pieces, of about the same size each, small enough for the memory of their matrices and samples."""
    numbers = numbers[np.argsort(sizes[numbers], kind="stable")]
    # Sizes that differ by less than a fourth are padded to the same one.
    steps = np.ceil(np.log(sizes[numbers]) / np.log(1.25)).astype(int)
    chunks = []
    for part in np.split(numbers, np.flatnonzero(np.diff(steps)) + 1):
        rows = sizes[part[-1]] * block
        most = max(AT_ONCE // (rows * max(rows, LARGEST, samples)), 1)
        chunks.extend(np.array_split(part, -(-len(part) // most)))
    return chunks


def _solve_stack(
    pieces: Pieces, numbers: np.ndarray, options: Options, monitor: Monitor, start: Start, coordinates: np.ndarray
) -> list[PartResult]:
    """The PartResults of the pieces of one stack."""
    stack = pieces.stack(numbers)
    column = None
    if start.column is not None:
        column = np.ones((*stack.used.shape, 1), stack.matrices.dtype)
        column[stack.used] = start.column[pieces.rows(numbers)]
    if options.method == "sdp":
        parts = solve_small(stack, options, monitor, column)
        return [_certify_stack(pieces, numbers[own], stack[own], found, coordinates) for own, found in parts]
    if options.method == DESCENT and column is not None:
        fields, steps, out_of_time = descend_stack(stack, column, monitor)
        status = Status.TIME_LIMIT if out_of_time else Status.UNCERTIFIED
        return [_stack_result(pieces, numbers, stack, fields, iterations=steps, status=status)]
    values, vectors = smallest_eigenpairs(stack)
    bound = float(stack.weights @ (values * pieces.sizes[numbers]))
    quality = {"bound": bound, "spectral_bound": bound, "certificate": Certificate.ESTIMATED}
    return [_stack_result(pieces, numbers, stack, vectors, **quality)]


def _stack_result(pieces: Pieces, numbers: np.ndarray, stack: Stack, fields: np.ndarray, **quality: Any) -> PartResult:
    """The :class:`PartResult` of the padded fields of a stack."""
    return PartResult(pieces.rows(numbers), stack.mass.shape[1], _unit_coordinates(stack, fields), **quality)


def _certify_stack(
    pieces: Pieces, numbers: np.ndarray, stack: Stack, found: SmallResult, coordinates: np.ndarray
) -> PartResult:
    """The :class:`PartResult` of a stack with the sums of its pieces' values and bounds, each at most its piece's
    value."""
    fields, lifted = _unit_coordinates(stack, found.fields), found.lifted[stack.used]
    status = Status.CERTIFIED if found.reached.all() else Status.TARGET_GAP_NOT_REACHED
    if found.out_of_time:
        fields, status = _lower_energy(pieces, numbers, fields[:, :1], coordinates), Status.TIME_LIMIT
    # Phases of less energy, which a tight relaxation may round to, are a better point of it.
    values = np.minimum(pieces.energies_of(numbers, lifted), pieces.energies_of(numbers, fields[:, :1]))
    largest = np.argmax(np.count_nonzero(stack.used, axis=1))
    sizes = np.linalg.norm(np.where(stack.used[largest, :, None], found.lifted[largest], 0), axis=0)
    return PartResult(
        pieces.rows(numbers),
        stack.mass.shape[1],
        fields,
        bound=float(np.minimum(stack.weights * found.bounds, values).sum()),
        sdp_value=float(values.sum()),
        certificate=Certificate.PROVED,
        status=status,
        lifted=lifted,
        singular_values=sizes[sizes > 0],
        iterations=found.steps,
    )


def _lower_energy(pieces: Pieces, numbers: np.ndarray, fields: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
    """Each piece's (m, 1) fields, or (N,) coordinates where these have less energy."""
    given = coordinates[pieces.rows(numbers)][:, None]
    is_worse = pieces.energies_of(numbers, fields) > pieces.energies(coordinates)[numbers]
    rows = pieces.sizes[numbers] * (len(given) // pieces.sizes[numbers].sum())
    return np.where(np.repeat(is_worse, rows)[:, None], given, fields)


def _unit_coordinates(stack: Stack, fields: np.ndarray) -> np.ndarray:
    """(m, c) unit coordinates of the pieces, one after the other, of (k, N, c) fields; grounds have the phase 1."""
    fields = candidates(stack.block, True).normalize(fields.reshape(-1, fields.shape[2])).reshape(fields.shape)
    grounded = np.flatnonzero(stack.grounds >= 0)
    values = fields[grounded, stack.grounds[grounded] * stack.block]
    sizes = np.abs(values)
    fields[grounded] *= np.where(sizes > 0, np.conj(values) / np.where(sizes > 0, sizes, 1), 1)[:, None, :]
    return fields[stack.used]
