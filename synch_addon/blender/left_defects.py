# SPDX-License-Identifier: GPL-3.0-or-later
"""Empties of defects whose object has been deleted: removed while the window rests.

A handler of the dependency graph only sees that objects are gone; data is removed outside of it, where no operator or
script is at work. Undoing the deletion brings the object and its empties back.
"""

import bpy
from bpy.app.handlers import depsgraph_update_post, persistent

from .defect_empties import orphaned_empties, remove_collections
from .timers import Timer


class _Watch:
    """Looks whether objects have been deleted."""

    def __init__(self):
        self._count, self._timer, self._handler = 0, Timer(remove_left_defects), self._look

    def register(self):
        depsgraph_update_post.append(self._handler)

    def unregister(self):
        depsgraph_update_post.remove(self._handler)
        self._timer.stop()

    @persistent
    def _look(self, *_):
        before, self._count = self._count, len(bpy.data.objects)
        if self._count < before:
            self._timer.start()


def remove_left_defects():
    """Remove the empties, and the collections that they leave empty."""
    left = orphaned_empties()
    collections = {collection for empty in left for collection in empty.users_collection}
    bpy.data.batch_remove(left)
    remove_collections(collections)


_watch = _Watch()
register, unregister = _watch.register, _watch.unregister
