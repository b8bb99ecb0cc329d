# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's data as it was before, where something fails or was made for a while only.

What changes the file runs inside :func:`whole_or_nothing`. Where that fails, every datablock that has appeared goes by
itself. Whoever changes what was there says how it is given back, by :func:`assign`, :func:`store` or
:func:`undone_by`; whoever takes something away has it leave (:func:`leave`), which it does when nothing can fail any
more. Outside all of these do what they are asked to, for good and at once.
"""

import os
import shutil
from contextlib import ExitStack, contextmanager
from pathlib import Path

import bpy
import numpy as np
from idprop.types import IDPropertyArray, IDPropertyGroup

from ...core.files.whole import place_beside

# Behind the name of what leaves, whose name something new may take.
_LEAVING = " (leaving)"


class _Work:
    """What the innermost work that may fail has done: at most one is open at a time."""

    def __init__(self):
        self._steps, self._ends, self._before, self._names = None, [], set(), []

    @contextmanager
    def whole_or_nothing(self):
        """Remove every datablock that appears inside and undo what was changed when that fails, and only then."""
        if self._steps is not None:  # a part of larger work
            yield
            return
        self._before, self._ends, self._names = set(all_data()), [], []
        with ExitStack() as steps:
            # The last one first: what was changed is given back, then what is new goes, then its names are free.
            steps.callback(self._name_again)
            steps.callback(self._remove_new)
            try:
                self._steps = steps
                yield
                steps.pop_all()
            finally:
                self._steps = None
        with ExitStack() as ends:  # each of them, whatever becomes of the others
            for end in reversed(self._ends):
                ends.callback(end)

    def undone_by(self, owner, step):
        """Call ``step``, which gives back what something of ``owner`` was, should the work fail, the last one first.

        What belongs to something new goes with it.
        """
        if self._steps is not None and owner.id_data.as_pointer() in self._before:
            self._steps.callback(step)

    def set_aside(self, thing):
        """Rename what is going to be removed, so that something new may have its name."""
        if self._steps is not None:
            self._names.append((thing, thing.name))
        thing.name += _LEAVING

    def at_the_end(self, step):
        """Call ``step`` when nothing can fail any more, now where nothing is open."""
        if self._steps is None:
            step()
        else:
            self._ends.append(step)

    def keep(self, block):
        """Change a datablock of ours at will from here on: where the work fails, a copy of now takes its place."""
        if self._steps is None or block.as_pointer() not in self._before:
            return
        name, copy = block.name, block.copy()
        copy.name = name + _LEAVING
        self._before.add(copy.as_pointer())
        self.at_the_end(lambda: bpy.data.batch_remove([copy]))

        def give_back():
            block.user_remap(copy)
            bpy.data.batch_remove([block])
            copy.name = name

        self.undone_by(block, give_back)

    def _remove_new(self):
        remove_all_but(self._before)
        bpy.context.view_layer.update()  # forgets what has been removed, and puts back what was moved

    def _name_again(self):
        for thing, name in reversed(self._names):
            thing.name = name


_work = _Work()
whole_or_nothing, keep, set_aside = _work.whole_or_nothing, _work.keep, _work.set_aside
undone_by, at_the_end = _work.undone_by, _work.at_the_end


def assign(owner, name, value):
    """``owner.name = value``, undone where the work fails."""
    before = _own(getattr(owner, name))
    undone_by(owner, lambda: setattr(owner, name, before))
    setattr(owner, name, value)


def _own(value):
    """A value that stays as it is: vectors, matrices and arrays of properties show what these are now."""
    if hasattr(value, "freeze"):
        return value.copy()
    return tuple(value) if isinstance(value, bpy.types.bpy_prop_array) else value


def store(block, key, value):
    """Set a custom property, undone where the work fails."""
    _keep_property(block, key)
    block[key] = value


def drop(block, key):
    """Remove a custom property, where it is there; undone where the work fails."""
    _keep_property(block, key)
    block.pop(key, None)


def _keep_property(block, key):
    if key not in block:
        undone_by(block, lambda: block.pop(key, None))
        return
    before, shown = _copy_value(block[key]), _limits(block, key)

    def give_back():
        block[key] = before
        if shown:
            block.id_properties_ui(key).update(**shown)

    undone_by(block, give_back)


def _copy_value(value):
    """A value of a custom property that stays as it is: Blender frees arrays and groups that others replace."""
    if isinstance(value, IDPropertyGroup):
        return {key: _copy_value(part) for key, part in value.items()}
    if isinstance(value, IDPropertyArray):
        return value.to_list() if value.typecode == "b" else np.array(value)  # an array of NumPy keeps its type
    return [_copy_value(part) for part in value] if isinstance(value, list) else value


def _limits(block, key):
    """How a custom property is shown: its limits, its default and the like; empty for a kind that has none."""
    try:
        return block.id_properties_ui(key).as_dict()
    except TypeError:
        return {}


def keep_file(owner, path):
    """Give a file back as it is now, or take away what has come to its place, should work on ``owner`` fail.

    What is no file, such as a device, is left alone.
    """
    place = Path(path).resolve()
    kept = place_beside(place)
    if not place.exists():
        undone_by(owner, lambda: place.unlink(missing_ok=True))
        return
    if not place.is_file():
        return
    shutil.copy2(place, kept)
    undone_by(owner, lambda: os.replace(kept, place))
    at_the_end(lambda: kept.unlink(missing_ok=True))


def leave(blocks):
    """Remove datablocks when nothing can fail any more; until then they have other names, which new ones may take."""
    blocks = list(blocks)
    for block in blocks:
        set_aside(block)
    at_the_end(lambda: bpy.data.batch_remove(blocks))


@contextmanager
def only_for_now():
    """Remove every datablock that appears inside, on success and on failure alike."""
    before = set(all_data())
    try:
        yield
    finally:
        remove_all_but(before)


def remove_all_but(before):
    """Remove every datablock whose address is not in a set; whether there were any."""
    new = [block for pointer, block in all_data().items() if pointer not in before]
    bpy.data.batch_remove(new)
    return bool(new)


def all_data():
    """Every datablock of the file, by address: the render result and the like included."""
    lists = (p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION")
    return {block.as_pointer(): block for name in lists for block in getattr(bpy.data, name)}
