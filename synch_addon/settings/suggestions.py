# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that the panels suggest while one is typed."""

from ...core.settings.guidance import BOUNDARY
from ..blender.strokes import SOURCE_TYPES


def _point_attributes(obj, data_type):
    """Names of an object's attributes of a type on the vertices."""
    return [a.name for a in obj.data.attributes if (a.domain, a.data_type) == ("POINT", data_type) and a.name[0] != "."]


def suggest_numbers(_properties, context, _text):
    """Float attributes and vertex groups of the active object."""
    obj = context.active_object
    return [*_point_attributes(obj, "FLOAT"), *(group.name for group in obj.vertex_groups)]


def suggest_vectors(_properties, context, _text):
    """Vector attributes of the active object."""
    return [name for name in _point_attributes(context.active_object, "FLOAT_VECTOR") if name != "position"]


def suggest_origins(_properties, context, _text):
    """Vertex groups of the active object, its boundary, and curves."""
    obj = context.active_object
    sources = [other.name for other in context.scene.objects if other.type in SOURCE_TYPES and other != obj]
    return [*(group.name for group in obj.vertex_groups), BOUNDARY, *sources]


def suggest_uv_maps(_properties, context, _text):
    """UV maps of the active object."""
    return [layer.name for layer in context.active_object.data.uv_layers]


def suggest_groups(properties, _context, _text):
    """Vertex groups of the object that owns the property, and its boundary."""
    return [*(group.name for group in properties.id_data.vertex_groups), BOUNDARY]


def suggest_solid_origins(properties, context, text):
    """Vertex groups of the object, its boundary, and the other meshes of the scene."""
    own = properties.id_data
    meshes = [obj.name for obj in context.scene.objects if obj.type == "MESH" and obj != own]
    return [*suggest_groups(properties, context, text), *meshes]


def suggest_curves(properties, context, _text):
    """Curves and drawn strokes of the scene."""
    own = properties.id_data
    return [obj.name for obj in context.scene.objects if obj.type in SOURCE_TYPES and obj != own]
