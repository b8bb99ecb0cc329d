# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of a solve, and its solution."""

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from enum import Enum, StrEnum
from typing import Self

import numpy as np

from .settings import solver
from .settings.solver import SolverSettings

METHODS: tuple[str, ...] = tuple(choice.name for choice in solver.METHODS)
DESCENT = "descent"
FIRST = "first"
GLANCE = "glance"
COARSE = "coarse"
# A rounding: a search on a coarse stage, and diffusion on the finest one, which moves lines of defects in space.
COARSE_DIFFUSED = "coarse-diffused"
ROUNDINGS: tuple[str, ...] = tuple(choice.name for choice in solver.ROUNDINGS)


class Certificate(StrEnum):
    """How a lower bound was obtained; reports show the text.

    ``strength``: order; a problem of several pieces has the weakest certificate of its pieces.
    """

    strength: int

    def __new__(cls, text: str, strength: int) -> Self:
        member = str.__new__(cls, text)
        member._value_, member.strength = text, strength
        return member

    NONE = "none", 0
    ESTIMATED = "estimated", 1
    PROVED = "proved", 2


class Status(Enum):
    """How a solve ended; reports show the value.

    ``severity``: order; a problem of several pieces has the most severe status of its pieces.
    """

    severity: int

    def __new__(cls, text: str, severity: int) -> Self:
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
    """All choices that a caller has; other parameters are constants beside the code that uses them.

    Attributes
    ----------
    method : "sdp", the default, relaxes, certifies and rounds; "spectral" takes the smallest eigenvector and
        "diffusion" the best of several runs of threshold dynamics, both with the weaker bound of Eq. (23); without a
        bound, "descent" improves a start, "first" gives the first field shown, and "coarse" searches a coarse stage
    rounding : how the lifted field of "sdp" becomes phases: "svd"; "random", the best of ``samples``
        projections (Eq. 29); "polish", the best of those followed by descent; "continuation", the default,
        after rounds of a seeded continuation; "coarse", after those rounds on a coarse stage
    target_gap : relative gap between the relaxation's value and its lower bound at which "sdp" stops, from
        :data:`core.settings.solver.SMALLEST_GAP` to 1; the energy that rounding adds is not included
    samples : random projections tried, at least 1; not for the rounding "svd"
    seed : of all random choices, 0 or more; the same seed gives the same result to the last digit
    time_limit : seconds after which the best so far is returned, with the status ``TIME_LIMIT``
    integrate : whether fields that fit up to the noise of a solve are found along a tree, without a search
    long_proofs : whether to prove bounds however long it takes, if memory suffices
    """

    method: str = SolverSettings.method
    rounding: str = SolverSettings.rounding
    target_gap: float = SolverSettings.target_gap
    samples: int = 64
    seed: int = SolverSettings.seed
    time_limit: float | None = SolverSettings.time_limit
    integrate: bool = False
    long_proofs: bool = False

    @classmethod
    def of(cls, settings: SolverSettings) -> "Options":
        """Take the options from settings."""
        return cls(**{item.name: getattr(settings, item.name) for item in fields(SolverSettings)})

    @property
    def rounds_coarsely(self) -> bool:
        """Whether the search for phases is made on a coarse stage."""
        return self.rounding in (COARSE, COARSE_DIFFUSED)


@dataclass(frozen=True)
class Solution:
    """Phases with their quality.

    Attributes
    ----------
    phases : (n,) complex on the circle, else (n, d), or (n, d, d) where nodes carry frames
    energy : of the phases, Eq. (17)
    lower_bound : no phases have less energy; 0 without a bound, and never above the energy by rounding errors
    sdp_value : of the relaxation, Eq. (22); None for other methods
    noise : energy of rounding errors; gaps are measured above it, so that an energy below it has gap 0
    certificate : of the lower bound
    rank : columns of the lifted field
    singular_values : of the largest piece's lifted field, descending
    lifted : (N, rank) lifted field in the coordinates of ``problem.factor``
    variations : (k, n), (k, n, d) or (k, n, d, d) phases of good fields near local optima, best first, beginning with
        ``phases``; variation k takes the k-th best of every piece
    spectral_bound : the weaker bound of Eq. (23), if the spectral relaxation was solved
    iterations, products : number of descent steps, and of columns multiplied by L
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
    times: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("lower_bound", "spectral_bound"):
            bound = getattr(self, name)
            if bound is not None:
                object.__setattr__(self, name, min(bound, self.energy))

    @property
    def gap(self) -> float:
        """(energy - lower bound) / energy: better phases can save at most this share of the energy."""
        return relative_gap(self.energy, self.lower_bound, self.noise)

    @property
    def sdp_gap(self) -> float | None:
        """(sdp value - lower bound) / sdp value, None without a relaxation."""
        return None if self.sdp_value is None else relative_gap(self.sdp_value, self.lower_bound, self.noise)


def relative_gap(value: float, bound: float, noise: float) -> float:
    """Compute the share of ``value`` that is above ``bound`` by more than the noise."""
    return max(value - bound - noise, 0.0) / value if value > 0 else 0.0


class Clock:
    """Seconds spent by named phase: ``with clock("relax"): ...``."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, phase: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add({phase: time.perf_counter() - start})

    def add(self, seconds: Mapping[str, float]) -> None:
        """Add seconds of phases that were measured elsewhere."""
        for phase, spent in seconds.items():
            self.seconds[phase] = self.seconds.get(phase, 0.0) + spent
