# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of solves, kept for requests of later tests that are the same to the last bit."""

import pickle
from collections import OrderedDict
from functools import wraps
from hashlib import blake2b

from synch_fields.core.process.ipc import Unpacker, pack_parts
from synch_fields.core.tasks.animation import FramesRequest
from synch_fields.core.tasks.flows import FlowRequest, SurfaceFlowRequest
from synch_fields.core.tasks.solids import SolidRequest
from synch_fields.core.tasks.surfaces import SurfaceRequest

KINDS = SurfaceRequest, FramesRequest, SolidRequest, FlowRequest, SurfaceFlowRequest
# Results at most, for memory: the latest ones that were asked for.
MOST = 200
_parcels = OrderedDict()


def kept(solve, asked):
    """The method ``solve`` of a kind of request, which hands out a copy, as a child process does, of a result that it
    has found before. It solves where a caller follows its progress, and what one test asks for again: the set ``asked``
    is that of a test."""

    @wraps(solve)
    def solve_or_copy(request, progress=None):
        key = None if _is_followed(progress) else _key_of(request)
        shared = getattr(request, "shared", ())
        if key in _parcels and key not in asked:
            asked.add(key)
            _parcels.move_to_end(key)
            return Unpacker(shared).feed(_parcels[key])[0]
        result = solve(request, progress)
        if key is not None:
            asked.add(key)
            _parcels[key] = b"".join(pack_parts(result, shared))
            if len(_parcels) > MOST:
                _parcels.popitem(last=False)
        return result

    return solve_or_copy


def _is_followed(progress):
    """Whether a progress is not that which operators draw at the pointer."""
    return progress is not None and not getattr(progress, "__qualname__", "").startswith("progress_of.")


def _key_of(request):
    """A digest of a request; None where it holds what cannot be pickled."""
    try:
        return type(request).__name__, blake2b(pickle.dumps(request, protocol=5)).digest()
    except (AttributeError, TypeError, pickle.PicklingError):
        return None
