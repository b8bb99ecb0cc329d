# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Field files of Directional and QuadWild: what they hold, the way to vertices and back, and clear refusals."""

import re
import warnings

import numpy as np
import pytest

from synch_fields.core.defects import disclination_numbers
from synch_fields.core.errors import SettingError
from synch_fields.core.fields import direction_field
from synch_fields.core.files.directions import FaceField, from_vertices, read_field, to_vertices, write_field
from synch_fields.core.geometry import TriangleMesh

from ..meshes import EVERY, FLAT, SHARED, bent_square, disk, icosphere, shared_mesh, square, together, torus


def random_field(mesh, symmetry, seed=0):
    return from_vertices(mesh, symmetry, np.random.default_rng(seed).uniform(-4, 4, mesh.vertex_count))


def equal_turns(first, second, symmetry):
    """Degrees between angles up to turns by 2 pi / symmetry."""
    return np.degrees(np.abs(np.angle(np.exp(1j * symmetry * (first - second))))) / symmetry


# Files


@pytest.mark.parametrize("symmetry", [1, 2, 4, 6])
@pytest.mark.parametrize("suffix", [".rawfield", ".rosy", ".ROSY"])
def test_what_is_written_is_read(tmp_path, suffix, symmetry):
    field = random_field(torus(), symmetry)
    path = tmp_path / f"field{suffix}"
    write_field(path, field)
    again = read_field(path)
    assert again.symmetry == symmetry
    kept = field.vectors if suffix == ".rawfield" else field.vectors[:, :1]
    np.testing.assert_array_equal(again.vectors, kept)


def test_rawfield_has_the_degree_first_and_a_line_a_face(tmp_path):
    path = tmp_path / "field.rawfield"
    path.write_text("2 3\n1 0 0 -1 0 0 \n\n0 2.5 0 0 -2.5 0\n0 1e-1 0 0 -.1 0\n")
    field = read_field(path)
    assert field.symmetry == 2
    np.testing.assert_array_equal(field.vectors[:, 0], [[1, 0, 0], [0, 2.5, 0], [0, 0.1, 0]])
    np.testing.assert_array_equal(field.vectors[:, 1], -field.vectors[:, 0])
    write_field(path, field)
    assert path.read_text().splitlines()[:2] == ["2 3", "1 0 0 -1 0 0"]


def test_the_mark_of_windows_before_a_text_is_left_out(tmp_path):
    path = tmp_path / "a.rawfield"
    path.write_text("1 1\n1 0 0\n", encoding="utf-8-sig")
    assert read_field(path).vectors.tolist() == [[[1, 0, 0]]]


def test_rosy_has_the_faces_first_and_one_vector_a_line(tmp_path):
    path = tmp_path / "field.rosy"
    path.write_text("2\n4\n1.000000 0.000000 0.000000 \n0.600000 0.800000 0.000000 \n")
    field = read_field(str(path))
    assert field.symmetry == 4
    np.testing.assert_array_equal(field.vectors, [[[1, 0, 0]], [[0.6, 0.8, 0]]])
    write_field(path, field)
    assert path.read_text().splitlines()[:3] == ["2", "4", "1 0 0"]


