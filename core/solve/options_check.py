# SPDX-License-Identifier: GPL-3.0-or-later
"""Check the options and the start of a solve."""

import numpy as np

from ..errors import SettingError
from ..problem import SynchronizationProblem
from ..settings.setting import records
from ..settings.solver import SolverSettings
from ..solution import COARSE, DESCENT, FIRST, GLANCE, METHODS, Options, Solution

_RECORDS = dict(records(SolverSettings))


def check_options(options: Options, problem: SynchronizationProblem, start: Solution | np.ndarray | None) -> None:
    """Refuse options out of range, and a start that does not fit the problem; see :func:`.solver.solve`."""
    if not isinstance(options, Options):
        raise SettingError(f"options are given as {type(options).__name__}: make them with Options(...)")
    for name, smallest in (("seed", 0), ("samples", 1)):
        value = getattr(options, name)
        if not isinstance(value, int | np.integer) or value < smallest:
            raise SettingError(f"{name} is {value!r}: give a whole number of at least {smallest}")
    for name in ("target_gap",) if options.time_limit is None else ("target_gap", "time_limit"):
        value = getattr(options, name)
        if not isinstance(value, int | float | np.number):
            raise SettingError(f"{name} is {value!r}: give a number")
    if options.method == DESCENT and start is None:
        raise SettingError("the method 'descent' goes on from a start: give one")
    if options.method not in (*METHODS, DESCENT, FIRST, GLANCE, COARSE):
        raise SettingError(f"method {options.method!r} is unknown: use one of {', '.join(METHODS)}")
    if not options.rounds_coarsely:
        _RECORDS["rounding"].check("rounding", options.rounding)
    for name in ("target_gap", "time_limit"):
        _RECORDS[name].check(name, getattr(options, name))
    if start is not None:
        _check_start(problem, start, options)


def _check_start(problem: SynchronizationProblem, start: Solution | np.ndarray, options: Options) -> None:
    if options.method not in ("sdp", DESCENT, FIRST, GLANCE, COARSE):
        raise SettingError(f"method {options.method!r} does not use a start: leave it out, or choose 'sdp'")
    phases = np.asarray(start.phases if isinstance(start, Solution) else start)
    count = problem.connection.node_count
    shape = (count, *problem.value_shape)
    if phases.shape != shape:
        raise SettingError(f"the start has the shape {phases.shape} and the problem {shape}: give one phase a node")
    if not np.isfinite(phases).all():
        node = np.flatnonzero(~np.isfinite(phases).reshape(count, -1).all(axis=1))[0]
        raise SettingError(f"the start is not a number at node {node}: give finite phases")
