# SPDX-License-Identifier: GPL-3.0-or-later
"""Work as plain data: what is asked (a request) and what is found (a result), with the function between them.

A request is a frozen dataclass of arrays and plain values, read from a scene beforehand. Its method
``solve(progress)`` gives the result and needs nothing else: no Blender, no file that is open, no state of the process.
Both can be pickled, so that a process of its own may do the work (:mod:`..process.child`).

``progress`` is a callable(stage, fraction) or None; a false answer other than None cancels with
:class:`..errors.Cancelled`. What the work should tell the user is in the result's ``warnings``, and how long its parts
took, by their names, in its ``seconds``. ``request.shared`` are objects that the result holds, too: they need not
travel back. A request that has ``solve_showing(show, progress)`` also gives results of the same kind on the way, by
calls of ``show``, and the pictures of them that a window draws, by ``picture(result)``. ``request.kept``,
where there is such a thing, are objects that the next request is likely to hold as well: a process that solves keeps
them until then.
"""

import importlib
import pkgutil
import sys

import numpy
import scipy


def load():
    """Load all that requests need, so that none of them has to wait for it."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f".{module.name}", __name__)


def versions():
    """What a result may depend on: by names, a version and where it was loaded from."""
    return {"python": sys.version} | {
        module.__name__: (module.__version__, module.__file__) for module in (numpy, scipy)
    }
