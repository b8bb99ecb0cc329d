# SPDX-License-Identifier: GPL-3.0-or-later
"""Favourites: configurations of defects that are kept as attributes of the mesh, and shown again without a solve.

A favourite is the directions and the phases at the vertices (:mod:`.read_back`), so that it survives saving, and costs
some bytes a vertex.
"""

import bpy
import numpy as np

from ...core.errors import SynchError
from ..blender import attributes, meshes, schema
from ..blender.pattern_surface import surface_of
from ..blender.transaction import at_the_end, undone_by, whole_or_nothing
from ..jobs.kept_results import read_result, read_settings
from ..jobs.report import Report
from . import job, memory
from .read_back import is_apart, read_back
from .write import SAME


def keep(obj, name=""):
    """Keep the shown variation of an object's stripes or quads under a name, by default the variation's.

    Returns str, the name: another one where it is taken. Raises SynchError, with nothing kept.
    """
    meshes.refuse(obj)
    result = read_result(obj.synch.result, obj.name)
    if result.get("command") not in schema.KEPT:
        raise SynchError(f"{obj.name} shows no stripes or quads: solve them first")
    if is_apart(read_settings(result, obj.name), result):
        raise SynchError(f"the pattern of {obj.name} has cuts, which attributes of vertices cannot store: use the seed")
    with meshes.object_mode(obj), whole_or_nothing():
        values = {
            attribute: attributes.read(surface_of(obj), attribute) for attribute in schema.KEPT[result["command"]]
        }
        if any(part is None for part in values.values()):
            raise SynchError(f"attributes of the pattern of {obj.name} are missing: solve it again")
        number = _unused_number(obj)
        count = len(obj.synch.favourites)
        undone_by(obj, lambda: obj.synch.favourites.remove(count))
        favourite = obj.synch.favourites.add()
        favourite.number, favourite.variation, favourite.result = number, obj.synch_shown.variation, obj.synch.result
        favourite.name = name
        for attribute, part in values.items():
            attributes.write(surface_of(obj), attribute.in_favourite(number), part)
    return favourite.name


def show(obj, name):
    """Show a favourite; returns the entries of its report that are stored (:func:`kept_results.result_line`).

    If the last solve has the same directions and settings, the favourite becomes one of its variations. Raises
    SynchError, with nothing written.
    """
    meshes.refuse(obj)
    favourite = _favourite(obj, name)
    result = favourite.result
    with meshes.object_mode(obj), whole_or_nothing():
        settings, request, field, pattern = read_back(obj, result, favourite.number)
        solved = matching_solve(obj, request, field)
        if solved is not None:
            phases, report = pattern.phases, solved.report.for_another_result()
            shown = solved.pattern.with_phases(phases)
            arguments = solved.request, solved.field, shown, report, favourite.variation
            job.write_result(obj, *arguments, lambda state: state.pattern.with_phases(phases))
        else:
            job.show(obj, request, field, pattern, Report(request.command, obj, settings))
            memory.show_line(obj, result, favourite.variation)
    return read_result(obj.synch.result, obj.name)


def remove(obj, name):
    """Remove a favourite, with its attributes unless a linked copy of the object has it, too."""
    meshes.refuse(obj)
    favourite = _favourite(obj, name)
    with meshes.object_mode(obj), whole_or_nothing():
        if not _is_shared(obj, favourite):
            for attribute in (*schema.KEPT["stripes"], *schema.KEPT["quads"]):
                attributes.remove_attribute(surface_of(obj), attribute.in_favourite(favourite.number).name)
        at_the_end(lambda: obj.synch.favourites.remove(obj.synch.favourites.find(name)))


def _favourite(obj, name):
    found = obj.synch.favourites.get(name)
    if found is None:
        names = ", ".join(other.name for other in obj.synch.favourites) or "none yet"
        raise SynchError(f"{obj.name} has no favourite {name!r}: choose one of its own ({names})")
    return found


def matching_solve(obj, request, field):
    """The solve in memory, where it is one of a request's command, spacing and branching along a field."""
    try:
        solved = memory.recall(obj)
    except SynchError:
        return None
    same = solved.request.command == request.command and len(solved.field.angles) == len(field.angles)
    same = same and np.array_equal(solved.request.spacings, request.spacings)
    same = same and solved.request.settings.branching == request.settings.branching
    same = same and np.abs(solved.field.scale - field.scale).max() < SAME
    return solved if same and np.abs(solved.field.vectors - field.vectors).max(initial=0) < SAME else None


def _unused_number(obj):
    """The next number for a favourite; linked copies of the mesh count, too."""
    found = [schema.FAVOURITE.match(attribute.name) for attribute in surface_of(obj).data.attributes]
    numbers = [favourite.number for favourite in obj.synch.favourites]
    return max([*numbers, *(int(match[1]) for match in found if match)], default=0) + 1


def _is_shared(obj, favourite):
    """Whether another object of the same mesh has the same favourite, as linked copies do."""
    data, made = surface_of(obj).data, [other for other in bpy.data.objects if other.type == "MESH" and other != obj]
    others = [other for other in made if surface_of(other).data == data and other != surface_of(obj)]
    return any(favourite.number == kept.number for other in others for kept in other.synch.favourites)
