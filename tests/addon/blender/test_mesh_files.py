# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh files: normals of imported meshes, which mark edges as sharp or flat faces, and the sides of faces that are
written."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files

from ..scenes import sphere

EXPORTERS = {
    ".obj": lambda path: bpy.ops.wm.obj_export(filepath=path),
    ".glb": lambda path: bpy.ops.export_scene.gltf(filepath=path),
}


def sharp_edges(mesh):
    marks = mesh.attributes.get("sharp_edge")
    return sum(mark.value for mark in marks.data) if marks else 0


@pytest.mark.parametrize("suffix", EXPORTERS)
def test_sharp_edges_that_normals_mark_stay(tmp_path, suffix):
    mesh = sphere(4).data
    mesh.shade_smooth()
    places = np.array([vertex.co for vertex in mesh.vertices])
    upper = places[[list(face.vertices) for face in mesh.polygons]].mean(axis=1)[:, 2] > 0.1
    faces = {}
    for face in mesh.polygons:
        for key in face.edge_keys:
            faces.setdefault(key, []).append(upper[face.index])
    marked = [bool(sum(faces[edge.key]) == 1) for edge in mesh.edges]
    mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE").data.foreach_set("value", np.array(marked))
    EXPORTERS[suffix](str(tmp_path / f"mesh{suffix}"))
    files.open_input(tmp_path / f"mesh{suffix}")
    assert sharp_edges(bpy.context.scene.objects[0].data) == sum(marked) > 10


@pytest.mark.any_surface
@pytest.mark.parametrize(("suffix", "faces"), tuple(zip(EXPORTERS, (300, 1000), strict=True)))
def test_a_flat_ball_from_a_file_gets_the_quads_of_a_smooth_one(tmp_path, suffix, faces):
    sphere(4).data.shade_flat()
    EXPORTERS[suffix](str(tmp_path / f"ball{suffix}"))
    obj = files.open_object(tmp_path / f"ball{suffix}")
    assert obj.data.normals_domain == "CORNER"  # each corner has that of its face
    report = api.quad_mesh(obj, faces=faces)
    assert report["quad_mesh"]["angle_deviation"] < 10
    assert not report["warnings"]


@pytest.mark.any_surface
def test_triangles_side_by_side_get_the_quads_of_a_joined_mesh(tmp_path):
    """Of a ball whose triangles share no vertex; the normals that are carried must not mark all edges as sharp."""
    mesh = sphere(3).data
    places = [mesh.vertices[corner].co for face in mesh.polygons for corner in face.vertices]
    lines = [f"v {x} {y} {z}" for x, y, z in places] + [f"f {k} {k + 1} {k + 2}" for k in range(1, len(places), 3)]
    joined = len(places) - len(mesh.vertices)
    (tmp_path / "soup.obj").write_text("\n".join(lines))
    report = api.quad_mesh(files.open_object(tmp_path / "soup.obj"), faces=1500)
    assert report["surface"]["joined"] == joined > 100
    assert report["quad_mesh"]["angle_deviation"] < 6 and report["quad_mesh"]["closed"]


@pytest.mark.parametrize("scale", [(1, 2, 0.5), (-1, 2, 0.5), (-1, -2, -0.5)])
@pytest.mark.parametrize("suffix", files.MESH_SUFFIXES)
@pytest.mark.parametrize("is_hidden", [False, True])
def test_faces_in_files_look_outwards_whatever_the_object_is_like(tmp_path, suffix, scale, is_hidden):
    """The volume that a file's faces enclose, by the divergence theorem, is positive and that of the ellipsoid."""
    obj, away = sphere(4), bpy.data.collections.new("Ball")
    bpy.context.scene.collection.children.link(away)
    away.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    obj.scale, obj.rotation_euler = scale, (0.3, 0.2, 1)
    bpy.context.view_layer.update()
    names = set(bpy.data.meshes.keys()), set(bpy.data.objects.keys())
    bpy.context.view_layer.layer_collection.children["Ball"].exclude = is_hidden
    files.export_mesh(obj, tmp_path / f"ball{suffix}")
    assert (set(bpy.data.meshes.keys()), set(bpy.data.objects.keys())) == names
    read = files.open_object(tmp_path / f"ball{suffix}").data
    corners = np.array([[read.vertices[v].co for v in face.vertices] for face in read.polygons], float)
    volume = np.einsum("fx,fx->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(4 / 3 * np.pi, rel=0.01)
