# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that surfaces, solids and flows have in common."""

from dataclasses import dataclass, fields

from ..keywords import check_choice, check_positive, check_whole, take_all
from ..solve import METHODS, ROUNDINGS, Options


@dataclass(frozen=True, kw_only=True)
class SolverSettings:
    """How a field is optimized.

    Attributes
    ----------
    method : "sdp", "spectral" or "diffusion"
    seed : of every random choice
    rounding : how "sdp" comes from the relaxation to a field: "continuation", "polish", "random" or "svd"
    target_gap : relative gap of the relaxation to prove
    time_limit : seconds for each solve, None for no limit
    """

    method: str = "sdp"
    rounding: str = "continuation"
    seed: int = 0
    target_gap: float = 1e-2
    time_limit: float | None = None

    def __post_init__(self):
        take_all(self)
        check_choice(self, "method", METHODS)
        check_choice(self, "rounding", ROUNDINGS)
        check_whole(self, "seed")
        check_positive(self, "target_gap", optional=("time_limit",))

    @property
    def options(self):
        """Options of the core's solver."""
        return Options(**{field.name: getattr(self, field.name) for field in fields(SolverSettings)})
