# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every main operator on a small object, in other languages than English: `tests/ui/test_languages.py` runs them. In
English the tests of each operator do."""

import os

import bpy
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.flows.job import clebsch
from synch_fields.synch_addon.looks.presets import PRESETS
from synch_fields.synch_addon.looks.render import render_picture

from .baked_images import bake
from .scenes import grid, make_active, sphere
from .solid_objects import block
from .vortex_scenes import QUICK, write_npz

pytestmark = pytest.mark.skipif("SYNCH_LANGUAGE" not in os.environ, reason="for other languages than English")
SPACING = {"stripes": 0.6, "quads": 0.8}


@pytest.mark.parametrize("kind", SPACING)
def test_a_pattern_and_all_that_is_made_of_it(kind, tmp_path):
    obj = sphere()
    obj.synch.automatic_spacing, obj.synch.spacing = False, SPACING[kind]
    finished = [bpy.ops.synch.directions(), getattr(bpy.ops.synch, kind)(), bpy.ops.synch.variation(number=1)]
    finished += [bpy.ops.synch.keep_favourite(), bpy.ops.synch.carry(), bpy.ops.synch.isolines()]
    (material,) = obj.data.materials
    assert any(link.to_node.bl_idname == "ShaderNodeOutputMaterial" for link in material.node_tree.links)
    make_active(obj)
    finished += [bpy.ops.synch.relief(), bpy.ops.synch.select_defects()]
    bpy.ops.object.mode_set(mode="OBJECT")
    if kind == "stripes":
        finished.append(bpy.ops.synch.number_stripes())
    assert finished == [{"FINISHED"}] * len(finished)
    bake(obj, tmp_path, size=64)
    render_picture(obj, tmp_path / "picture.png", resolution=(32, 32), samples=1)
    assert (tmp_path / "picture.png").exists() and len(list(tmp_path.iterdir())) >= 3


@pytest.mark.parametrize("name", PRESETS)
def test_material_presets(name):
    obj = sphere()
    assert bpy.ops.synch.preset(preset=name) == {"FINISHED"}
    assert obj.data.materials


def test_quad_meshes():
    obj = sphere()
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.4
    assert bpy.ops.synch.quad_mesh() == {"FINISHED"}
    assert bpy.context.object.name == f"{obj.name} Quads"


def test_layers_and_their_volume(tmp_path):
    obj = block()
    assert api.layers(obj, guidance="axis:Z", spacing=0.3, size=0.1)["layers"] == 3
    make_active(obj)
    assert bpy.ops.synch.layer_volume(filepath=str(tmp_path / "layers.vdb"), resolution=16) == {"FINISHED"}


@pytest.mark.parametrize("show", ["filaments", "tubes"])
def test_vortices(show, tmp_path):
    assert clebsch(write_npz(tmp_path / "ring.npz"), show=show, **QUICK)["gap"] < 0.06


def test_lists_maps_samples_and_subdivision():
    obj = grid()
    finished = [bpy.ops.synch.guide_add(), bpy.ops.synch.guide_remove()]
    finished += [bpy.ops.synch.constraint_add(), bpy.ops.synch.constraint_remove()]
    finished += [bpy.ops.synch.refine(), bpy.ops.synch.add_sample(shape="SUZANNE")]
    make_active(obj)
    finished.append(bpy.ops.synch.paint_map(target="SPACING"))
    assert finished == [{"FINISHED"}] * len(finished)
