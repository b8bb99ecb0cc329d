# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets on patterns that are there and on others, numbered stripes, thumbnails, and the library of assets."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.looks import assets
from synch_fields.synch_addon.looks.presets import PRESETS
from synch_fields.synch_addon.operators.presets import SYNCH_OT_preset
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.other_settings import shows_other_settings

from ..scenes import attribute, grid, make_active, quad_sphere, save_and_reopen, snapshot, sphere, torus

OF_STRIPES = [name for name, preset in PRESETS.items() if preset.kind == "stripes"]


def phases(obj):
    return {a.name: attribute(obj, a.name).tobytes() for a in obj.data.attributes if a.name.startswith("synch_phase")}


def test_every_preset_is_shown_on_the_pattern_that_is_there():
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    before = phases(obj)
    for name in OF_STRIPES:
        report = api.preset(obj, name)
        assert report["solve"] is None and phases(obj) == before
        (material,) = obj.data.materials
        assert material.name == report["material"] == f"Synch {PRESETS[name].label}"
        assert api.preset(obj, name)["material"] == material.name  # and no second one is made
    assert len(bpy.data.materials) == len(OF_STRIPES) + 1
    assert api.stripes(obj, spacing=0.5) and obj.data.materials[0] == material  # another solve leaves it
    obj = quad_sphere()
    api.quads(obj, spacing=1.0)
    before = phases(obj)
    assert api.preset(obj, "cane")["solve"] is None and phases(obj) == before
    assert [slot.material.name for slot in obj.material_slots] == ["Synch Woven Cane"]


@pytest.mark.parametrize("first, name", [("quads", "zebra"), ("stripes", "cane"), (None, "wood-cut"), (None, "cane")])
def test_a_preset_of_another_pattern_is_solved_for(first, name):
    obj = torus()
    if first:
        getattr(api, first)(obj, spacing=1.0)
    report = api.preset(obj, name)
    preset = PRESETS[name]
    assert report["solve"]["command"] == preset.kind
    assert report["solve"]["settings"]["guidance"] == preset.settings.get("guidance", "smooth")
    assert ("synch_phase" in obj.data.attributes) == (preset.kind == "stripes")
    assert [slot.material.name for slot in obj.material_slots] == [f"Synch {preset.label}"]


def test_settings_and_solve_ask_for_a_new_pattern():
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    assert api.preset(obj, "zebra", solve=True)["solve"]["settings"]["spacing"] != pytest.approx(0.4)
    assert api.preset(obj, "zebra", spacing=0.7, seed=3)["solve"]["settings"]["spacing"] == 0.7


@pytest.mark.parametrize("name", PRESETS)
def test_what_is_seen_varies_over_the_surface(name, tmp_path):
    """As Cycles bakes it."""
    obj = torus()
    api.preset(obj, name, spacing=1.0 if name == "cane" else 0.5, method="spectral")
    report = api.bake(obj, maps="colour,height", size=64, samples=1, unwrap=True, folder=str(tmp_path))
    for entry in report["maps"].values():
        values = pixels(entry["file"])
        seen = values[values[:, :3].max(axis=1) > 0, :3]
        assert np.ptp(seen, axis=0).max() > 0.3 and len(np.unique(seen.round(2), axis=0)) > 20


def pixels(path):
    image = bpy.data.images.load(str(path))
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(-1, 4)


def test_other_materials_keep_their_slots():
    obj = grid()
    steel = bpy.data.materials.new("steel")
    obj.data.materials.append(steel)
    obj.data.materials.append(bpy.data.materials.new("glass"))
    obj.data.polygons[0].material_index = 1
    api.preset(obj, "zebra", spacing=0.5)
    assert [material.name for material in obj.data.materials] == ["steel", "glass", "Synch Zebra"]
    assert obj.data.polygons[0].material_index == 1


def test_operator_shows_and_undoes():
    sphere(3)
    bpy.ops.ed.undo_push(message="before")
    before = snapshot()
    assert bpy.ops.synch.preset(preset="wood-cut") == {"FINISHED"}
    stored = bpy.context.active_object.synch
    assert (stored.guidance, stored.symmetry, stored.automatic_spacing) == ("CURVATURE_MIN", "LINE", False)
    assert bpy.ops.synch.preset(preset="corduroy", solve=True) == {"FINISHED"}
    assert (stored.guidance, stored.guide.axis) == ("AXIS", "Z")
    assert bpy.ops.synch.preset(preset="knit") == {"FINISHED"}
    assert attribute(bpy.context.active_object, "synch_number").any()
    assert bpy.context.active_object.active_material.name == "Synch Knit Ribs"
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert snapshot() == before


@pytest.mark.parametrize("name", ["zebra", "knit", "cane"])
def test_presets_are_solved_and_shown_in_edit_mode(name):
    obj = sphere(2)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.synch.preset(preset=name) == {"FINISHED"} and obj.mode == "EDIT"
    assert obj.active_material.name == f"Synch {PRESETS[name].label}"
    assert bpy.ops.synch.preset(preset="corduroy") == {"FINISHED"} and obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert obj.active_material.name == "Synch Corduroy" and attribute(obj, "synch_number").any()


