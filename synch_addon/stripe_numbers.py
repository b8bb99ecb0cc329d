# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of an object's stripes and coordinates along them, written for shaders and geometry nodes."""

from ..core.errors import SettingError, SynchError
from ..core.extract.isolines import isolines
from ..core.extract.stripe_numbers import stripe_table
from . import memory, scene_io
from .bake_index import pattern_kind, read_phases
from .stripe_profiles import ALONG, NUMBER

# Between the points of the lines along which coordinates are measured, in spacings.
_STEP = 0.1


def number_stripes(obj):
    """Number the stripes of an object's last solve and write coordinates along them, for shaders and relief.

    What is written follows every later solve and variation of the object.

    Parameters
    ----------
    obj : bpy.types.Object with stripes that were solved since the file was opened

    Returns
    -------
    int, how many stripes there are: number k is that of spline k - 1 of :func:`api.isolines`

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    reason = scene_io.refusal(obj)
    if reason:
        raise SynchError(reason)
    with scene_io.object_mode(obj):
        return _write(obj)


def _write(obj):
    solved = memory.recall(obj)
    if solved.pattern is None or pattern_kind(obj) != "stripes":
        raise SynchError("stripes are numbered: solve stripes first")
    task = solved.task
    lines = isolines(solved.pattern.edge_phases)
    if len(lines.sizes) == 0:
        raise SettingError(f"no stripe has its middle on {obj.name}: reduce the spacing and solve again")
    (phase,) = read_phases(obj, "stripes")
    table = stripe_table(phase, task.given.polygons, lines.resampled(_STEP * task.spacing), task.spacing)
    scene_io.write_attribute(obj, NUMBER, "FACE", "FLOAT_VECTOR", table.numbers)
    scene_io.write_attribute(obj, ALONG, "CORNER", "FLOAT_VECTOR", table.along)
    scene_io.update(obj)
    return len(lines.sizes)


def renew_numbers(obj):
    """Number the stripes of an object anew where they were numbered before; they go where that cannot be."""
    if NUMBER not in obj.data.attributes:
        return
    try:
        _write(obj)
    except SynchError:
        for name in (NUMBER, ALONG):
            scene_io.remove_attribute(obj, name)
