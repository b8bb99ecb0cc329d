# SPDX-License-Identifier: GPL-3.0-or-later
"""What need not be relaxed piece by piece: a field that fits all of a piece is found along a tree, and small pieces are
solved together."""

import numpy as np

from ...monitor import OutOfTime
from ...solution import DESCENT, Certificate, Status
from ..methods.manifolds import candidates
from .parts import PartResult
from .small import AT_ONCE, LARGEST, descend_stack, smallest_eigenpairs, solve_small


def solve_components(problem, options, monitor, clock, start):
    """Solve what need not be solved piece by piece.

    Parameters
    ----------
    problem : SynchronizationProblem
    options : Options
    monitor : Monitor of the whole work
    clock : Clock
    start : Start; with one, a perfect fit that is far from it does not count

    Returns
    -------
    results : list of PartResult
    left : (k,) numbers of the other pieces
    """
    pieces = problem.pieces
    results, is_left = [], np.ones(len(pieces), bool)
    coordinates = None if start.column is None else start.column[:, 0]
    if coordinates is None:
        with clock("build"):
            coordinates = problem.along_trees()
            fitted = np.flatnonzero(pieces.fitted(coordinates))
        if len(fitted):
            results.append(_as_they_are(pieces, fitted, coordinates, options, True))
            is_left[fitted] = False
    small = np.flatnonzero(is_left & (pieces.sizes <= LARGEST) & (pieces.weights > 0) & (len(pieces) > 1))
    if problem.is_circle and options.method != "diffusion" and len(small):
        share = pieces.sizes[small].sum() / pieces.sizes.sum()
        with clock("small pieces"):
            results.extend(_small(problem, small, options, monitor.portion(0.0, share), start, coordinates))
        is_left[small] = False
    return results, np.flatnonzero(is_left)


def _as_they_are(pieces, numbers, coordinates, options, is_perfect):
    """The result of (N,) coordinates that fit some pieces perfectly, or that time has left as they are."""
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


def _small(problem, numbers, options, monitor, start, coordinates):
    """The results of small pieces; of (N,) coordinates where time runs out, if no better ones were found."""
    pieces, results = problem.pieces, []
    chunks = _chunks(pieces.sizes, numbers, problem.block, options.samples)
    for place, chunk in enumerate(chunks):
        try:
            monitor.at("small pieces", place / len(chunks))
        except OutOfTime:
            results.append(_as_they_are(pieces, np.concatenate(chunks[place:]), coordinates, options, False))
            break
        results.extend(_solve_stack(pieces, chunk, options, monitor, start, coordinates))
    return results


def _chunks(sizes, numbers, block, samples):
    """Parts of some pieces, in each of which they have about the same size, and few numbers are worked on at once, of
    their matrices as of their samples."""
    numbers = numbers[np.argsort(sizes[numbers], kind="stable")]
    # Sizes that differ by less than a fourth are filled up to the same one.
    steps = np.ceil(np.log(sizes[numbers]) / np.log(1.25)).astype(int)
    chunks = []
    for part in np.split(numbers, np.flatnonzero(np.diff(steps)) + 1):
        rows = sizes[part[-1]] * block
        most = max(AT_ONCE // (rows * max(rows, LARGEST, samples)), 1)
        chunks.extend(np.array_split(part, -(-len(part) // most)))
    return chunks


def _solve_stack(pieces, numbers, options, monitor, start, coordinates):
    """The PartResults of the pieces of one stack."""
    stack = pieces.stack(numbers)
    column = None
    if start.column is not None:
        column = np.ones((*stack.used.shape, 1), stack.matrices.dtype)
        column[stack.used] = start.column[pieces.rows(numbers)]
    if options.method == "sdp":
        parts = solve_small(stack, options, monitor, column)
        return [_certify_stack(pieces, numbers[own], stack[own], found, coordinates) for own, found in parts]
    if options.method == DESCENT:
        fields, steps, out_of_time = descend_stack(stack, column, monitor)
        status = Status.TIME_LIMIT if out_of_time else Status.UNCERTIFIED
        return [_alone(pieces, numbers, stack, fields, iterations=steps, status=status)]
    values, vectors = smallest_eigenpairs(stack)
    bound = float(stack.weights @ (values * pieces.sizes[numbers]))
    quality = {"bound": bound, "spectral_bound": bound, "certificate": Certificate.ESTIMATED}
    return [_alone(pieces, numbers, stack, vectors, **quality)]


def _alone(pieces, numbers, stack, fields, **quality):
    return PartResult(pieces.rows(numbers), stack.mass.shape[1], _columns(stack, fields), **quality)


def _certify_stack(pieces, numbers, stack, found, coordinates):
    fields, lifted = _columns(stack, found.fields), found.lifted[stack.used]
    status = Status.CERTIFIED if found.reached.all() else Status.TARGET_GAP_NOT_REACHED
    if found.out_of_time:
        fields, status = _better(pieces, numbers, fields[:, :1], coordinates), Status.TIME_LIMIT
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


def _better(pieces, numbers, fields, coordinates):
    """Each piece's (m, 1) fields, or (N,) coordinates where these have less energy."""
    given = coordinates[pieces.rows(numbers)][:, None]
    is_worse = pieces.energies_of(numbers, fields) > pieces.energies(coordinates)[numbers]
    rows = pieces.sizes[numbers] * (len(given) // pieces.sizes[numbers].sum())
    return np.where(np.repeat(is_worse, rows)[:, None], given, fields)


def _columns(stack, fields):
    """(m, c) unit coordinates of the pieces, one after the other, of (k, N, c) fields; grounds have the phase 1."""
    fields = candidates(stack.block, True).normalize(fields.reshape(-1, fields.shape[2])).reshape(fields.shape)
    held = np.flatnonzero(stack.grounds >= 0)
    values = fields[held, stack.grounds[held] * stack.block]
    sizes = np.abs(values)
    fields[held] *= np.where(sizes > 0, np.conj(values) / np.where(sizes > 0, sizes, 1), 1)[:, None, :]
    return fields[stack.used]
