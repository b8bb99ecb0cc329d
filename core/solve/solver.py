# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve a synchronization problem piece by piece: relax, certify, round, polish."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from ..algebra.metric import SMALLEST_SHIFT
from ..algebra.workers import solving
from ..memory import check_memory
from ..monitor import Callback, Monitor, OutOfTime
from ..problem import SynchronizationProblem
from ..solution import COARSE, DESCENT, FIRST, Certificate, Clock, Options, Solution, Status, relative_gap
from .batched.components import solve_components
from .batched.parts import PartResult, Start, combine
from .methods import rounding
from .methods.diffusion import diffuse
from .methods.initial_field import first_field, search_after_relaxation, search_without_relaxation
from .methods.manifolds import fields_of, random_columns
from .methods.memory_estimate import connection_bytes
from .methods.spectral import smallest_eigenpair
from .methods.stage import Workspace
from .methods.staircase import MAX_RANK, relax, start_rank
from .options_check import check_options

DIFFUSION_STARTS = 8
DIFFUSION_TIMES = 0.5 ** np.arange(11)
DIFFUSION_STEPS = 30
# Share by which the problem is calmed on which most of the search for phases is made.
CALM_SHARE = 0.1
# A rounded relaxation whose gap is at most this is taken for an exact recovery, which descent completes.
NEARLY_TIGHT = 0.05
# How many times as long as a first field a bound takes, about (measured in bench/README.md).
PROOF_IN_FIRSTS = 3.0


def solve(
    problem: SynchronizationProblem,
    options: Options | None = None,
    callback: Callback | None = None,
    start: Solution | np.ndarray | None = None,
    show: Callable[[Solution], object] | None = None,
) -> Solution:
    """Find phases of low energy together with a lower bound.

    Parameters
    ----------
    problem : SynchronizationProblem
    options : Options, optional
    callback : callable(stage, fraction) -> bool, optional
        Asked at every iteration; returning False (any false value but None) cancels.
    start : phases of a nearby problem on the same nodes, optional
        The result is then the local optimum that descent reaches from them, so that it stays near: the next frame
        of an animation, a changed spacing, one more constraint. A Solution may be given as well, whose
        lifted field then starts the relaxation. With the rounding "svd" or "random" only that counts.
    show : callable(Solution), optional
        Called before the end with what there is: a first field after a small part of the time, the same when its bound
        is known, and then each better one. What is returned is the same without it. For the method "sdp".

    Returns
    -------
    Solution

    Raises
    ------
    SettingError
        for an option out of range, or a start that does not fit
    Cancelled
        when the callback says so; nothing has been changed. Both are in ``core.errors``
    """
    options = Options() if options is None else options
    check_options(options, problem, start)
    with solving():
        return _solve(problem, options, callback, start, show if options.method == "sdp" else None)


def _solve(problem, options, callback, start, show):
    clock = Clock()
    monitor = Monitor(callback, options.time_limit)
    if options.method == "sdp":
        _check_memory(problem)
    with clock("build"):
        pieces = problem.pieces
        begin = Start.of(problem, start)
    work = pieces.sizes.sum() or 1
    results, left = [], np.arange(len(pieces))
    if len(pieces) > 1 or (len(pieces) and options.method in ("sdp", FIRST, COARSE)):
        results, left = solve_components(problem, options, monitor, clock, begin)
    done = 1 - pieces.sizes[left].sum() / work
    calmed = _Calmed(problem)
    watches = {} if show is None else _show_better_fields(problem, options, monitor, clock, begin, results, left, show)
    for number in left:
        share = pieces.sizes[number] / work
        piece = pieces[number]
        calm = partial(calmed.matrix, number)
        part = monitor.portion(done, share)
        watch = watches.get(number)
        results.append(_solve_piece(piece, options, part, clock, begin.on(piece), calm, watch))
        done += share
    return combine(problem, results, options, clock.seconds)