# To vertices and back


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("build", "characteristic"), FLAT)
def test_a_constant_field_passes_exactly(build, characteristic, symmetry):
    mesh = build()
    turns = 0.4 + 2 * np.pi / symmetry * np.arange(symmetry)
    star = np.column_stack([np.cos(turns), np.sin(turns), 0 * turns])
    # Faces number their vectors as they like.
    shifts = np.random.default_rng(1).integers(0, symmetry, mesh.triangle_count)
    field = FaceField(symmetry, np.stack([np.roll(star, shift, axis=0) for shift in shifts]))
    guide = to_vertices(mesh, field)
    np.testing.assert_allclose(guide.weights, mesh.vertex_masses / mesh.areas.sum(), rtol=1e-9)
    back = from_vertices(mesh, symmetry, guide.angles)
    fits = np.einsum("tkc,c->tk", back.vectors, star[0]).max(axis=1)
    np.testing.assert_allclose(fits, 1, atol=1e-9)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_faces_get_unit_vectors_in_their_planes(build, characteristic, symmetry):
    mesh = build()
    vectors = random_field(mesh, symmetry).vectors
    assert vectors.shape == (mesh.triangle_count, symmetry, 3)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=2), 1, atol=1e-9)
    assert np.abs(np.einsum("tkc,tc->tk", vectors, mesh.face_normals)).max() < 1e-6
    turned = np.cross(vectors[:, 0], vectors[:, -1])
    sine = np.einsum("tc,tc->t", turned, mesh.face_normals)
    np.testing.assert_allclose(sine, -np.sin(2 * np.pi / symmetry), atol=1e-6)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("build", [lambda: torus(around=48, across=24), lambda: icosphere(3), lambda: bent_square(20)])
def test_a_smooth_field_survives_the_way_to_faces_and_back(build, symmetry):
    mesh = build()
    field = direction_field(mesh, symmetry)
    guide = to_vertices(mesh, from_vertices(mesh, symmetry, field.angles))
    away = np.ones(mesh.vertex_count, bool)
    for defect in field.disclinations:
        away &= np.linalg.norm(mesh.vertices - defect.position, axis=1) > 0.25
    assert equal_turns(guide.angles, field.angles, symmetry)[away].max() < 4
    shares = mesh.vertex_masses / mesh.areas.sum()
    assert (guide.weights <= shares * (1 + 1e-12)).all()
    assert (guide.weights[away] > 0.7 * shares[away]).all()


def test_uneven_sets_stand_for_their_nearest_cross():
    mesh = square(3)
    # A narrow rhombus about the diagonal: two directions 40 degrees to each side of it, shuffled.
    turns = np.radians([5, 85, 185, 265])[[2, 0, 3, 1]]
    vectors = np.column_stack([np.cos(turns), np.sin(turns), 0 * turns]) * [[1], [3], [2], [1]]
    guide = to_vertices(mesh, FaceField(4, np.tile(vectors, (mesh.triangle_count, 1, 1))))
    exact = to_vertices(mesh, FaceField(4, np.tile([[1.0, 0, 0]], (mesh.triangle_count, 1, 1))))
    np.testing.assert_allclose(equal_turns(guide.angles, exact.angles, 4), 0, atol=1e-9)


def test_uneven_sets_are_taken_in_counterclockwise_order():
    mesh = square(3)
    turns = np.radians([130, 10, 260])
    vectors = np.column_stack([np.cos(turns), np.sin(turns), 0 * turns])
    guide = to_vertices(mesh, FaceField(3, np.tile(vectors, (mesh.triangle_count, 1, 1))))
    # Turned back by thirds the arms are at 10, 10 and 20 degrees.
    arm = np.angle(np.exp(1j * np.radians([10, 10, 20])).sum())
    exact = to_vertices(mesh, FaceField(3, np.tile([[np.cos(arm), np.sin(arm), 0]], (mesh.triangle_count, 1, 1))))
    np.testing.assert_allclose(equal_turns(guide.angles, exact.angles, 3), 0, atol=1e-9)


def test_vectors_without_a_direction_ask_for_nothing():
    mesh = disk(6, 24)
    vectors = np.tile([[1.0, 0, 0]], (mesh.triangle_count, 1, 1))
    empty = (mesh.vertices[mesh.triangles][:, :, 0] < 0).any(axis=1)
    vectors[empty] = [0, 0, 1]
    vectors[np.flatnonzero(empty)[::2]] = 0
    weights = to_vertices(mesh, FaceField(4, vectors)).weights
    alone = np.ones(mesh.vertex_count, bool)
    alone[mesh.triangles[~empty]] = False
    np.testing.assert_array_equal(weights == 0, alone)


