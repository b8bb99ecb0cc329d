# SPDX-License-Identifier: GPL-3.0-or-later
"""How fine a spacing an object's mesh carries, seen on some of its faces, and subdivision where it is too coarse.

The panel asks at every redraw, so that the answer is kept until a mesh changes, and costs the same for any mesh.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import bpy
import numpy as np

from ...core.errors import SettingError, SynchError, quote_value
from ...core.files.json_text import Json
from ...core.refinement.spacing import (
    FEW_LINES,
    SLACK,
    carried_spacing,
    carries_few_lines,
    lines_in_period,
    spacing_across,
    spacing_carried,
    wished_spacing,
)
from ...core.validation import convert_value
from ..blender import attributes, groups, meshes
from ..blender.changes import changes
from ..blender.transaction import assign, keep, undone_by, whole_or_nothing
from ..blender.translations import operator_error, translate
from ..jobs.kept_results import read_result_or_empty
from ..jobs.lru_cache import LruCache
from ..jobs.report import versions
from . import memory, write

# Faces that are looked at, spread over all of them.
FACES_SEEN = 500
MOST_LEVELS, MOST_FACES = 6, 4_000_000

# Names of metric units in a scene's settings: as they are written, and how many a metre has.
_UNITS = {"METERS": ("m", 1), "CENTIMETERS": ("cm", 1e2), "MILLIMETERS": ("mm", 1e3), "MICROMETERS": ("µm", 1e6)}
# What is known of the objects that were asked for last.
_seen = LruCache(16)


@dataclass(frozen=True)
class MeshDetail:
    """Size of a mesh and the finest spacings that it can carry, in scene units.

    Attributes
    ----------
    spacing : the finest one with the spacing map
    finest : the finest one without the map
    size : longest side of the object
    area : of its faces
    density : factor by which the map makes quads more
    """

    spacing: float
    finest: float
    size: float
    area: float
    density: float


def refine(obj: bpy.types.Object, levels: int | None = None) -> Json:
    """Subdivide an object's mesh, so that it carries the spacing that is set.

    One that looks smooth (:func:`looks_smooth`) goes to its limit surface by Catmull and Clark; of others no place
    changes. Returns dict, the report with ``levels``, ``faces_before``, ``faces`` and whether it is ``smooth``. Raises
    SynchError, with nothing changed. ``levels``: how often every edge is halved; None for as often as its spacing
    needs, at least once.
    """
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        levels = max(offered_levels(obj), 1) if levels is None else convert_value("level", int, levels)
        before, smooth = len(obj.data.polygons), looks_smooth(obj)
        _subdivide(obj, levels, smooth)
    memory.forget(obj)
    counts = {"levels": levels, "faces_before": before, "faces": len(obj.data.polygons), "smooth": smooth}
    return {"status": "made", "command": "refine", "object": obj.name, **counts, "versions": versions()}


def mesh_detail(obj):
    """:class:`MeshDetail` of a mesh object, or None where it has no faces; in edit mode of the mesh before it."""
    data, settings = obj.data, obj.synch
    scale = tuple(tuple(row) for row in obj.matrix_world.to_3x3())
    counts = len(data.polygons), len(data.loops)
    state = changes.state(data), counts, scale, settings.spacing_map, settings.spacing_range
    return _seen.renewed(obj.session_uid, state, lambda: _look_at(obj))


def expected_spacing(command, obj):
    """Estimate the automatic spacing of a command on an object before it runs; None if that is not known."""
    found = mesh_detail(obj)
    if found is None:
        return None
    per_period = lines_in_period(command)
    if obj.synch.surface == "FACES":
        return spacing_carried(found.size, found.finest, per_period)
    spacing = spacing_across(found.size, found.area, found.finest, per_period)
    is_refined = obj.synch.surface == "SEEN" or carries_few_lines(command, found.size, spacing)
    return wished_spacing(found.area, per_period) if is_refined else spacing


def expected_faces(obj, stored):
    """About how many faces a quad mesh of an object gets from the spacing in some settings; None where that is not
    known."""
    found = mesh_detail(obj)
    if found is None:
        return None
    spacing = expected_spacing("quad_mesh", obj) if stored.automatic_spacing else stored.spacing
    side = spacing / lines_in_period("quad_mesh")
    return round(found.density * found.area / side**2) if side > 0 else None


def missing_levels(obj):
    """Number of subdivisions that the mesh needs for the spacing that is set, to be rounded up; 0 or less for none.

    Automatic spacing counts as :data:`FEW_LINES` lines across.
    """
    found = mesh_detail(obj)
    if found is None or found.size == 0:
        return 0.0
    wanted = found.size / FEW_LINES if obj.synch.automatic_spacing else obj.synch.spacing
    return math.log2(found.spacing / (SLACK * wanted)) if wanted > 0 and found.spacing > 0 else 0.0


def faces_after(obj, levels):
    """How many faces the mesh has after simple subdivision: one at each corner, then four times as many each time."""
    return len(obj.data.loops) * 4 ** (levels - 1)


def offered_levels(obj):
    """How often the mesh should be subdivided, as often as is sensible; 0 where it need not be."""
    levels = min(math.ceil(missing_levels(obj)), MOST_LEVELS)
    while levels > 1 and faces_after(obj, levels) > MOST_FACES:
        levels -= 1
    return max(levels, 0)


def looks_smooth(obj):
    """Whether an object in object mode is to look smooth: by a Subdivision Surface modifier of its own, or because all
    its faces are shaded so and no edge is sharp."""
    if any(map(_is_smoothing, obj.modifiers)):
        return True
    sharp = [attributes.read_values(obj, *name) for name in (("sharp_face", "FACE"), ("sharp_edge", "EDGE"))]
    return not any(map(_is_by_angle, obj.modifiers)) and not any(marks is not None and marks.any() for marks in sharp)


def _is_by_angle(modifier):
    """Whether a modifier is Blender's own that makes edges sharp."""
    group = modifier.node_group if modifier.type == "NODES" else None
    return group is not None and group.name.startswith("Smooth by Angle")