@pytest.mark.parametrize("given", [{}, {"preset": "fingerprint"}])
def test_a_key_map_chooses_the_preset_and_a_bare_button_shows_that_of_the_scene(given):
    """As the window invokes the operator, which Blender does not without one."""
    bpy.context.scene.synch_preset = "knit"
    operator = SimpleNamespace(
        preset=given.get("preset", "zebra"),
        properties=SimpleNamespace(is_property_set=given.__contains__),
        _begin=lambda context: {"FINISHED"},
        _reporting=lambda step, context: step(context),
    )
    assert SYNCH_OT_preset.invoke(operator, bpy.context, None) == {"FINISHED"}
    assert operator.preset == given.get("preset", "knit")


def test_the_panel_offers_every_preset_and_settings_of_a_script_count():
    obj = torus()
    for name in PRESETS:
        bpy.context.scene.synch_preset = name
        assert bpy.context.scene.synch_preset == name
    assert bpy.ops.synch.preset(preset="cane", method="SPECTRAL", seed=5, spacing=0.9) == {"FINISHED"}
    assert [slot.material.name for slot in obj.material_slots] == ["Synch Woven Cane"]
    kept = memory.recall(obj).plain["settings"]
    assert (kept["method"], kept["seed"], kept["symmetry"]) == ("spectral", 5, "cross")
    assert kept["spacing"] == obj.synch.spacing == pytest.approx(0.9)


def test_unknown_presets_and_bare_objects_are_refused():
    obj = grid()
    before = snapshot()
    with pytest.raises(SettingError, match="the preset 'tartan' is unknown: use one of zebra, corduroy"):
        api.preset(obj, "tartan")
    with pytest.raises(SettingError, match="the setting 'width' is unknown"):
        api.preset(obj, "zebra", width=0.3)
    with pytest.raises(SynchError, match="stripes are numbered: solve stripes first"):
        api.number_stripes(obj)
    assert snapshot() == before


# Numbers


def test_numbers_follow_later_solves_and_go_with_the_stripes():
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    assert "synch_number" not in obj.data.attributes
    assert bpy.ops.synch.number_stripes() == {"FINISHED"}
    count = api.number_stripes(obj)
    assert count == api.isolines(obj)["lines"] == np.abs(attribute(obj, "synch_number")).max()
    make_active(obj)
    api.stripes(obj, spacing=0.25)
    assert np.abs(attribute(obj, "synch_number")).max() == api.isolines(obj)["lines"] != count
    make_active(obj)
    bpy.ops.synch.variation(number=1)
    assert np.abs(attribute(obj, "synch_number")).max() == api.isolines(obj)["lines"]
    api.quads(obj, spacing=0.8)
    assert not {"synch_number", "synch_along"} & set(obj.data.attributes.keys())
    with pytest.raises(SynchError, match="solve stripes first"):
        api.number_stripes(obj)
    with pytest.raises(RuntimeError, match="has no stripes: solve them first"):
        bpy.ops.synch.number_stripes()


def test_numbered_presets_do_without_a_solve_as_long_as_the_numbers_are_there(tmp_path):
    obj = sphere(3)
    api.preset(obj, "knit")
    obj = save_and_reopen(tmp_path / "file.blend", obj.name)
    assert not memory.holds(obj)
    assert api.preset(obj, "corduroy")["solve"] is None
    for name in ("synch_number", "synch_along"):
        obj.data.attributes.remove(obj.data.attributes[name])
    assert api.preset(obj, "zebra")["solve"] is None
    assert api.preset(obj, "knit")["solve"] is not None


# What ships


def test_thumbnails_are_there_and_show_different_things():
    names = [*PRESETS, *(thumbnail for _, thumbnail in assets.GROUPS.values())]
    seen = [pixels(assets.THUMBNAILS / f"{name}.png") for name in names]
    assert {len(values) for values in seen} == {128 * 128}
    for number, values in enumerate(seen):
        assert values[:, :3].std() > 0.1
        assert all(np.abs(values - other).mean() > 0.02 for other in seen[:number])
    assert sum((assets.THUMBNAILS / f"{name}.png").stat().st_size for name in names) < 400_000