def test_the_cross_field_of_directional_keeps_its_directions_and_its_index_sum():
    mesh = shared_mesh("cheburashka")
    path = SHARED / "cheburashka-cf.rawfield"
    if not path.exists():
        pytest.skip(f"{path.name} is not here")
    field = read_field(path)
    assert field.symmetry == 4 and field.vectors.shape == (13334, 4, 3)
    np.testing.assert_array_equal(field.vectors[0, 0], [0.0744144, 0.713655, 1.21456])
    guide = to_vertices(mesh, field)
    assert guide.weights.sum() > 0.97
    # The bisector of the first two arms is half a quarter turn from the nearest cross.
    units = field.vectors / np.linalg.norm(field.vectors, axis=2, keepdims=True)
    bisectors = units[:, 0] + units[:, 1]
    bisectors /= np.linalg.norm(bisectors, axis=1, keepdims=True)
    back = from_vertices(mesh, 4, guide.angles)
    cosines = np.einsum("tc,tkc->tk", bisectors, back.vectors).max(axis=1)
    angles = np.abs(np.degrees(np.arccos(np.minimum(cosines, 1))) - 45)
    assert np.median(angles) < 0.5 and np.quantile(angles, 0.95) < 4
    assert disclination_numbers(mesh, np.exp(4j * guide.angles), 4).sum() == 8


