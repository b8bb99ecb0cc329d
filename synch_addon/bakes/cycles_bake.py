# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake by Cycles of a scene with one object: in this process, or as a program in one of its own.

The program, ``cycles_bake.py SCENE.blend KIND MARGIN VALUES.npy``, imports nothing of the extension.
"""

import sys

import bpy
import numpy as np


def baked(scene, kind, margin):
    """(size, size, 4) float32 values of the image in the materials of the scene's only object, the lowest row first.

    ``kind``: "EMIT" or "NORMAL"; ``margin``: pixels.
    """
    (obj,), layer = scene.collection.objects, scene.view_layers[0]
    layer.objects.active = obj
    obj.select_set(True, view_layer=layer)
    seen = {"active_object": obj, "object": obj, "selected_objects": [obj], "selected_editable_objects": [obj]}
    with bpy.context.temp_override(scene=scene, view_layer=layer, **seen):
        bpy.ops.object.bake(
            type=kind,
            margin=margin,
            target="IMAGE_TEXTURES",
            save_mode="INTERNAL",
            use_clear=True,
            use_selected_to_active=False,
            normal_space="TANGENT",
            normal_r="POS_X",
            normal_g="POS_Y",
            normal_b="POS_Z",
        )
    image = obj.material_slots[0].material.node_tree.nodes.active.image
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def _main(source, kind, margin, target):
    with bpy.data.libraries.load(source) as (stored, wanted):
        wanted.scenes = stored.scenes
    (scene,) = wanted.scenes
    np.save(target, baked(scene, kind, int(margin)))


if __name__ == "__main__":
    _main(*sys.argv[-4:])
