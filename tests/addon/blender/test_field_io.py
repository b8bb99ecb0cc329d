# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Field files: written from directions and read back, followed as guidance, by operator, API and command line."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.files.directions import FaceField, read_field, write_field
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.pattern_surface import surface_of
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.settings.guide_list import stored_guidance

from ..run_commands import undo_and_redo
from ..scenes import attribute, directions, grid, snapshot, sphere, torus

OTHER = Path(__file__).resolve().parents[4] / "shared" / "meshes" / "cheburashka-cf.rawfield"
NUMBERS = {"vector": 1, "line": 2, "cross": 4}
SUFFIXES = [".rawfield", ".rosy"]


def triangles(build, **values):
    """The object with all faces split into triangles."""
    obj = build(**values)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.quads_convert_to_tris()
    bpy.ops.object.mode_set(mode="OBJECT")
    return obj


def normals(obj):
    """(m, 3) of the faces, in object space."""
    return np.array([p.normal[:] for p in obj.data.polygons])


def misses(obj, found, expected, symmetry):
    """Degrees between directions at vertices as they are scaled, up to turns that count as the same."""
    up = np.array([v.normal[:] for v in obj.data.vertices]) / obj.scale
    up /= np.linalg.norm(up, axis=1)[:, None]
    found, expected = found * obj.scale, expected * obj.scale
    sine = np.einsum("ij,ij->i", np.cross(expected, found), up)
    turn = 360 / NUMBERS[symmetry]
    angle = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", expected, found)))
    return np.abs((angle + turn / 2) % turn - turn / 2)


@pytest.mark.parametrize("symmetry", NUMBERS)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_constant_field_is_written_for_every_triangle_and_read_back_exactly(symmetry, suffix, tmp_path):
    obj = triangles(grid)
    obj.scale, obj.rotation_euler = (3, 3, 3), (0.3, 0.5, 0.7)
    path = tmp_path / f"field{suffix}"
    api.directions(obj, guidance="axis:X", symmetry=symmetry, angle=0.4)
    before = directions(obj)
    api.export_field(obj, path, symmetry)
    field = read_field(path)
    assert field.symmetry == NUMBERS[symmetry] and len(field.vectors) == len(obj.data.polygons)
    along = np.array([np.cos(0.4), np.sin(0.4), 0])
    turns = field.vectors @ along + 1j * np.cross(np.broadcast_to(along, field.vectors.shape), field.vectors)[..., 2]
    np.testing.assert_allclose(turns**field.symmetry, 1, atol=1e-4)
    obj.data.attributes.remove(obj.data.attributes["synch_direction"])
    api.import_field(obj, path)
    np.testing.assert_allclose(misses(obj, directions(obj), before, symmetry), 0, atol=1e-2)


@pytest.mark.parametrize("symmetry, scale", [("vector", (1, 1, 1)), ("line", (2, 0.6, 1)), ("cross", (2, 0.6, 1))])
def test_a_curved_field_comes_back_up_to_the_mean_over_faces(symmetry, scale, tmp_path):
    obj = sphere(4)
    obj.scale = scale
    api.directions(obj, guidance="axis:Z", symmetry=symmetry)
    before = directions(obj)
    path = tmp_path / "field.rawfield"
    api.export_field(obj, path, symmetry)
    vectors = read_field(path).vectors
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=2), 1, atol=1e-6)
    assert np.abs(np.einsum("tkc,tc->tk", vectors, normals(obj))).max() < 1e-5
    assert api.import_field(obj, path) == symmetry
    # The mean over the faces is no mean beside a singularity.
    assert np.quantile(misses(obj, directions(obj), before, symmetry), 0.9) < 2


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_operators_read_and_write_and_the_settings_follow(suffix, tmp_path):
    obj = triangles(torus)
    api.directions(obj, guidance="curvature-max", symmetry="cross")
    before = directions(obj)
    path = tmp_path / f"field{suffix}"
    assert bpy.ops.synch.export_field(filepath=str(path), symmetry="CROSS") == {"FINISHED"}
    obj.data.attributes.remove(obj.data.attributes["synch_direction"])
    assert bpy.ops.synch.import_field(filepath=str(path)) == {"FINISHED"}
    assert (obj.synch.symmetry, stored_guidance(obj.synch)) == ("CROSS", "attribute:synch_direction")
    imported = directions(obj)
    assert misses(obj, imported, before, "cross").max() < 4
    api.run("directions", obj, SurfaceSettings(symmetry="cross", guidance=stored_guidance(obj.synch)))
    np.testing.assert_allclose(misses(obj, directions(obj), imported, "cross"), 0, atol=0.05)


