# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes far from the origin and tiny ones: solved in their own frame, written with all their digits."""

import json
import re
from itertools import permutations, product

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import MeshError, SettingError
from synch_fields.core.files.digits import number_format
from synch_fields.core.files.obj_files import far_centre
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.command.main import main

from .scenes import add_object, sphere

FAR = np.array([512002.87, 5403003.61, 216.4])


def ball():
    """Vertices and faces of a sphere of radius 4 that no file has rounded, around the origin."""
    obj = sphere(3)
    places = 4.0 * np.array([vertex.co[:] for vertex in obj.data.vertices])
    return places, [list(face.vertices) for face in obj.data.polygons]


def write(path, places, faces):
    rows = ["o far ball", *("v " + " ".join(map(repr, place)) for place in places.tolist())]
    path.write_text("\n".join([*rows, *("f " + " ".join(str(k + 1) for k in face) for face in faces)]) + "\n")


def rows(path, keyword):
    lines = path.read_text().splitlines()
    return [line.split()[1:] for line in lines if line.startswith(f"{keyword} ")]


def without_digits(line):
    """A line whose decimal numbers end after three digits: rounding far from the origin changes later ones."""
    return re.sub(r"\d+\.\d+", lambda number: f"{float(number[0]):.3g}", line)


def places_of(path):
    return np.array(rows(path, "v"), float)


def test_a_mesh_far_from_the_origin_is_solved_in_its_own_frame_and_written_back(tmp_path):
    places, faces = ball()
    reports = []
    for name, shift in (("near", np.zeros(3)), ("far", FAR)):
        write(tmp_path / f"{name}.obj", places + shift, faces)
        outputs = ["--export-mesh", str(tmp_path / f"{name}_quads.obj"), "--report", str(tmp_path / f"{name}.json")]
        assert main(["quad_mesh", str(tmp_path / f"{name}.obj"), "--faces", "300", "--quiet", *outputs]) == 0
        reports.append(json.loads((tmp_path / f"{name}.json").read_text()))
    near, far = reports
    assert near["quad_mesh"]["faces"] == far["quad_mesh"]["faces"]
    assert [without_digits(line) for line in far["warnings"]] == [without_digits(line) for line in near["warnings"]]
    assert near["energy"] == pytest.approx(far["energy"], rel=1e-2)  # rounding may lead to another field as good
    made = places_of(tmp_path / "far_quads.obj")
    assert np.abs(np.linalg.norm(made - FAR, axis=1) - 4).max() < 0.1
    assert len(np.unique(made, axis=0)) == len(made)


def write_block(folder, shift, count=6):
    """A unit cube of 6 tetrahedra in each of its cells as block.mesh, with vertical vectors as block.sol."""
    places = np.array(list(product(range(count + 1), repeat=3))) / count + shift
    rows = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(places))]
    rows += [" ".join(map(repr, place)) + " 0" for place in places.tolist()]
    numbers = np.arange(len(places)).reshape(3 * [count + 1])
    tets = []
    for corner in product(range(count), repeat=3):
        for axes in permutations(range(3)):
            steps = np.cumsum([np.zeros(3, int), *(np.eye(3, dtype=int)[axis] for axis in axes)], axis=0)
            tets.append([numbers[tuple(step)] + 1 for step in steps + corner])
    rows += ["Tetrahedra", str(len(tets)), *(" ".join(map(str, tet)) + " 0" for tet in tets), "End"]
    (folder / "block.mesh").write_text("\n".join(rows) + "\n")
    vectors = f"SolAtVertices\n{len(places)}\n1 2\n" + f"0 {0.6} {0.8}\n" * len(places)
    (folder / "block.sol").write_text(f"MeshVersionFormatted 2\nDimension 3\n{vectors}End\n")


def test_tetrahedra_far_from_the_origin_are_solved_in_their_own_frame_and_written_back(tmp_path, capfd):
    reports, made = [], []
    for name, shift in (("near", np.zeros(3)), ("far", FAR)):
        (tmp_path / name).mkdir()
        write_block(tmp_path / name, shift)
        place = str(tmp_path / name / "block")
        outputs = ["--export-mesh", f"{place}.obj", "--export-paths", f"{place}.csv", "--report", f"{place}.json"]
        arguments = ["layers", f"{place}.mesh", "--spacing", "0.4", "--guidance", f"file:{place}.sol", "--quiet"]
        assert main([*arguments, *outputs]) == 0, capfd.readouterr().err
        reports.append(json.loads((tmp_path / name / "block.json").read_text()))
        made.append(places_of(tmp_path / name / "block.obj"))
    near, far = reports
    assert far["layers"] == near["layers"] and far["energy"] == pytest.approx(near["energy"], rel=1e-3, abs=1e-6)
    assert np.abs(made[1] - FAR - made[0]).max() < 1e-4
    paths = [np.loadtxt(tmp_path / name / "block.csv", delimiter=",", skiprows=1)[:, 2:5] for name in ("near", "far")]
    assert len(paths[1]) == pytest.approx(len(paths[0]), rel=0.2)  # points on straight ways are left out
    distances, _ = cKDTree(paths[0]).query(paths[1] - FAR)
    assert np.median(distances) < 1e-6


