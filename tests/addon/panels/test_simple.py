# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The simple panel: its few choices say what the object's settings say, and all else hides."""

import math
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import pytest
from mathutils import Matrix, Vector

from synch_fields.synch_addon import api
from synch_fields.synch_addon.nodes.vortices import add_filaments_modifier
from synch_fields.synch_addon.panels import sidebar
from synch_fields.synch_addon.patterns.refine import expected_faces, expected_spacing
from synch_fields.synch_addon.patterns.symmetry import mirror_axes
from synch_fields.synch_addon.settings import preferences
from synch_fields.synch_addon.settings.fields import stored_settings

from ..scenes import add_object, grid, make_active, sphere


@pytest.fixture(params=["SIMPLE", "ADVANCED"])
def chosen(request, monkeypatch):
    """The panel that the preferences hold, as an installed extension has them."""
    held = SimpleNamespace(panel=request.param)
    for module in (preferences, sidebar):
        monkeypatch.setattr(module, "preferences", lambda: held)
    return request.param


def triangles_of(obj):
    """Positions and triangles of a mesh."""
    obj.data.calc_loop_triangles()
    return [tuple(v.co) for v in obj.data.vertices], [tuple(t.vertices) for t in obj.data.loop_triangles]


def panels():
    names = [name for name in dir(bpy.types) if name.startswith("SYNCH_PT_") and name != "SYNCH_PT_presets"]
    found = [getattr(bpy.types, name) for name in names]
    return {panel.__name__.removeprefix("SYNCH_PT_") for panel in found if panel.poll(bpy.context)}


def drawn():
    """The names of the settings and operators that the first panel draws."""
    layout = MagicMock()
    sidebar.SYNCH_PT_fields.draw(SimpleNamespace(layout=layout), bpy.context)
    ends = [(call[0].rsplit(".", 1)[-1], call.args) for call in layout.mock_calls]
    return [args[-1] for name, args in ends if name in ("prop", "operator") and args]


def test_all_but_a_few_panels_hide(chosen):
    obj = sphere()
    api.stripes(obj, spacing=0.5)
    few = {"fields", "result", "material_presets"}
    assert (
        panels() == few
        if chosen == "SIMPLE"
        else panels() > few | {"guide", "pattern", "make", "solver", "figures", "layers", "overlay"}
    )


@pytest.mark.parametrize("chosen", ["SIMPLE"], indirect=True)
def test_there_is_one_button_and_it_makes_what_was_chosen(chosen):
    obj = sphere()
    for kind in ("stripes", "quads", "quad_mesh", "directions"):
        obj.synch_simple.kind = kind
        names = drawn()
        assert names.count(f"synch.{kind}") == 1
        assert not {"synch.stripes", "synch.quads", "synch.quad_mesh", "synch.directions"} & (
            set(names) - {f"synch.{kind}"}
        )
        assert {"panel", "kind", "direction"} <= set(names)
    obj.synch_simple.kind = "quad_mesh"
    assert {"faces", "faces_auto", "mesh_branching"} <= set(drawn())
    assert not {"lines", "automatic_spacing"} & set(drawn())  # one automatic number is enough
    obj.synch.automatic_spacing = False
    assert {"faces", "lines", "automatic_spacing"} <= set(drawn())
    obj.synch.faces = 500
    assert "automatic_spacing" not in drawn()


def test_a_spacing_that_is_no_longer_automatic_begins_at_the_one_that_was_used():
    obj = sphere()
    used = api.stripes(obj)["settings"]["spacing"]
    assert obj.synch.spacing == used and obj.synch.automatic_spacing
    obj.synch.automatic_spacing, obj.synch.spacing = False, 0.4
    assert api.stripes(obj, spacing=0.5) and obj.synch.spacing == pytest.approx(0.4)


