# SPDX-License-Identifier: GPL-3.0-or-later
"""Attributes of a mesh as arrays, read and written."""

from contextlib import suppress
from itertools import count

import numpy as np

from ...core.errors import SettingError, name_elements
from .groups import is_group, read_weights
from .schema import FORMAT, PREFIX, STAMP, TYPES, layout_of
from .transaction import at_the_end, store, undone_by

# Attributes that mark edges.
MARKS = {"seams": "uv_seam", "sharp": "sharp_edge", "creases": "crease_edge"}
# In the names of attributes that leave.
_numbers = count()


def read_all(elements, name, width=1, dtype=np.int32):
    """(n,) or (n, width) values of a property of all elements of a collection."""
    values = np.empty(len(elements) * width, dtype)
    elements.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def read_vectors(obj, name, given):
    """(n, 3) vectors of a POINT attribute, on the vertices and in the measured space of a :class:`MeshInput`.

    Raises SettingError when the attribute is missing or of another kind.
    """
    return _read(_point_attribute(obj, name, "FLOAT_VECTOR", "vector")).astype(float)[given.source] @ given.stretch.T


def read_numbers(obj, name, given, outside=0.0):
    """(n,) numbers of a POINT attribute, or weights of a vertex group, ``outside`` it another number.

    Errors as :func:`read_vectors`.
    """
    if is_group(obj, name):
        return read_weights(obj, name, outside)[given.source]
    return _read(_point_attribute(obj, name, "FLOAT", "float")).astype(float)[given.source]


def read_factors(obj, given, name, factor):
    """(n,) factors on the spacing: a float attribute as it is, or a vertex group by its weights.

    Raises SettingError when there is neither, or a value of the attribute is not positive and finite.

    Parameters
    ----------
    name : of the attribute or vertex group; the attribute goes first
    factor : of a vertex with weight 1 in the group; 1 at weight 0, and geometric in between
    """
    values = read_numbers(obj, name, given)
    if is_group(obj, name):
        return factor**values
    values[given.mesh.loose_vertices] = 1
    _refuse(obj, given, name, ~(np.isfinite(values) & (values > 0)), "a positive factor on the spacing")
    return values


def read_turns(obj, given, name, turn):
    """(n,) radians by which directions are turned: a float attribute as it is, or a vertex group by its weights, where
    a weight of 1 is ``turn`` radians.

    Raises SettingError when there is neither, or a value is not finite.
    """
    values = read_numbers(obj, name, given)
    if is_group(obj, name):
        return turn * values
    _refuse(obj, given, name, ~np.isfinite(values), "a finite angle in radians")
    return values


def _refuse(obj, given, name, bad, wanted):
    vertices = np.unique(given.source[bad])
    if len(vertices):
        raise SettingError(
            f"the attribute {name!r} of {obj.name} is of no use at {name_elements('vertex', vertices)}: give {wanted}"
        )


def read_uv_map(obj, name):
    """(c, 2) coordinates of the faces' corners in a UV map, the active one where the name is "".

    Raises SettingError when there is no such map.
    """
    layers = obj.data.uv_layers
    layer = layers.get(name) if name else layers.active
    if layer is None:
        which = f"UV map {name!r}" if name else "UV map"
        present = ", ".join(found.name for found in layers) or "none yet"
        raise SettingError(f"the mesh {obj.data.name} has no {which}: choose one of its maps ({present}), or unwrap it")
    return _read(obj.data.attributes[layer.name]).astype(float)


def _point_attribute(obj, name, data_type, kind):
    attribute = obj.data.attributes.get(name)
    if attribute is None:
        layout = data_type, "POINT"
        present = [a.name for a in obj.data.attributes if (a.data_type, a.domain) == layout and a.name != "position"]
        have = f"it has {', '.join(present)}" if present else "it has none"
        raise SettingError(f"the mesh {obj.data.name} has no attribute {name!r}: choose a {kind} attribute ({have})")
    if attribute.data_type != data_type or attribute.domain != "POINT":
        raise SettingError(
            f"the attribute {name!r} is {attribute.data_type} on {attribute.domain}: it must be a {kind} on points"
        )
    return attribute


def read_marked_edges(obj, mark):
    """(k, 2) vertices of the edges that are "seams", "sharp" or "creases", where a face uses them."""
    marked = read_values(obj, MARKS[mark], "EDGE")
    if marked is None:
        return np.empty((0, 2), int)
    loose = read_all(obj.data.edges, "is_loose", dtype=bool)
    return read_all(obj.data.edges, "vertices", 2)[(marked > 0) & ~loose].astype(np.int64)