def _show_better_fields(problem, options, monitor, clock, begin, results, left, show):
    """Show a first field, and later each better one; returns the :class:`_Watch` of each piece that is left."""
    done = tuple(results)
    watches: dict[int, _Watch] = {}

    def tell():
        parts = [watch.part for watch in watches.values()]
        show(combine(problem, [*done, *parts], options, clock.seconds.copy()))

    for number in left:
        piece, start = problem.pieces[number], time.perf_counter()
        first = replace(options, method=FIRST)
        part = _solve_piece(piece, first, monitor.portion(0.0, 0.0), clock, begin.on(piece), None, None)
        watches[number] = _Watch(part, tell, PROOF_IN_FIRSTS * (time.perf_counter() - start))
    if len(left):
        tell()
    return watches


class _Watch:
    """What is shown of a piece before its end.

    Attributes
    ----------
    part : PartResult that is shown, at the piece's own scale
    proof_in : seconds after which a bound may be expected
    """

    def __init__(self, part, tell, proof_in):
        self.part, self.proof_in, self._tell = part, proof_in, tell
        self._piece, self._weight, self._energy = None, 1.0, np.inf

    def on(self, piece, weight):
        """The solve begins, on the scaled piece."""
        self._piece, self._weight = piece, weight
        self._energy = float(piece.energy(self.part.fields)[0])

    def proved(self, **quality):
        """There is a bound."""
        self.part = _rescale_piece(_finish_piece(self._piece, self.part.fields, **quality), self._weight)
        self._tell()

    def found(self, energy, column):
        """There is a field, (N * width, 1), of an energy."""
        if energy < self._energy:
            self._energy = energy
            fields = _finish_piece(self._piece, column).fields
            self.part = replace(self.part, fields=fields)
            self._tell()


def _check_memory(problem):
    """Refuse a problem whose largest piece takes more memory than there is."""
    connection, sizes = problem.connection, problem.component_sizes
    share = sizes.max(initial=0) / max(sizes.sum(), 1)
    whole = connection_bytes(connection.node_count, len(connection.edges), problem.block, problem.is_complex)
    check_memory(share * whole, f"a solve of {connection.node_count:,} phases")


class _Calmed:
    """The pieces of the calmed problem, made when the first one asks for its matrix."""

    def __init__(self, problem):
        self._problem = problem

    @cached_property
    def _pieces(self):
        problem = self._problem
        turns = np.zeros(0) if problem.calmer is None else problem.calmer()
        if not turns.any() or not np.isfinite(turns).all():
            return None
        return problem.turned_by(CALM_SHARE * turns).pieces

    def matrix(self, number, weight):
        """That of a piece over its weight; None where nothing can be calmed."""
        return None if self._pieces is None else self._pieces[number].matrix / weight


def _solve_piece(piece, options, monitor, clock, start, calm, watch):
    """Solve a piece scaled to a mean diagonal and a mean mass of 1, so that single precision holds all of it."""
    if piece.total_weight == 0:  # nothing is asked
        status = Status.CERTIFIED if options.method == "sdp" else Status.UNCERTIFIED
        return _without_search(piece, options, status, start)
    scaled, weight = piece.scaled()
    if watch is not None:
        watch.on(scaled, weight)
    try:
        by_weight = None if calm is None else partial(calm, weight)
        result = _solve_by_method(scaled, options, monitor, clock, start, by_weight, watch)
    except OutOfTime:
        result = _without_search(scaled, options, Status.TIME_LIMIT, start)
    return _rescale_piece(result, weight)


def _rescale_piece(result, weight):
    return replace(
        result,
        bound=weight * result.bound,
        sdp_value=weight * result.sdp_value,
        spectral_bound=weight * result.spectral_bound,
    )


