# SPDX-License-Identifier: GPL-3.0-or-later
"""A first field, long before the relaxation is solved: found on a coarse stage, prolonged to the finest and polished.

A lifted field that descends on the coarse stages is near the relaxation's solution there. Its projections are diffused
and polished on a stage with a ninth of the nodes, which costs little, and the best one, prolonged along the transports,
needs a few steps. They use the metric of fields, which the workspace has; that of turns would first have to be built.
"""

from functools import partial

import numpy as np

from ...monitor import Monitor, OutOfTime
from ...piece import Piece
from ...solution import COARSE_DIFFUSED, Options
from . import rounding
from .descent import descend
from .diffusion import diffuse
from .manifolds import CirclesByFields, random_columns
from .stage import LIFTED_SHIFT, Stage, Workspace

# The shift of the metric that finds the first smooth point, as a share of the stiffness.
FIRST_SHIFT = 1e-3
# Nodes of the smallest stage that is solved on the way, and the tolerance of lifted descents on coarser stages.
SMALLEST_START = 300
COARSE_TOLERANCE = 3e-3
# For a first field: steps of lifted descents; how many projections are drawn, diffused and polished; steps of polishing
# on the coarse stage and on the finest. With half the projections energies are up to 6 % higher.
LIFTED_STEPS = 5
PROJECTIONS, DIFFUSED, POLISHED = 32, 12, 6
COARSE_STEPS, FINE_STEPS, TOLERANCE = 8, 8, 1e-4
# For a rough field: steps on the finest stage, and their damping.
SMOOTHED, DAMPING = 10, 2 / 3
# For a search on a coarse stage: steps of lifted descents before it, fields that are prolonged to the finest stage and
# steps of the best one there.
SEARCHED_STEPS, PROLONGED, LAST_STEPS = 20, 3, 20
# Prolonged lines of defects stay between the coarse nodes, where descent does not move them; diffusion does. Its
# time, in units of 1 / density, and its steps, each of which gives candidates; the number of these that are kept (of
# knots on 24^3 to 48^3 nodes, the best of all is among them); steps and tolerance of the descent of the best one.
FREEING_TIME, FREEING_STEPS, FREED, FREED_STEPS, FREED_TOLERANCE = 0.15, 6, 12, 150, 1e-6


def coarse_field(
    workspace: Workspace, rank: int, random: np.random.Generator, monitor: Monitor, steps: int
) -> tuple[Stage, np.ndarray]:
    """The finest of the coarser stages that is large enough, or the piece itself, and an (N, rank) lifted field on it.

    The field is smooth: it descends on the coarser stages one after the other, by at most ``steps`` on each.
    """
    piece, stages = workspace.piece, [workspace.stages[0]]
    point = random_columns(piece, rank, random)
    for stage in workspace.stages[1:]:
        if stage.node_count < SMALLEST_START:
            break
        stages.append(stage)
        point = stage.restrict(point)
    stage = stages[-1]
    point = _smooth(piece, stage, stage.lifted.normalize(point.astype(stage.matrix.dtype)))
    for finer in stages[-2::-1]:
        metric = monitor.during(partial(stage.metric, stage.shift_at(point)))
        point = descend(stage.matrix, stage.lifted, point, metric, COARSE_TOLERANCE, steps, monitor).point
        if finer is workspace.stages[0]:
            break
        stage, point = finer, finer.lifted.normalize(stage.prolong(point))
    return stage, point


def _smooth(piece: Piece, stage: Stage, point: np.ndarray) -> np.ndarray:
    """A smooth field from a rough one.

    The shift has to be small against the smooth field's energy per mass: a first pass with a guessed shift finds it.
    """
    density = FIRST_SHIFT * piece.stiffness / LIFTED_SHIFT
    for _ in range(2):
        metric = stage.metric(LIFTED_SHIFT * density)
        for _ in range(2):
            point = stage.lifted.normalize(metric.solve(point))
        density = stage.density(point)
    return point


def first_field(workspace: Workspace, rank: int, seed: int, monitor: Monitor, is_rough: bool = False) -> np.ndarray:
    """(N * width, 1) field, from a lifted one of a given rank, some percent above the energy of the whole solve.

    A rough one, of a workspace with a rough hierarchy, is only smoothed on the finest stage.
    """
    random = np.random.default_rng(seed)
    stage, lifted = coarse_field(workspace, rank, random, monitor, LIFTED_STEPS)
    density = stage.density(lifted)
    directions = rounding.random_directions(stage.is_complex, rank, PROJECTIONS - 1, random, stage.width)
    columns = rounding.projections(stage, lifted, directions, DIFFUSED, monitor)
    if density > 0:  # no perfect fit
        metrics = map(stage.metric, rounding.shifts(stage, rounding.TIMES[:2], density))
        columns = diffuse(stage, columns, metrics, 1, monitor)
    columns = _polish_columns(stage, rounding.lowest(stage, columns, POLISHED), density, COARSE_STEPS, monitor)
    columns = _prolong_to_finest(workspace, stage, columns[:, :1])
    if is_rough:
        return _smooth_column(workspace.stages[0], columns)
    return _polish_columns(workspace.stages[0], columns, density, FINE_STEPS, monitor)