def test_the_library_holds_every_preset_and_group_as_assets(tmp_path):
    path = assets.write_library(tmp_path)
    catalogs = dict(
        line.split(":")[:2] for line in (tmp_path / assets.CATALOGS).read_text().splitlines() if ":" in line
    )
    assert sorted(catalogs.values()) == ["Synch Fields/Materials", "Synch Fields/Node Groups"]
    assert "CC0" in (tmp_path / "LICENSE.txt").read_text()
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(path), assets_only=True) as (there, here):
        here.materials, here.node_groups = there.materials, there.node_groups
    assert sorted(m.name for m in bpy.data.materials) == sorted(f"Synch {preset.label}" for preset in PRESETS.values())
    marked = [group for group in bpy.data.node_groups if group.asset_data]
    assert sorted(group.name for group in marked) == sorted(assets.GROUPS)
    for block in (*bpy.data.materials, *marked):
        tree = block if block in marked else block.node_tree
        assert all(link.is_valid for link in tree.links)
        assert not any(node.bl_idname == "NodeUndefined" for node in tree.nodes)
        assert block.asset_data.catalog_id in catalogs and block.asset_data.license == "CC0-1.0"
        picture = np.empty(4 * 128 * 128, np.float32)
        block.preview.image_pixels_float.foreach_get(picture)
        assert picture.reshape(-1, 4)[:, :3].std() > 0.1
    # A material from the library is that of the preset.
    obj = sphere(3)
    assert api.preset(obj, "zebra", spacing=0.5)["material"] == "Synch Zebra"
    assert len(bpy.data.materials) == len(PRESETS) + 1  # the other is the one of the solve


def values_of(thing):
    """What a user could set of a node or a socket, numbers as the file has them."""
    found = {}
    for name, kind in thing.bl_rna.properties.items():
        if kind.type in ("BOOLEAN", "INT", "FLOAT", "STRING", "ENUM") and not kind.is_readonly:
            value = getattr(thing, name)
            found[name] = tuple(value) if kind.type != "STRING" and getattr(kind, "array_length", 0) else value
    return found


def drawn(tree):
    """Nodes, sockets and links of a tree, and of the trees in it."""
    nodes = {
        node.name: (
            node.bl_idname,
            values_of(node) | {"location": None},
            [(socket.identifier, values_of(socket)) for socket in (*node.inputs, *node.outputs)],
            drawn(node.node_tree) if getattr(node, "node_tree", None) else None,
        )
        for node in tree.nodes
    }
    links = {
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    }
    return nodes, links


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="the library is made by Blender 4.5, and compared there")
def test_the_library_that_ships_is_what_the_code_makes(tmp_path):
    found = []
    for path in (assets.FOLDER / assets.FILE, assets.write_library(tmp_path)):
        bpy.ops.wm.read_homefile(use_empty=True)
        with bpy.data.libraries.load(str(path), assets_only=True) as (there, here):
            here.materials, here.node_groups = there.materials, there.node_groups
        found.append({m.name: drawn(m.node_tree) for m in bpy.data.materials})
        found[-1] |= {group.name: drawn(group) for group in bpy.data.node_groups if group.asset_data}
        for name in (assets.CATALOGS, "LICENSE.txt"):
            assert (path.parent / name).read_text() == (assets.FOLDER / name).read_text()
    assert len(found[0]) == len(PRESETS) + len(assets.GROUPS)
    assert found[0] == found[1], "make it anew: make library VENV=.venv-3.11"


def test_the_library_is_listed_in_the_preferences_only_when_asked(tmp_path, monkeypatch):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    before = len(libraries)
    monkeypatch.setattr(assets, "FOLDER", tmp_path)
    assets.write_library(tmp_path)
    assert not assets.is_registered(bpy.context.preferences)
    for _ in range(2):
        assert bpy.ops.synch.asset_library() == {"FINISHED"}
        assert assets.is_registered(bpy.context.preferences) and len(libraries) == before + 1
    libraries.remove(libraries[-1])


def test_the_picture_is_that_of_the_look_that_is_shown():
    obj, scene = sphere(3), bpy.context.scene
    assert scene.synch_preset == "plain"
    api.stripes(obj, spacing=0.4)
    (plain,) = obj.data.materials
    for name in ("zebra", "knit"):
        api.preset(obj, name)
        assert scene.synch_preset == name
    assert bpy.ops.synch.plain_look() == {"FINISHED"}
    assert scene.synch_preset == "plain" and list(obj.data.materials) == [plain]
    api.quads(obj, spacing=0.8)
    api.preset(obj, "cane")
    assert scene.synch_preset == "cane"
    assert bpy.ops.synch.plain_look() == {"FINISHED"} and scene.synch_preset == "plain"
    assert obj.active_material.name == "Synch Quads"
    make_active(grid())
    assert not bpy.ops.synch.plain_look.poll()


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("corduroy", {}),
        ("wood-cut", {}),
        ("zebra", {}),
        ("zebra", {"guidance": "axis:X=3"}),
        ("zebra", {"guidance": "curvature-min=2,axis:Z"}),
    ],
)
def test_a_preset_that_was_just_solved_is_of_the_settings_of_the_panel(name, given):
    obj = sphere(3)
    assert bpy.ops.synch.preset(preset=name, **given) == {"FINISHED"}
    assert not shows_other_settings(obj, "stripes")
    obj.synch.guidance = "CURVATURE_MAX"
    assert shows_other_settings(obj, "stripes")


def test_a_preset_counts_lines_across_an_object_that_a_script_has_just_scaled():
    spacings = []
    for scale in (1, 2):
        obj = sphere(3)
        obj.scale = (scale,) * 3
        spacings.append(api.preset(obj, "zebra")["solve"]["settings"]["spacing"])
    assert spacings[1] == pytest.approx(2 * spacings[0])