def read_values(obj, name, domain):
    """(n,) or (n, width) values of an attribute as they are, None where the mesh has none of the name on a domain."""
    attribute = obj.data.attributes.get(name)
    if attribute is None or attribute.domain != domain or attribute.data_type not in TYPES:
        return None
    return _read(attribute)


def _read(attribute):
    dtype, width, name = TYPES[attribute.data_type]
    return read_all(attribute.data, name, width, dtype)


def read(obj, attribute):
    """What :func:`read_values` reads of an attribute of :mod:`.schema`, None where it has another type."""
    found = obj.data.attributes.get(attribute.name)
    fits = found is not None and (found.domain, found.data_type) == attribute.layout
    return _read(found) if fits else None


def write(obj, attribute, values):
    """Write an attribute of :mod:`.schema`; errors as :func:`write_attribute`."""
    write_attribute(obj, attribute.name, *attribute.layout, values)


def write_attribute(obj, name, domain, data_type, values):
    """Write an attribute, replacing one of the same name that has another domain or type.

    Raises ValueError before anything is changed, where values do not fit the domain and the type, or one of ours does
    not fit :mod:`.schema`, or is not finite.
    """
    mesh = obj.data
    values = _fitting(name, domain, data_type, mesh.attributes.domain_size(domain), np.asarray(values))
    present = mesh.attributes.get(name)
    if present is not None and (present.domain, present.data_type) == (domain, data_type):
        before = _read(present)
        undone_by(mesh, lambda: _put(mesh, name, before))
    else:
        _make_way(mesh, name)
        undone_by(mesh, lambda: _remove(mesh, name))
        mesh.attributes.new(name, data_type, domain)
    _put(mesh, name, values)
    if name.startswith(PREFIX) and mesh.get(STAMP) != FORMAT:
        store(mesh, STAMP, FORMAT)


def _put(mesh, name, values):
    attribute = mesh.attributes[name]
    attribute.data.foreach_set(TYPES[attribute.data_type][2], values.ravel())


def _make_way(mesh, name):
    """Remove an attribute once nothing can fail any more. Until then it has another name, which Blender hides, and gets
    its own back if the work fails."""
    if name not in mesh.attributes:
        return
    hidden = next(free for free in map(".synch_leaving_{}".format, _numbers) if free not in mesh.attributes)

    def give_back():
        if hidden in mesh.attributes:
            mesh.attributes[hidden].name = name

    undone_by(mesh, give_back)
    mesh.attributes[name].name = hidden
    at_the_end(lambda: _remove(mesh, hidden))


def _remove(mesh, name):
    """Remove an attribute if it exists, at the end of a transaction, when the mesh itself may have been removed."""
    with suppress(ReferenceError):
        if name in mesh.attributes:
            mesh.attributes.remove(mesh.attributes[name])


def _fitting(name, domain, data_type, count, given):
    dtype, width, _ = TYPES[data_type]
    fits = given.shape == ((count, width) if width > 1 else (count,)) and np.can_cast(given.dtype, dtype, "same_kind")
    values = np.ascontiguousarray(given, dtype) if fits else given
    if fits and name.startswith(PREFIX):
        finite = np.isfinite(values) if values.dtype.kind == "f" else values == given
        fits = layout_of(name) == (domain, data_type) and finite.all()
    if not fits:
        raise ValueError(f"{name} as {data_type} on {count} x {domain} does not take {given.dtype} {given.shape}")
    return values


def remove_attribute(obj, name):
    """Remove an attribute if it is there."""
    _make_way(obj.data, name)


def show_same_maps(obj, made):
    """Make the same UV maps and colours the active and the rendered ones on another mesh as on the given one."""
    layers, others = obj.data.uv_layers, made.data.uv_layers
    for layer in layers:
        if layer.active_render and layer.name in others:
            others[layer.name].active_render = True
    if layers.active is not None and layers.active.name in others:
        others.active = others[layers.active.name]
    colors, others = obj.data.color_attributes, made.data.color_attributes
    if colors.active_color_name in others:
        others.active_color_name = colors.active_color_name
    if 0 <= colors.render_color_index < len(colors) and colors[colors.render_color_index].name in others:
        others.render_color_index = others.find(colors[colors.render_color_index].name)