def test_numbering_place_and_size_do_not_matter():
    mesh = together(bent_square(6), icosphere(1))
    random = np.random.default_rng(2)
    field = FaceField(2, np.stack([v := random.standard_normal((mesh.triangle_count, 3)), -v], axis=1))
    rotation = np.linalg.qr(random.standard_normal((3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    names, order = random.permutation(mesh.vertex_count), random.permutation(mesh.triangle_count)
    rolled = (np.arange(3) + random.integers(0, 3, (mesh.triangle_count, 1))) % 3
    vertices = np.empty_like(mesh.vertices)
    vertices[names] = 0.01 * mesh.vertices @ rotation.T
    changed = TriangleMesh(vertices, np.take_along_axis(names[mesh.triangles], rolled, axis=1)[order])
    before, after = to_vertices(mesh, field), to_vertices(changed, FaceField(2, (field.vectors @ rotation.T)[order]))
    np.testing.assert_allclose(after.weights[names], before.weights, rtol=1e-9)
    given, moved = (
        np.cos(guide.angles)[:, None] * m.tangent_frames[0] + np.sin(guide.angles)[:, None] * m.tangent_frames[1]
        for m, guide in ((mesh, before), (changed, after))
    )
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", moved[names], given @ rotation.T)), 1, atol=1e-9)


# Refusals


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.rawfield", "", "a.rawfield ends before its header: start with"),
        ("a.rawfield", "4\n", "a.rawfield, line 1: '4' is not a header, start with \"N faces\""),
        ("a.rawfield", "\n4 x\n", "a.rawfield, line 2: '4 x' is not a header"),
        ("a.rawfield", "0 1\n\n", "a.rawfield, line 1: '0 1' is not a header"),
        ("a.rawfield", "1 2\n1 0 0\n", "a.rawfield promises 2 faces and has 1 lines of vectors"),
        ("a.rawfield", "1 1\n1 0 0\n1 0 0\n", "a.rawfield promises 1 faces and has 2 lines of vectors"),
        ("a.rawfield", "2 2\n1 0 0 1 0 0\n1 0 0\n", "a.rawfield, line 3: 3 numbers where 6 are needed"),
        ("a.rawfield", "1 2\n1 0 0\n1 0 zero\n", "a.rawfield, line 3: '1 0 zero' is not all finite numbers, correct"),
        ("a.rawfield", "1 2\n1 nan 0\n1 0 0\n", "a.rawfield, line 2: '1 nan 0' is not all finite numbers"),
        ("a.rosy", "2\n", "a.rosy ends before its header: start with a line for the number of faces"),
        ("a.rosy", "2 4\n1 0 0\n1 0 0\n", "a.rosy, line 1: '2 4' is not a header, start with a line"),
        ("a.rosy", "2\n4\n1 0 0\n", "a.rosy promises 2 faces and has 1 lines"),
        ("a.rosy", "1\n4\n1 0\n", "a.rosy, line 3: 2 numbers where 3 are needed"),
        ("a.rosy", "1\n4\n1 0 é\n", "a.rosy is not a text file: export the field again"),
        ("a.field", "1\n", "a.field is not a field file: use the suffix .rawfield or .rosy"),
    ],
)
def test_malformed_files_are_refused_in_one_line(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SettingError, match=re.escape(message)) as caught:
        read_field(path)
    assert "\n" not in str(caught.value)


def test_fields_that_do_not_fit_are_refused(tmp_path):
    mesh = disk(3, 8)
    one = FaceField(4, np.tile([[1.0, 0, 0]], (mesh.triangle_count, 1, 1)))
    uneven = np.tile([[1.0, 0, 0], [1, 1, 0], [-1, 0, 0], [-1, -1, 0]], (mesh.triangle_count, 1, 1))
    with pytest.raises(SettingError, match=r"no\.rosy cannot be read \(No such file or directory\): check the path"):
        read_field(tmp_path / "no.rosy")
    with pytest.raises(SettingError, match=r"cannot be written .*: make room, or choose another place"):
        write_field(tmp_path / "nowhere" / "a.rosy", one)
    with pytest.raises(SettingError, match=r"needs 4 vectors a face and the field has one: pass it through"):
        write_field(tmp_path / "a.rawfield", one)
    with pytest.raises(SettingError, match=r"cannot hold face 0 \(40 in all\), .*: write a \.rawfield file"):
        write_field(tmp_path / "a.rosy", FaceField(4, uneven))
    with pytest.raises(SettingError, match="use the suffix"):
        write_field(tmp_path / "a.txt", one)
    assert not list(tmp_path.iterdir())
    with pytest.raises(SettingError, match=r"vectors of shape \(5, 2, 3\) do not make a field of symmetry 4: give"):
        FaceField(4, np.zeros((5, 2, 3)))
    with pytest.raises(SettingError, match=r"40 faces and the mesh has 18 triangles: load it on the triangle mesh"):
        to_vertices(square(3), one)
    on_vertices = FaceField(1, np.ones((mesh.vertex_count, 1, 3)))
    with pytest.raises(SettingError, match=r"has 25 faces \(it may be a field on vertices\) and the mesh has 40"):
        to_vertices(mesh, on_vertices)
    with pytest.raises(SettingError, match="every vector of the field is zero or normal to its face"):
        to_vertices(mesh, FaceField(1, np.tile([[0, 0, 1.0]], (mesh.triangle_count, 1, 1))))


@pytest.mark.parametrize("text", ["9" * 5000 + "\n4\n", "0\n4\n", "2\n" + "4" * 5000 + "\n", "-2\n4\n"])
def test_headers_without_a_number_that_can_be_are_refused_in_one_line(tmp_path, text):
    path = tmp_path / "field.rosy"
    path.write_text(text + "1 0 0\n1 0 0\n")
    with pytest.raises(SettingError, match=r"line \d: .* is not a header") as caught:
        read_field(path)
    assert len(str(caught.value)) < 300


def test_vectors_shorter_than_any_usual_number_have_no_direction(tmp_path):
    mesh = icosphere(0)
    for length, has_one in ((1e-300, True), (5e-324, False)):
        vectors = np.tile([[[0.0, length, length]]], (mesh.triangle_count, 1, 1))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            if has_one:
                assert to_vertices(mesh, FaceField(1, vectors)).weights.max() > 0
                continue
            with pytest.raises(SettingError, match="every vector of the field is zero"):
                to_vertices(mesh, FaceField(1, vectors))