def _without_search(piece, options, status, start):
    """The start, or equal phases, and zero as the bound, which proves something only where nothing is asked."""
    size = piece.matrix.shape[0] * piece.width
    column = np.zeros((size, 1), piece.matrix.dtype) if start.column is None else start.column
    column = fields_of(piece).normalize(column)
    lifted = column.reshape(-1, piece.width)
    return _finish_piece(
        piece,
        column,
        sdp_value=float(piece.energy(column)[0]),
        certificate=Certificate.NONE if status is Status.TIME_LIMIT else Certificate.PROVED,
        status=status,
        lifted=lifted if options.method == "sdp" else None,
        singular_values=np.linalg.norm(lifted, axis=0),
    )


def _solve_by_method(piece, options, monitor, clock, start, calm, watch):
    if options.method == "spectral":
        return _solve_spectral(piece, options, monitor, clock)
    with clock("relax"):
        monitor.at("building", 0.0)
        workspace = monitor.during(partial(Workspace, piece))
    if options.method == "diffusion":
        return _solve_diffusion(workspace, options, monitor, clock)
    if options.method == DESCENT:
        return _solve_descent(workspace, monitor, clock, start.column)
    if options.method in (FIRST, COARSE):
        return _solve_first(workspace, options, monitor, clock, start.column)
    return _solve_sdp(workspace, options, monitor, clock, start, calm, watch)


def _finish_piece(piece, columns, **quality):
    fields = fields_of(piece).normalize(columns.astype(piece.matrix.dtype))
    return PartResult(piece.rows, piece.node_count, rounding.ground_to_one(piece, fields), **quality)


def _solve_spectral(piece, options, monitor, clock):
    with clock("relax"):
        monitor.at("spectral relaxation", 0.0)
        eigenvalue, vector = monitor.during(partial(smallest_eigenpair, piece, options.seed))
    bound = eigenvalue * piece.total_mass
    return _finish_piece(
        piece,
        vector[:, None],
        bound=bound,
        spectral_bound=bound,
        certificate=Certificate.ESTIMATED,
        status=Status.UNCERTIFIED,
    )


def _solve_diffusion(workspace, options, monitor, clock):
    """MBO from random starts with falling times, the best polished: the strongest baseline."""
    piece, stage = workspace.piece, workspace.stages[0]
    random = np.random.default_rng(options.seed)
    with clock("relax"):
        monitor.at("diffusion", 0.0)
        eigenvalue, _ = monitor.during(partial(smallest_eigenpair, piece, options.seed))
        bound = eigenvalue * piece.total_mass
        columns = random_columns(piece, DIFFUSION_STARTS * piece.width, random).reshape(-1, DIFFUSION_STARTS)
        times = DIFFUSION_TIMES / max(eigenvalue, SMALLEST_SHIFT * piece.stiffness)
        metrics = (stage.metric(1 / tau) for tau in times)
        columns = diffuse(stage, columns, metrics, DIFFUSION_STEPS, monitor, tolerance=1e-2)
    with clock("round"):
        monitor.at("polish", 0.8)
        metric = stage.candidate_metric(eigenvalue)
        columns = rounding.polish(stage, columns, metric, monitor)
        columns = np.hstack([rounding.finish(workspace, columns[:, :1], metric, monitor), columns[:, 1:]])
    return _finish_piece(
        piece, columns, bound=bound, spectral_bound=bound, certificate=Certificate.ESTIMATED, status=Status.UNCERTIFIED
    )


def _solve_descent(workspace, monitor, clock, start):
    """The local optimum that descent reaches."""
    piece = workspace.piece
    with clock("round"):
        monitor.at("descent", 0.0)
        density = float(piece.energy(start)[0]) / piece.total_mass
        metric = monitor.during(partial(workspace.stages[0].candidate_metric, rounding.CANDIDATE_SHIFT * density))
        column = rounding.finish(workspace, start, metric, monitor)
    return _finish_piece(piece, column, certificate=Certificate.NONE, status=Status.UNCERTIFIED)


