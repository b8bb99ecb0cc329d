# SPDX-License-Identifier: GPL-3.0-or-later
"""Sources of quad meshes: digests of everything that a solve reads from the source object, besides settings.

They are only read, so that a panel may ask for them while it is drawn.
"""

import os

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.settings.guidance import GUIDES
from ..blender import attributes, meshes
from ..blender.changes import changes
from ..blender.groups import read_weights
from ..blender.modifiers import carries, changing_modifiers, foreign_modifiers, is_relief, last_bending, shows_frames
from ..jobs.lru_cache import LruCache
from ..reading.refinement import digest_of, state_of, unequal_levels
from ..reading.surface import settings_for
from ..settings.fields import stored_settings
from .curves_read import curves_read

# Stands for a digest where the solve reads nothing, or where it is unknown whether that has changed.
_UNREAD = "-"
# Whether the sources of the quad meshes that were asked for last have changed.
_changed = LruCache(8)


def made_from(obj, settings, reads_modifiers):
    """Digests, as one line of text, of what a solve on an object in object mode reads: its mesh, the result of its
    modifiers, and what settings name.

    Parameters
    ----------
    settings : SurfaceSettings, with the constraint list
    reads_modifiers : whether the solve is on the result of the modifiers
    """
    seen = _evaluated(obj, settings.surface) if reads_modifiers else _UNREAD
    return f"{_of_mesh(obj.data, meshes.measured_places(obj))} {seen} {_named_inputs(obj, settings)}"


def has_changed(made, source):
    """Whether the source of a quad mesh, in object mode, has changed since the mesh was made from it."""
    try:
        settings = settings_for("quad_mesh", source, stored_settings(made))
        read = settings, curves_read(source, settings), _files(settings)
    except SynchError:  # what settings ask for cannot be
        settings = read = None
    states = changes.state(source.data), changes.state(source), _levels(source)
    key = *states, made.synch.made_from, tuple(source.scale), read
    return _changed.renewed(made.session_uid, key, lambda: _compare(made, source, settings))


def _compare(made, source, settings):
    if not np.allclose(made.scale, source.scale):
        return True
    before = made.synch.made_from.split()
    if settings is None or len(before) == 1:  # of an earlier version
        return before[0] != state_of(source)
    now = made_from(source, settings, reads_modifiers=before[1] != _UNREAD).split()
    return any(one != other for one, other in zip(before, now, strict=True) if _UNREAD not in (one, other))


def _evaluated(obj, surface):
    """Digest of the evaluated mesh of an object, where the surface of that name, such as "seen", is made of it.

    It is not read where a modifier of ours shows a pattern, nor where the view layer does not evaluate the object.
    """
    if any(is_relief(one) or shows_frames(one) or carries(one) for one in obj.modifiers if one.show_viewport):
        return _UNREAD
    if not (foreign_modifiers(obj) if surface == "seen" else changing_modifiers(obj)):
        return digest_of()
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = obj.evaluated_get(graph)
    if all(one != evaluated for one in graph.ids):
        return _UNREAD
    mesh = evaluated.to_mesh()
    try:
        places = attributes.read_all(mesh.attributes["position"].data, "vector", 3, np.float32)
        bending = [] if surface == "seen" else last_bending(obj)
        if not bending:
            return _of_mesh(mesh, places, _levels(obj))
        # The quad mesh is bent by the same modifiers, so that places count as far as settings of the others say.
        others = [_settings_text(one) for one in foreign_modifiers(obj) if one not in bending]
        return _of_mesh(mesh, places[:0], _levels(obj), np.frombuffer("\n".join(others).encode(), np.uint8))
    finally:
        evaluated.to_mesh_clear()


def _settings_text(modifier):
    """The settings of a modifier's own kind as text that is the same in each session."""
    common, parts = bpy.types.Modifier.bl_rna.properties.keys(), [modifier.type]
    for name, setting in modifier.bl_rna.properties.items():
        if name in common or setting.is_readonly or setting.type == "COLLECTION":
            continue
        value = getattr(modifier, name)
        if setting.type == "POINTER":
            value = getattr(value, "name", "")
        elif setting.type == "ENUM":
            value = sorted(value) if setting.is_enum_flag else value
        elif getattr(setting, "is_array", False):
            value = tuple(value)
        parts.append(f"{name} {value}")
    return "\n".join(parts)


def _of_mesh(mesh, places, *more):
    """Digest of the faces of a mesh and of (n, 3) places of its vertices."""
    corners = mesh.attributes.get(".corner_vert")
    corners = () if corners is None else attributes.read_all(corners.data, "value")
    starts = attributes.read_all(mesh.polygons, "loop_start")
    return digest_of(np.float32(places), np.int32(corners), starts, *map(np.array, more))


def _levels(obj):
    """Levels of modifiers that differ in renders, which the viewport does not show."""
    return tuple((one.levels, one.render_levels) for one in unequal_levels(obj))


def _maps(settings):
    return {name for name in (settings.angle_attribute, settings.spacing_map) if name}


def _named_inputs(obj, settings):
    """Digest of the groups, attributes, marks, curves and files of an object that settings name."""
    rows, sources = settings.all_constraints, settings.sources
    names = _maps(settings) | {row.name for row in rows if row.where in ("boundary", "group", "attribute")}
    names |= {source.name for source in sources if GUIDES[source.kind].names in ("numbers", "origin", "vectors")}
    maps = {source.name for source in sources if GUIDES[source.kind].names == "uv_map"}
    active = obj.data.uv_layers.active
    names |= {name or getattr(active, "name", "") for name in maps}
    marks = {row.where for row in rows} | ({"sharp"} if settings.features > 0 else set())
    parts = [part for name in sorted(names - {""}) for part in (name, _values(obj, name))]
    parts += [attributes.read_marked_edges(obj, mark) for mark in sorted(marks & set(attributes.MARKS))]
    parts += [part for curve in curves_read(obj, settings) for part in curve]
    parts += _files(settings)
    return digest_of(*(np.frombuffer(part.encode(), np.uint8) if isinstance(part, str) else part for part in parts))


def _values(obj, name):
    """The values of an attribute, or else the weights of a vertex group; empty without either."""
    attribute = obj.data.attributes.get(name)
    if attribute is not None:
        values = attributes.read_values(obj, name, attribute.domain)
        return np.empty(0) if values is None else values
    return read_weights(obj, name) if name in obj.vertex_groups else np.empty(0)


def _files(settings):
    """For each file that guides name, what :func:`_file` says."""
    return [_file(source.name) for source in settings.sources if GUIDES[source.kind].names == "path"]


def _file(path):
    """Time of change and size of a file; "" if it does not exist."""
    try:
        found = os.stat(bpy.path.abspath(path))
    except OSError:
        return ""
    return f"{found.st_mtime_ns} {found.st_size}"
