# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh carries an object's pattern: its own, or a finer one that a modifier puts in place of its faces."""

from ...core.errors import SynchError
from .attributes import read
from .modifiers import changes_faces, input_value, is_ours, is_surface
from .objects import SURFACE_MARK
from .schema import SOURCE_FACE

# Modifiers that put what they add behind the vertices that are there.
_KEEP_FIRST = {"ARRAY", "MIRROR", "MULTIRES", "SOLIDIFY", "SUBSURF"}


def surface_of(obj):
    """The object whose mesh carries an object's pattern: the object, or the one that its modifier shows.

    Of an evaluated object it is always its own mesh, which has the pattern when all modifiers are done.
    """
    modifier = None if obj.is_evaluated else surface_modifier(obj)
    return obj if modifier is None else shown_by(modifier)


def surface_modifier(obj):
    """The modifier of an object that shows a surface of its pattern's own, or None."""
    return next((modifier for modifier in obj.modifiers if is_surface(modifier) and shown_by(modifier)), None)


def shows_vertices_first(obj):
    """Whether the first vertices that an object's modifiers show are those of the mesh that carries its pattern."""
    return not any(one.type not in _KEEP_FIRST for one in changing_later(obj))


def changing_later(obj):
    """The modifiers after the one that shows a pattern's own surface, or all without it, that may make other faces."""
    bound, modifiers = surface_modifier(obj), list(obj.modifiers)
    later = modifiers if bound is None else modifiers[modifiers.index(bound) + 1 :]
    return [modifier for modifier in later if changes_faces(modifier) and not is_ours(modifier)]


def faces_of_object(obj, faces):
    """The faces of an object's own mesh that faces of the mesh that carries its pattern are part of, ascending.

    Errors as :func:`source_faces`.
    """
    return faces if surface_of(obj) == obj else sorted(set(source_faces(obj)[faces].tolist()))


def source_faces(obj):
    """(m,) the face of an object's own mesh that each face of its pattern's own surface is part of.

    Raises SynchError where that is made of what modifiers made of the object.
    """
    source = read(surface_of(obj), SOURCE_FACE)
    if source is None or source.max(initial=-1) >= len(obj.data.polygons):
        raise SynchError(f"the pattern of {obj.name} lies on faces that its modifiers make: apply them and solve again")
    return source


def shown_by(modifier):
    """The object whose mesh a modifier shows; None if it was removed or is not one of the extension."""
    found = input_value(modifier, "Surface")
    return found if found is not None and SURFACE_MARK in found else None


def is_of_modifiers(obj):
    """Whether an object's modifier shows a surface that was made of other vertices than the object's own."""
    modifier = surface_modifier(obj)
    return modifier is not None and input_value(modifier, "Vertices") != len(obj.data.vertices)
