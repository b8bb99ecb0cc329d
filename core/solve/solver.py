# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve a synchronization problem piece by piece: relax, certify, round, polish."""

from dataclasses import dataclass

import numpy as np

from ..errors import SettingError
from . import rounding
from .diffusion import diffuse
from .metric import SMALLEST_SHIFT, Metric
from .monitor import Monitor, OutOfTime
from .solution import METHODS, ROUNDINGS, Clock, Options, Solution, Status, relative_gap
from .spectral import smallest_eigenpair
from .spheres import Spheres
from .staircase import MAX_RANK, SHIFT, relax
from .threads import one_blas_thread

DIFFUSION_STARTS = 8
DIFFUSION_TIMES = 0.5 ** np.arange(11)
DIFFUSION_STEPS = 30
FINAL_TOLERANCE = 1e-9
FINAL_STEPS = 200


@dataclass(frozen=True)
class _PieceResult:
    field: np.ndarray
    bound: float = 0.0
    sdp_value: float = 0.0
    certificate: str = "none"
    status: Status = Status.UNCERTIFIED
    lifted: np.ndarray | None = None
    singular_values: np.ndarray | None = None
    spectral_bound: float = 0.0
    iterations: int = 0
    products: int = 0


def solve(problem, options=None, callback=None):
    """Find phases of low energy together with a lower bound.

    Parameters
    ----------
    problem : SynchronizationProblem
    options : Options, optional
    callback : callable(stage, fraction) -> bool, optional
        Asked at every iteration; returning False cancels.

    Returns
    -------
    Solution

    Raises
    ------
    SettingError
        for an option out of range
    Cancelled
        when the callback says so; nothing has been changed
    """
    options = Options() if options is None else options
    _check(options)
    with one_blas_thread():
        return _solve(problem, options, callback)


def _solve(problem, options, callback):
    clock = Clock()
    monitor = Monitor(callback, options.time_limit)
    with clock("build"):
        pieces = problem.pieces
    work = sum(piece.node_count for piece in pieces) or 1
    done, results = 0, []
    for piece in pieces:
        share = piece.node_count / work
        results.append(_solve_piece(piece, options, _Portion(monitor, done, share), clock))
        done += share
    return _combine(problem, pieces, results, options, clock.seconds)


def _check(options):
    if options.method not in METHODS:
        raise SettingError(f"method {options.method!r} is unknown: use one of {', '.join(METHODS)}")
    if options.rounding not in ROUNDINGS:
        raise SettingError(f"rounding {options.rounding!r} is unknown: use one of {', '.join(ROUNDINGS)}")
    if not 0 < options.target_gap < 1:
        raise SettingError(f"the target gap is {options.target_gap:g}: give a share between 0 and 1, such as 0.001")
    if options.samples < 1:
        raise SettingError(f"{options.samples} random projections were asked for: at least 1 is needed")
    if options.time_limit is not None and not options.time_limit > 0:
        raise SettingError(f"the time limit is {options.time_limit:g} s: give a positive number of seconds")


class _Portion:
    """A monitor for one piece: its fractions are a part of the whole work."""

    def __init__(self, monitor, start, share):
        self._monitor, self._start, self._share = monitor, start, share

    def at(self, stage, fraction):
        self._monitor.at(stage, self._start + fraction * self._share)

    def check(self):
        self._monitor.check()


def _solve_piece(piece, options, monitor, clock):
    try:
        return _solve_by_method(piece, options, monitor, clock)
    except OutOfTime:
        # Not even begun, or a method without a result on the way: equal phases, and zero is a bound.
        column = _fill_zeros(piece, np.zeros((piece.matrix.shape[0], 1), piece.matrix.dtype))
        return _finished(
            piece,
            column,
            sdp_value=float(piece.energy(column)[0]),
            certificate="proved",
            status=Status.TIME_LIMIT,
            lifted=column if options.method == "sdp" else None,
            singular_values=np.linalg.norm(column, axis=0),
        )


def _solve_by_method(piece, options, monitor, clock):
    if options.method == "spectral":
        return _solve_spectral(piece, options, monitor, clock)
    if options.method == "diffusion":
        return _solve_diffusion(piece, options, monitor, clock)
    return _solve_sdp(piece, options, monitor, clock)


def _finished(piece, columns, **quality):
    field = rounding.ground_to_one(piece, columns[:, :1])
    return _PieceResult(field[:, 0], **quality)


def _solve_spectral(piece, options, monitor, clock):
    with clock("relax"):
        monitor.at("spectral relaxation", 0.0)
        eigenvalue, vector = smallest_eigenpair(piece, options.seed)
        column = Spheres(piece.block, lifted=False).normalize(vector[:, None])
        # Where the eigenvector vanishes any phase is as good.
        column = _fill_zeros(piece, column)
    bound = eigenvalue * piece.mass.sum()
    return _finished(
        piece, column, bound=bound, spectral_bound=bound, certificate="estimated", status=Status.UNCERTIFIED
    )


def _fill_zeros(piece, column):
    lengths = Spheres(piece.block, lifted=False).node_products(column, column)[:, 0]
    column[np.flatnonzero(lengths < 0.5) * piece.block] = 1.0
    return column


