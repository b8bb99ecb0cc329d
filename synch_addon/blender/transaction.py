# SPDX-License-Identifier: GPL-3.0-or-later
"""Transactions on Blender's data: if the work inside :func:`whole_or_nothing` fails, the file is as it was before.

New datablocks are removed then. A change to one that was there is restored if it is made by :func:`assign`,
:func:`store` or :func:`drop`, or if :func:`undone_by` was given the step that restores it. Removals wait until nothing
can fail any more (:func:`leave`, :func:`at_the_end`). Outside a transaction all of these act at once.

The user's undo is Blender's own and needs nothing of this.
"""

import os
import shutil
from contextlib import ExitStack, contextmanager
from pathlib import Path

import bpy
import numpy as np
from idprop.types import IDPropertyArray, IDPropertyGroup

from ...core.files.whole import place_beside

# Added to the name of what will be removed, so that something new may take its name.
_LEAVING = " (leaving)"


class _Work:
    """The open transaction; a nested one is part of it."""

    def __init__(self):
        self._steps, self._ends, self._before, self._names = None, [], set(), []

    @contextmanager
    def whole_or_nothing(self):
        """Context of a transaction: on an error, new datablocks are removed and changes are undone."""
        if self._steps is not None:  # part of a larger transaction
            yield
            return
        self._before, self._ends, self._names = set(all_data()), [], []
        with ExitStack() as steps:
            # Called in reverse order: changes are undone, then new datablocks removed, then old names given back.
            steps.callback(self._name_again)
            steps.callback(self._remove_new)
            try:
                self._steps = steps
                yield
                steps.pop_all()
            finally:
                self._steps = None
        with ExitStack() as ends:  # all are called, even if one of them fails
            for end in reversed(self._ends):
                ends.callback(end)

    def undone_by(self, owner, step):
        """If the transaction fails, call ``step``, which restores something of ``owner``; the last step first.

        A new owner needs no step: it is removed.
        """
        if self._steps is not None and owner.id_data.as_pointer() in self._before:
            self._steps.callback(step)

    def set_aside(self, thing):
        """Rename what will be removed, so that something new may take its name."""
        if self._steps is not None:
            self._names.append((thing, thing.name))
        thing.name += _LEAVING

    def at_the_end(self, step):
        """Call ``step`` when the transaction has succeeded; at once outside a transaction."""
        if self._steps is None:
            step()
        else:
            self._ends.append(step)

    def keep(self, block):
        """Copy a datablock of ours before it is changed: if the transaction fails, the copy takes its place."""
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
    """``owner.name = value``, undone if the transaction fails."""
    before = _copy_of(getattr(owner, name))
    undone_by(owner, lambda: setattr(owner, name, before))
    setattr(owner, name, value)


def _copy_of(value):
    """A copy of a property's value: vectors, matrices and arrays would follow later changes of the property."""
    if hasattr(value, "freeze"):
        return value.copy()
    return tuple(value) if isinstance(value, bpy.types.bpy_prop_array) else value


def store(block, key, value):
    """Set a custom property, undone if the transaction fails."""
    _keep_property(block, key)
    block[key] = value


def drop(block, key):
    """Remove a custom property if it exists, undone if the transaction fails."""
    _keep_property(block, key)
    block.pop(key, None)


def _keep_property(block, key):
    """Restore a custom property with its limits, or remove it where there was none, if the work fails."""
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
    """A copy of a custom property's value: Blender frees arrays and groups that are replaced."""
    if isinstance(value, IDPropertyGroup):
        return {key: _copy_value(part) for key, part in value.items()}
    if isinstance(value, IDPropertyArray):
        return value.to_list() if value.typecode == "b" else np.array(value)  # an array of NumPy keeps its type
    return [_copy_value(part) for part in value] if isinstance(value, list) else value


def _limits(block, key):
    """Limits, default and the like of a custom property; empty for types that have none."""
    try:
        return block.id_properties_ui(key).as_dict()
    except TypeError:
        return {}


def keep_file(owner, path):
    """Restore a file as it is now, or remove a new one at its place, if the transaction on ``owner`` fails.

    Devices and the like are left alone.
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
    """Remove datablocks when the transaction has succeeded; new ones may take their names before that."""
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
    """Remove every datablock whose address is not in a set; returns whether there were any."""
    new = [block for pointer, block in all_data().items() if pointer not in before]
    bpy.data.batch_remove(new)
    return bool(new)


def all_data():
    """Every datablock of the file by its address, the render result and the like included."""
    lists = (p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION")
    return {block.as_pointer(): block for name in lists for block in getattr(bpy.data, name)}
