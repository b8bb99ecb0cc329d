# SPDX-License-Identifier: GPL-3.0-or-later
"""Caches of computed values, for as long as a file is open."""

import bpy

from ...core.errors import SynchError


class LruCache:
    """The latest values by keys that undo does not change.

    All caches are emptied when another file is opened, and when the extension is taken out.
    """

    _all: list["LruCache"] = []

    def __init__(self, most):
        self.most, self._kept = most, {}
        self._all.append(self)

    def put(self, key, value):
        """Store a value, replacing the old one."""
        kept = {other: found for other, found in self._kept.items() if other != key} | {key: value}
        self._kept = dict(list(kept.items())[-self.most :])

    def get(self, key):
        """The value of a key, or None."""
        return self._kept.get(key)

    def drop(self, key):
        """Remove the value of a key."""
        self._kept.pop(key, None)

    def renewed(self, key, state, make):
        """The result of ``make()`` in a state, stored until it is asked for in another state."""
        if key not in self._kept or self._kept[key][0] != state:
            self.put(key, (state, make()))
        return self._kept[key][1]

    def clear(self):
        """Remove all values."""
        self._kept.clear()

    @classmethod
    def clear_all(cls):
        """Remove the values of all caches."""
        for cache in cls._all:
            cache.clear()


class ObjectCache(LruCache):
    """The values of the latest objects."""

    def put(self, obj, value):
        """Store the value of an object, replacing the old one."""
        super().put(obj.session_uid, value)

    def get(self, obj):
        """The value of an object. Raises SynchError where there is none."""
        if not self.holds(obj):
            kept = f"kept for the last {self.most} objects while the file is open"
            raise SynchError(f"{obj.name} has no solve in memory ({kept}): solve it first")
        return super().get(obj.session_uid)

    def drop(self, obj):
        """Remove the value of an object."""
        super().drop(obj.session_uid)

    def holds(self, obj):
        """Whether an object has a value."""
        return obj is not None and super().get(obj.session_uid) is not None


@bpy.app.handlers.persistent
def _forget(*_):
    LruCache.clear_all()


def register():
    bpy.app.handlers.load_post.append(_forget)


def unregister():
    bpy.app.handlers.load_post.remove(_forget)
    _forget()
