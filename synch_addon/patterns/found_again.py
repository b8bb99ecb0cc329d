# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs for variations: those of an opened file, found by solving again, and one that is drawn at random."""

from ...core.errors import SynchError
from ...core.files.json_text import Json
from ...core.tasks.variations import VariationRequest
from ..blender import meshes
from ..blender.objects import ObjectLink
from ..blender.transaction import whole_or_nothing
from ..jobs.kept_results import read_result, read_settings
from . import job, memory
from .favourites import matching_solve
from .read_back import read_back


class VariationsJob(job.FieldJob):
    """The solve that an object's attributes are of, with its own settings; see :mod:`..jobs.job`.

    Its result is remembered as the solve of the pattern that the object shows, which may be a variation or have placed
    defects. Where it does not fit, since mesh or guides have changed or the search was ended early, the new pattern is
    shown, with a warning.
    """

    def __init__(self, obj):
        meshes.refuse(obj)
        with meshes.object_mode(obj):
            _, *self._shown = read_back(obj, obj.synch.result)
        self._number = obj.synch_shown.variation
        kept = read_result(obj.synch.result, obj.name)
        super().__init__(kept["command"], obj, read_settings(kept, obj.name))

    def write(self, result):
        """Write the result to the object at once; returns the report."""
        obj, (request, field, pattern) = self.link.found, self._shown
        with meshes.object_mode(obj), whole_or_nothing():
            report = super().write(result)
            solved = matching_solve(obj, request, field)
            if solved is None:
                line = "this is another pattern, since mesh or guides have changed, or the search was ended early: "
                line += "undo brings the other one back"
                return report | {"warnings": [*report["warnings"], line]}
            phases = pattern.phases
            arguments = solved.request, solved.field, solved.pattern.with_phases(phases)
            fresh = solved.report.for_another_result()
            change = lambda state: state.pattern.with_phases(phases)  # noqa: E731
            return job.write_result(obj, *arguments, fresh, self._number, change, instead=True)


class DrawnVariationJob:
    """The nearest of some variations of what an object shows; see :mod:`..jobs.job`."""

    def __init__(self, obj, numbers):
        meshes.refuse(obj)
        with meshes.object_mode(obj):
            solved = memory.recall(obj).compact()
        self.link, self.request = ObjectLink.to(obj), VariationRequest(solved.shown, tuple(numbers))

    def write(self, result) -> Json:
        """Write the result to the object at once; returns the report with the number as ``variation``, and as ``more``
        how much more energy it has than the best, as a share."""
        obj, best, (number, phases) = self.link.found, self.request.solved.solution, result
        change = lambda solved: solved.shown.with_phases(phases)  # noqa: E731
        with meshes.object_mode(obj), whole_or_nothing():
            solved = memory.recall(obj)
            if solved.shown.solution is not best:
                raise SynchError(f"{obj.name} shows another solve than before: draw again")
            report = job.write_changed(obj, solved, change, change, number)
        more = report["energy"] / best.energy - 1 if best.energy > 0 else 0.0
        return report | {"variation": number, "more": more}
