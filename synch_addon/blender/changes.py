# SPDX-License-Identifier: GPL-3.0-or-later
"""Which state meshes and objects are in, for what is computed from them at a redraw and kept until they change."""

import bpy
from bpy.app.handlers import depsgraph_update_post, frame_change_post, load_post, persistent, redo_post, undo_post

from .registration import register_handlers


class _Changes:
    """How many changes Blender has reported of each mesh, and of the shape that modifiers give each object; undo and
    redo may change any."""

    def __init__(self):
        self._counts, self._steps = {}, 0
        self.handlers = [(event, self._count) for event in (depsgraph_update_post, frame_change_post)]
        self.handlers += [(event, self._forget) for event in (load_post, undo_post, redo_post)]

    def state(self, block):
        """A value that stays equal while a mesh or object is the same and keeps its shape."""
        return block.session_uid, self._steps, self._counts.get(block.session_uid, 0)

    @persistent
    def _count(self, _scene, depsgraph):
        for update in depsgraph.updates:
            if update.is_updated_geometry and isinstance(update.id, (bpy.types.Mesh, bpy.types.Object)):
                uid = update.id.original.session_uid
                self._counts[uid] = self._counts.get(uid, 0) + 1

    @persistent
    def _forget(self, *_):
        self._counts.clear()
        self._steps += 1


changes = _Changes()
register, unregister = register_handlers(*changes.handlers)
