# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve a synchronization problem piece by piece: relax, certify, round, polish."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial

import numpy as np
from scipy.sparse import csr_matrix

from ..algebra.metric import SMALLEST_SHIFT
from ..algebra.workers import beside, solving
from ..monitor import Callback, Monitor, OutOfTime
from ..piece import Piece
from ..pieces import Pieces
from ..problem import SynchronizationProblem
from ..solution import COARSE, DESCENT, FIRST, GLANCE, Certificate, Clock, Options, Solution, Status
from .batched.components import solve_components
from .batched.parts import PartResult, Start, combine
from .methods import rounding
from .methods.diffusion import diffuse
from .methods.initial_field import descend_from, first_field, search_without_relaxation
from .methods.manifolds import fields_of, random_columns
from .methods.memory_estimate import check_problem_memory
from .methods.spectral import smallest_eigenpair
from .methods.stage import Workspace
from .methods.staircase import start_rank
from .options_check import check_options
from .semidefinite import prepare_search, solve_semidefinite
from .task import Task, Watch, finish_piece, rescale

DIFFUSION_STARTS = 8
DIFFUSION_TIMES = 0.5 ** np.arange(11)
DIFFUSION_STEPS = 30
# Share of the curl that is removed from the problem on which most of the search for phases is made.
CURL_SHARE = 0.1
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

    Raises SettingError for an option out of range, or a start that does not fit; Cancelled when the callback cancels;
    nothing has been changed. Both are in ``core.errors``.

    Parameters
    ----------
    callback : callable(stage, fraction), optional
        Called at every iteration; returning False (any false value but None) cancels.
    start : phases of a nearby problem on the same nodes, optional
        The result is then the local optimum that descent reaches from them, so that it stays near: the next frame
        of an animation, a changed spacing, one more constraint. A Solution may be given as well, whose
        lifted field then starts the relaxation. With the rounding "svd" or "random" only that counts.
    show : callable(Solution), optional
        Called with preliminary solutions: a first field after a small part of the time, the same when its bound is
        known, and then each better one. The result is the same without it. For the method "sdp".
    """
    options = Options() if options is None else options
    check_options(options, problem, start)
    with solving():
        return _solve(problem, options, Monitor(callback, options.time_limit), start, show)


def _solve(
    problem: SynchronizationProblem,
    options: Options,
    monitor: Monitor,
    start: Solution | np.ndarray | None,
    show: Callable[[Solution], object] | None,
) -> Solution:
    """As :func:`solve`, after checks: small or perfect pieces together, then the others one by one."""
    clock = Clock()
    if options.method == "sdp":
        check_problem_memory(problem)
    with clock("build"):
        pieces = problem.pieces
        begin = Start.of(problem, start)
    work = pieces.sizes.sum() or 1
    results: list[PartResult] = []
    left = np.arange(len(pieces))
    if len(pieces) > 1 or (options.integrate and options.method == "sdp"):
        results, left = solve_components(problem, options, monitor, clock, begin)
    done = 1 - pieces.sizes[left].sum() / work
    less_curl, watches = _LessCurl(problem), {}
    if show is not None and options.method == "sdp":
        watches = _show_first_fields(problem, options, monitor, clock, begin, results, left, show)
    for number in left.tolist():
        share = pieces.sizes[number] / work
        task = Task(pieces[number], options, monitor.portion(done, share), clock, begin.on(pieces[number]))
        matrix = partial(less_curl.matrix, number)
        results.append(_solve_piece(replace(task, less_curl=matrix, watch=watches.get(number))))
        done += share
    return combine(problem, results, options, clock.seconds)


def _show_first_fields(
    problem: SynchronizationProblem,
    options: Options,
    monitor: Monitor,
    clock: Clock,
    begin: Start,
    results: list[PartResult],
    left: np.ndarray,
    show: Callable[[Solution], object],
) -> dict[int, "Watch"]:
    """Show a first field; returns the :class:`Watch` that shows better ones of each piece that is left."""
    done = tuple(results)
    watches: dict[int, Watch] = {}

    def show_all() -> None:
        parts = [watch.part for watch in watches.values()]
        show(combine(problem, [*done, *parts], options, clock.seconds.copy()))

    first = replace(options, method=FIRST)
    for number in left.tolist():
        piece, start = problem.pieces[number], time.perf_counter()
        part = _solve_piece(Task(piece, first, monitor.portion(0.0, 0.0), clock, begin.on(piece)))
        watches[number] = Watch(part, show_all, PROOF_IN_FIRSTS * (time.perf_counter() - start))
    if len(left):
        show_all()
    return watches


class _LessCurl:
    """The pieces of the problem with less curl, built when the first matrix is needed."""

    def __init__(self, problem: SynchronizationProblem) -> None:
        self._problem = problem

    @cached_property
    def _pieces(self) -> Pieces | None:
        problem = self._problem
        turns = np.zeros(0) if problem.calmer is None else problem.calmer()
        if not turns.any() or not np.isfinite(turns).all():
            return None
        return problem.turned_by(CURL_SHARE * turns).pieces

    def matrix(self, number: int, weight: float) -> csr_matrix | None:
        """A piece's matrix over its weight; None where there is no curl to remove."""
        return None if self._pieces is None else self._pieces[number].matrix / weight


