# SPDX-License-Identifier: GPL-3.0-or-later
"""What a job is: read, solve, write, and only the middle one takes long.

Making a job reads the scene and refuses what cannot be; its ``request`` is then all that a solve needs, plain data that
can be pickled (:mod:`core.tasks`). ``write(result)`` refuses what no longer fits before its first change, then puts
the result into the scene at once, and returns the report. Before that nothing has changed, and nothing has where it
fails. A job also has

- ``link``, the :class:`ObjectLink` of the object that it is for, None where there is none;
- ``advance()``, where it reads, or does all its work, in pieces that need Blender: it does one and returns what comes
  next and the share of the pieces that is done, None when that was the last one. ``close()`` ends it between two, and
  ``at_once`` are seconds for which the window may do pieces before it is drawn again;
- ``request = None`` in its class, where pieces are all its work: ``write(None)`` then returns the report.
"""

from ...core.errors import SettingError, quote_value
from ...core.files.json_text import Json
from ...core.monitor import Monitor, portion

# Share of the work that reading in pieces is.
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
    """Whether a job that is done in pieces goes on to solve."""
    return getattr(type(job), "request", None) is not None


def _do_pieces(job, progress):
    monitor = Monitor(progress)
    try:
        while (piece := job.advance()) is not None:
            monitor.at(*piece)
    finally:
        job.close()