def _is_smoothing(modifier):
    return modifier.type == "SUBSURF" and modifier.subdivision_type == "CATMULL_CLARK" and modifier.show_viewport


def _subdivide(obj, levels, smooth):
    """Subdivide the mesh of an object in object mode, and take the pattern of the old faces away.

    UV maps, colours, groups, seams, materials and attributes go over; other users of the mesh keep theirs. Raises
    SynchError where it cannot be; nothing is changed.
    """
    if not 1 <= levels <= MOST_LEVELS:
        raise SettingError(f"the level is {quote_value(levels)}: give a whole number from 1 to {MOST_LEVELS}")
    if obj.data.shape_keys:
        raise SynchError(f"{obj.name} has shape keys, which subdivision would lose: apply or remove them first")
    if len(obj.data.polygons) == 0:
        raise SynchError(f"{obj.name} has no faces: add some first")
    if faces_after(obj, levels) > MOST_FACES:
        raise SettingError(f"level {levels} would make {faces_after(obj, levels):,} faces: take a lower one")
    mesh, present = obj.data, {modifier.name for modifier in obj.modifiers}
    keep(mesh)
    undone_by(obj, lambda: setattr(obj, "data", mesh))
    undone_by(obj, lambda: [obj.modifiers.remove(one) for one in list(obj.modifiers) if one.name not in present])
    modifier = obj.modifiers.new("Synch Refine", "SUBSURF")
    name = modifier.name
    modifier.levels = levels
    if smooth:
        modifier.boundary_smooth, modifier.use_limit_surface = "PRESERVE_CORNERS", True
        for other in filter(_is_smoothing, obj.modifiers[:-1]):  # as many faces are seen as before
            assign(other, "levels", max(other.levels - levels, 0))
            assign(other, "render_levels", max(other.render_levels - levels, 0))
    else:
        modifier.subdivision_type, modifier.uv_smooth = "SIMPLE", "NONE"
        modifier.use_limit_surface = False  # it would bend what is on a face
    obj.modifiers.move(len(obj.modifiers) - 1, 0)
    render = bpy.context.scene.render
    simplified, render.use_simplify = render.use_simplify, False  # it would hold the levels down
    try:
        with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
            bpy.ops.object.modifier_apply(modifier=name, single_user=True)
    except RuntimeError as error:
        raise SynchError(f"{obj.name} cannot be subdivided: {operator_error(error)}") from error
    finally:
        render.use_simplify = simplified
        if name in obj.modifiers:
            obj.modifiers.remove(obj.modifiers[name])
    write.clear(obj)


