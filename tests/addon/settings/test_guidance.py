# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What directions follow, against closed forms: every source by API, operator and command line, blends and maps."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.core.settings.guidance import Source, parse_guidance
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.settings.guide_list import GUIDE_ITEMS, UNGUIDED, store_guidance, stored_guidance

from ..run_commands import WAYS, add_weights, solve
from ..scenes import (
    add_curve,
    add_group,
    directions,
    grid,
    places,
    save_and_reopen,
    set_numbers,
    set_vectors,
    snapshot,
    sphere,
    tube,
)


def furnished_grid():
    """A flat square with numbers, groups, UV maps and a curve to follow, all of them straight."""
    obj = grid(16)
    x, y, _ = places(obj).T
    set_numbers(obj, "slope", 2 * x + y)
    add_weights(obj, "ramp", (1 - x) / 2)
    add_group(obj, "left, side", np.flatnonzero(x < -1 + 1e-6))
    turned = obj.data.uv_layers.new(name="Turned")
    corners = np.array([loop.vertex_index for loop in obj.data.loops])
    turned.uv.foreach_set("vector", np.float32(np.column_stack([-y, x])[corners]).ravel())
    add_curve([(-1, -1, 0.1), (-1, 1, 0.1)], "Edge")
    return obj


# All by the API, one by the others, too.
STRAIGHT = [
    ("gradient:slope", (2, 1)),
    ("contour:slope", (-1, 2)),
    ("gradient:ramp", (-1, 0)),
    ("contour:ramp", (0, -1)),
    ('distance:"left, side"', (1, 0)),
    ('offset:"left, side"', (0, 1)),
    ("distance:Edge", (1, 0)),
    ("offset:Edge", (0, 1)),
    ("axis:X", (1, 0)),
    ("axis:Y", (0, 1)),
    ("uv-u", (1, 0)),
    ("uv-v:UVMap", (0, 1)),
    ("uv-u:Turned", (0, -1)),
    ("uv-v:Turned", (1, 0)),
]


@pytest.mark.parametrize(
    ("way", "guidance", "expected"), [("api", *row) for row in STRAIGHT] + [(way, *STRAIGHT[4]) for way in WAYS[1:]]
)
def test_straight_guides_on_a_square_are_followed(way, guidance, expected):
    obj = furnished_grid()
    solve(way, obj, guidance=guidance, symmetry="vector")
    expected = np.array([*expected, 0]) / np.linalg.norm(expected)
    misses = np.degrees(np.arccos(np.clip(directions(obj) @ expected, -1, 1)))
    if guidance.endswith("Edge"):  # the triangles that it passes leave out a corner
        assert np.median(misses) < 0.1 and misses[np.abs(places(obj)[:, 1]) < 0.7].max() < 12
    else:
        assert misses.max() < 0.1


@pytest.mark.parametrize("guidance, upright", [("distance:boundary", True), ("offset:boundary", False)])
def test_the_boundary_of_a_tube_gives_its_axis_and_its_circles(guidance, upright):
    obj = tube()
    api.directions(obj, guidance=guidance)
    heights = np.abs(directions(obj)[:, 2])
    away = np.abs(places(obj)[:, 2] - 1) > 0.2  # in the middle both rims are as near
    assert (heights[away] > 0.99).all() if upright else (heights[away] < 0.1).all()


def test_offsets_keep_the_sources_on_their_left():
    obj = tube()
    add_group(obj, "lower", range(24))
    api.directions(obj, guidance="offset:lower", symmetry="vector")
    around = np.cross(places(obj) * (1, 1, 0), (0, 0, 1))
    assert np.einsum("ij,ij->i", directions(obj), around).min() > 0.99


def test_uv_maps_are_followed_across_their_seams():
    obj = tube()
    vertices = np.array([loop.vertex_index for loop in obj.data.loops])
    column, ring = vertices % 24, vertices // 24
    last = np.repeat([p.index % 24 == 23 for p in obj.data.polygons], 4)
    u = np.where(last & (column == 0), 24, column) / 24
    obj.data.uv_layers.new(name="Around").uv.foreach_set("vector", np.float32(np.column_stack([u, ring / 8])).ravel())
    around = np.cross((0, 0, 1), places(obj) * (1, 1, 0))
    for guidance, expected in (("uv-u", around), ("uv-v:Around", np.tile((0, 0, 1), (len(around), 1)))):
        api.directions(obj, guidance=guidance, symmetry="vector")
        assert np.einsum("ij,ij->i", directions(obj), expected).min() > 0.999


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 0.6, 1), (-1, 1, 1)])
def test_an_axis_is_the_objects_own(scale):
    obj = grid()
    obj.scale, obj.rotation_euler = scale, (0.3, 0.5, 0.7)
    api.directions(obj, guidance="axis:X", symmetry="vector")
    np.testing.assert_allclose(directions(obj), np.tile((1.0, 0, 0), (len(directions(obj)), 1)), atol=1e-5)


