# SPDX-License-Identifier: GPL-3.0-or-later
"""What a job is: read, solve, write, and only the middle one takes long.

Making a job reads the scene and refuses what cannot be; its ``request`` is then all that a solve needs, plain data that
can be pickled (:mod:`core.tasks`). ``write(result)`` puts the result into the scene at once, whole or not at all, and
returns the report. Before that nothing has changed. A job also has

- ``link``, the :class:`ObjectLink` of the object that it is for, None where there is none;
- ``advance()``, where it reads, or does all its work, in pieces that need Blender: see :class:`.queue.Work`;
- ``show_early(result)``, where a first result can be shown.
"""


def run(job, progress=None):
    """Solve and write here and now; returns the report.

    Parameters
    ----------
    progress : callable(stage, fraction) -> bool, optional; False cancels

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    return job.write(job.request.solve(progress))
