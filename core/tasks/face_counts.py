# SPDX-License-Identifier: GPL-3.0-or-later
"""Chooses among quad meshes that were tried for a wanted number of faces, and the spacings to try."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..errors import SettingError
from ..extract.quads.finishing import TooLargeQuads
from ..extract.quads.measure.faults import WORST_ANGLE
from ..extract.quads.measure.quality import quality
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..monitor import Callback
from ..solution import Clock
from .quad_drafts import FEW, Draft, complete, is_sound, may_close_tunnels, settle, with_tunnels_closed
from .surface_result import SurfaceResult

# Largest relative error of the number of faces without a warning.
FAR = 0.05
# Ratio of spacings, one with too many faces and one with too few, below which no others between them are tried.
NARROW = 1.008
# Largest ratio of the wanted to the found number of faces that a correction of the spacing relies on.
MOST_CHANGE = 16.0
# A traced mesh with more than this many times FEW faces, where fewer than FEW were expected, is not finished.
SPOILT = 2
# Relative error of the number of faces beyond which meshes are not finished where tunnels may be closed.
HOPELESS = 1.0
# Mean of |angle - 90| over the corners, in degrees, up to which a mesh without narrow tunnels is preferred to one with
# another number of faces; beyond, only if its corners are better than that one's.
GOOD_ANGLE = 8.0


@dataclass(frozen=True)
class Trial:
    """A quad mesh that was tried, without the last step of its smoothing where that takes long."""

    result: SurfaceResult
    last_step: Callable[[], QuadMesh] | None = None

    @classmethod
    def of(cls, draft: Draft, progress: Callback | None = None) -> "Trial":
        """The finished mesh of a settled draft; SettingError as :func:`complete`."""
        later: list[Callable[[], QuadMesh]] = []
        return cls(complete(draft, progress, later), later[0] if later else None)

    def finished(self, tried: dict[int, float]) -> SurfaceResult:
        """The result with its smoothing done; ``tried`` as of :func:`choose`."""
        result = self.result
        if self.last_step is not None:
            clock = Clock()
            clock.add(result.seconds)
            with clock("extract"):
                result = replace(result, quads=self.last_step())
            result = replace(result, seconds=clock.seconds)
        tried[self.face_count] = mean_angle(result)
        return result

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return face_count(self.result)

    def misses(self, faces: int) -> float:
        """Relative error of the number of faces."""
        return misses(self.result, faces)

    @cached_property
    def mean_angle(self) -> float:
        """Mean of |angle - 90| over all corners, in degrees."""
        return mean_angle(self.result)


def mean_angle(result: SurfaceResult) -> float:
    """Mean of |angle - 90| over all corners, in degrees."""
    assert result.quads is not None
    return quality(result.quads)["angle_deviation"]


def misses(result: SurfaceResult, faces: int) -> float:
    """Relative error of the number of faces, 0 where none is wanted."""
    return abs(face_count(result) / faces - 1) if faces else 0.0


def face_count(result: SurfaceResult) -> int:
    """Number of faces."""
    return 0 if result.quads is None else len(result.quads.sizes)


def choose(trials: list[Trial], faces: int, tried: dict[int, float]) -> SurfaceResult:
    """The mesh with the number of faces nearest to the wanted one.

    If its corners are far from right angles, another one is taken whose corners are nearer and whose number is twice
    as far from the wanted one as needs no warning, at most. ``tried`` gets the mean deviations of corners of all.
    """
    nearest = min(trials, key=lambda trial: trial.misses(faces))
    tried |= {trial.face_count: trial.mean_angle for trial in trials if trial is not nearest}
    found = nearest.finished(tried)
    if mean_angle(found) <= WORST_ANGLE:
        return found
    others = [trial for trial in trials if trial.misses(faces) <= 2 * FAR and trial.mean_angle < nearest.mean_angle]
    if not others:
        return found
    return min(found, min(others, key=lambda trial: trial.mean_angle).finished(tried), key=mean_angle)


def best_count(
    faces: int, wanted: float, drafts: list[Draft], refused: list[Draft], found: list[Trial], tried: dict[int, float]
) -> SurfaceResult:
    """The finished mesh as of :func:`choose`.

    The nearest draft is finished if it is nearer, and others as long as the number of faces is far from the wanted one.
    If it stays far from that, narrow tunnels are closed in a draft whose quads are too large for them, unless that
    makes bad corners. If there is one, no time goes into drafts with several times as many faces, or unsound ones.
    """
    trials, refused, left = found.copy(), refused.copy(), []
    for draft in sorted(drafts, key=lambda draft: draft.misses(wanted)):
        nearest = min((trial.misses(faces) for trial in trials), default=np.inf)
        if nearest <= draft.misses(wanted) or (len(trials) > len(found) and nearest <= FAR):
            break
        if refused and (draft.misses(wanted) > HOPELESS or not is_sound(draft)):
            left.append(draft)
        else:
            _try_draft(draft, trials, refused)
    best = min(trials, key=lambda trial: trial.misses(faces), default=None)
    narrow = min(refused, key=lambda draft: draft.misses(wanted), default=None)
    if narrow is not None and (best is None or best.misses(faces) > FAR):
        with suppress(SettingError):
            closed = Trial.of(with_tunnels_closed(narrow))
            is_nearer = best is None or closed.misses(faces) < best.misses(faces)
            if is_nearer and (best is None or closed.mean_angle <= max(GOOD_ANGLE, best.mean_angle)):
                return closed.finished(tried)
    while left and not trials:
        _try_draft(left.pop(0), trials, refused)
    if not trials:
        raise SettingError(f"{faces} faces are too few for a quad mesh of this surface: ask for more")
    return choose(trials, faces, tried)


def _try_draft(draft: Draft, trials: list[Trial], refused: list[Draft]) -> None:
    """Settle and finish a draft, and add it to the trials, or to those refused where tunnels may be closed."""
    settled = settle(draft)
    try:
        # Corrections that make many small faces of a few large ones are not used.
        is_spoilt = settled.face_count < FEW and settled.traced_count > SPOILT * FEW
        trials.append(Trial.of(draft if is_spoilt else settled))
    except TooLargeQuads:
        refused += [settled] if may_close_tunnels(settled) else []
    except SettingError:
        return


class SpacingFactor:
    """The factor of the spacing that gives a number of faces.

    The number changes in steps, by whole loops. The factor is corrected proportionally, and then to the geometric mean
    of one that gives too many faces and one that gives too few.
    """

    def __init__(self, factor: float, faces: int) -> None:
        self.factor, self._faces, self._bounds = factor, faces, [0.0, np.inf]

    def correct(self, count: float) -> None:
        """Correct the factor, which has given a number of faces."""
        self._bounds[count < self._faces] = self.factor
        proportional = self.factor * float(np.sqrt(np.clip(count / self._faces, 1 / MOST_CHANGE, MOST_CHANGE)))
        low, high = self._bounds
        self.factor = float(np.sqrt(low * high)) if low > 0 and np.isfinite(high) else proportional

    @property
    def is_settled(self) -> bool:
        """Whether factors that give too many faces and too few are so near each other that the number jumps there."""
        return self._bounds[1] < NARROW * self._bounds[0]

    def be_smaller(self) -> None:
        """Reduce the factor, which has given quads that are too large for a mesh."""
        self._bounds[1] = self.factor
        self.factor = float(np.sqrt(np.prod(self._bounds))) if self._bounds[0] > 0 else self.factor / 2
