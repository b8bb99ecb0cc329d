# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids as mesh files have them, from the command line: bodies that overlap, cracks, holes, and what is up."""

import json

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.command.intake import mend, turn_up
from synch_fields.synch_addon.solids.surface import read_area, read_surface

from ..solid_objects import placed


def box(low, high):
    """(12, 3, 3) corners of a box's triangles."""
    low, high = np.array(low, float), np.array(high, float)
    triangles = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            corners = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                share = np.zeros(3)
                share[axis], share[u], share[v] = side, a, b
                corners.append(low + share * (high - low))
            corners = corners if side else corners[::-1]
            triangles += [corners[:3], [corners[0], corners[2], corners[3]]]
    return np.array(triangles)


def write_stl(path, triangles):
    rows = ["solid part"]
    for triangle in np.asarray(triangles).tolist():
        rows += ["facet normal 0 0 0", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in triangle), "endloop"]
        rows.append("endfacet")
    path.write_text("\n".join([*rows, "endsolid part", ""]))
    return str(path)


def solved(folder, triangles, *flags):
    """The report of layers of a file of triangles."""
    report = folder / "report.json"
    run = ["layers", write_stl(folder / "part.stl", triangles), "--quiet", "--report", str(report), *flags]
    assert main.main(run) == 0
    return json.loads(report.read_text())


PLATE = box((0, 0, 0), (10, 10, 2))


@pytest.mark.parametrize("low", [1.0, 2.0])  # in the plate, or upon it
def test_bodies_that_overlap_or_touch_are_one(tmp_path, low):
    boss = box((3, 3, low), (7, 7, 6))
    report = solved(tmp_path, np.concatenate([PLATE, boss]), "--spacing", "1", "--size", "0.45")
    assert report["volume"] == pytest.approx(200 + 64, rel=0.02)
    assert any("2 bodies that touch or overlap are one" in line for line in report["warnings"])
    assert report["layers"] == 6


def test_a_cavity_stays_where_another_body_is_united(tmp_path):
    hollow = np.concatenate([box((0, 0, 0), (6, 6, 6)), box((2, 2, 2), (4, 4, 4))[:, ::-1]])
    report = solved(tmp_path, np.concatenate([hollow, box((5, 1, 1), (9, 5, 5))]), "--spacing", "1", "--size", "0.45")
    assert report["volume"] == pytest.approx(216 - 8 + 48, rel=0.02)
    assert any("2 bodies that touch or overlap are one" in line for line in report["warnings"])


def test_cracks_and_small_holes_are_closed(tmp_path):
    random = np.random.default_rng(0)
    cracked = PLATE + random.uniform(-2e-4, 2e-4, PLATE.shape)
    report = solved(tmp_path, cracked, "--spacing", "1", "--size", "0.45")
    assert report["volume"] == pytest.approx(200, rel=0.01)
    assert any("corners that did not quite meet are joined" in line for line in report["warnings"])
    report = solved(tmp_path, PLATE[1:], "--spacing", "1", "--size", "0.45")
    assert report["volume"] == pytest.approx(200, rel=0.01)
    assert any("1 small holes are closed" in line for line in report["warnings"])


def test_triangles_without_area_are_taken_out(tmp_path):
    a, b, c = PLATE[0]
    middle = (a + b) / 2
    flat = np.concatenate([[(a, middle, c), (middle, b, c), (a, b, middle)], PLATE[1:]])
    report = solved(tmp_path, flat, "--spacing", "1", "--size", "0.45")
    assert report["volume"] == pytest.approx(200, rel=0.01)
    assert any("1 triangles without area are taken out" in line for line in report["warnings"])


@pytest.mark.parametrize(("up", "layers"), [("Z", 2), ("X", 10), ("-Y", 10)])
def test_an_axis_of_a_file_is_turned_up(tmp_path, up, layers):
    report = solved(tmp_path, PLATE, f"--up={up}", "--spacing", "1", "--size", "0.45")
    made = bpy.data.objects[report["layers_object"]]
    assert report["layers"] == layers
    heights = placed(made)[:, 2]
    low = placed(bpy.data.objects[report["object"]])[:, 2]
    np.testing.assert_allclose(np.unique(np.round(heights - low.min(), 4)), np.arange(layers) + 0.5, atol=1e-3)


@pytest.mark.parametrize("up", ["X", "Y", "Z", "-Y"])
def test_an_axis_of_a_glb_file_is_turned_up(tmp_path, up):
    """Such files have Y up: an object of 2 by 6 by 4 in Blender, by its scale, is 2 by 4 by 6 there."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    obj = bpy.context.active_object
    obj.data.transform(Matrix.Diagonal((1, 3, 1, 1)))
    obj.scale.z = -2
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "box.glb"))
    obj = files.open_object(tmp_path / "box.glb")
    turn_up(obj, up, is_turned=True)
    bpy.context.view_layer.update()
    assert obj.dimensions.z == pytest.approx({"X": 2, "Y": 4, "Z": 6}[up[-1]])
    assert sorted(obj.dimensions) == pytest.approx([2, 4, 6])
    assert read_surface(obj).distance.volume == pytest.approx(48)
    outwards = [face.normal @ face.center for face in obj.data.polygons]
    assert min(outwards) > 0


def test_united_bodies_have_the_same_order_each_time():
    """Python and Blender order the parts of meshes by their addresses, which are others each time."""
    found = []
    for _ in range(4):
        bpy.ops.wm.read_homefile(use_empty=True)
        for x in (0, 0.7, 1.5, 2.2):
            bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8, location=(x, 0.1 * x, 0.05))
        for other in bpy.context.scene.objects:
            other.select_set(True)
        bpy.ops.object.join()
        obj = bpy.context.active_object
        assert any("4 bodies" in line for line in mend(obj))
        found.append([vertex.co[:] for vertex in obj.data.vertices])
        found[-1] += [face.vertices[:] for face in obj.data.polygons]
    assert all(one == found[0] for one in found)


def test_faces_that_look_down_and_up_are_groups(tmp_path):
    flags = (
        "--guidance",
        "harmonic:bottom:top",
        "--groups",
        "bottom=layer,top=layer",
        "--spacing",
        "1",
        "--size",
        "0.4",
    )
    report = solved(tmp_path, PLATE, *flags)
    assert report["layers"] == 3 and all(share < 0.01 for share in report["far_from_layers"].values())
    assert set(report["far_from_layers"]) == {"the bottom", "the top"}


@pytest.mark.parametrize("inside_out", [False, True])
@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (1, 1, -1), (2, 1, -0.5)])
def test_bottom_and_top_are_those_of_the_world(scale, inside_out):
    bpy.ops.mesh.primitive_cone_add(radius1=1, radius2=0.5, depth=1, rotation=(0.1, 0.05, 1))
    obj = bpy.context.active_object
    obj.scale = scale
    if inside_out:
        obj.data.flip_normals()
    bpy.context.view_layer.update()
    given = read_surface(obj).given
    places = obj.matrix_world.to_3x3() @ Matrix(np.linalg.inv(given.stretch))
    heights = (given.mesh.vertices @ np.array(places).T)[:, 2][given.mesh.triangles].mean(axis=1)
    bottom, top = (read_area(obj, given, name).triangles for name in ("bottom", "top"))
    assert heights[bottom].mean() < heights[top].mean()
