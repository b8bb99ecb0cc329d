# SPDX-License-Identifier: GPL-3.0-or-later
"""Many small pieces on the circle at once, as stacks of dense matrices: relaxed, proved and rounded like large ones.

Most small pieces are tight: the best phases have the energy of the relaxation (22), and the multipliers of Eq. (22) at
these phases prove it. So each is first polished from its smallest eigenvector (Eq. 19). Where the result cannot be
proved optimal, a lifted field is computed (Eq. 24), with enough columns to rule out other local optima, and rounded.

Fields are arrays of (k, N, c): c columns of each of the k pieces. For the descent they stand side by side.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...monitor import Monitor
from ...piece import NOISE
from ...pieces import Stack
from ...solution import Options
from ..methods.descent import Descent, descend
from ..methods.manifolds import Circles, Columns, gaussian
from ..methods.rounding import CANDIDATE_SHIFT, FINAL_TOLERANCE, SAME_FIELD, TOLERANCE, random_directions
from ..methods.stage import LIFTED_SHIFT
from ..methods.staircase import AIMED_AT, WEAKEST_GAP
from .arrays import (
    OfLifted,
    SideBySide,
    as_columns,
    diagonals,
    multipliers,
    positive_inverse,
    principal_columns,
    set_unused,
    side_by_side,
    stacked_fields,
    turning_hessian,
    turning_laplacians,
    unit_lifted,
    with_diagonal,
)

# Nodes of a small piece at most, and numbers in an array of a stack at most.
LARGEST, AT_ONCE = 64, 1 << 21
# The part of the multipliers that is subtracted in the metric of lifted fields.
SUBTRACTED = 0.9
# The least eigenvalue of a Hessian as a metric, in units of the energy per mass.
HESSIAN_SHIFT = 0.01
# More than the least eigenvalue of any piece, which is about 1 at most.
UNUSED = 1e2
# Rounding error of the least eigenvalue of a matrix with unit diagonal, in units of the last digit, for each row.
ROUNDINGS = 5
# The least energy per mass in a metric.
LEAST_DENSITY = 1e-12
# Steps of consecutive descents, each with a new metric, and steps of candidates.
FIRST_STEPS, STEPS, CANDIDATE_STEPS = (10, 10), (10, 10, 60), 15
# Steps of lifted fields, after each of which a proof is tried; after some few pieces are left.
LIFTED_TOLERANCE = 1e-8
LIFTED_STEPS = 10, 10, 10, 10, 20, 20, 40, 40, 80, 80, 160, 320
# Projections that descend.
KEPT = 16


@dataclass(frozen=True)
class SmallResult:
    """The result of a stack.

    ``fields`` (k, N, c), best first, a piece with fewer repeats its last; ``lifted`` (k, N, r) in principal columns;
    ``bounds`` (k,), all proved; ``reached`` (k,) bool, whether the target gap was reached; ``steps`` of descents;
    ``out_of_time``, whether time ran out before the end.
    """

    fields: np.ndarray
    lifted: np.ndarray
    bounds: np.ndarray
    reached: np.ndarray
    steps: int
    out_of_time: bool


def smallest_eigenpairs(stack: Stack) -> tuple[np.ndarray, np.ndarray]:
    """(k,) smallest eigenvalues of (L, M) and (k, N, 1) eigenvectors."""
    root = np.sqrt(stack.row_mass)
    matrices = stack.matrices / (root[:, :, None] * root[:, None, :])
    set_unused(matrices, stack, UNUSED)
    grounded = np.flatnonzero(stack.grounds >= 0)
    for row in range(1, stack.block):
        at = stack.grounds[grounded] * stack.block + row
        matrices[grounded, at, at] = UNUSED
    values, vectors = np.linalg.eigh(matrices)
    return np.maximum(values[:, 0], 0.0), vectors[:, :, :1] / root[:, :, None]


def solve_small(
    stack: Stack, options: Options, monitor: Monitor, start: np.ndarray | None = None
) -> list[tuple[np.ndarray, SmallResult]]:
    """Relax, prove and round all pieces of a stack on the circle; returns numbers of pieces with their results.

    With (k, N, 1) fields as the start, and the rounding "polish" or "continuation", the fields returned are the local
    optima that descent reaches from there.
    """
    search, fields = _Search(stack, options, monitor), None
    if start is not None and options.rounding in ("polish", "continuation"):
        fields = search.polish(start, STEPS)
    first = search.polish(smallest_eigenpairs(stack)[1], FIRST_STEPS)
    reached = search.prove(first, AIMED_AT * options.target_gap)[1]
    easy, hard = np.flatnonzero(reached), np.flatnonzero(~reached)
    results = []
    if search.out_of_time:
        results.append((np.arange(len(stack)), search.finish_tight(first)))
    elif len(easy):
        results.append((easy, _Search(stack[easy], options, monitor).finish_tight(first[easy])))
    if len(hard) and not search.out_of_time:
        results.append((hard, _Search(stack[hard], options, monitor).relax(first[hard])))
    return results if fields is None else [(k, replace(found, fields=fields[k])) for k, found in results]


def descend_stack(stack: Stack, start: np.ndarray, monitor: Monitor) -> tuple[np.ndarray, int, bool]:
    """(k, N, 1) local optima that descent reaches from fields, its steps, and whether time ran out before."""
    search = _Search(stack, Options(), monitor)
    return search.polish(start, STEPS), search.steps, search.out_of_time


class _Search:
    """The search for the fields of a stack of small pieces: descents, and proofs of bounds.

    Attributes
    ----------
    steps : number of steps of all descents
    out_of_time : whether a descent was ended by the time limit
    """

    def __init__(self, stack: Stack, options: Options, monitor: Monitor) -> None:
        self._stack, self._options, self._monitor = stack, options, monitor
        self._circles = Circles(stack.block)
        self.steps, self.out_of_time = 0, False

    def polish(self, fields: np.ndarray, all_steps: tuple[int, ...]) -> np.ndarray:
        """(k, N, 1) fields after consecutive descents, each in the metric of the Hessian at its start."""
        point = self._circles.normalize(side_by_side(fields))
        for steps in all_steps:
            metric = SideBySide(self._invert_hessian(stacked_fields(point, len(self._stack))))
            point = self._descend_fields(point, metric, steps, FINAL_TOLERANCE)
            if self.out_of_time:
                break
        return stacked_fields(point, len(self._stack))

    def _descend_fields(self, point: np.ndarray, metric: SideBySide, steps: int, tolerance: float) -> np.ndarray:
        matrix = SideBySide(self._stack.matrices)
        return self._count_steps(descend(matrix, self._circles, point, metric, tolerance, steps, self._monitor))

    def _invert_hessian(self, fields: np.ndarray) -> np.ndarray:
        """(k, n, n) inverses of the Hessians in angles, their eigenvalues made positive."""
        densities = _densities(self._stack, multipliers(self._stack, fields).sum(axis=1))
        return positive_inverse(turning_hessian(self._stack, fields), HESSIAN_SHIFT * densities)

    def finish_tight(self, fields: np.ndarray) -> SmallResult:
        """The result of fields whose energy is that of the relaxation."""
        fields = self.polish(fields, STEPS[-1:])
        bounds, reached = self.prove(fields, AIMED_AT * self._options.target_gap)
        return SmallResult(fields, fields, bounds, reached, self.steps, self.out_of_time)

    def prove(self, fields: np.ndarray, gap: float) -> tuple[np.ndarray, np.ndarray]:
        """(k,) bounds at a relative gap, or within rounding, from the energies of lifted fields, and whether each is
        proved. The others are zero, which always holds."""
        stack, duals = self._stack, multipliers(self._stack, fields)
        values = np.maximum(duals.sum(axis=1), 0.0)
        noise = NOISE * np.count_nonzero(stack.used, axis=1)
        aims = np.maximum(values - np.maximum(gap * values, noise), 0.0)
        shift = LIFTED_SHIFT * _densities(stack, values)
        mass = np.where(stack.used[:, :: stack.block], stack.mass, 0.0).sum(axis=1)
        depth = np.maximum((duals.sum(axis=1) - aims) / (aims + shift * mass), 0.0)
        share = 1 / (1 + depth)
        bounds = share * duals.sum(axis=1) - (1 - share) * shift * mass
        certain = self._is_definite(shift, duals, depth)
        return np.where(certain, np.maximum(bounds, 0.0), 0.0), certain | (values <= noise)

    def _is_definite(self, shift: np.ndarray, duals: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """(k,) bool: whether S + depth A is positive definite, A = L + shift M (see :mod:`..methods.certificate`).

        With L scaled to a unit diagonal, the eigenvalues have an error of some units of rounding, subtracted first.
        """
        stack = self._stack
        matrices = (1 + depth)[:, None, None] * stack.matrices
        diagonal = diagonals(stack)
        added = (depth * shift)[:, None] * stack.row_mass - np.repeat(duals, stack.block, axis=1)
        hidden = ROUNDINGS * np.finfo(float).eps * matrices.shape[1]
        matrices = with_diagonal(matrices, added - hidden * diagonal)
        scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        matrices *= scale[:, :, None] * scale[:, None, :]
        set_unused(matrices, stack, 1.0)
        return np.linalg.eigvalsh(matrices)[:, 0] > 0

    def relax(self, found: np.ndarray) -> SmallResult:
        """The result of lifted fields and of the fields that they round to, with (k, N, 1) fields found before."""
        stack, options = self._stack, self._options
        random = np.random.default_rng(options.seed)
        point = gaussian((*stack.used.shape, self._rank), stack.is_complex, random)
        grounded = np.flatnonzero(stack.grounds >= 0)
        for row in range(1, stack.block):  # unused
            point[grounded, stack.grounds[grounded] * stack.block + row] = 0
        point = unit_lifted(stack, point)
        values = multipliers(stack, found).sum(axis=1)
        bounds, going = np.zeros(len(stack)), np.arange(len(stack))
        tolerance = LIFTED_TOLERANCE * options.target_gap
        for steps in LIFTED_STEPS:
            part = _Search(stack[going], options, self._monitor)
            point[going] = part.descend_lifted(point[going], values[going], steps, tolerance)
            self.steps, self.out_of_time = self.steps + part.steps, part.out_of_time
            bounds[going], reached = part.prove(point[going], AIMED_AT * options.target_gap)
            going = going[~reached]
            if len(going) == 0 or self.out_of_time:
                break
        is_reached = np.ones(len(stack), bool)
        is_reached[going] = False
        for gap in options.target_gap * 10.0 ** np.arange(1, 1 + int(np.log10(WEAKEST_GAP / options.target_gap))):
            if len(going):
                bounds[going], reached = _Search(stack[going], options, self._monitor).prove(point[going], gap)
                going = going[~reached]
        lifted = principal_columns(stack, point)
        fields = found if self.out_of_time else self._round(lifted, found, random)
        return SmallResult(fields, unit_lifted(stack, lifted), bounds, is_reached, self.steps, self.out_of_time)

    @property
    def _rank(self) -> int:
        """Columns with which a lifted field has no other local optima in general (Barvinok and Pataki)."""
        size = self._stack.mass.shape[1]
        return int(np.ceil(np.sqrt(size) if self._stack.is_complex else np.sqrt(2 * size))) + 1

    def descend_lifted(self, point: np.ndarray, values: np.ndarray, steps: int, tolerance: float) -> np.ndarray:
        """(k, N, r) lifted fields after descent, preconditioned by the matrix less most of the multipliers.

        ``values`` are (k,) energies that are not far below those of the relaxation.
        """
        stack = self._stack
        duals = multipliers(stack, point)
        shift = LIFTED_SHIFT * _densities(stack, np.minimum(duals.sum(axis=1), values))[:, None]
        lowered = (1 - SUBTRACTED) * shift * stack.row_mass - SUBTRACTED * np.repeat(duals, stack.block, axis=1)
        inverse = positive_inverse(with_diagonal(stack.matrices, lowered), (1 - SUBTRACTED) * shift[:, 0])
        matrix = OfLifted(stack.matrices)
        spheres, columns = Columns(as_columns(point[:1]).shape[0] // stack.mass.shape[1]), as_columns(point)
        descent = descend(matrix, spheres, columns, OfLifted(inverse), tolerance, steps, self._monitor)
        return matrix.fields(self._count_steps(descent))

    def _count_steps(self, descent: Descent) -> np.ndarray:
        """The end of a descent, whose steps are added up."""
        self.steps += descent.steps
        self.out_of_time |= descent.out_of_time
        return descent.point

    def _round(self, lifted: np.ndarray, found: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """(k, N, c) fields that lifted ones round to, best first (Section 4.5)."""
        stack, options = self._stack, self._options
        if options.rounding == "svd":
            return self._normalize(lifted[:, :, :1])
        directions = random_directions(stack.is_complex, lifted.shape[2], options.samples, random)
        fields = self._lowest(self._normalize(lifted @ directions), KEPT)
        if options.rounding == "random":
            return fields
        point = side_by_side(np.concatenate([fields, found], axis=2))
        shifts = CANDIDATE_SHIFT * _densities(stack, multipliers(stack, lifted).sum(axis=1))
        metric = SideBySide(positive_inverse(turning_laplacians(stack), shifts))
        fields = self._lowest(
            stacked_fields(self._descend_fields(point, metric, CANDIDATE_STEPS, TOLERANCE), len(stack)), KEPT
        )
        fields[:, :, :1] = self.polish(fields[:, :, :1], STEPS)
        return self._remove_copies(fields)

    def _normalize(self, fields: np.ndarray) -> np.ndarray:
        return stacked_fields(self._circles.normalize(side_by_side(fields)), len(self._stack))

    def _lowest(self, fields: np.ndarray, count: int) -> np.ndarray:
        """The ``count`` fields of least energy of each piece, best first."""
        order = np.argsort(self._energies(fields), axis=1, kind="stable")[:, :count]
        return _take(fields, order)

    def _energies(self, fields: np.ndarray) -> np.ndarray:
        """(k, c) energies."""
        return (np.conj(fields) * (self._stack.matrices @ fields)).real.sum(axis=1)

    def _remove_copies(self, fields: np.ndarray) -> np.ndarray:
        """Fields without those that equal a better one up to a turn of the whole; pieces with fewer repeat the last."""
        stack = self._stack
        fields = self._lowest(fields, fields.shape[2])
        used = np.where(stack.used[:, :, None], fields, 0)
        sizes = np.count_nonzero(stack.used, axis=1) / stack.block
        agreement = np.abs(np.conj(used).swapaxes(1, 2) @ used) / sizes[:, None, None]
        kept = np.ones(fields.shape[::2], bool)
        for column in range(1, fields.shape[2]):
            kept[:, column] = ~((agreement[:, column, :column] > SAME_FIELD) & kept[:, :column]).any(axis=1)
        order, counts = np.argsort(~kept, axis=1, kind="stable"), kept.sum(axis=1)
        order = np.take_along_axis(order, np.minimum(np.arange(counts.max()), counts[:, None] - 1), axis=1)
        return _take(fields, order)


def _take(fields: np.ndarray, order: np.ndarray) -> np.ndarray:
    """(k, N, m) the columns of (k, m) numbers of each piece."""
    return np.take_along_axis(fields, order[:, None, :], axis=2)


def _densities(stack: Stack, values: np.ndarray) -> np.ndarray:
    """(k,) energies per mass, positive; the mean mass is 1, and so is the mean diagonal."""
    return np.maximum(values * stack.block / np.count_nonzero(stack.used, axis=1), LEAST_DENSITY)