def test_import_is_undone(tmp_path):
    obj = triangles(torus)
    path = tmp_path / "field.rosy"
    api.directions(obj)
    api.export_field(obj, path, "line")
    obj.data.attributes.remove(obj.data.attributes["synch_direction"])
    assert obj.synch.guidance == "AUTOMATIC"
    undo_and_redo(
        lambda: bpy.ops.synch.import_field(filepath=str(path)),
        lambda: (snapshot(), bpy.context.active_object.synch.guidance),
    )


def test_files_are_read_and_written_in_edit_mode(tmp_path):
    obj = sphere()
    api.directions(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    path = tmp_path / "field.rosy"
    assert bpy.ops.synch.export_field(filepath=str(path)) == {"FINISHED"}
    assert bpy.ops.synch.import_field(filepath=str(path)) == {"FINISHED"}
    assert obj.mode == "EDIT"


@pytest.mark.parametrize("command, suffix", [("directions", ".rosy"), ("stripes", ".rawfield")])
def test_command_line_exports_what_it_solved_and_follows_files(command, suffix, tmp_path, capfd):
    obj = triangles(grid)
    path = tmp_path / f"field{suffix}"
    flags = ["--quiet", "--guidance=axis:Y", "--export-field", str(path)]
    assert main.main([command, *flags], loaded=True) == 0
    assert f"wrote {path}" in capfd.readouterr().out
    np.testing.assert_allclose(np.abs(read_field(path).vectors[..., 1]), 1, atol=1e-6)
    for guidance in (f"file:{path}", f"file:{path}=0.5,axis:X=0.1"):
        api.directions(obj)
        assert main.main([command, "--quiet", f"--guidance={guidance}"], loaded=True) == 0
        np.testing.assert_allclose(np.abs(directions(obj)[:, 1]), 1, atol=1e-4)


def test_a_file_beside_the_blend_is_found_by_its_relative_path(tmp_path):
    obj = triangles(grid)
    api.directions(obj, guidance="axis:Y")
    api.export_field(obj, tmp_path / "field.rosy")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    api.directions(bpy.context.active_object, guidance="file://field.rosy")
    np.testing.assert_allclose(np.abs(directions(bpy.context.active_object)[:, 1]), 1, atol=1e-4)


def test_crosses_cannot_guide_lines(tmp_path):
    obj = triangles(grid)
    path = tmp_path / "field.rosy"
    count = len(obj.data.polygons)
    write_field(path, FaceField(4, np.tile((1.0, 0, 0), (count, 1, 1))))
    with pytest.raises(SynchError, match=r"gives 4 directions at a point.* a line field: set the symmetry to cross"):
        api.directions(obj, guidance=f"file:{path}")
    api.directions(obj, guidance=f"file:{path}", symmetry="cross")
    write_field(path, FaceField(6, np.tile((1.0, 0, 0), (count, 1, 1))))
    with pytest.raises(SynchError, match=r"gives 6 directions at a point.*: leave it out"):
        api.directions(obj, guidance=f"file:{path}", symmetry="cross")
    with pytest.raises(SynchError, match="has 6 directions a face: import fields of 1, 2 or 4"):
        api.import_field(obj, path)


def test_vertices_without_a_direction_in_the_file_get_none(tmp_path):
    obj = triangles(grid)
    x = np.array([p.center.x for p in obj.data.polygons])
    path = tmp_path / "field.rosy"
    write_field(path, FaceField(2, np.where(x < 0, 1.0, 0.0)[:, None, None] * (0, 1, 0)))
    api.import_field(obj, path)
    x = attribute(obj, "position")[:, 0]
    assert not directions(obj)[x > 0.01].any()
    np.testing.assert_allclose(np.abs(directions(obj)[x < -0.01, 1]), 1, atol=1e-6)


REMEDY = "has more than three corners and a field file has directions for triangles only: triangulate the mesh"


def test_faces_that_are_no_triangles_are_refused(tmp_path, capfd):
    obj = grid()
    path = tmp_path / "field.rosy"
    write_field(path, FaceField(2, np.tile((1.0, 0, 0), (len(obj.data.polygons), 1, 1))))
    api.directions(obj)
    before = snapshot()
    for attempt in (
        lambda: api.import_field(obj, path),
        lambda: api.export_field(obj, tmp_path / "other.rosy"),
        lambda: api.directions(obj, guidance=f"file:{path}"),
    ):
        with pytest.raises(SynchError, match=f"faces 0, 1, 2 and 141 more {REMEDY}"):
            attempt()
    for operator in (bpy.ops.synch.import_field, bpy.ops.synch.export_field):
        with pytest.raises(RuntimeError, match=REMEDY):
            operator(filepath=str(path))
    bpy.context.active_object.data.attributes.remove(obj.data.attributes["synch_direction"])
    arguments = ["directions", "--quiet", "--export-field", str(tmp_path / "other.rosy")]
    assert main.main(arguments, loaded=True) == 1
    assert REMEDY in capfd.readouterr().err
    assert "synch_direction" not in obj.data.attributes, "it was solved before it was refused"
    assert [p.name for p in tmp_path.iterdir()] == ["field.rosy"]
    api.directions(obj)
    assert snapshot() == before


def test_what_cannot_be_read_or_written_is_one_line(tmp_path, capfd):
    obj = triangles(grid)
    (tmp_path / "short.rosy").write_text("3\n2\n1 0 0\n1 0 0\n1 0 0\n")
    before = snapshot()
    for attempt, message in (
        (lambda: api.import_field(obj, tmp_path / "absent.rosy"), "cannot be read"),
        (lambda: api.import_field(obj, tmp_path / "short.rosy"), "the field has 3 faces and the mesh has 288"),
        (lambda: api.export_field(obj, tmp_path / "new.rosy"), "has no attribute 'synch_direction'"),
    ):
        with pytest.raises(SynchError, match=message):
            attempt()
    for name, message in (("field.txt", "must end in .rawfield or .rosy"), ("short.rosy/f.rosy", "cannot be written")):
        assert main.main(["directions", "--quiet", "--export-field", str(tmp_path / name)], loaded=True) == 1
        assert message in capfd.readouterr().err
    assert snapshot() == before


@pytest.mark.any_surface
@pytest.mark.parametrize("scale", [(1, 1, 1), (1, 1, 2)])
def test_directions_of_a_pattern_on_its_own_surface_are_written_for_the_faces_of_the_object(scale, tmp_path):
    obj = sphere(2)
    obj.scale = scale
    bpy.context.view_layer.update()
    api.stripes(obj, spacing=0.3, guidance="axis:Z", method="spectral")
    assert surface_of(obj) != obj and "synch_direction" not in obj.data.attributes
    api.export_field(obj, tmp_path / "field.rawfield", "line")
    vectors, up = read_field(tmp_path / "field.rawfield").vectors[:, 0], normals(obj)
    assert len(vectors) == len(obj.data.polygons)
    assert np.abs(np.einsum("ij,ij->i", vectors, up)).max() < 1e-4
    beside = np.abs(up[:, 2]) < 0.5  # away from the poles: along the axis, as seen on the face
    measured, axis = vectors * scale, np.array([0, 0, 1.0])
    across = up / scale
    across /= np.linalg.norm(across, axis=1)[:, None]
    axis = axis - across[:, 2:] * across
    cosines = np.einsum("ij,ij->i", measured, axis) / np.linalg.norm(measured, axis=1) / np.linalg.norm(axis, axis=1)
    assert np.abs(cosines[beside]).min() > 0.95


@pytest.mark.any_surface
def test_a_pattern_on_the_faces_of_modifiers_is_refused_with_what_helps(tmp_path):
    obj = sphere(2)
    obj.modifiers.new("smooth", "SUBSURF").levels = 1
    api.stripes(obj, spacing=0.3, method="spectral", surface="seen")
    with pytest.raises(SynchError, match="lies on faces that its modifiers make: apply them and solve again"):
        api.export_field(obj, tmp_path / "field.rawfield", "line")
    assert not list(tmp_path.iterdir())


def test_stretched_crosses_need_the_file_that_holds_them_all(tmp_path):
    obj = sphere()
    obj.scale = (2, 0.6, 1)
    api.directions(obj, symmetry="cross")
    with pytest.raises(SynchError, match=r"write a \.rawfield file"):
        api.export_field(obj, tmp_path / "field.rosy", "cross")
    api.export_field(obj, tmp_path / "field.rawfield", "cross")


@pytest.mark.skipif(not OTHER.exists(), reason="the shared meshes are not here")
def test_a_field_of_another_program_guides_crosses():
    """The cross field that comes with Directional's cheburashka."""
    arguments = ["directions", str(OTHER.parent / "cheburashka.obj"), "--symmetry=cross", "--quiet"]
    assert main.main([*arguments, f"--guidance=file:{OTHER}"]) == 0
    obj = next(obj for obj in bpy.context.scene.objects if obj.type == "MESH")
    followed = directions(obj)
    api.import_field(obj, OTHER)
    assert np.median(misses(obj, followed, directions(obj), "cross")) < 3
