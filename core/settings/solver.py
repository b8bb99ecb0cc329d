# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the solver, which surfaces, solids and flows have in common."""

from dataclasses import dataclass
from functools import partial

from ..validation import MOST
from .setting import SECONDS, SHARE, SMALLEST, Choice, SettingsRecord, setting

# Commands that solve on a surface, and all that solve.
SURFACES = ("directions", "stripes", "quads", "quad_mesh", "isolines", "animate")
SOLVING = (*SURFACES, "layers", "clebsch")
_solver_setting = partial(setting, commands=SOLVING, group="solver")
# The smallest target gap: double precision reached it on all meshes tried, and 1e-8 on three of four.
SMALLEST_GAP = 1e-6
METHODS = (
    Choice(
        "sdp",
        "Semidefinite",
        "Best results, with a bound on what could still be gained: proved, or estimated for large meshes",
    ),
    Choice("spectral", "Spectral", "Fast and rough: one eigenvector"),
    Choice("diffusion", "Diffusion", "Repeated smoothing and normalizing, without a useful bound"),
)
ROUNDINGS = (
    Choice("continuation", "Continuation", "Search from many projections for the least energy"),
    Choice("polish", "Polished", "The best of many random projections, and the local optimum below it"),
    Choice("random", "Randomized", "The best of many random projections and the principal one, without descent"),
    Choice("svd", "Singular Vector", "The principal projection, without descent"),
)


@dataclass(frozen=True, kw_only=True)
class SolverSettings(SettingsRecord):
    """How a field is optimized."""

    method: str = _solver_setting("sdp", "Method", "How the field is optimized", choices=METHODS)
    seed: int = _solver_setting(
        0, "Seed", "Another seed gives another result of about the same quality", least=0, most=MOST
    )
    rounding: str = _solver_setting(
        "continuation",
        "Rounding",
        "How the method Semidefinite finds a field from the solution of the relaxation",
        choices=ROUNDINGS,
    )
    target_gap: float = _solver_setting(
        1e-2,
        "Target Gap",
        "How closely the relaxation's optimum is bracketed, as a share of its energy",
        unit=SHARE,
        least=SMALLEST_GAP,
        most=0.5,
    )
    time_limit: float | None = setting(
        None,
        "Time Limit",
        "Seconds for each solve, after which the best result so far is taken",
        unit=SECONDS,
        least=SMALLEST,
        unset="without a limit",
        commands=SOLVING,
    )
