# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of layers: what it shows before a solve, and that the operator takes what it stores."""

import re
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import numpy as np
import pytest

from synch_fields.core.geometry.filling.closed_surface import Area
from synch_fields.core.geometry.filling.lengths import estimate
from synch_fields.core.tasks.solids import TET_SECONDS
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes
from synch_fields.synch_addon.blender.schema import LAYER
from synch_fields.synch_addon.jobs.queue import Work
from synch_fields.synch_addon.nodes.layers import layer_colors
from synch_fields.synch_addon.operators.layers import SYNCH_OT_layers
from synch_fields.synch_addon.panels import overlay
from synch_fields.synch_addon.panels.layers import SYNCH_PT_layers
from synch_fields.synch_addon.solids import memory
from synch_fields.synch_addon.solids.expected import measures_of
from synch_fields.synch_addon.solids.properties import LENGTHS, LayerProperties, SynchLayering
from synch_fields.synch_addon.solids.surface import read_surface

from ..scenes import add_group, make_active
from ..solid_objects import bent_bar, block, made


def drawn():
    """The texts of the labels that the panel draws, and the names of its settings, some of them in rows."""
    layout = MagicMock()
    SYNCH_PT_layers.draw(SimpleNamespace(layout=layout), bpy.context)
    calls = layout.mock_calls
    labels = [call.kwargs["text"] for call in calls if call[0].endswith("label")]
    settings = [call.args[1] for call in calls if call[0].endswith(".prop") or call[0] == "prop"]
    return labels, settings


def taken(stored):
    """The operator's values after it took those of the panel; lengths that are not set are missing."""
    properties = {name: None for name in LayerProperties.__annotations__}
    operator = MagicMock()
    operator._target.return_value.synch_layering = stored
    operator.properties.property_unset.side_effect = properties.pop
    SYNCH_OT_layers._take(operator, bpy.context)
    return {name: getattr(operator, name) for name in (*properties, "guidance", "groups")}


@pytest.mark.parametrize("size", [None, 0.07])
def test_the_panel_tells_beforehand_how_many_tetrahedra_there_will_be(size):
    obj = bent_bar(faces=(24, 6, 8))
    obj.scale = (1.5, 1, 1)
    bpy.context.view_layer.update()
    if size is not None:
        obj.synch_layering.automatic_size, obj.synch_layering.size = False, size
    text = "\n".join(drawn()[0])
    found = re.search(r"About ([\d,]+) tetrahedra\nAbout (\d+) s, ([\d,]+) MB", text)
    count, seconds = int(found[1].replace(",", "")), int(found[2])
    assert seconds == pytest.approx(max(TET_SECONDS * count * Work._paces.get("Layers", 1.0), 1), abs=0.6)
    surface = read_surface(obj)
    assert count == pytest.approx(estimate(surface.distance, size).tets, rel=0.02)
    if size is not None:
        assert count == pytest.approx(surface.filled(size).solid.tet_count, rel=0.1)


def test_the_panel_says_how_many_tetrahedra_thin_walls_between_groups_may_add():
    obj = block((1, 1, 0.12), (4, 4, 1))
    places = np.array([vertex.co for vertex in obj.data.vertices])
    low, high = (np.flatnonzero(places[:, 2] * side > 0) for side in (-1, 1))
    obj.synch_layering.automatic_size, obj.synch_layering.size = False, 0.1
    assert "thin walls" not in "\n".join(drawn()[0])
    for name, members in (("Low", low), ("High", high)):
        add_group(obj, name, members)
        obj.synch_layering.groups.add().group = name
    found = re.search(r"About ([\d,]+) tetrahedra\nUp to ([\d,]+) with thin walls", "\n".join(drawn()[0]))
    least, most = (int(text.replace(",", "")) for text in found.groups())
    surface = read_surface(obj)
    up = surface.mesh.face_normals[:, 2]
    areas = [Area("Low", np.flatnonzero(up < -0.9)), Area("High", np.flatnonzero(up > 0.9))]
    assert 1.3 * least < surface.filled(0.1, areas).solid.tet_count <= 1.1 * most


@pytest.mark.parametrize(
    "height",
    [
        lambda x, y: 0.2 * np.sin(3 * x + y),
        lambda x, y: 0.5 * (x**2 - y**2),
        lambda x, y: 0.3 * x * y,
        lambda x, y: 0 * x,
    ],
)
def test_the_panel_is_drawn_for_open_meshes(height):
    """Their signed volume is a rounding error, or the difference of the parts above and below their centre."""
    assert bpy.ops.mesh.primitive_grid_add(x_subdivisions=12, y_subdivisions=10) == {"FINISHED"}
    obj = bpy.context.object
    for vertex in obj.data.vertices:
        vertex.co.z = height(*vertex.co[:2])
    obj.synch_layering.guide = "HARMONIC"
    labels, settings = drawn()
    assert "guide" in settings and not any("nan" in label for label in labels)