def _smooth_column(stage: Stage, column: np.ndarray) -> np.ndarray:
    """An (N * width, 1) field after some steps of damped Jacobi, which even out what lies within aggregates."""
    if stage.flips is not None:
        return column
    steps = (DAMPING / stage.matrix.matrix.diagonal().real)[:, None]
    for _ in range(SMOOTHED):
        fields = column.reshape(len(steps), -1)
        column = stage.candidates.normalize((fields - steps * (stage.matrix @ fields)).reshape(-1, 1))
    return column


def search_without_relaxation(
    workspace: Workspace, rank: int, seed: int, samples: int, monitor: Monitor
) -> tuple[np.ndarray, bool]:
    """(N * width, 1) field by the search of a whole solve, on a coarse stage, and whether time ran out before its end.

    It starts from a lifted field of a given rank on that stage, and tries ``samples`` random projections.

    Raises :class:`OutOfTime` when there is no field yet.
    """
    random = np.random.default_rng(seed)
    stage, lifted = coarse_field(workspace, rank, random, monitor, SEARCHED_STEPS)
    return _search_on_stage(workspace, stage, lifted, samples, random, monitor)


def search_after_relaxation(
    workspace: Workspace, lifted: np.ndarray, options: Options, random: np.random.Generator, monitor: Monitor
) -> tuple[np.ndarray, bool]:
    """As :func:`search_without_relaxation`, but from the (N, r) lifted field of a relaxation.

    With the rounding :data:`COARSE_DIFFUSED`, diffusion also moves lines of defects on the finest stage.
    """
    finest = workspace.stages[0]
    coarser = [stage for stage in workspace.stages[1:2] if stage.node_count >= SMALLEST_START]
    for stage in coarser:
        lifted = stage.lifted.normalize(stage.restrict(lifted.astype(stage.matrix.dtype)))
    is_freed = options.rounding == COARSE_DIFFUSED
    return _search_on_stage(workspace, (coarser or [finest])[0], lifted, options.samples, random, monitor, is_freed)


def _search_on_stage(
    workspace: Workspace,
    stage: Stage,
    lifted: np.ndarray,
    samples: int,
    random: np.random.Generator,
    monitor: Monitor,
    is_freed: bool = False,
) -> tuple[np.ndarray, bool]:
    """The best field that a search on a stage finds, after descent on the finest, and whether time ran out."""
    finest, density = workspace.stages[0], stage.density(lifted)
    columns, timed_out = lifted[:, : stage.width].reshape(-1, 1), False
    if density > 0:
        monitor_here = monitor if stage is finest else monitor.without_found()  # it reports fields of the finest stage
        columns, timed_out = rounding.continuation(stage, lifted, samples, density, random, monitor_here)
    columns = _prolong_to_finest(workspace, stage, columns[:, :PROLONGED])
    try:
        if not timed_out:
            monitor.at("polish", 0.9)
            is_freed = is_freed and stage is not finest and density > 0
            if is_freed:
                columns = rounding.lowest(finest, _diffused(finest, columns, density, monitor), FREED)
            columns = _polish_columns(finest, columns, density, FINE_STEPS, monitor)
            kept, tolerance = (PROLONGED, FREED_TOLERANCE) if is_freed else (1, TOLERANCE)
            columns = _polish_columns(finest, columns[:, :kept], density, LAST_STEPS, monitor, tolerance)
            if is_freed:
                columns = _polish_columns(finest, columns[:, :1], density, FREED_STEPS, monitor, tolerance)
            monitor.check()
    except OutOfTime:
        timed_out = True
    return columns[:, :1], timed_out


def _diffused(stage: Stage, columns: np.ndarray, density: float, monitor: Monitor) -> np.ndarray:
    """(N * width, k) columns, and what each step of diffusion makes of them, beside them."""
    (shift,) = rounding.shifts(stage, np.array([FREEING_TIME]), density)
    metric = monitor.during(partial(stage.metric, shift))
    made = [columns]
    for _ in range(FREEING_STEPS):
        made.append(diffuse(stage, made[-1], [metric], 1, monitor))
    return np.hstack(made)


def descend_from(workspace: Workspace, column: np.ndarray, monitor: Monitor) -> np.ndarray:
    """An (N * width, 1) field after some steps of descent."""
    stage, piece = workspace.stages[0], workspace.piece
    density = float(piece.energy(column)[0]) / piece.total_mass
    return _polish_columns(stage, column.astype(stage.matrix.dtype), density, LAST_STEPS, monitor)


def _prolong_to_finest(workspace: Workspace, stage: Stage, columns: np.ndarray) -> np.ndarray:
    """(N * width, k) fields of a stage on the finest one."""
    finest = workspace.stages[0]
    if stage is finest:
        return columns
    rows = [stage.prolong(column.reshape(stage.matrix.shape[0], -1)).reshape(-1, 1) for column in columns.T]
    return finest.candidates.normalize(np.hstack(rows))


def _polish_columns(
    stage: Stage, columns: np.ndarray, density: float, steps: int, monitor: Monitor, tolerance: float = TOLERANCE
) -> np.ndarray:
    """Columns after up to ``steps`` of descent in the metric of fields, best first."""
    if stage.flips is not None:
        return rounding.lowest(stage, stage.flips.descend(columns), columns.shape[1])
    spheres = CirclesByFields(stage.block) if stage.is_circle else stage.candidates
    metric = monitor.during(partial(stage.metric, rounding.CANDIDATE_SHIFT * density))
    found = descend(stage.matrix, spheres, columns, metric, tolerance, steps, monitor)
    return np.take(found.point, np.argsort(found.values, kind="stable"), axis=1)
