# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs: read the scene, solve, write the result. Only the solve takes long.

Making a job reads the scene and refuses what cannot be solved; its ``request`` is then all that the solve needs, plain
data that can be pickled (:mod:`core.tasks`). ``write(result)`` checks that the scene still fits, writes the result in
one transaction and returns the report; the scene does not change before, nor if it fails. A job also has

- ``link``, the :class:`ObjectLink` of its object, or None;
- ``advance()``, if it reads, or does all its work, in steps that need Blender: it does one step and returns the name of
  the next and the share done so far, None after the last. ``close()`` ends it between two steps, and ``at_once`` is the
  number of seconds for which the window may do steps before it is drawn again;
- ``request = None`` in its class, if steps are all its work: ``write(None)`` then returns the report.
"""

from ...core.errors import SettingError, quote_value
from ...core.files.json_text import Json
from ...core.monitor import Monitor, portion

# Share of the work that reading in steps takes.
READING = 0.1


def run(job, progress=None) -> Json:
    """Solve and write here and now; returns the report. Raises SynchError, with nothing written.

    ``progress``: callable(stage, fraction) -> bool, optional; False cancels.
    """
    if progress is not None and not callable(progress):
        raise SettingError(
            f"the callback is {quote_value(progress)}: give a function of a stage and a fraction, or None"
        )
    if hasattr(job, "advance"):
        solves = solves_after_pieces(job)
        _do_pieces(job, portion(progress, 0.0, READING) if solves else progress)
        if not solves:
            return job.write(None)
        progress = portion(progress, READING, 1 - READING)
    return job.write(job.request.solve(progress))


def solves_after_pieces(job):
    """Whether a job with steps solves after them."""
    return getattr(type(job), "request", None) is not None


def _do_pieces(job, progress):
    monitor = Monitor(progress)
    try:
        while (piece := job.advance()) is not None:
            monitor.at(*piece)
    finally:
        job.close()
