# SPDX-License-Identifier: GPL-3.0-or-later
"""The method "sdp" on a piece: relax, certify, round and polish."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from scipy.sparse import csr_matrix

from ..algebra.workers import idle_workers
from ..monitor import Monitor, OutOfTime, Running
from ..solution import Certificate, Status, relative_gap
from .batched.parts import PartResult
from .methods import rounding
from .methods.initial_field import search_after_relaxation
from .methods.stage import Stage, Workspace
from .methods.staircase import MAX_RANK, Relaxation, relax
from .task import Task, finish_piece

# A rounded relaxation with at most this gap counts as an exact recovery, which descent completes.
NEARLY_TIGHT = 0.05
# Returns what :func:`prepare_search` does.
_Prepared: TypeAlias = Callable[[], csr_matrix | None]


def prepare_search(task: Task, stage: Stage) -> csr_matrix | None:
    """Build what the search for phases needs besides the relaxation; returns the matrix with less curl, or None."""
    if task.options.rounding != "continuation" or task.start.column is not None:
        return None
    stage.prepare_candidates()
    return None if task.less_curl is None else task.less_curl(task.weight)


def solve_semidefinite(task: Task, workspace: Workspace, prepared: _Prepared) -> PartResult:
    """Relax, certify and round."""
    piece, monitor, watch = task.piece, task.monitor, task.watch
    monitor.expect(0.0 if watch is None else watch.proof_in)
    monitor.at("relaxation", 0.0)
    if watch is not None:
        watch.follow(piece, monitor)
    early = _EarlyRounding(task, workspace, prepared)
    is_early = idle_workers() > 1 and task.options.time_limit is None
    relaxation = relax(workspace, task.options, monitor, task.clock, task.start.lifted, early if is_early else None)
    is_rounded = relaxation is early.relaxation
    if not (is_rounded and early.is_announced):
        _announce_bound(task, relaxation)
    with task.clock("round"):
        columns, timed_out = early.result if is_rounded else _round(task, workspace, relaxation, prepared)
    quality = _quality(relaxation)
    if relaxation.out_of_time or timed_out:
        quality["status"] = Status.TIME_LIMIT
    result = finish_piece(piece, columns, **quality)
    # Phases of less energy, which a tight relaxation may round to, are a better point of it.
    return replace(result, sdp_value=min(relaxation.value, float(piece.energy(result.fields[:, :1])[0])))


def _quality(relaxation: Relaxation) -> dict[str, Any]:
    """What a relaxation says about fields that are rounded from it."""
    if relaxation.reached:
        status = Status.CERTIFIED if relaxation.certificate is Certificate.PROVED else Status.ESTIMATED
    else:
        status = Status.MAX_RANK if relaxation.lifted.shape[1] >= MAX_RANK else Status.TARGET_GAP_NOT_REACHED
    return {
        "status": status,
        "bound": relaxation.lower_bound,
        "sdp_value": relaxation.value,
        "certificate": relaxation.certificate,
        "lifted": relaxation.lifted,
        "singular_values": relaxation.singular_values,
        "iterations": relaxation.steps,
        "products": relaxation.products,
    }


def _announce_bound(task: Task, relaxation: Relaxation) -> None:
    """Report the bound, and show the field of the watch with it."""
    task.monitor.proved(relaxation.lower_bound)
    if task.watch is not None:
        task.watch.proved(task.piece, task.weight, **_quality(relaxation))


class _Refuted(Exception):
    """The bound, whose proof was expected to succeed, cannot be proved."""


class _EarlyRounding:
    """Rounding while a bound is being proved, which nearly always succeeds; where it fails, the work is dropped.

    The result is that of rounding after the proof, to the last bit.

    Attributes
    ----------
    relaxation : what was rounded, None if the proof failed on the way
    result : what :func:`_round` returned
    is_announced : whether the proof ended on the way, and its bound was announced
    """

    def __init__(self, task: Task, workspace: Workspace, prepared: _Prepared) -> None:
        self._task, self._workspace, self._prepared = task, workspace, prepared
        self.relaxation: Relaxation | None = None
        self.is_announced = False

    def __call__(self, relaxation: Relaxation, proof: Running[bool]) -> None:
        """Round a relaxation whose bound is being proved."""
        task = self._task

        def react(monitor: Monitor, is_proved: bool) -> None:
            if not is_proved:
                raise _Refuted
            self.is_announced = True
            _announce_bound(replace(task, monitor=monitor), relaxation)

        task = replace(task, monitor=task.monitor.awaiting(proof, react))
        try:
            with task.clock("round"):
                self.result = _round(task, self._workspace, relaxation, self._prepared)
        except _Refuted:
            return
        self.relaxation = relaxation


def _round(task: Task, workspace: Workspace, relaxation: Relaxation, prepared: _Prepared) -> tuple[np.ndarray, bool]:
    """Candidates as columns, best first, and whether time ran out before they were finished."""
    piece, options, monitor = task.piece, task.options, task.monitor
    stage, lifted = workspace.stages[0], relaxation.lifted
    start = None if options.rounding in ("svd", "random") else task.start.column
    leading = lifted[:, : piece.width].reshape(-1, 1)
    columns = by_svd = stage.candidates.normalize(leading) if start is None else start
    if options.rounding == "svd" or relaxation.out_of_time:
        return by_svd, relaxation.out_of_time
    random = np.random.default_rng(options.seed + 1)
    density = relaxation.value / piece.total_mass
    try:
        if options.rounding in ("random", "polish") and start is None:
            sizes = lifted.shape[1], options.samples
            directions = rounding.random_directions(piece.is_complex, *sizes, random, piece.width)
            columns = rounding.projections(stage, lifted, directions, rounding.ALONE.kept, monitor).astype(lifted.dtype)
            if options.rounding == "random":
                return columns, False
        if options.rounds_coarsely and start is None:
            return search_after_relaxation(workspace, lifted, options, random, monitor)
        if options.rounding == "continuation" and start is None:
            monitor.at("continuation", 0.4)
            energy = float(piece.energy(by_svd)[0])
            if relative_gap(energy, relaxation.lower_bound, piece.perfect) > NEARLY_TIGHT:
                less_curl = monitor.during(prepared)
                columns, timed_out = rounding.continuation(
                    stage, lifted, options.samples, density, random, monitor, less_curl, relaxation.metric
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
