# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's data as it was before, where something fails or was made for a while only."""

from contextlib import contextmanager

import bpy


@contextmanager
def only_for_now():
    """Remove every datablock that appears inside, on success and on failure alike."""
    before = set(all_data())
    try:
        yield
    finally:
        _remove_all_but(before)


@contextmanager
def whole_or_nothing():
    """Remove every datablock that appears inside when that fails."""
    before = set(all_data())
    try:
        yield
    except BaseException:
        _remove_all_but(before)
        raise


def _remove_all_but(before):
    bpy.data.batch_remove([block for pointer, block in all_data().items() if pointer not in before])


def all_data():
    """Every datablock of the file, by address: the render result and the like included."""
    lists = (p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION")
    return {block.as_pointer(): block for name in lists for block in getattr(bpy.data, name)}