def _solve_diffusion(piece, options, monitor, clock):
    """MBO from random starts with falling times, the best polished: the strongest baseline."""
    random = np.random.default_rng(options.seed)
    with clock("relax"):
        monitor.at("diffusion", 0.0)
        eigenvalue, _ = smallest_eigenpair(piece, options.seed)
        bound = eigenvalue * piece.mass.sum()
        columns = rounding.random_fields(piece, DIFFUSION_STARTS, random)
        spheres = Spheres(piece.block, lifted=False)
        times = DIFFUSION_TIMES / max(eigenvalue, SMALLEST_SHIFT * piece.stiffness)
        columns = diffuse(piece, spheres, columns, times, DIFFUSION_STEPS, monitor, tolerance=1e-2)
    with clock("round"):
        monitor.at("polish", 0.8)
        metric = Metric(piece, SHIFT * eigenvalue)
        columns = rounding.polish(piece, columns, metric, monitor)
        columns = _polish_best(piece, columns, metric, monitor)
    return _finished(
        piece, columns, bound=bound, spectral_bound=bound, certificate="estimated", status=Status.UNCERTIFIED
    )


def _polish_best(piece, columns, metric, monitor):
    """Descend from the best column to the last digit that matters."""
    return rounding.polish(piece, columns[:, :1], metric, monitor, FINAL_STEPS, FINAL_TOLERANCE)


def _solve_sdp(piece, options, monitor, clock):
    monitor.at("relaxation", 0.0)
    relaxation = relax(piece, options.target_gap, options.seed, monitor, clock)
    out_of_time = relaxation.out_of_time
    with clock("round"):
        columns, timed_out = _round(piece, relaxation, options, monitor, out_of_time)
    if out_of_time or timed_out:
        status = Status.TIME_LIMIT
    elif relaxation.reached:
        status = Status.CERTIFIED if relaxation.certificate == "proved" else Status.ESTIMATED
    else:
        status = Status.MAX_RANK if relaxation.lifted.shape[1] >= MAX_RANK else Status.TARGET_GAP_NOT_REACHED
    return _finished(
        piece,
        columns,
        bound=relaxation.lower_bound,
        # Phases of less energy, which a tight relaxation may round to, are a better point of it.
        sdp_value=min(relaxation.value, float(piece.energy(columns[:, :1])[0])),
        certificate=relaxation.certificate,
        status=status,
        lifted=relaxation.lifted,
        singular_values=relaxation.singular_values,
        iterations=relaxation.steps,
        products=relaxation.products,
    )


def _round(piece, relaxation, options, monitor, out_of_time):
    """Candidates as columns, best first, and whether time ran out before they were finished."""
    lifted = relaxation.lifted
    by_svd = rounding.round_by_svd(piece, lifted)
    if options.rounding == "svd" or out_of_time:
        return by_svd, out_of_time
    random = np.random.default_rng(options.seed + 1)
    directions = rounding.random_directions(piece, lifted.shape[1], options.samples, random)
    columns = np.hstack([by_svd, rounding.project(piece, lifted, directions)])
    columns = rounding.best_columns(piece, columns, columns.shape[1])
    if options.rounding == "random":
        return columns, False
    energy_density = relaxation.value / piece.mass.sum()
    metric = Metric(piece, SHIFT * energy_density)
    try:
        if options.rounding == "continuation":
            polished = _polish_best(piece, by_svd, metric, monitor)
            energy = float(piece.energy(polished)[0])
            if relative_gap(energy, relaxation.lower_bound, piece.noise) <= options.target_gap:
                return polished, False  # exact recovery: the relaxation is tight
            monitor.at("continuation", 0.6)
            columns = rounding.continuation(piece, lifted, columns, metric, energy_density, random, monitor)
        monitor.at("polish", 0.8)
        columns = _polish_best(piece, columns, metric, monitor)
    except OutOfTime:
        return columns, True
    return columns, False


def _combine(problem, pieces, results, options, times):
    """Put the pieces' results together: energies and bounds add up."""
    coordinates = problem.unit_coordinates()
    rank = max([r.lifted.shape[1] for r in results if r.lifted is not None], default=0)
    lifted = np.zeros((len(coordinates), rank), coordinates.dtype)
    lifted[:, :1] = coordinates[:, None]
    for piece, result in zip(pieces, results, strict=True):
        coordinates[piece.rows] = result.field
        if result.lifted is not None:
            lifted[piece.rows] = 0
            lifted[piece.rows, : result.lifted.shape[1]] = result.lifted
    phases = problem.expand(coordinates)
    order = list(Status)
    is_sdp = options.method == "sdp"
    kinds = {r.certificate for r in results} or {"proved"}
    largest = max(range(len(pieces)), key=lambda k: pieces[k].node_count, default=None)
    default_status = Status.CERTIFIED if is_sdp else Status.UNCERTIFIED
    return Solution(
        phases=phases,
        energy=problem.energy(phases),
        lower_bound=sum(r.bound for r in results),
        sdp_value=sum(r.sdp_value for r in results) if is_sdp else None,
        noise=sum(piece.noise for piece in pieces),
        certificate=next(kind for kind in ("none", "estimated", "proved") if kind in kinds),
        status=max((r.status for r in results), key=order.index, default=default_status),
        rank=rank,
        singular_values=np.empty(0) if largest is None else results[largest].singular_values,
        lifted=lifted if rank else None,
        spectral_bound=None if is_sdp else sum(r.spectral_bound for r in results),
        iterations=sum(r.iterations for r in results),
        products=sum(r.products for r in results),
        times=times,
    )
