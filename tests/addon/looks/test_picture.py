# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The product picture of an object: what it shows, and that it leaves the file as it was."""

import json
from functools import partial

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from synch_fields.core.errors import MeshError, SettingError
from synch_fields.synch_addon.blender.defect_empties import DefectEmpty, write_defects
from synch_fields.synch_addon.blender.transaction import only_for_now
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.looks import render
from synch_fields.synch_addon.looks.demo import add_demo_object
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.nodes.materials import pattern_material

from ..scenes import datablocks, sphere
from ..single_faces import CONVEX_QUAD, FACES, some_defects


@pytest.mark.parametrize("edges", [False, True])
def test_picture_leaves_the_file_as_it_was(edges, tmp_path):
    obj = FACES["regular quad"].build()
    pattern_material(obj, "stripes")
    write_defects(obj, some_defects())
    before, scene = datablocks(), bpy.context.scene
    path = render_picture(obj, tmp_path / "picture.png", resolution=(64, 48), samples=1, edges=edges)
    assert datablocks() == before and bpy.context.scene == scene
    image = bpy.data.images.load(str(path))
    assert tuple(image.size) == (64, 48)
    assert np.ptp(np.array(image.pixels[:]).reshape(-1, 4)[:, :3]) > 0.2


def test_picture_of_nothing_is_refused_and_leaves_the_file_as_it_was(tmp_path):
    obj = bpy.data.objects.new("empty", bpy.data.meshes.new("empty"))
    bpy.context.scene.collection.objects.link(obj)
    before = datablocks()
    with pytest.raises(MeshError, match="no faces"):
        render_picture(obj, tmp_path / "picture.png")
    with pytest.raises(SettingError, match=r"picture\.obj"):
        render_picture(obj, tmp_path / "picture.obj")
    assert datablocks() == before


def test_picture_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "a_file").touch()
    with pytest.raises(SettingError, match="cannot be written"):
        render_picture(FACES["regular quad"].build(), tmp_path / "a_file" / "p.png", resolution=(8, 8), samples=1)


def test_subject_stands_where_its_parents_and_modifiers_put_it():
    obj, parent = FACES["regular quad"].build(), bpy.data.objects.new("parent", None)
    parent.location, parent.scale, obj.parent = (5, 0, 1), (3, 1, 1), parent
    obj.rotation_euler.z = 0.5
    obj.modifiers.new("thick", "SOLIDIFY").thickness = 0.25
    scene = bpy.data.scenes.new("other")
    matrix, points = render._evaluate(render.stand_in(obj, scene, edges=False), scene)
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    expected = CONVEX_QUAD @ turn.T * (3, 1) + (5, 0)
    assert np.allclose(np.array(matrix)[:3, 3], (5, 0, 1))
    assert all(np.isclose(points[:, :2], corner, atol=1e-5).all(axis=1).sum() == 2 for corner in expected)
    assert np.ptp(points[:, 2]) == pytest.approx(0.25, abs=1e-6)


@pytest.mark.parametrize("on_faces", [True, False])
def test_markers_stand_where_the_defects_are_on_the_bent_object(on_faces):
    """Those of faces follow a twist, as Blender moves the empties in the scene itself; those of the object do not."""
    obj = sphere(2)
    obj.location, obj.rotation_euler, obj.scale = (3, -1, 0.5), (0.4, 0.2, 1), (1, 2, 0.5)
    obj.modifiers.new("twist", "SIMPLE_DEFORM").angle = 1
    faces = (0, 17, 60)
    middles = [tuple(obj.data.polygons[face].center) for face in faces]
    defects = [
        DefectEmpty("disclination", face, 0.5, place, (0, 0, 1)) for face, place in zip(faces, middles, strict=True)
    ]
    empties = write_defects(obj, defects, mesh=obj.data if on_faces else None)
    bpy.context.view_layer.update()
    there = np.array([empty.matrix_world.translation for empty in empties])
    assert (
        np.linalg.norm(there - [obj.matrix_world @ Vector(middle) for middle in middles], axis=1).max()
        > 0.05 * on_faces
    )
    with only_for_now():
        scene, _ = render.picture_scene(obj, resolution=(60, 40), markers=True, edges=False, view=(0, 0))
        markers = [one for one in scene.objects if one.type == "MESH" and one.name.startswith("disclination")]
        assert np.allclose([one.matrix_world.translation for one in markers], there, atol=1e-5)


@pytest.mark.parametrize(
    ("size", "view"),
    [((1, 1, 1), (25, 18)), ((0.01, 0.01, 4), (-130, 0)), ((30, 20, 0), (0, 90)), ((1e-3, 2e-3, 1e-3), (10, -40))],
)
def test_camera_is_as_close_as_a_whole_view_of_the_object_allows(size, view):
    scene = bpy.context.scene
    corners = np.array(np.meshgrid(*((-s / 2, s / 2) for s in size))).reshape(3, -1).T + 5.0
    camera = render._add_camera(scene, render._orientation(view), corners, (400, 200))
    scene.render.resolution_x, scene.render.resolution_y = 400, 200
    bpy.context.view_layer.update()
    seen = np.array([world_to_camera_view(scene, camera, Vector(corner)) for corner in corners])
    assert seen[:, 2].min() > camera.data.clip_start
    free = min((seen[:, :2]).min(), (1 - seen[:, :2]).min())
    assert free == pytest.approx(0.07, abs=2e-3)


@pytest.mark.parametrize("coarseness", [4.0, pytest.param(1.0, marks=pytest.mark.slow)])
def test_the_demo_solves_and_renders_suzanne(coarseness, tmp_path, monkeypatch):
    """With a coarse one and a small picture; slow, the whole demo."""
    if coarseness > 1:
        monkeypatch.setattr(main, "add_demo_object", partial(add_demo_object, coarseness))
        set_up = render._set_up_render
        monkeypatch.setattr(render, "_set_up_render", lambda scene, path, *_: set_up(scene, path, (32, 24), 1))
    assert main.main(["demo", "--folder", str(tmp_path), "--quiet"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["demo.blend", "demo.json", "demo.png"]
    assert json.loads((tmp_path / "demo.json").read_text())["certificate"] == "proved"
