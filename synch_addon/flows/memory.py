# SPDX-License-Identifier: GPL-3.0-or-later
"""The latest solves of flows, kept while Blender runs, so that another point of the sphere needs no new solve."""

from collections.abc import Callable
from dataclasses import dataclass

from ...core.settings.flow import FlowSettings
from ...core.tasks.flows import FlowResult
from ..jobs.lru_cache import ObjectCache

# Frames of a sequence that are kept, and so solved at once.
MOST_FRAMES = 10_000


@dataclass(frozen=True)
class SolvedFlow:
    """A solve and what shows it.

    Attributes
    ----------
    name : of what the flow was read from
    fill : callable(result, settings, objects) that shows a result in the objects and returns the :class:`Filled`
    objects : session numbers of all that show it
    sources : names of the objects that the flow was read from
    """

    name: str
    settings: FlowSettings
    result: FlowResult
    fill: Callable
    objects: tuple[int, ...]
    sources: tuple[str, ...] = ()


@dataclass(frozen=True)
class Filled:
    """Result of filling the objects of a flow.

    Attributes
    ----------
    facts : for the report
    fill : what fills them the next time
    warnings : lines that the user should read
    """

    facts: dict
    fill: Callable
    warnings: tuple[str, ...] = ()


class _Flows:
    """Solves of the latest objects that show vortices, about a kilobyte a node each, and of all frames of the latest
    sequence."""

    def __init__(self):
        self._single, self._frames = ObjectCache(4), ObjectCache(MOST_FRAMES)

    def put(self, obj, solved):
        """Keep the :class:`SolvedFlow` of an object."""
        self._shelf(solved.settings.frames is not None).put(obj, solved)

    def get(self, obj):
        """The :class:`SolvedFlow` of an object; raises SynchError without one."""
        return self._shelf(self._frames.holds(obj)).get(obj)

    def holds(self, obj):
        """Whether the solve of an object is kept."""
        return self._frames.holds(obj) or self._single.holds(obj)

    def begin_sequence(self):
        """Make room for the frames of another sequence."""
        self._frames.clear()

    def _shelf(self, is_frame):
        return self._frames if is_frame else self._single


flows = _Flows()
# Of the same objects, whatever the method: the list of Filament that they show, and the Linked of these or None.
shown_filaments = ObjectCache(4)
