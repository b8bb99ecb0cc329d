# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Names as other languages and other people give them: nothing that we have made is found by one of Blender's names.

Blender as a module has no translations, so names of nodes, materials and objects are replaced by random ones between
the steps, which is more than any language does; where this Blender has languages, one of them is chosen as well.
"""

from contextlib import suppress

import bpy

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api

from .fuzz_cases import COUNTS, check_line, empty_scene, st, tried
from .fuzz_texts import hostile_texts
from .scenes import make_active, sphere

LANGUAGES = sorted(bpy.app.translations.locales) or [bpy.context.preferences.view.language]
STEPS = {
    "stripes": lambda obj: api.stripes(obj, spacing=0.7, method="spectral"),
    "quads": lambda obj: api.quads(obj, spacing=0.7, method="spectral"),
    "quad_mesh": lambda obj: api.quad_mesh(obj, spacing=0.7, method="spectral", smoothing=0),
    "isolines": api.isolines,
    "relief": api.relief,
    "preset": lambda obj: bpy.ops.synch.preset(preset="zebra") if obj else None,
    "bake": lambda obj: api.bake(obj, size=16, maps="mask"),
}


def rename_all(text):
    """Give everything that has a name of Blender's in a material or a tree another one, and objects and meshes, too."""
    materials = [material.node_tree for material in bpy.data.materials if material.node_tree]
    nodes = [node for tree in (*materials, *bpy.data.node_groups) for node in tree.nodes]
    for number, thing in enumerate((*nodes, *bpy.data.materials, *bpy.data.objects, *bpy.data.meshes)):
        with suppress(UnicodeError, ValueError, TypeError):
            thing.name = f"{text}{number}"


@tried(
    st.sampled_from(LANGUAGES),
    st.sampled_from(["stripes", "quads"]),
    st.lists(st.tuples(st.sampled_from(sorted(STEPS)), hostile_texts), min_size=1, max_size=2),
)
def test_no_step_depends_on_a_name(language, first, steps):
    bpy.context.preferences.view.language = language
    bpy.context.preferences.view.use_translate_new_dataname = True
    empty_scene()
    obj = sphere(2)
    assert STEPS[first](obj)["status"]
    for name, text in steps:
        rename_all(text)
        make_active(obj)
        try:
            STEPS[name](obj)
            COUNTS[f"renamed, then {name} done"] += 1
        except (SynchError, RuntimeError) as error:  # RuntimeError is what an operator reports
            check_line(str(error).removeprefix("Error: ").strip())
            COUNTS[f"renamed, then {name} refused"] += 1
            assert name in ("isolines", "relief", "bake", "preset"), error
    assert STEPS["stripes"](obj)["status"]
    (output,) = [
        node for node in obj.data.materials[-1].node_tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial"
    ]
    assert output.inputs[0].links