def _solve_piece(task: Task) -> PartResult:
    """Solve a piece scaled to a mean diagonal and a mean mass of 1, so that single precision holds all of it."""
    if task.piece.total_weight == 0:  # nothing is asked
        return _without_search(task, Status.CERTIFIED if task.options.method == "sdp" else Status.UNCERTIFIED)
    scaled, weight = task.piece.scaled()
    task = replace(task, piece=scaled, weight=weight)
    try:
        result = _solve_by_method(task)
    except OutOfTime:
        result = _without_search(task, Status.TIME_LIMIT)
    return rescale(result, weight)


def _without_search(task: Task, status: Status) -> PartResult:
    """The start, or equal phases, and zero as the bound, which proves something only where nothing is asked."""
    piece, column = task.piece, task.start.column
    if column is None:
        column = np.zeros((piece.matrix.shape[0] * piece.width, 1), piece.matrix.dtype)
    column = fields_of(piece).normalize(column)
    lifted = column.reshape(-1, piece.width)
    return finish_piece(
        piece,
        column,
        sdp_value=float(piece.energy(column)[0]),
        certificate=Certificate.NONE if status is Status.TIME_LIMIT else Certificate.PROVED,
        status=status,
        lifted=lifted if task.options.method == "sdp" else None,
        singular_values=np.linalg.norm(lifted, axis=0),
    )


def _solve_by_method(task: Task) -> PartResult:
    """Solve one piece by the method of its options."""
    method = task.options.method
    if method == "spectral":
        return _solve_spectral(task)
    with task.clock("relax"):
        task.monitor.at("building", 0.0)
        workspace = task.monitor.during(partial(Workspace, task.piece, is_rough=method == GLANCE))
    if method == "diffusion":
        return _solve_diffusion(task, workspace)
    if method == DESCENT:
        return _solve_descent(task, workspace)
    if method in (FIRST, GLANCE, COARSE):
        return _solve_first(task, workspace)
    with beside(partial(prepare_search, task, workspace.stages[0])) as prepared:
        return solve_semidefinite(task, workspace, prepared)


def _finish_spectral(piece: Piece, columns: np.ndarray, bound: float) -> PartResult:
    quality = {"certificate": Certificate.ESTIMATED, "status": Status.UNCERTIFIED}
    return finish_piece(piece, columns, bound=bound, spectral_bound=bound, **quality)


def _solve_spectral(task: Task) -> PartResult:
    piece, monitor = task.piece, task.monitor
    with task.clock("relax"):
        monitor.at("spectral relaxation", 0.0)
        eigenvalue, vector = monitor.during(partial(smallest_eigenpair, piece, task.options.seed))
    return _finish_spectral(piece, vector[:, None], eigenvalue * piece.total_mass)


def _solve_diffusion(task: Task, workspace: Workspace) -> PartResult:
    """MBO from random starts with falling times, the best polished: the strongest baseline."""
    piece, stage, monitor, seed = task.piece, workspace.stages[0], task.monitor, task.options.seed
    random = np.random.default_rng(seed)
    with task.clock("relax"):
        monitor.at("diffusion", 0.0)
        eigenvalue, _ = monitor.during(partial(smallest_eigenpair, piece, seed))
        columns = random_columns(piece, DIFFUSION_STARTS * piece.width, random).reshape(-1, DIFFUSION_STARTS)
        times = DIFFUSION_TIMES / max(eigenvalue, SMALLEST_SHIFT * piece.stiffness)
        metrics = (stage.metric(1 / tau) for tau in times)
        columns = diffuse(stage, columns, metrics, DIFFUSION_STEPS, monitor, tolerance=1e-2)
    with task.clock("round"):
        monitor.at("polish", 0.8)
        metric = stage.candidate_metric(eigenvalue)
        columns = rounding.polish(stage, columns, metric, monitor)
        columns = rounding.lowest(stage, columns, columns.shape[1])
        columns = np.hstack([rounding.finish(workspace, columns[:, :1], metric, monitor), columns[:, 1:]])
    return _finish_spectral(piece, columns, eigenvalue * piece.total_mass)


def _solve_descent(task: Task, workspace: Workspace) -> PartResult:
    """The local optimum that descent from the start reaches."""
    piece, monitor, start = task.piece, task.monitor, task.start.column
    assert start is not None  # options_check.py refuses the method without one
    with task.clock("round"):
        monitor.at("descent", 0.0)
        density = float(piece.energy(start)[0]) / piece.total_mass
        metric = monitor.during(partial(workspace.stages[0].candidate_metric, rounding.CANDIDATE_SHIFT * density))
        column = rounding.finish(workspace, start, metric, monitor)
    return finish_piece(piece, column, certificate=Certificate.NONE, status=Status.UNCERTIFIED)


def _solve_first(task: Task, workspace: Workspace) -> PartResult:
    """The start, with COARSE after descent; without one the first field, or that of a search on a coarse stage."""
    options, monitor, timed_out = task.options, task.monitor, False
    with task.clock("first"):
        monitor.at("first field", 0.0)
        rank = start_rank(task.piece, True, options.target_gap)
        if task.start.column is not None:
            column = task.start.column
            if options.method == COARSE:
                column = descend_from(workspace, column, monitor)
        elif options.method in (FIRST, GLANCE):
            column = first_field(workspace, rank, options.seed, monitor, is_rough=options.method == GLANCE)
        else:
            column, timed_out = search_without_relaxation(workspace, rank, options.seed, options.samples, monitor)
    status = Status.TIME_LIMIT if timed_out else Status.UNCERTIFIED
    return finish_piece(task.piece, column, certificate=Certificate.NONE, status=status)