def test_an_axis_on_a_sphere_gives_meridians_and_smooth_poles():
    obj = sphere(4)
    report = api.directions(obj, guidance="axis:Z")
    up = np.array((0.0, 0, 1)) - places(obj) * places(obj)[:, 2:]
    lengths = np.linalg.norm(up, axis=1)
    cosines = np.abs(np.einsum("ij,ij->i", directions(obj), up)) / np.maximum(lengths, 1e-9)
    assert cosines[lengths > 0.6].min() > np.cos(np.radians(10))
    assert sum(d["index"] for d in report["disclinations"]) == 2
    assert all(abs(d["position"][2]) > 0.85 for d in report["disclinations"])


# Blends and strengths


@pytest.mark.parametrize(
    ("way", "strengths"), [*(("api", pair) for pair in ((1, 1), (0.5, 0.1), (0, 1))), *((way, (1, 2)) for way in WAYS)]
)
def test_a_blend_of_two_axes_points_between_them_by_their_strengths(way, strengths):
    obj = grid()
    solve(way, obj, guidance="axis:X={},axis:Y={}".format(*strengths), symmetry="vector")
    expected = np.array([*strengths, 0]) / np.linalg.norm(strengths)
    np.testing.assert_allclose(directions(obj), np.tile(expected, (len(directions(obj)), 1)), atol=1e-4)


def test_lines_at_right_angles_do_not_mix():
    obj = grid()
    for guidance, axis in (("axis:X=2,axis:Y", 0), ("axis:X,axis:Y=2", 1)):
        api.directions(obj, guidance=guidance)
        np.testing.assert_allclose(np.abs(directions(obj)[:, axis]), 1, atol=1e-4)


def test_without_a_strength_it_is_one():
    obj = grid()
    api.directions(obj, guidance="axis:X,axis:Y=1", symmetry="vector")
    np.testing.assert_allclose(directions(obj)[:, 0], np.sqrt(0.5), atol=1e-4)


@pytest.mark.parametrize("strength", [0.04, 0.2])
def test_strength_says_how_far_smoothness_reaches(strength):
    """A step of the guide from -a to a is crossed over root(area / (300 strength))."""
    obj = grid(64)
    x = places(obj)[:, 0]
    step = 0.05
    angles = step * np.sign(np.round(x, 6))
    set_vectors(obj, "wish", np.column_stack([np.cos(angles), np.sin(angles), 0 * x]))
    api.directions(obj, guidance=f"attribute:wish={strength}", symmetry="vector", target_gap=1e-6)
    reach = np.sqrt(4 / (300 * strength))
    expected = step * np.sign(x) * (1 - np.cosh((1 - np.abs(x)) / reach) / np.cosh(1 / reach))
    found = np.arctan2(directions(obj)[:, 1], directions(obj)[:, 0])
    np.testing.assert_allclose(found, expected, atol=0.02 * step)
    api.directions(obj, guidance="attribute:wish", symmetry="vector")
    np.testing.assert_allclose(np.arctan2(*directions(obj).T[1::-1]), angles, atol=1e-6)


def test_curvature_counts_by_its_square_and_an_axis_by_its_share_of_the_area():
    """On a tube of area 4 pi, where the curvatures are 1 and 0: 1 against 300 / (4 pi) = 23.9."""
    obj = tube(segments=48, rings=33)
    for strength, upright in ((20, True), (28, False)):
        api.directions(obj, guidance=f"curvature-max={strength},axis:Z")
        heights = np.abs(directions(obj)[:, 2])
        assert np.median(heights) > 0.99 if upright else np.median(heights) < 0.1


# Text


@pytest.mark.parametrize(
    "text, expected",
    [
        ("smooth", ()),
        ("automatic", ()),
        (" curvature-max = 2", None),
        ("curvature-max=2,axis:Z", (Source("curvature-max", "", 2.0), Source("axis", "Z"))),
        ("gradient: two words , uv-u", (Source("gradient", "two words"), Source("uv-u"))),
        ('contour:"a,b=""c"""=0.5', (Source("contour", 'a,b="c"', 0.5),)),
        ("file:/tmp/a b/c:d.rosy", (Source("file", "/tmp/a b/c:d.rosy"),)),
        ("uv-v:Map=1e-3", (Source("uv-v", "Map", 1e-3),)),
    ],
)
def test_guidance_is_read(text, expected):
    if expected is None:
        with pytest.raises(SettingError, match="cannot be read"):
            parse_guidance(text)
    else:
        assert parse_guidance(text) == expected
        assert parse_guidance(",".join(map(str, expected)) or "smooth") == expected


