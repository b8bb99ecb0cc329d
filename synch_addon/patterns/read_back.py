# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object shows, read back from its attributes: the pattern of a file that was opened again, or a favourite.

Directions and phases at the vertices suffice: the changes of phases that a solve asks for along the edges follow from
the directions. If it asks for fewer branches or singularities than the shape has, they depend on the constraints, too.
"""

from dataclasses import replace

import numpy as np

from ...core.errors import SynchError
from ...core.geometry.manifold_repair import APART
from ...core.settings.surface import SurfaceSettings
from ..blender import attributes, schema
from ..blender.pattern_surface import surface_of
from ..jobs.kept_results import read_result, read_settings
from ..reading.surface import gather, settings_for
from . import memory


def shown_pattern(obj):
    """The SurfaceRequest and the Pattern that an object in object mode shows: of its last solve, or else read back.

    Raises SynchError where there is none.
    """
    if memory.holds(obj):
        solved = memory.recall(obj)
        if solved.pattern is None:
            raise SynchError("lines are drawn of stripes and quads: solve one of them first")
        return solved.request, solved.pattern
    _, request, _, pattern = read_back(obj, obj.synch.result)
    return request, pattern


def read_back(obj, result, favourite=None):
    """The SurfaceSettings, SurfaceRequest, DirectionField and Pattern of attributes on the vertices.

    The pattern has no problem and no solution. Raises SynchError where an attribute is missing or of a newer version,
    or the surface is cut, so that vertices on a cut have several phases.

    Parameters
    ----------
    result : what the object keeps of their solve, see :func:`kept_results.result_line`
    favourite : number of the one that the attributes are of, None for what the object shows
    """
    surface = surface_of(obj)
    kept, stamp = read_result(result, obj.name), surface.data.get(schema.STAMP, 1)
    found = max(kept.get("format", 1), stamp if isinstance(stamp, int) else 1)
    if found > schema.FORMAT:
        raise SynchError(
            f"the pattern of {obj.name} is of a newer Synch Fields (format {found}, this one reads up to "
            f"{schema.FORMAT}): update the extension, or solve it again"
        )
    command = kept.get("command")
    if command not in schema.KEPT or kept["settings"] is None:
        raise SynchError(f"{obj.name} has no pattern whose settings are known: solve stripes or quads on it first")
    settings = settings_for(command, obj, read_settings(kept, obj.name))
    if is_apart(settings, kept):
        raise SynchError(f"the pattern of {obj.name} has cuts, which its attributes cannot store: solve it again")
    request = gather(command, surface, _without_direction_guides(settings))
    given = request.given
    own = schema.KEPT[command] if favourite is None else [a.in_favourite(favourite) for a in schema.KEPT[command]]
    vectors = attributes.read_vectors(surface, own[0].name, given)
    columns = [attributes.read_numbers(surface, phase.name, given) for phase in own[1:]]
    phases = np.exp(1j * np.column_stack(columns)).ravel()
    return settings, request, *request.known(vectors, phases)


def is_apart(settings, kept):
    """Whether vertices have several phases: where edges are cut, or the surface comes apart.

    ``kept``: what :func:`kept_results.result_line` keeps of the solve, as a dict.
    """
    is_cut = any(row.what == "cut" for row in settings.constraints)
    return is_cut or any(name in APART for name in kept.get("carrier", {}))


def _without_direction_guides(settings):
    """The settings of a pattern whose directions are known: what only guides directions is left out.

    Where neither the directions' singularities nor the branching of lines are limited, constraints do not change how
    phases differ along edges either.
    """
    plain = SurfaceSettings()
    names = ["guidance", "angle", "angle_attribute", "angle_range"]
    if settings.exact_attribute is not None:
        settings = replace(settings, singularities=1.0, pins="")
    if settings.branching == 1 and settings.singularities == 1 and not settings.pins:
        names += ["boundary", "vertex_group", "mirror"]
        settings = replace(settings, constraints=())
    return replace(settings, **{name: getattr(plain, name) for name in names})
