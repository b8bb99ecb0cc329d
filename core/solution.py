# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solve is asked and what it answers."""

import time
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from enum import Enum, StrEnum

import numpy as np

from .settings import solver
from .settings.solver import SolverSettings

METHODS: tuple[str, ...] = tuple(choice.name for choice in solver.METHODS)
DESCENT = "descent"
FIRST = "first"
COARSE = "coarse"
ROUNDINGS: tuple[str, ...] = tuple(choice.name for choice in solver.ROUNDINGS)


class Certificate(StrEnum):
    """What vouches for a lower bound; the text is what reports say.

    Attributes
    ----------
    strength : the larger, the more; a problem of several pieces has the weakest of theirs
    """

    strength: int

    def __new__(cls, text, strength):
        member = str.__new__(cls, text)
        member._value_, member.strength = text, strength
        return member

    NONE = "none", 0
    ESTIMATED = "estimated", 1
    PROVED = "proved", 2


class Status(Enum):
    """How far a solve came; the value is what reports say.

    Attributes
    ----------
    severity : a problem of several pieces has the status of the most severe of theirs
    """

    severity: int

    def __new__(cls, text, severity):
        member = object.__new__(cls)
        member._value_, member.severity = text, severity
        return member

    CERTIFIED = "certified", 0
    ESTIMATED = "target gap reached by estimate", 1
    TARGET_GAP_NOT_REACHED = "target gap not reached", 2
    MAX_RANK = "largest rank reached", 3
    TIME_LIMIT = "time limit", 4
    UNCERTIFIED = "no bound asked", 5


@dataclass(frozen=True)
class Options:
    """How to solve: all that a caller may turn. What else was chosen are constants beside the code that uses them.

    Attributes
    ----------
    method : "sdp", the default, relaxes, certifies and rounds; "spectral" takes the smallest eigenvector and
        "diffusion" the best of some starts of threshold dynamics, both with the weaker bound of Eq. (23); "descent"
        only goes on from a start, "first" gives the first field that is shown, and "coarse" searches on a coarse stage;
        these three have no bound
    rounding : how the lifted field of "sdp" becomes phases: "svd"; "random", the best of ``samples``
        projections (Eq. 29); "polish", the best of those followed by descent; "continuation", the default,
        with rounds of a seeded continuation before; "coarse", with those rounds on a coarse stage
    target_gap : relative gap between the relaxation's value and its lower bound at which "sdp" stops, from
        :data:`core.settings.solver.SMALLEST_GAP` to 1; it says nothing of what rounding adds
    samples : random projections tried, at least 1; not for the rounding "svd"
    seed : of every random choice, 0 or more; the same seed gives the same result to the last digit
    time_limit : seconds after which the best so far is returned, with the status ``TIME_LIMIT``; None for no limit
    long_proofs : whether bounds are proved that take more than some ten seconds to prove, as far as memory reaches
    """

    method: str = SolverSettings.method
    rounding: str = SolverSettings.rounding
    target_gap: float = SolverSettings.target_gap
    samples: int = 64
    seed: int = SolverSettings.seed
    time_limit: float | None = SolverSettings.time_limit
    long_proofs: bool = False

    @classmethod
    def of(cls, settings: SolverSettings) -> "Options":
        """The options that settings stand for."""
        return cls(**{item.name: getattr(settings, item.name) for item in fields(SolverSettings)})


@dataclass(frozen=True)
class Solution:
    """Phases with their quality.

    Attributes
    ----------
    phases : (n,) complex on the circle, else (n, d), or (n, d, d) where nodes carry frames
    energy : of the phases, by Eq. (17)
    lower_bound : no phases have less energy; 0 when no bound was asked. What rounding leaves of it above the energy is
        taken off
    sdp_value : of the relaxation (22); None for other methods
    noise : energy that rounding alone can cause, as a share of all weights; gaps are measured above it, so that a fit
        below it has none
    certificate : Certificate of the lower bound
    status : Status
    rank : columns of the lifted field
    singular_values : of the lifted field, descending, of the largest piece
    lifted : (N, rank) lifted field in the coordinates of ``problem.factor``, or None
    variations : (k, n), (k, n, d) or (k, n, d, d) phases of other good fields, near local optima, best first; the first
        are ``phases``. In problems of several pieces every piece takes its next best at the same time.
    spectral_bound : the weaker bound of Eq. (23), when the spectral relaxation was solved
    iterations, products : descent steps, and columns multiplied by L
    times : seconds by phase of the work
    """

    phases: np.ndarray
    energy: float
    lower_bound: float
    sdp_value: float | None
    noise: float
    certificate: Certificate
    status: Status
    rank: int
    singular_values: np.ndarray
    lifted: np.ndarray | None
    variations: np.ndarray
    spectral_bound: float | None
    iterations: int
    products: int
    times: dict = field(default_factory=dict)

    def __post_init__(self):
        for name in ("lower_bound", "spectral_bound"):
            bound = getattr(self, name)
            if bound is not None:
                object.__setattr__(self, name, min(bound, self.energy))

    @property
    def gap(self) -> float:
        """(energy - lower bound) / energy: at most this share of the energy could be saved."""
        return relative_gap(self.energy, self.lower_bound, self.noise)

    @property
    def sdp_gap(self) -> float | None:
        """(sdp value - lower bound) / sdp value, None without a relaxation."""
        return None if self.sdp_value is None else relative_gap(self.sdp_value, self.lower_bound, self.noise)


def relative_gap(value, bound, noise):
    """Share of ``value`` that is above ``bound`` by more than rounding noise."""
    return max(value - bound - noise, 0.0) / value if value > 0 else 0.0


class Clock:
    """Seconds spent by named phase: ``with clock("relax"): ...``."""

    def __init__(self):
        self.seconds = {}

    @contextmanager
    def __call__(self, phase):
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add({phase: time.perf_counter() - start})

    def add(self, seconds):
        """Seconds that phases have taken elsewhere, by their names."""
        for phase, spent in seconds.items():
            self.seconds[phase] = self.seconds.get(phase, 0.0) + spent