@pytest.mark.parametrize(
    ("command", "settings", "expected"),
    [
        ("quad_mesh", {}, "curvature-max"),
        ("quad_mesh", {"guidance": "smooth"}, "smooth"),
        ("quad_mesh", {"boundary": "along"}, "smooth"),
        ("quad_mesh", {"constraints": [{"where": "seams", "what": "along"}]}, "smooth"),
        ("quads", {}, "smooth"),
        ("stripes", {}, "smooth"),
        ("stripes", {"guidance": "axis:Z"}, "axis:Z"),
    ],
)
def test_without_a_guide_quad_meshes_follow_curvature_where_nothing_else_is_asked_for(command, settings, expected):
    assert SurfaceSettings(**settings).for_command(command).guidance == expected


REFUSED = {
    "": "the guidance '' is unknown: use one of automatic, smooth, curvature-max",
    "wind": "the guidance 'wind' is unknown: use one of automatic, smooth",
    "axis:Z,": "the guidance '' is unknown",
    "smooth,axis:Z": "smooth stands alone: leave it out",
    "gradient": "the guidance gradient has no name: write gradient: and a float attribute or vertex group",
    "curvature-max:x": "curvature-max takes no name: leave 'x' out",
    "axis:W": "the axis 'W' is unknown: use X, Y or Z",
    "axis:Z=-1": "the strength of axis:Z is -1.0: give a number from 0 on",
    "axis:Z=nan": "the strength of axis:Z is nan: give",
    "axis:Z=strong": "the strength 'strong' of axis is not a number: write axis=1",
    'gradient:a"b': "the guidance 'gradient:a\"b' cannot be read: write KIND:NAME=STRENGTH",
    "gradient:absent": "has no attribute 'absent': choose a float attribute (it has flat)",
    "gradient:flat": "gradient:flat: the guiding values are the same all over: give them a slope",
    "axis:X,gradient:flat=2": "gradient:flat: the guiding values are the same all over: give them a slope",
    "distance:absent": "'absent' is neither a vertex group nor an object: choose a vertex group (all), a curve",
    "distance:all": "distance:all: every vertex is at distance 0: leave at least one out",
    "offset:boundary": "the mesh Icosphere has no boundary: measure from a vertex group or a curve",
    "distance:Lamp": "the object 'Lamp' is a light: choose a curve",
    "distance:Far": "the object 'Far' has a length of 1.41e+06, and no more than",
    "uv-u": "the mesh Icosphere has no UV map: choose one of its maps (none yet), or unwrap it",
    "uv-v:Other": "has no UV map 'Other': choose one of its maps",
    "attribute:still=1": "attribute:still: every guidance vector is zero or points straight out of the surface",
    "attribute:still": "the guidance vector of vertex 0 (162 in all) is zero or points straight out of the surface",
    "file:absent.rosy": "absent.rosy cannot be read (No such file or directory): check the path",
    "file:field.txt": "field.txt is not a field file: use the suffix .rawfield or .rosy",
}


def bare_sphere():
    obj = sphere()
    obj.data.uv_layers.remove(obj.data.uv_layers[0])
    set_numbers(obj, "flat", np.ones(len(obj.data.vertices)))
    set_vectors(obj, "still", 0 * places(obj))
    add_curve([(1, 0, 0), (0, 1, 0), (1e6, 1e6, 0)], "Far")
    add_group(obj, "all", range(len(obj.data.vertices)))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    return obj


@pytest.mark.parametrize("guidance", REFUSED, ids=repr)
def test_guidance_that_cannot_be_followed_is_one_line_and_changes_nothing(guidance, capfd):
    obj = bare_sphere()
    before = snapshot()
    with pytest.raises(SynchError) as refused:
        api.directions(obj, guidance=guidance)
    line = str(refused.value)
    assert REFUSED[guidance] in line and "\n" not in line
    with pytest.raises(RuntimeError) as cancelled:
        bpy.ops.synch.stripes(guidance=guidance)
    assert line in str(cancelled.value)
    capfd.readouterr()
    assert main.main(["directions", "--quiet", f"--guidance={guidance}"], loaded=True) == 1
    assert f"synch directions: {line}\n" in capfd.readouterr().err
    assert snapshot() == before


@pytest.mark.parametrize("guidance", [None, 3, ["axis:X"]])
def test_guidance_that_is_no_text_is_refused(guidance):
    with pytest.raises(SynchError, match="give a text"):
        api.directions(sphere(), guidance=guidance)


@pytest.mark.parametrize("guidance", ["curvature-max", "curvature-min=2", "axis:Z,curvature-max"])
def test_lines_cannot_guide_vectors(guidance):
    obj = tube()
    with pytest.raises(SynchError, match=r"curvature-m\w+ gives 2 directions at a point.* set the symmetry to line or"):
        api.directions(obj, guidance=guidance, symmetry="vector")
    for symmetry in ("line", "cross"):
        api.directions(obj, guidance=guidance, symmetry=symmetry)


