# SPDX-License-Identifier: GPL-3.0-or-later
"""A first result while a job goes on: shown on a copy of the object, in its place, which is gone afterwards.

The object itself stays as it is until the end, so that cancelling has nothing to put back.
"""

import bpy

from ..blender.transaction import all_data
from . import write

# The running job's preview, or None.
shown = None


class Preview:
    """A copy of an object with a field or pattern, while the object is hidden.

    Blender data may move meanwhile: everything is found again by the number that it has in this session.
    """

    def __init__(self, obj, task, field, pattern, report):
        self._object, self._selected = obj.session_uid, obj.select_get()
        before = set(all_data())
        try:
            self._put(obj, task, field, pattern, report)
        except BaseException:
            self._made = _made_since(before)
            self.remove()
            raise
        self._made = _made_since(before)

    def _put(self, obj, task, field, pattern, report):
        """The copy in the object's place."""
        copy = obj.copy()
        copy.data = obj.data.copy()
        for collection in obj.users_collection:
            collection.objects.link(copy)
        write.results(copy, task, field, pattern, report)
        for space in _spaces():
            if space.local_view and obj.local_view_get(space):
                copy.local_view_set(space, True)
        obj.hide_set(True)

    def remove(self):
        """Take the copy away and show the object again."""
        bpy.data.batch_remove([block for block in all_data().values() if block.session_uid in self._made])
        bpy.context.view_layer.update()
        for obj in bpy.context.view_layer.objects:
            if obj.session_uid == self._object:
                obj.hide_set(False)
                obj.select_set(self._selected)


def show(obj, *result):
    """Show a first result of a job on an object in object mode that can be seen; the arguments are a Preview's."""
    global shown
    if obj is not None and obj.mode == "OBJECT" and obj.visible_get():
        hide()
        shown = Preview(obj, *result)


@bpy.app.handlers.persistent
def hide(*_):
    """Take the preview away, where there is one: the job ends, or the file is about to be saved or closed."""
    global shown
    preview, shown = shown, None
    if preview is not None:
        preview.remove()


def _made_since(before):
    """Numbers of the blocks of data whose pointers are not among these."""
    return {block.session_uid for pointer, block in all_data().items() if pointer not in before}


def _spaces():
    """The 3D views of all windows."""
    for window in bpy.context.window_manager.windows:
        yield from (area.spaces.active for area in window.screen.areas if area.type == "VIEW_3D")


def register():
    bpy.app.handlers.save_pre.append(hide)
    bpy.app.handlers.load_pre.append(hide)


def unregister():
    bpy.app.handlers.load_pre.remove(hide)
    bpy.app.handlers.save_pre.remove(hide)
    hide()
