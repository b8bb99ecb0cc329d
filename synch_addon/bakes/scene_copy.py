# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary scene with a copy of the object, which is unwrapped there, and baked by Cycles.

The object itself keeps its materials, image nodes, UV maps and visibility, and its scene its settings, even if a bake
fails or is interrupted.
"""

from contextlib import contextmanager

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.interrupts import hold_interrupts
from ..blender.attributes import read_all
from ..blender.pattern_surface import surface_modifier, surface_of
from ..blender.transaction import only_for_now
from ..blender.translations import operator_error
from .cycles_bake import baked

# Angle from which Smart UV Project makes a seam, radians: Blender's default.
_SEAM_ANGLE = 1.1519173


class SceneCopy:
    """A scene with a copy of an object, ready to bake it.

    Attributes
    ----------
    obj : the copy, whose materials may be replaced
    scene : its scene
    """

    def __init__(self, obj, scene):
        self.obj, self.scene = obj, scene

    def prepare(self, materials, size, samples):
        """Show materials with an image that is baked to, one material for each slot of the object."""
        image = bpy.data.images.new("Synch Bake", size, size, float_buffer=True, is_data=True)
        for slot, material in zip(self.obj.material_slots, materials, strict=True):
            node = material.node_tree.nodes.new("ShaderNodeTexImage")
            node.image = image
            material.node_tree.nodes.active = node
            slot.material = material
        self.scene.cycles.samples = samples

    def bake(self, kind, margin):
        """(size, size, 4) float32 values of a bake of what was prepared, see :func:`.cycles_bake.baked`."""
        try:
            with hold_interrupts():
                return baked(self.scene, kind, margin)
        except RuntimeError as error:
            raise SynchError(f"Cycles cannot bake {self.obj.name}: {operator_error(error).splitlines()[0]}") from error

    def use_map(self, name, coordinates):
        """Bake over the UV map of this name from now on; it is made if it is missing.

        Blender takes the tangents of normals from the active map, whatever map it bakes over.
        """
        layers = self.obj.data.uv_layers
        layer = layers.get(name) or layers.new(name=name, do_init=False)
        write_uv(layer, coordinates)
        layers.active = layers[name]

    def unwrapped(self, margin):
        """(c, 2) UV coordinates of the corners by Smart UV Project; ``margin`` between islands, a share of the map."""
        layer = self.obj.data.uv_layers.new(name="Synch Bake", do_init=False)
        layer.active = True
        with self._context():
            bpy.ops.object.mode_set(mode="EDIT")
            try:
                with bpy.context.temp_override(edit_object=self.obj):
                    bpy.ops.mesh.reveal(select=True)
                    bpy.ops.mesh.select_all(action="SELECT")
                    bpy.ops.uv.smart_project(
                        angle_limit=_SEAM_ANGLE, margin_method="FRACTION", island_margin=margin, scale_to_bounds=False
                    )
            finally:
                bpy.ops.object.mode_set(mode="OBJECT")
        coordinates = read_uv(self.obj.data.uv_layers.active)
        return coordinates / max(coordinates.max(initial=0.0), 1.0)  # many islands far apart do not fit

    def _context(self):
        return bpy.context.temp_override(
            scene=self.scene,
            view_layer=self.scene.view_layers[0],
            active_object=self.obj,
            object=self.obj,
            selected_objects=[self.obj],
            selected_editable_objects=[self.obj],
        )


@contextmanager
def make_scene_copy(obj, modifiers=True):
    """A :class:`SceneCopy` for a copy of an object in object mode, with or without its modifiers."""
    with only_for_now():
        scene = bpy.data.scenes.new("Synch Bake")
        scene.frame_set(bpy.context.scene.frame_current, subframe=bpy.context.scene.frame_subframe)
        copy = obj.copy()
        copy.data = surface_of(obj).data.copy()
        bound = surface_modifier(copy)
        if bound is not None:  # its mesh replaces the result of the modifiers before it
            for modifier in copy.modifiers[: copy.modifiers.find(bound.name) + 1]:
                copy.modifiers.remove(modifier)
        copy.hide_render = copy.hide_viewport = copy.hide_select = False
        if not copy.material_slots:
            copy.data.materials.append(None)
        if not modifiers:
            copy.modifiers.clear()
        scene.collection.objects.link(copy)
        scene.view_layers[0].objects.active = copy
        copy.select_set(True, view_layer=scene.view_layers[0])
        scene.render.engine = "CYCLES"
        scene.cycles.device = "CPU"
        scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
        yield SceneCopy(copy, scene)


def read_uv(layer):
    """(c, 2) coordinates of a UV map."""
    return read_all(layer.uv, "vector", 2, np.float32)


def write_uv(layer, values):
    """Set all coordinates of a UV map."""
    layer.uv.foreach_set("vector", np.ascontiguousarray(values, np.float32).ravel())