@pytest.mark.any_surface
@pytest.mark.parametrize("surface", ["automatic", "faces"])
@pytest.mark.parametrize("kind", ["stripes", "quads", "quad_mesh"])
def test_automatic_turned_off_leaves_its_spacing(kind, surface):
    """The estimate before a solve and after a change of the mesh, and the exact one after a solve."""
    obj = sphere()
    simple, stored = obj.synch_simple, obj.synch
    stored.surface = surface.upper()
    simple.kind = kind

    def turn_off():
        simple.automatic_spacing = True
        lines = simple.lines
        simple.automatic_spacing = False
        assert not stored.automatic_spacing
        assert simple.lines == pytest.approx(lines, rel=0.1)
        return stored.spacing

    assert turn_off() == pytest.approx(expected_spacing(kind, obj))
    simple.automatic_spacing = True
    if kind != "quad_mesh":  # which is another object
        used = getattr(api, kind)(obj, surface=surface)["settings"]["spacing"]
        assert turn_off() == pytest.approx(used)
    obj.data.transform(Matrix.Scale(3, 4))
    obj.data.update()
    bpy.context.view_layer.update()
    assert turn_off() == pytest.approx(expected_spacing(kind, obj))
    obj.synch.automatic_spacing = True  # as a script does, which gives the spacing itself
    obj.synch.automatic_spacing, stored.spacing = False, 0.7
    simple.automatic_spacing = True
    assert turn_off() == pytest.approx(expected_spacing(kind, obj))


def test_lines_across_and_spacing_say_the_same():
    obj = sphere()
    simple, stored = obj.synch_simple, obj.synch
    expected = expected_spacing("stripes", obj)
    assert stored.automatic_spacing and simple.lines == pytest.approx(max(obj.dimensions) / expected)
    simple.lines = 10
    assert not stored.automatic_spacing and stored.spacing == pytest.approx(max(obj.dimensions) / 10)
    simple.kind = "quads"
    assert simple.lines == pytest.approx(20)  # two lines to a period


def test_a_direction_is_what_the_settings_say():
    obj = sphere()
    simple, stored = obj.synch_simple, obj.synch
    asked = {
        "AUTOMATIC": ("automatic", 0.0),
        "SMOOTH": ("smooth", 0.0),
        "CURVATURE": ("curvature-min=1", 0.0),
        "AXIS": ("axis:Z=1", math.pi / 2),
        "STROKES": ("smooth", 0.0),
    }
    for direction, (guidance, angle) in (*asked.items(), *reversed(asked.items())):
        simple.direction = direction
        settings = stored_settings(obj)
        assert (settings.guidance, settings.angle) == (guidance, pytest.approx(angle)), direction
        assert simple.direction == direction
    stored.guidance = "UV_U"
    assert simple.direction == "OTHER"
    simple.direction = "OTHER"
    assert stored.guidance == "UV_U"
    stored.guidance, stored.angle = "AXIS", 0.3
    assert simple.direction == "OTHER"  # as it was chosen
    for direction in ("AXIS", "CURVATURE", "SMOOTH"):
        simple.direction = direction
        stored.angle = 0.3
        assert simple.direction == direction
    stored.guidance, stored.angle = "AXIS", 0.0
    assert simple.direction == "OTHER"


def test_rings_around_an_axis_are_the_preset():
    """As the shipped preset of that name asks for them."""
    obj = sphere()
    obj.synch_simple.direction, obj.synch.guide.axis = "AXIS", "Z"
    simple = stored_settings(obj)
    other = sphere()
    path = sidebar.__file__.replace("sidebar.py", "shipped/presets/synch_fields/Rings_around_Z.py")
    bpy.ops.script.python_file_run(filepath=path)
    assert stored_settings(other) == simple


@pytest.mark.parametrize("chosen", ["SIMPLE"], indirect=True)
def test_mirrors_of_directions_are_offered_where_the_mesh_has_them_and_those_of_patterns_always(chosen):
    obj = grid()
    triangulated = add_object(*triangles_of(obj))
    for own, expected in ((obj, 2), (triangulated, 0)):  # the latter's diagonals differ on both sides
        make_active(own)
        for kind, axes in (("stripes", 3), ("quads", 3), ("quad_mesh", 3), ("directions", expected)):
            own.synch_simple.kind = kind
            assert drawn().count("mirror") == axes
    make_active(obj)
    obj.data.vertices[0].co += Vector((0.01, 0, 0.01))
    obj.data.update()
    bpy.context.view_layer.update()
    assert drawn().count("mirror") == 0


def test_a_vortex_curve_is_named_as_what_it_is():
    curve = bpy.data.objects.new("Ring", bpy.data.curves.new("Ring", "CURVE"))
    bpy.context.scene.collection.objects.link(curve)
    add_filaments_modifier(curve, 0.1, 1.0)
    layout = MagicMock()
    assert sidebar.draw_unready(layout, curve)
    assert [call.kwargs["text"] for call in layout.label.call_args_list] == ["Ring", "Vortex filaments"]


