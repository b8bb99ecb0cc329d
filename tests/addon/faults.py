# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults in the middle of writing the scene: memory ends before the k-th line of the add-on that a write comes to."""

import sys
from contextlib import contextmanager
from pathlib import Path

import bpy

from synch_fields.synch_addon.blender import transaction

from .scenes import datablocks, snapshot

_ADDON = str(Path(transaction.__file__).parents[1])


@contextmanager
def fault_at(number, everywhere=False):
    """Raise MemoryError before the ``number``-th different line of the add-on while anything of the scene is written,
    or everywhere.

    Yields a list of the lines that were come to.
    """
    lines, seen = [], set()

    def each(frame, event, _):
        place = frame.f_code, frame.f_lineno
        if event == "line" and (everywhere or transaction._work._steps is not None) and place not in seen:
            seen.add(place)
            lines.append(f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}")
            if len(lines) == number:
                raise MemoryError(f"no memory at {lines[-1]}")
        return each

    def called(frame, _event, _):
        path = frame.f_code.co_filename
        return each if path.startswith(_ADDON) and path != transaction.__file__ else None

    before = sys.gettrace()
    sys.settrace(called)
    try:
        yield lines
    finally:
        sys.settrace(before)


def state(folder=None):
    """What the file holds, with what is hidden, nodes and their values, and what the panel keeps; and the bytes of all
    files in a folder."""
    bpy.context.view_layer.update()
    trees = [(m.name, m.node_tree) for m in bpy.data.materials] + [(g.name, g) for g in bpy.data.node_groups]
    return {
        # First, since Blender 4.5 keeps that these have been asked for.
        "results": {
            obj.name: (
                obj.synch.result,
                len(obj.synch.favourites),
                obj.synch_shown.variation,
                obj.synch_vortices.result,
            )
            for obj in bpy.data.objects
        },
        "files": {} if folder is None else {path.name: path.read_bytes() for path in Path(folder).iterdir()},
        "file": snapshot(),
        "data": datablocks(),
        "hidden": {obj.name: (obj.hide_get(), obj.hide_render) for obj in bpy.context.view_layer.objects},
        "nodes": {name: tree_state(tree) for name, tree in trees if tree is not None},
        "curves": {curve.name: [_spline(s) for s in curve.splines] for curve in bpy.data.curves},
        "modifiers": {obj.name: [_modifier(m) for m in obj.modifiers] for obj in bpy.data.objects},
        "maps": {mesh.name: _maps(mesh) for mesh in bpy.data.meshes},
        "volumes": {volume.name: volume.filepath for volume in bpy.data.volumes},
        "images": [(image.name, tuple(image.size), image.packed_file is not None) for image in bpy.data.images],
    }


def tree_state(tree):
    nodes = sorted(
        (node.bl_idname, node.name, [_value(socket) for socket in node.inputs if not socket.is_linked])
        for node in tree.nodes
    )
    return nodes, len(tree.links), [(item.name, item.in_out) for item in getattr(tree.interface, "items_tree", ())]


def _value(socket):
    value = getattr(socket, "default_value", None)
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else str(value)


def _maps(mesh):
    layers = mesh.uv_layers
    return [(layer.name, layer == layers.active, layer.active_render) for layer in layers]


def _spline(spline):
    points = spline.points if spline.type == "POLY" else spline.bezier_points
    return [tuple(point.co) for point in points], spline.use_cyclic_u


def _modifier(modifier):
    group = getattr(modifier, "node_group", None)
    return modifier.name, modifier.type, group and group.name


def differences(before, after, path=()):
    """Names of the parts of two states that differ."""
    if not (isinstance(before, dict) and isinstance(after, dict)):
        return [] if before == after else [": ".join(path)]
    names = [*before, *(name for name in after if name not in before)]
    return [line for name in names for line in differences(before.get(name), after.get(name), (*path, str(name)))]


def check_faults(begin, stride=1, first=1, folder=None, everywhere=False):
    """Let a fault come to each ``stride``-th place of work that writes the scene, which stays as it was; how many did.

    ``begin()`` gives the work, a function, for the scene as it is; what is in a folder stays as well. Faults come while
    the scene is written, or everywhere. In the handlers of properties Blender itself takes faults, and goes on.
    """
    work, number, count = begin(), first, 0
    before = state(folder)
    while True:
        with fault_at(number, everywhere) as lines:
            try:
                work()
            except MemoryError as error:
                found = differences(before, state(folder))
                assert not found, f"{error}: {found}"
                count += 1
            else:
                work, before = begin(), state(folder)
        if len(lines) < number:
            return count
        number += stride
