# SPDX-License-Identifier: GPL-3.0-or-later
"""The latest solves of solids, kept while Blender runs, so that outputs of layers need no new solve."""

from dataclasses import replace
from uuid import uuid4

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.tasks.layer_outputs import Layering
from ..blender import meshes
from ..blender.transaction import at_the_end, store
from ..jobs.lru_cache import LruCache
from .links import made_of

# Solves of solids that are kept, up to a kilobyte a tetrahedron; undo brings earlier ones of an object back.
_MOST = 3
KEPT_SOLIDS = f"kept for the last {_MOST} solves while the file is open"
# Custom property of the layers that were made: which solve they show.
RUN = "synch_run"
# By the run that the layers show.
_solids = LruCache(_MOST)


def remember_layers(obj, given, layering):
    """Keep the :class:`Layering` that the layers of an object show, whose mesh was a :class:`MeshInput`."""
    run = uuid4().hex
    store(made_of(obj, "layers"), RUN, run)
    at_the_end(lambda: _solids.put(run, (given, layering)))


def recall_layers(obj) -> Layering:
    """The :class:`Layering` that the layers of an object show, where these layers are now.

    Raises SynchError if it is no longer in memory or the mesh has changed since.
    """
    made = made_of(obj, "layers")
    if not holds_layers(obj):
        raise SynchError(f"no layers of {obj.name} are in memory ({KEPT_SOLIDS}): solve them first")
    given, layering = _solids.get(made[RUN])
    if not meshes.is_unchanged(obj, given):
        raise SynchError(f"the mesh or the scale of {obj.name} has changed since its layers were solved: solve again")
    bpy.context.view_layer.update()
    return replace(layering, matrix=np.array(made.matrix_world, float))


def holds_layers(obj):
    """Whether the :class:`Layering` of an object's layers is in memory, even if its mesh has changed since."""
    made = made_of(obj, "layers")
    return made is not None and _solids.get(made.get(RUN)) is not None


def solid_matrix(obj, given):
    """(4, 4) from the space in which an object was measured to the world."""
    unscaled = np.eye(4)
    unscaled[:3, :3] = np.linalg.inv(given.stretch)
    return np.array(obj.matrix_world, float) @ unscaled