@pytest.mark.parametrize("chosen", ["SIMPLE"], indirect=True)
def test_vortices_of_a_curve_are_one_click_away(chosen):
    bpy.ops.curve.primitive_bezier_circle_add()
    assert panels() == {"fields", "simple_vortices"}
    layout = MagicMock()
    bpy.types.SYNCH_PT_simple_vortices.draw(SimpleNamespace(layout=layout), bpy.context)
    assert "'synch.clebsch'" in str(layout.mock_calls) and "nodes" in str(layout.mock_calls)
    sphere()
    assert "simple_vortices" not in panels()


def test_a_count_of_lines_that_stays_as_it_is_shown_changes_nothing():
    """As Enter does in the field, which shows no decimals, and rounded ones while it is edited."""
    obj = sphere()
    simple, stored = obj.synch_simple, obj.synch
    before = simple.lines
    assert before != round(before)
    simple.lines = round(before)
    simple.lines = before * (1 + 2e-6)
    assert stored.automatic_spacing and simple.lines == before
    simple.lines = round(before) + 1
    assert not stored.automatic_spacing and simple.lines == pytest.approx(round(before) + 1)


def test_a_count_of_faces_begins_at_the_one_that_was_expected():
    obj = sphere()
    simple, stored = obj.synch_simple, obj.synch
    simple.kind = "quad_mesh"
    expected = simple.faces
    assert simple.faces_auto and stored.faces == 0 and expected == pytest.approx(expected_faces(obj, stored))
    simple.faces = expected  # Enter in the field
    assert simple.faces_auto and stored.faces == 0
    simple.faces_auto = False
    assert stored.faces == simple.faces == expected
    simple.faces = expected + 1
    assert stored.faces == expected + 1
    simple.faces_auto = True
    assert stored.faces == 0 and simple.faces == expected


def test_in_edit_mode_automatic_turned_off_leaves_its_spacing_too():
    obj = sphere()
    simple, stored = obj.synch_simple, obj.synch
    lines, mirrors = simple.lines, mirror_axes(obj)
    with bpy.context.temp_override(active_object=obj, object=obj):
        bpy.ops.object.mode_set(mode="EDIT")
        assert simple.lines == lines and mirror_axes(obj) == mirrors
        simple.automatic_spacing = False
        assert not stored.automatic_spacing and simple.lines == pytest.approx(lines)
        bpy.ops.object.mode_set(mode="OBJECT")


def test_without_a_surface_the_spacing_stays_automatic():
    obj = add_object([], [])
    assert obj.synch_simple.lines == 0
    obj.synch_simple.automatic_spacing = False
    assert obj.synch.automatic_spacing


def test_why_an_object_carries_nothing_fits_into_the_panel():
    light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
    text = bpy.data.objects.new("Letters", bpy.data.curves.new("Letters", "FONT"))
    for obj, ways in ((light, ["select a mesh object"]), (text, ["select a mesh object", "Object > Convert"])):
        bpy.context.scene.collection.objects.link(obj)
        layout = MagicMock()
        assert sidebar.draw_unready(layout, obj)
        lines = [call.kwargs["text"] for call in layout.label.call_args_list]
        assert max(map(len, lines)) <= 30 and [way in " ".join(lines) for way in ways] == [True] * len(ways)
        assert ("Convert" in " ".join(lines)) == (obj == text)


@pytest.mark.any_surface
def test_a_mesh_whose_halves_differ_is_mirrored_from_its_positive_side(chosen):
    """A ball with a bulge on the side of +X: the bulge is on both sides of its quads."""
    obj = sphere()
    for vertex in obj.data.vertices:
        vertex.co.y *= 1.0 + max(vertex.co.x, 0.0) * (vertex.co.y > 0)
    obj.data.update()
    assert mirror_axes(obj) == ()
    assert bpy.ops.synch.quad_mesh(faces=300, mirror=(True, False, False)) == {"FINISHED"}
    made = bpy.context.active_object
    points = {tuple(round(number, 4) + 0.0 for number in vertex.co) for vertex in made.data.vertices}
    assert points == {(-x + 0.0, y, z) for x, y, z in points}
    assert max(vertex.co.y for vertex in made.data.vertices if vertex.co.x < -0.2) > 1.15
