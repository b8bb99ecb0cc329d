# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of a few faces on small meshes, split and torn ones too: sound faces, or one line."""

import warnings

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.tasks import surfaces
from synch_fields.synch_addon import api

from ..scenes import add_object, attribute, grid, make_active, sphere, tube

SHAPES = {
    "grid": lambda n: bpy.ops.mesh.primitive_grid_add(x_subdivisions=1 + n, y_subdivisions=2),
    "ball": lambda n: bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1 + n % 2),
    "cube": lambda n: bpy.ops.mesh.primitive_cube_add(),
    "torus": lambda n: bpy.ops.mesh.primitive_torus_add(major_segments=3 + n, minor_segments=3 + n),
    "tube": lambda n: bpy.ops.mesh.primitive_cylinder_add(vertices=3 + n, end_fill_type="NOTHING"),
    "disk": lambda n: bpy.ops.mesh.primitive_circle_add(vertices=3 + 4 * n, fill_type="NGON"),
    "cone": lambda n: bpy.ops.mesh.primitive_cone_add(vertices=3 + n),
}
TWO_TRIANGLES = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0), (2, 1, 0)], [(0, 1, 2), (3, 4, 5)]


def torn(obj, how, random):
    """The object with all or some edges split, some faces removed, or vertices moved."""
    import bmesh  # on the path once bpy is loaded

    edited = bmesh.new()
    edited.from_mesh(obj.data)
    if how == "split":
        bmesh.ops.split_edges(edited, edges=edited.edges[:])
    elif how == "cut":
        bmesh.ops.split_edges(edited, edges=[edge for edge in edited.edges if random.random() < 0.4])
    elif how == "holes":
        bmesh.ops.delete(edited, geom=[face for face in edited.faces[1:] if random.random() < 0.3], context="FACES")
    elif how == "bent":
        for vertex in edited.verts:
            vertex.co += 0.1 * type(vertex.co)(random.normal(size=3))
    edited.to_mesh(obj.data)
    edited.free()
    return make_active(obj)


def checked(obj, **settings):
    """The report of a quad mesh whose faces are sound, or None where it was refused in one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            report = api.quad_mesh(obj, seed=1, time_limit=5.0, **settings)
        except SynchError as error:
            assert "\n" not in str(error) and "internal" not in str(error)
            return None
    made = bpy.data.objects[report["quad_mesh"]["object"]]
    faces = [set(polygon.vertices) for polygon in made.data.polygons]
    assert faces and all(
        len(face) == polygon.loop_total > 2 for face, polygon in zip(faces, made.data.polygons, strict=True)
    )
    assert set().union(*faces) == set(range(len(made.data.vertices)))
    assert np.isfinite(attribute(made, "position")).all() and not made.data.validate()
    return report


HOW = ["whole", "split", "cut", "holes", "bent"]


# Of each shape two ways.
@pytest.mark.parametrize(
    ("shape", "how"), [(shape, HOW[(k + step) % len(HOW)]) for k, shape in enumerate(SHAPES) for step in (0, 2)]
)
def test_small_meshes_become_a_few_sound_faces_or_one_line(shape, how):
    random = np.random.default_rng([len(shape), len(how)])
    for faces in random.choice([1, 2, 3, 4, 6, 12], 1).tolist():
        bpy.ops.wm.read_homefile(use_empty=True)
        SHAPES[shape](int(random.integers(1, 4)))
        checked(torn(bpy.context.object, how, random), faces=faces, branching=float(random.integers(2)))


@pytest.mark.parametrize("branching", [0.0, 1.0])
def test_two_triangles_are_two_faces(branching):
    report = checked(add_object(*TWO_TRIANGLES), faces=2, branching=branching)
    assert report["quad_mesh"]["faces"] == 2 and not report["warnings"]


def test_a_surface_of_loose_triangles_keeps_them_and_says_what_joins_them():
    """Merge by Distance, which the line names, then gives about as many faces as were asked for."""
    obj = torn(sphere(2), "split", np.random.default_rng(0))
    pieces = len(obj.data.polygons)
    report = checked(obj, faces=10)
    assert report["quad_mesh"]["faces"] >= pieces
    (said,) = (line for line in report["warnings"] if "faces, not 10" in line)
    assert f"{pieces} pieces" in said and "Merge by Distance" in said
    make_active(obj)
    obj.hide_set(False)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert checked(obj, faces=10)["quad_mesh"]["faces"] <= 24


def test_pieces_that_are_too_small_are_told():
    small, large = tube(), sphere(3)
    small.location, small.scale = (3, 0, 0), (0.01, 0.01, 0.01)
    bpy.context.view_layer.update()
    small.select_set(True)
    make_active(large)
    small.select_set(True)
    bpy.ops.object.transform_apply(location=True, scale=True)
    bpy.ops.object.join()
    told = "1 of 2 pieces of the surface are too small"
    report = checked(bpy.context.object, spacing=0.8, features=0)
    assert any(told in line for line in report["warnings"])


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(
    "corners",
    [
        [(0, 1, 0), (0, 0, 0), (0, -2, 0), (0, 0, 3), (1, 0, 0)],  # no quad fits at first
        [(0, 0, 0), (0, 0, 0), (0, -3, 0), (3, 0, -3), (-2, 0, 0)],  # a grid line without length
        [(0, 1, 0), (0, 0, 0), (0, 0, 0), (0, 0, 1)],  # triangles without area
    ],
)
def test_one_face_of_corners_that_coincide_or_leave_its_plane(corners, scale):
    checked(add_object(scale * np.array(corners, float), [range(len(corners))]), faces=1)


def test_a_spike_among_tiny_faces_is_not_cut_into_thousands_of_quads(monkeypatch):
    sizes, finish = [], surfaces.finish_quads

    def counted(quads, *rest, **wanted):
        sizes.append(len(quads.sizes))
        return finish(quads, *rest, **wanted)

    monkeypatch.setattr(surfaces, "finish_quads", counted)
    obj = grid(7, 7)
    obj.data.vertices[37].co = (-8e5, 0, -8e5)
    assert checked(obj, faces=12) and 0 < max(sizes) < 1000
