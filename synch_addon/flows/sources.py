# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in space: from files, volume objects, and curves that stand for filaments."""

import math
from collections.abc import Iterable
from numbers import Real
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError, quote_value
from ...core.fields.biot_savart import FilamentCurves
from ...core.files.flows import VELOCITY, flow_file
from ...core.files.volumes import VolumeFile
from ..blender.modifiers import is_of_filaments
from ..blender.objects import no_object
from ..blender.openvdb import module_file
from ..blender.strokes import SOURCE_TYPES, polylines
from ..blender.volume_files import shown_file
from ..nodes.vortices import STRENGTH


def flow_source(source, core, attribute=VELOCITY):
    """What a flow is read from, a :class:`VolumeFile`, :class:`ArrayFile` or :class:`FilamentCurves`.

    The vorticity of curves is spread over a radius of ``core`` cells; of a volume ``attribute`` is the grid's name.
    """
    if isinstance(source, str | Path):
        return flow_file(source, attribute, module_file())
    if isinstance(source, bpy.types.Object) and source.type == "VOLUME":
        return VolumeFile(shown_file(source), np.array(source.matrix_world), source.name, attribute, module_file())
    return _filaments(objects_of(source), core)


def objects_of(source):
    """The objects, one or several, of a source that is not a file.

    Raises SettingError for anything else.
    """
    objects = [source] if isinstance(source, bpy.types.Object) else source
    objects = list(objects) if isinstance(objects, Iterable) else []
    if not objects or not all(isinstance(obj, bpy.types.Object) for obj in objects):
        raise SettingError(
            f"{quote_value(source)} is not a flow: give a file, a volume, a mesh, or curves that stand for filaments"
        )
    for reason in filter(None, map(no_object, objects)):
        raise SettingError(reason)
    return objects


def _filaments(objects, core):
    """The :class:`FilamentCurves` that objects stand for."""
    curves = []
    for obj in objects:
        if obj.type not in SOURCE_TYPES:
            raise SettingError(f"{obj.name} is not a curve: choose curves, a volume, or a file with a flow")
        strength = obj.get(STRENGTH, 1.0)
        if not isinstance(strength, Real) or not math.isfinite(strength):
            raise SettingError(f"{obj.name}: its {STRENGTH} is {strength!r}: give the circulation as a number")
        matrix = np.array(obj.matrix_world)
        for line, number in _strands(obj):
            curves.append((line @ matrix[:3, :3].T + matrix[:3, 3], number * strength))
    if not curves:
        raise SettingError("there is no curve with two points: draw the vortex filaments")
    return FilamentCurves(objects[0].name, tuple(curves), core)


def _strands(obj):
    """(p, 3) points of every curve of an object, and how many filaments lie on it: in what a flow has shown, the square
    of its radius."""
    splines = obj.data.splines if obj.type == "CURVE" and any(map(is_of_filaments, obj.modifiers)) else ()
    if not splines or any(spline.type != "POLY" for spline in splines):
        return [(line, 1.0) for line in polylines(obj)]
    strands = []
    for spline in splines:
        points = np.array([point.co[:3] for point in spline.points])
        number = np.mean([point.radius**2 for point in spline.points])
        strands.append((np.concatenate([points, points[:1]]) if spline.use_cyclic_u else points, number))
    return [(points, number) for points, number in strands if np.ptp(points, axis=0).any()]
