# SPDX-License-Identifier: GPL-3.0-or-later
"""What was computed, kept while a file is open."""

import bpy

from ...core.errors import SynchError


class LruCache:
    """What was computed, the latest of it, by keys that undo does not change.

    All shelves are emptied when another file is opened, and when the extension is taken out.
    """

    _all: list["LruCache"] = []

    def __init__(self, most):
        self.most, self._kept = most, {}
        self._all.append(self)

    def put(self, key, value):
        """Keep something, in place of what there was, which stays where this fails."""
        kept = {other: found for other, found in self._kept.items() if other != key} | {key: value}
        self._kept = dict(list(kept.items())[-self.most :])

    def get(self, key):
        """What is kept, or None."""
        return self._kept.get(key)

    def drop(self, key):
        """Keep it no longer."""
        self._kept.pop(key, None)

    def renewed(self, key, state, make):
        """What ``make()`` gives in a state, kept until it is asked for in another."""
        if key not in self._kept or self._kept[key][0] != state:
            self.put(key, (state, make()))
        return self._kept[key][1]

    def clear(self):
        """Keep nothing."""
        self._kept.clear()

    @classmethod
    def clear_all(cls):
        """Keep nothing on any shelf."""
        for shelf in cls._all:
            shelf.clear()


class ObjectCache:
    """A shelf with a place for each object.

    ``most``: objects, the latest ones.
    """

    def __init__(self, most):
        self._shelf = LruCache(most)

    def put(self, obj, solved):
        """Keep something for an object, in place of what there was."""
        self._shelf.put(obj.session_uid, solved)

    def get(self, obj):
        """What is kept for an object. Raises SynchError where there is nothing."""
        if not self.holds(obj):
            kept = f"kept for the last {self._shelf.most} objects while the file is open"
            raise SynchError(f"{obj.name} has no solve in memory ({kept}): solve it first")
        return self._shelf.get(obj.session_uid)

    def drop(self, obj):
        """Keep it no longer."""
        self._shelf.drop(obj.session_uid)

    def clear(self):
        """Keep nothing."""
        self._shelf.clear()

    def holds(self, obj):
        """Whether anything is kept for an object."""
        return obj is not None and self._shelf.get(obj.session_uid) is not None


@bpy.app.handlers.persistent
def _forget(*_):
    LruCache.clear_all()


def register():
    bpy.app.handlers.load_post.append(_forget)


def unregister():
    bpy.app.handlers.load_post.remove(_forget)
    _forget()
