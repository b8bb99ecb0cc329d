# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a pattern that is not solved on the object's own faces.

An object that no scene shows has its mesh, and a modifier of the pattern's object puts it in place of the faces.
"""

import numpy as np

from ...core.settings.pins import parse_pins, text_of_pins
from ..blender import attributes, meshes, schema
from ..blender.bvh import surface_tree
from ..blender.modifiers import changes_faces, is_ours
from ..blender.objects import SURFACE_MARK
from ..blender.pattern_surface import is_of_modifiers, surface_modifier, surface_of
from ..blender.refined_mesh import carry_groups
from ..blender.transaction import assign, at_the_end, leave, set_aside, undone_by
from ..nodes.bound_surface import bound_surface_group
from ..nodes.canvas import add_modifier, set_inputs
from ..nodes.materials import take_over_look
from ..reading.refinement import made_of, source_of, state_of, unequal_levels


def bind(obj, refinement, warn):
    """Give an object the surface of a Refinement, in place of one that it has; None for its own faces.

    ``warn`` is called with lines that the user should read. Raises SynchError where the object's faces are others by
    now.
    """
    if refinement is None:
        release(obj)
        return
    former, present = surface_of(obj), surface_modifier(obj)
    with source_of(obj, refinement.is_seen) as source:
        made = made_of(obj, source, refinement)
        values = {"Surface": made, "Vertices": len(source.data.vertices)}
        if former != obj:
            _take_over(obj, former, made)
    if refinement.is_seen:
        _level(obj, warn)
    group = bound_surface_group()
    if present is None:
        add_modifier(obj, group, values)
    else:
        _let_go(former, made)
        set_inputs(present, values)
    _move_to_its_place(obj, surface_modifier(obj), refinement.is_seen)


def release(obj):
    """Let an object show its own faces again."""
    modifier = surface_modifier(obj)
    if modifier is None:
        return
    _let_go(surface_of(obj), None)
    set_aside(modifier)
    set_inputs(modifier, {"Surface": None})
    at_the_end(lambda: obj.modifiers.remove(modifier))


def carry_painted_groups(obj):
    """Give the surface of an object, if it has one, the weights that vertex groups have by now."""
    surface = surface_of(obj)
    if surface == obj:
        return
    parents = np.column_stack([attributes.read(surface, attribute) for attribute in schema.PARENTS])
    with source_of(obj, is_of_modifiers(obj)) as source:
        if parents.max(initial=-1) < len(source.data.vertices):  # others are refused when the result is written
            carry_groups(source, surface, parents, attributes.read(surface, schema.WEIGHTS))


def is_unchanged(obj, given):
    """Whether what an object's pattern was solved on is still there: a MeshInput of its own mesh, or of the surface
    that its modifier shows, made of the same mesh as the object has now."""
    surface = surface_of(obj)
    return meshes.is_unchanged(surface, given) and (surface == obj or surface[SURFACE_MARK] == state_of(obj))


def moved_pins(text, before, after):
    """Move pins, as text, from faces of an object's mesh to the faces of another mesh at the same places."""
    pins = parse_pins(text)
    if not pins or before == after or _are_alike(before, after):
        return text
    polygons, there = (meshes.read_polygons(obj) for obj in (before, after))
    corners = meshes.measured_places(before)[polygons.corner_vertices]
    centres = np.add.reduceat(corners, polygons.starts) / polygons.sizes[:, None]
    tree = surface_tree(meshes.measured_places(after), there.triangles)
    known = {face: turns for face, turns in pins.items() if 0 <= face < len(centres)}
    if len(known) < len(pins):  # of a mesh that is there no more
        return text
    return text_of_pins({int(there.triangle_faces[tree.find_nearest(centres[f])[2]]): t for f, t in known.items()})


def _let_go(former, made):
    """Remove a surface that nothing else shows, when nothing can fail any more; ``made`` may have its name."""
    if former.users > 1:  # a copy of the object shows it, too
        return
    data = former.data
    leave([former, data] if data.users == 1 else [former])
    if made is not None:
        made.name = made.name.rsplit(".", 1)[0]


def _take_over(obj, former, made):
    """Give a new surface the look of the former one, and where it has the same faces all that the former got as well:
    favourites, numbers, UV maps."""
    take_over_look(made, former)
    if not _are_alike(former, made):
        if hasattr(obj, "synch"):  # as long as the extension is registered
            at_the_end(obj.synch.favourites.clear)
        if schema.NUMBER.name in former.data.attributes:  # so that its stripes are numbered anew
            attributes.write(made, schema.NUMBER, np.zeros((len(made.data.polygons), 3)))
        return
    for attribute in list(former.data.attributes):
        name, domain = attribute.name, attribute.domain
        values = attributes.read_values(former, name, domain)
        if name[0] != "." and name not in made.data.attributes and values is not None:
            attributes.write_attribute(made, name, domain, attribute.data_type, values)


def _are_alike(first, second):
    names = (("position", "POINT"), (".corner_vert", "CORNER"))
    pairs = [[attributes.read_values(obj, *name) for obj in (first, second)] for name in names]
    return all(np.array_equal(*pair) for pair in pairs) and len(first.data.polygons) == len(second.data.polygons)


def _level(obj, warn):
    """Let viewport and renders subdivide as often, since the pattern is bound to the faces of both."""
    for modifier in unequal_levels(obj):
        level = max(modifier.levels, modifier.render_levels)
        warn(f"{modifier.name} has level {level} in viewport and renders now: the pattern is bound to its faces")
        assign(modifier, "levels", level)
        assign(modifier, "render_levels", level)
    for modifier in obj.modifiers:
        if changes_faces(modifier) and not is_ours(modifier) and modifier.show_viewport != modifier.show_render:
            where = "the viewport" if modifier.show_viewport else "renders"
            warn(
                f"{modifier.name} is shown in {where} alone, and the pattern is bound to the faces of the viewport: "
                "show it in both, or in neither"
            )


def _move_to_its_place(obj, modifier, is_seen):
    """Put the modifier behind what its faces are made of: all that does not show a pattern, or does not change faces
    where the mesh itself was refined."""
    others = [other for other in obj.modifiers if other != modifier]
    later = [is_ours(other) or (changes_faces(other) and not is_seen) for other in others]
    place = later.index(True) if True in later else len(others)
    now, name = list(obj.modifiers).index(modifier), modifier.name
    if now != place:
        undone_by(obj, lambda: obj.modifiers.move(obj.modifiers.find(name), now))
        obj.modifiers.move(now, place)