def test_what_is_read_far_away_is_written_as_it_was(tmp_path):
    places, faces = ball()
    write(tmp_path / "ball.obj", places + FAR, faces)
    obj = files.open_object(tmp_path / "ball.obj")
    files.export_mesh(obj, tmp_path / "again.obj")
    assert np.abs(places_of(tmp_path / "again.obj") - (places + FAR)).max() < 2e-6
    assert obj.name == "far ball"
    assert far_centre(tmp_path / "ball.obj") is not None
    write(tmp_path / "ball.obj", places + [30, 0, 0], faces)
    assert far_centre(tmp_path / "ball.obj") is None


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_obj_files_have_as_many_places_as_the_mesh(tmp_path, size):
    places, faces = ball()
    places = (places * size).astype(np.float32)
    obj = add_object(places, faces)
    files.export_mesh(obj, tmp_path / "ball.obj", z_up=True)
    written = places_of(tmp_path / "ball.obj")
    np.testing.assert_array_equal(written.astype(np.float32), places)
    corners = [[int(word.split("/")[0]) - 1 for word in face] for face in rows(tmp_path / "ball.obj", "f")]
    assert corners == faces


def test_obj_files_carry_normals_uv_and_the_side_of_mirrored_objects(tmp_path):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    obj = bpy.context.object
    obj.name = "a\nb  c"
    obj.data.shade_smooth()
    obj.scale = (-1, 2, 1)
    bpy.context.view_layer.update()
    files.export_mesh(obj, tmp_path / "ball.obj")
    assert "\no a_b_c\n" in (tmp_path / "ball.obj").read_text()
    files.open_input(tmp_path / "ball.obj")
    back = bpy.context.scene.objects[0].data
    assert len(back.uv_layers) == 1 and back.has_custom_normals and all(face.use_smooth for face in back.polygons)
    inwards = [face.normal.dot(face.center) for face in back.polygons]
    assert min(inwards) > 0
    assert (
        min(
            corner.vector.dot(back.vertices[loop.vertex_index].co)
            for corner, loop in zip(back.corner_normals, back.loops, strict=True)
        )
        > 0
    )


def test_single_precision_that_has_destroyed_a_shape_is_named():
    places, faces = ball()
    obj = add_object(places / 8 + FAR, faces)
    line = r"coordinates of 5.4e\+06 leave steps of 0.5 between neighbours in single precision: move the object's"
    with pytest.raises(MeshError, match=line):
        api.stripes(obj)


def test_single_precision_that_is_seen_is_told(tmp_path):
    places, faces = ball()
    obj = add_object(places * 8 + FAR, faces)
    report = api.stripes(obj, method="spectral")
    assert any("leave steps of 0.5" in line for line in report["warnings"])
    for suffix in (".stl", ".ply"):
        with pytest.raises(SettingError, match=r"leave steps of 0\.5 .*, or write an \.obj"):
            files.export_mesh(obj, tmp_path / f"ball{suffix}")


SPIKED = [
    ("stripes", {}),
    ("quads", {}),
    ("quads", {"spacing": 0.5}),
    ("quad_mesh", {"faces": 500}),
    pytest.param("layers", {"spacing": 0.5}, marks=pytest.mark.slow),
]


@pytest.mark.any_surface
@pytest.mark.parametrize(("command", "settings"), SPIKED)
def test_a_vertex_far_out_is_named_and_deleting_it_helps(command, settings):
    places, faces = ball()
    places[100] *= 1e6 if command == "stripes" else 1e9
    obj = add_object(places, faces)
    with pytest.raises(MeshError, match=r"vertex 100 lies .* from the origin, the others within 4: delete it"):
        getattr(api, command)(obj, **settings)
    keep = [face for face in faces if 100 not in face]
    rim = {vertex for face in faces if 100 in face for vertex in face} - {100}
    if command == "layers":  # a hole has to be closed, as the vertex may be put back
        places[100] = np.mean([places[vertex] for vertex in rim], axis=0)
        keep = faces
    report = getattr(api, command)(add_object(places, keep), **settings, method="spectral")
    assert not any("lies" in line for line in report["warnings"])


def test_what_needs_no_finer_faces_is_made_with_a_vertex_far_out_and_warned_of(tmp_path):
    places, faces = ball()
    places[100] *= 1e9
    obj = add_object(places, faces)
    report = api.directions(obj)
    assert any("vertex 100 lies" in line for line in report["warnings"])
    report = api.stripes(obj, surface="faces")
    assert any("vertex 100 lies" in line for line in report["warnings"])
    api.bake(obj, maps="mask", size=16, samples=1, unwrap=True, folder=str(tmp_path))
    assert list(tmp_path.glob("*.png"))


def test_the_finest_spacing_that_is_named_is_accepted():
    places, faces = ball()
    obj = add_object(places * 1e6, faces)
    with pytest.raises(SettingError, match="finer than the precision of coordinates") as refused:
        api.quads(obj, spacing=1e-4, surface="faces")
    finest = float(str(refused.value).split("give one from ")[1].removesuffix(" on"))
    api.quads(obj, spacing=finest, surface="faces", method="spectral")


def test_numbers_have_nine_digits_of_the_extent():
    assert number_format(np.array([[0, 0, 0], [1e-6, 0, 0]])) == "%.9g"
    assert number_format(np.array([[5e6, 0, 0], [5e6 + 8, 0, 0]])) == "%.15g"
    assert number_format(np.empty((0, 3))) == "%.9g"


def test_names_with_line_ends_stay_in_one_line(tmp_path):
    obj = add_object(np.zeros((3, 3)), [[0, 1, 2]])
    obj.name = "two\nlines\x1b[2J"
    with pytest.raises(Exception, match=r"two\\nlines\\x1b\[2J") as caught:
        api.vary(obj, 1)
    assert "\n" not in str(caught.value)
