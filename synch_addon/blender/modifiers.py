# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers of an object: those that change faces, those of the extension, and evaluation without them."""

from contextlib import ExitStack, contextmanager
from itertools import takewhile

# Names of our groups of geometry nodes, by what they show.
FRAMES = {"stripes": "Synch Frames", "quads": "Synch Quad Frames"}
RELIEFS = {"stripes": "Synch Relief", "quads": "Synch Quad Relief"}
SURFACE = "Synch Surface"
CARRIES = {"stripes": "Synch Carry", "quads": "Synch Quad Carry"}
FILAMENTS = "Synch Filaments"
# Modifiers after which the mesh may have other faces.
_CHANGES_FACES = (
    {"ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "MASK", "MIRROR", "MULTIRES"}
    | {"NODES", "OCEAN", "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "TRIANGULATE"}
    | {"VOLUME_TO_MESH", "WELD", "WIREFRAME"}
)  # fmt: skip
# Modifiers that bend any mesh alike, whatever its faces.
_BENDING = {"ARMATURE", "CAST", "CURVE", "LATTICE", "SIMPLE_DEFORM", "WARP"}


def changing_modifiers(obj):
    """The visible modifiers after which the mesh may have other faces than the one that carries a pattern."""
    return [modifier for modifier in foreign_modifiers(obj) if changes_faces(modifier)]


def foreign_modifiers(obj):
    """The modifiers that are seen and do not show a pattern."""
    return [modifier for modifier in obj.modifiers if modifier.show_viewport and not is_ours(modifier)]


def last_subdivisions(obj):
    """The visible Subdivision Surface modifiers that are followed only by modifiers that show patterns."""
    return list(takewhile(lambda modifier: modifier.type == "SUBSURF", reversed(foreign_modifiers(obj))))


def bends(modifier):
    """Whether a modifier bends any mesh alike, whatever its faces."""
    return modifier.type in _BENDING


def last_bending(obj):
    """The visible modifiers that bend the object and are followed only by others that do, by subdivisions, and by those
    that show patterns."""
    last = takewhile(lambda one: bends(one) or one.type in ("SUBSURF", "MULTIRES"), reversed(foreign_modifiers(obj)))
    return [modifier for modifier in last if bends(modifier)][::-1]


def changes_faces(modifier):
    """Whether the mesh may have other faces after a modifier."""
    return modifier.type in _CHANGES_FACES


def is_ours(modifier):
    """Whether a modifier shows a pattern and does not shape the mesh that carries it."""
    return shows_frames(modifier) or is_relief(modifier) or carries(modifier) or is_surface(modifier)


def is_surface(modifier):
    """Whether a modifier puts a pattern's own surface in place of the faces before it."""
    return _uses(modifier, [SURFACE])


def shows_frames(modifier):
    """Whether a modifier shows a pattern frame by frame."""
    return _uses(modifier, FRAMES.values())


def is_relief(modifier):
    """Whether a modifier raises the surface by its pattern."""
    return _uses(modifier, RELIEFS.values())


def carries(modifier):
    """Whether a modifier carries a pattern through those before it."""
    return _uses(modifier, CARRIES.values())


def is_of_filaments(modifier):
    """Whether a modifier makes tubes of filaments."""
    return _uses(modifier, [FILAMENTS])


def modifier_of(obj, name):
    """The first modifier of an object with a node group whose name begins with this, or None."""
    groups = [(modifier, modifier.node_group) for modifier in obj.modifiers if modifier.type == "NODES"]
    return next((modifier for modifier, group in groups if group and group.name.startswith(name)), None)


def _uses(modifier, names):
    group = modifier.node_group if modifier.type == "NODES" else None
    return group is not None and group.name in names


@contextmanager
def hidden(modifiers):
    """Evaluate without modifiers for a while."""
    with ExitStack() as restored:
        for modifier in modifiers:
            if modifier.show_viewport:
                restored.callback(setattr, modifier, "show_viewport", True)
                modifier.show_viewport = False
        yield


def input_value(modifier, name):
    """The value of an input of a geometry nodes modifier, or None."""
    holder, key = input_property(modifier, name)
    return holder.value if key == "value" else modifier.get(key[2:-2])


def input_property(modifier, name):
    """Owner and name of the property that holds an input of a geometry nodes modifier, for layouts."""
    identifier = modifier.node_group.interface.items_tree[name].identifier
    if hasattr(modifier, "properties"):  # from Blender 5.2 on
        return getattr(modifier.properties.inputs, identifier), "value"
    return modifier, f'["{identifier}"]'