# The panel's properties


def test_the_panels_guide_is_what_the_button_follows():
    obj = furnished_grid()
    expected = {
        "AUTOMATIC": "automatic",
        "SMOOTH": "smooth",
        "CURVATURE_MAX": "curvature-max=1",
        "CURVATURE_MIN": "curvature-min=1",
        "GRADIENT": "gradient:slope=1",
        "CONTOUR": "contour:slope=1",
        "DISTANCE": 'distance:"left, side"=1',
        "OFFSET": 'offset:"left, side"=1',
        "AXIS": "axis:Y=1",
        "UV_U": "uv-u=1",
        "UV_V": "uv-v=1",
        "ATTRIBUTE": "attribute:wish",
        "FILE": "file:field.rosy=1",
    }
    assert set(expected) == {*UNGUIDED, *(name for name, *_ in GUIDE_ITEMS)}
    guide = obj.synch.guide
    guide.numbers, guide.origin, guide.axis = "slope", "left, side", "Y"
    guide.vectors, guide.path = "wish", "field.rosy"
    for kind, text in expected.items():
        obj.synch.guidance = kind
        assert stored_guidance(obj.synch) == text
    obj.synch.guidance = "CONTOUR"
    api.run("directions", obj, SurfaceSettings(symmetry="vector", guidance=stored_guidance(obj.synch)))
    np.testing.assert_allclose(directions(obj) @ (-1, 2, 0), np.sqrt(5), rtol=1e-4)


@pytest.mark.parametrize(
    "text",
    [
        "automatic",
        "smooth",
        "curvature-max=1",
        'distance:"left, side"=2.5',
        "uv-u:Map=1",
        "uv-v=1",
        "attribute:wish",
        "attribute:wish=2",
        "curvature-min=2,axis:Z=1,file:field.rosy=0.5",
    ],
)
def test_a_guidance_that_is_stored_is_the_same_text_again(text):
    obj = grid()
    obj.synch.guidance, obj.synch.guide.strength = "AXIS", 7.0
    obj.synch.guides.add()
    store_guidance(obj.synch, text)
    assert stored_guidance(obj.synch) == text
    store_guidance(obj.synch, text.replace("=1", ""))  # which is what it is without a number
    assert stored_guidance(obj.synch) == text


def test_values_of_the_guidance_keep_the_numbers_that_files_have():
    items = grid().synch.bl_rna.properties["guidance"].enum_items
    names = ["SMOOTH", *(name for name, *_ in GUIDE_ITEMS[:11]), "BLEND", *(name for name, *_ in GUIDE_ITEMS[11:])]
    assert {item.identifier: item.value for item in items} == {"AUTOMATIC": 100} | {n: k for k, n in enumerate(names)}
    assert names[11:13] == ["FILE", "BLEND"]


def test_a_blend_is_kept_in_the_file_and_followed(tmp_path):
    obj = grid()
    obj.synch.guidance = "BLEND"
    assert stored_guidance(obj.synch) == "smooth"
    for axis, strength in (("X", 1.0), ("Z", 9.0), ("Y", 3.0)):
        assert bpy.ops.synch.guide_add() == {"FINISHED"}
        guide = obj.synch.guides[-1]
        guide.kind, guide.axis, guide.strength = "AXIS", axis, strength
    assert bpy.ops.synch.guide_remove(number=1) == {"FINISHED"}
    assert bpy.ops.synch.guide_remove(number=2) == {"CANCELLED"}
    obj = save_and_reopen(tmp_path / "blend.blend", obj.name)
    assert stored_guidance(obj.synch) == "axis:X=1,axis:Y=3"
    api.run("directions", obj, SurfaceSettings(symmetry="vector", guidance=stored_guidance(obj.synch)))
    np.testing.assert_allclose(directions(obj) @ (1, 3, 0), np.sqrt(10), rtol=1e-4)


def test_a_guide_without_its_name_is_refused():
    obj = grid()
    obj.synch.guidance = "GRADIENT"
    with pytest.raises(SettingError, match="the guidance gradient has no name"):
        stored_guidance(obj.synch)


def test_adding_and_removing_a_guide_is_undone():
    obj = grid()
    obj.synch.guidance = "BLEND"
    bpy.ops.synch.guide_add()
    bpy.ops.ed.undo_push(message="one")
    bpy.ops.synch.guide_remove(number=0)
    bpy.ops.ed.undo_push(message="none")
    bpy.ops.ed.undo()
    assert len(bpy.context.active_object.synch.guides) == 1


# A result as the next run's input