def draw_warning(layout, obj):
    """Say where the object's own faces, if they are chosen, are too coarse for the spacing that is set, with a button
    that subdivides them."""
    is_made = read_result_or_empty(obj.synch.result).get("command") == "quad_mesh"  # of another mesh
    if obj.synch.surface != "FACES" or obj.mode != "OBJECT" or is_made or missing_levels(obj) <= 0:
        return
    found, levels = mesh_detail(obj), offered_levels(obj)
    column = layout.box().column(align=True)
    if obj.synch.automatic_spacing:
        across = max(round(found.size / found.spacing), 1)
        one = translate("Coarse mesh: about one line across")
        text = one if across == 1 else translate("Coarse mesh: about {count} lines across", count=across)
        column.label(text=text, icon="ERROR")
    else:
        column.label(text=translate("Coarse mesh: carries {spacing}", spacing=as_length(found.spacing)), icon="ERROR")
    text = translate("Subdivide to {count:,} Faces", count=faces_after(obj, levels))
    column.operator("synch.refine", text=text, icon="MOD_SUBSURF").levels = levels


def draw_expected_spacing(column, command, obj):
    """Draw the automatic spacing of a command, for quad meshes the length of edges, unless it is off or unknown."""
    length = expected_spacing(command, obj) if obj.synch.automatic_spacing else None
    if length is not None:
        text = "About {length} for two quads" if lines_in_period(command) == 2 else "About {length} apart"
        if command == "quad_mesh":
            length, text = length / lines_in_period(command), "Edges of about {length}"
        column.label(text=translate(text, length=as_length(length)), icon="BLANK1", translate=False)


def as_length(number):
    """A length in the scene's unit, as Blender's fields show it."""
    units = bpy.context.scene.unit_settings
    if units.system != "NONE":
        number *= units.scale_length
    if units.system == "METRIC" and units.length_unit in _UNITS:
        name, factor = _UNITS[units.length_unit]
        return f"{float(f'{number * factor:.3g}'):g} {name}"
    return bpy.utils.units.to_string(units.system, "LENGTH", number, precision=3)


def _look_at(obj):
    """Measure the :class:`MeshDetail` of an object on a sample of its triangles; None without triangles."""
    places, triangles, share = _sample(obj.data)
    if len(triangles) == 0:
        return None
    vertices = np.array(list(places))
    points = np.array(list(places.values()))
    rotated = points @ np.array(obj.matrix_world.to_3x3()).T
    seen = np.searchsorted(vertices, triangles)
    sides = np.roll(rotated[seen], -1, axis=1) - rotated[seen]
    lengths = np.linalg.norm(sides, axis=2).ravel()
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    factors = np.maximum(_factors(obj, vertices.tolist()), 1e-6)[seen]
    density = areas @ (1 / factors**2).mean(axis=1) / areas.sum() if areas.any() else 1.0
    factors = factors.ravel()
    stretched = np.ptp(points, axis=0) * np.array(obj.matrix_world.to_scale())
    size = float(np.abs(stretched).max())
    finest = carried_spacing(lengths / factors), carried_spacing(lengths)
    return MeshDetail(*finest, size, float(areas.sum() / share), float(density))


def _sample(data):
    """Positions by vertex, in order, (t, 3) triangles that some faces are cut into, and the share of these faces.

    Each side of a triangle counts, so that an edge between two faces counts twice, as one inside a face does.
    """
    places, triangles = {}, []
    step = max(1, len(data.polygons) // FACES_SEEN)
    chosen = range(0, len(data.polygons), step)
    for number in chosen:
        corners = data.polygons[number].vertices[:]
        triangles += [(corners[0], *pair) for pair in pairwise(corners[1:])]
        places.update((vertex, data.vertices[vertex].co[:]) for vertex in corners)
    share = len(chosen) / max(len(data.polygons), 1)
    return dict(sorted(places.items())), np.array(triangles, int).reshape(-1, 3), share


def _factors(obj, vertices):
    """Factors of the spacing map at some vertices; 1 where it cannot be used."""
    name, data = obj.synch.spacing_map, obj.data
    if name and groups.is_group(obj, name):
        index = obj.vertex_groups[name].index
        weights = [{m.group: m.weight for m in data.vertices[v].groups}.get(index, 0.0) for v in vertices]
        return obj.synch.spacing_range ** np.array(weights)
    found = data.attributes.get(name) if name else None
    if found is None or (found.domain, found.data_type) != ("POINT", "FLOAT"):
        return np.ones(len(vertices))
    return np.array([found.data[v].value for v in vertices])
