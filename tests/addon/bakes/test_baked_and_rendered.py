# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is baked is what is rendered: the mask beside a picture of the material, taken over the same texels."""

import numpy as np
import pytest

from synch_fields.synch_addon.bakes.shaders import pattern_node
from synch_fields.synch_addon.nodes.canvas import find_node

from ..baked_images import bake, patterned, picture, rasterised
from ..scenes import add_object, attribute
from ..single_faces import VIEW_WIDTH, rendered

SIZE = 512
LOOKS = {"thin": {"Width": 0.2}, "soft": {"Softness": 0.3}}


def unfolded(obj):
    """The faces of an object laid out in the camera's view as they lie in the baked map, with all that shaders read."""
    starts = [(face.loop_start, face.loop_start + face.loop_total) for face in obj.data.polygons]
    places = np.pad((attribute(obj, "Synch Bake") - 0.5) * VIEW_WIDTH, ((0, 0), (0, 1)))
    flat = add_object(places, [range(*face) for face in starts], "Unfolded")
    for given in obj.data.attributes:
        if given.name.startswith("synch") and given.domain in ("CORNER", "FACE"):
            values = flat.data.attributes.new(given.name, given.data_type, given.domain).data
            name = {"FLOAT_VECTOR": "vector", "FLOAT2": "vector", "FLOAT_COLOR": "color"}.get(given.data_type, "value")
            values.foreach_set(name, attribute(obj, given.name).ravel())
    return flat


def glowing(material):
    """A copy of a material that glows with what it links to its shader as base colour, and nothing else."""
    copy = material.copy()
    tree = copy.node_tree
    (link,) = find_node(tree, "ShaderNodeBsdfPrincipled").inputs["Base Color"].links
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(link.from_socket, glow.inputs["Color"])
    tree.links.new(glow.outputs[0], find_node(tree, "ShaderNodeOutputMaterial").inputs["Surface"])
    return copy


@pytest.mark.parametrize("kind, look", [("stripes", "soft"), ("quads", "thin")])
def test_mask_is_the_rendered_material_at_every_texel(kind, look, tmp_path):
    """Black and white, the material shows its mask; also in the faces of defects, and at the edges of stripes."""
    obj = patterned(kind)
    (material,) = obj.data.materials
    group = pattern_node(material, kind)
    group.inputs["Color"].default_value, group.inputs["Background"].default_value = (1, 1, 1, 1), (0, 0, 0, 1)
    for name, value in LOOKS[look].items():
        group.inputs[name].default_value = value
    bake(obj, tmp_path, maps="mask", size=SIZE)
    baked = picture(tmp_path / "mask.png", SIZE)[:, :, 0]
    flat = unfolded(obj)
    flat.data.materials.append(glowing(material))
    obj.hide_render = True
    seen = rendered(tmp_path, pixels=SIZE)
    rows, columns = rasterised(obj, SIZE)[0].T
    off = np.abs(baked - seen)[rows, columns]
    assert len(off) > 0.3 * SIZE**2 and 0.1 < baked[rows, columns].mean() < 0.9
    assert off.mean() < 0.5 / 255 and off.max() < 0.05
