# SPDX-License-Identifier: GPL-3.0-or-later
"""Work as plain data: requests, results, and the computations between them.

A request is a frozen dataclass of arrays and plain values, read from a scene beforehand. Its method
``solve(progress)`` computes the result without Blender, open files or any state of the process. Requests and results
can be pickled, so that a child process can do the work (:mod:`..process.child`).

``progress`` is a callable(stage, fraction) or None; a false answer other than None cancels with
:class:`..errors.Cancelled`; if it has a method ``expect``, that is called with the expected seconds of the work.
Messages for the user are in the result's ``warnings``, the times of parts of the work, by name, in its ``seconds``.
``request.shared`` are objects that are also part of the result, so that they need not be sent back, and
``request.kept`` objects that the next request will probably contain too: the child process keeps them until then. Both
may be missing. A request with ``solve_showing(show, progress)`` calls ``show`` with intermediate results, and
``picture(result)`` makes the picture of one for a window.
"""

import importlib
import pkgutil
import sys

import numpy
import scipy


def load() -> None:
    """Import everything that requests need, so that none of them has to wait for it."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f".{module.name}", __name__)


def versions() -> dict[str, str | tuple[str, str | None]]:
    """Versions that results may depend on, and where modules were loaded from, by name."""
    return {"python": sys.version} | {
        module.__name__: (module.__version__, module.__file__) for module in (numpy, scipy)
    }