def _solve_first(workspace, options, monitor, clock, start):
    """The first field that is shown, or the one that a search on a coarse stage finds: where there is a start, that."""
    with clock("first"):
        monitor.at("first field", 0.0)
        rank, timed_out = start_rank(workspace.piece, True, options.target_gap), False
        if start is not None:
            column = start
        elif options.method == FIRST:
            column = first_field(workspace, rank, options.seed, monitor)
        else:
            column, timed_out = search_without_relaxation(workspace, rank, options.seed, options.samples, monitor)
    status = Status.TIME_LIMIT if timed_out else Status.UNCERTIFIED
    return _finish_piece(workspace.piece, column, certificate=Certificate.NONE, status=status)


def _solve_sdp(workspace, options, monitor, clock, start, calm, watch):
    monitor.expect(0.0 if watch is None else watch.proof_in)
    monitor.at("relaxation", 0.0)
    piece = workspace.piece
    relaxation = relax(workspace, options, monitor, clock, start.lifted)
    monitor.proved(relaxation.lower_bound)
    if relaxation.reached:
        status = Status.CERTIFIED if relaxation.certificate is Certificate.PROVED else Status.ESTIMATED
    else:
        status = Status.MAX_RANK if relaxation.lifted.shape[1] >= MAX_RANK else Status.TARGET_GAP_NOT_REACHED
    quality = {
        "bound": relaxation.lower_bound,
        "sdp_value": relaxation.value,
        "certificate": relaxation.certificate,
        "lifted": relaxation.lifted,
        "singular_values": relaxation.singular_values,
        "iterations": relaxation.steps,
        "products": relaxation.products,
    }
    if watch is not None:
        watch.proved(status=status, **quality)
        monitor.on_found = watch.found
    with clock("round"):
        columns, timed_out = _round(workspace, relaxation, options, monitor, start.column, calm)
    if relaxation.out_of_time or timed_out:
        status = Status.TIME_LIMIT
    result = _finish_piece(piece, columns, status=status, **quality)
    # Phases of less energy, which a tight relaxation may round to, are a better point of it.
    return replace(result, sdp_value=min(relaxation.value, float(piece.energy(result.fields[:, :1])[0])))


def _round(workspace, relaxation, options, monitor, start, calm):
    """Candidates as columns, best first, and whether time ran out before they were finished."""
    piece, stage, lifted = workspace.piece, workspace.stages[0], relaxation.lifted
    start = start if options.rounding in ("polish", "continuation", COARSE) else None
    leading = lifted[:, : piece.width].reshape(-1, 1)
    by_svd = stage.candidates.normalize(leading) if start is None else start
    if options.rounding == "svd" or relaxation.out_of_time:
        return by_svd, relaxation.out_of_time
    random = np.random.default_rng(options.seed + 1)
    density = relaxation.value / piece.total_mass
    columns = by_svd
    try:
        if options.rounding in ("random", "polish") and start is None:
            sizes = lifted.shape[1], options.samples
            directions = rounding.random_directions(piece.is_complex, *sizes, random, piece.width)
            columns = rounding.projections(stage, lifted, directions, rounding.ALONE.kept, monitor).astype(lifted.dtype)
            if options.rounding == "random":
                return columns, False
        if options.rounding == COARSE and start is None:
            return search_after_relaxation(workspace, lifted, options.samples, random, monitor)
        if options.rounding == "continuation" and start is None:
            monitor.at("continuation", 0.4)
            energy = float(piece.energy(by_svd)[0])
            if relative_gap(energy, relaxation.lower_bound, piece.perfect) > NEARLY_TIGHT:
                matrix = monitor.during(calm)
                columns, timed_out = rounding.continuation(
                    stage, lifted, options.samples, density, random, monitor, matrix, relaxation.metric
                )
                if timed_out:
                    return columns, True
        monitor.at("polish", 0.9)
        metric = stage.candidate_metric(rounding.CANDIDATE_SHIFT * density)
        finished = rounding.finish(workspace, columns[:, :1], metric, monitor)
        columns = np.hstack([finished, columns[:, 1:]])
    except OutOfTime:
        return columns, True
    return columns, False