def test_the_operator_takes_what_the_panel_stores():
    obj = block()
    stored = obj.synch_layering
    assert taken(stored)["guidance"] == "axis:Z" and not set(LENGTHS) & set(taken(stored))
    stored.guide, stored.low, stored.high = "HARMONIC", "Bottom", "a:b"
    row = stored.groups.add()
    row.group, row.wish = "Top", "CONSTANT"
    stored.groups.add().group = ""
    stored.automatic_spacing, stored.spacing, stored.seed = False, 0.25, 3
    values = taken(stored)
    assert (values["guidance"], values["groups"]) == ('harmonic:Bottom:"a:b"', "Top=constant")
    assert values["spacing"] == 0.25 and "size" not in values and values["seed"] == 3


def test_rows_of_groups_come_and_go_by_their_buttons():
    obj = block()
    for _ in range(2):
        assert bpy.ops.synch.layer_group_add() == {"FINISHED"}
    obj.synch_layering.groups[0].group = "Bottom"
    assert bpy.ops.synch.layer_group_remove(number=0) == {"FINISHED"}
    assert [row.group for row in obj.synch_layering.groups] == ["Top"]
    assert bpy.ops.synch.layer_group_remove(number=5) == {"CANCELLED"}
    assert drawn()[1].count("wish") == 1


def test_the_layers_show_the_settings_of_the_object_that_they_fill():
    obj = block()
    report = api.layers(obj, spacing=0.3, size=0.14)
    make_active(made(report))
    assert "Layers of Block" in drawn()[0] and memory.holds_layers(obj)
    assert not any("hidden" in label for label in drawn()[0])  # as it should be
    bpy.data.objects.remove(obj)
    assert not any(label.startswith("Layers of") for label in drawn()[0])


def test_the_panel_of_an_empty_scene_says_what_to_select():
    bpy.context.view_layer.objects.active = None
    assert drawn()[0] == ["Select a mesh object"]
    assert SynchLayering.bl_rna.properties["guide"].description


def test_solid_view_shows_layers_in_the_colours_of_their_material():
    obj = block()
    shown = made(api.layers(obj, spacing=0.3, size=0.14))
    ((corners, colours),) = overlay.layer_faces(shown)
    layers = attributes.read(shown, LAYER)
    assert corners.shape == (len(shown.data.polygons), 3, 3) and colours.shape == (len(corners), 4)
    assert len(np.unique(colours, axis=0)) == len(np.unique(layers)) > 2
    every = layer_colors(np.arange(41))[:, :3].sum(axis=1)  # every other one is darker than both beside it
    assert (every[1::2] < np.minimum(every[:-1:2], every[2::2])).all()
    assert overlay.layer_faces(obj) == []


@pytest.mark.parametrize("name", LENGTHS)
def test_a_length_that_is_no_longer_automatic_begins_at_the_one_that_is_used(name):
    stored = block().synch_layering
    shown, button = f"shown_{name}", f"shown_{name}_auto"
    expected = getattr(stored, shown)
    used = api.layers(bpy.context.object)["settings"][name]
    assert getattr(stored, button) and expected == pytest.approx(used, rel=0.02)
    setattr(stored, shown, expected)  # Enter in the field
    assert getattr(stored, button)
    setattr(stored, button, False)
    assert not getattr(stored, LENGTHS[name]) and getattr(stored, name) == pytest.approx(expected)
    setattr(stored, shown, 2 * expected)
    assert getattr(stored, name) == pytest.approx(2 * expected)
    setattr(stored, button, True)
    assert getattr(stored, LENGTHS[name]) and getattr(stored, shown) == pytest.approx(expected)


def test_lengths_of_what_encloses_nothing_are_not_known():
    assert bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4) == {"FINISHED"}
    stored = bpy.context.object.synch_layering
    assert stored.shown_spacing == 0
    stored.shown_spacing_auto = False
    assert stored.automatic_spacing


def test_the_volume_is_measured_again_where_only_vertices_inside_the_box_have_moved():
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    obj = bpy.context.active_object
    before = measures_of(obj).volume
    places = np.array([vertex.co for vertex in obj.data.vertices])
    places[np.abs(places).max(axis=1) < 0.95] *= 0.5
    obj.data.vertices.foreach_set("co", places.astype(np.float32).ravel())
    obj.data.update()
    bpy.context.view_layer.update()
    assert tuple(obj.bound_box[6]) == pytest.approx((1, 1, 1), abs=1e-6)
    triangles = places[[face.vertices[:] for face in obj.data.polygons]]
    volume = np.linalg.det(triangles).sum() / 6
    assert measures_of(obj).volume == pytest.approx(volume, rel=1e-5) and volume < 0.7 * before
