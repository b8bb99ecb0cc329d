# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Filaments in files, read back by readers of their own."""

import csv
from xml.etree import ElementTree

import numpy as np
import pytest

from synch_fields.core.extract.vortices.filaments import Filament
from synch_fields.core.extract.vortices.linking_numbers import linking_numbers
from synch_fields.core.extract.vortices.tubes import Tubes
from synch_fields.core.files.filaments import (
    WRITERS,
    filament_shape,
    legacy_of,
    obj_of,
    ply_of,
    polydata_of,
    table_of,
    tube_shape,
)

from ..flows import ring_curve

RING = ring_curve(1.0)[:-1]
LINES = [
    Filament(RING, 2.0, True, share=0.5),
    Filament(np.array([[0, 0, 0], [0, 0, 0.25], [0, 0, 0.75]]), 1.0, True, (0, 0, 1), np.array([0, 0, 1.0])),
    Filament(np.array([[3.0, 0, 0], [4, 0, 0]]), 1.0, False),
]
WINDING = linking_numbers(LINES, np.zeros(3))
COURSES = [np.vstack([RING, RING[:1]]), np.array([[0, 0, 0], [0, 0, 0.25], [0, 0, 0.75], [0, 0, 1.0]]), LINES[2].points]
VALUES = {
    "circulation": [2, 1, 1],
    "length": [LINES[0].length, 1, 1],
    "writhe": [0, 0, 0],
    "vorticity_share": [0.5, 0, 0],
    "closed": [1, 1, 0],
    "winding_z": [0, 1, 0],
}


def check(courses, values):
    assert len(courses) == len(COURSES)
    for found, expected in zip(courses, COURSES, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-8)
    for name, expected in VALUES.items():
        np.testing.assert_allclose(values[name], expected, atol=1e-8)


def test_a_table_has_a_row_for_each_point():
    rows = list(csv.DictReader(table_of(LINES, WINDING).splitlines()))
    lists = [[row for row in rows if row["filament"] == str(k)] for k in range(3)]
    values = {name: [float(one[0][name]) for one in lists] for name in VALUES}
    check([[[float(row[axis]) for axis in "xyz"] for row in one] for one in lists], values)


def test_polydata_has_a_polyline_for_each_filament():
    piece = ElementTree.fromstring(polydata_of(filament_shape(LINES, WINDING))).find("PolyData/Piece")
    points = np.array(piece.find("Points/DataArray").text.split(), float).reshape(-1, 3)
    assert piece.get("NumberOfPoints") == str(len(points)) and piece.get("NumberOfLines") == "3"
    arrays = {found.get("Name"): found.text.split() for found in piece.iter("DataArray") if found.get("Name")}
    ends = np.array(arrays["offsets"], int)
    order = np.array(arrays["connectivity"], int)
    courses = [points[run] for run in np.split(order, ends[:-1])]
    check(courses, {name: np.array(arrays[name], float) for name in VALUES})


def test_the_older_form_says_the_same():
    words = legacy_of(filament_shape(LINES, WINDING)).split("ASCII\n", 1)[1].split()
    assert words[:3] == ["DATASET", "UNSTRUCTURED_GRID", "POINTS"]
    count = int(words[3])
    points = np.array(words[5 : 5 + 3 * count], float).reshape(-1, 3)
    words = words[5 + 3 * count :]
    pieces = sum(len(course) - 1 for course in COURSES)
    assert words[:3] == ["CELLS", str(pieces), str(3 * pieces)]
    ends = np.array(words[3 : 3 + 3 * pieces], int).reshape(-1, 3)
    assert (ends[:, 0] == 2).all() and words[3 + 3 * pieces : 5 + 4 * pieces] == ["CELL_TYPES", str(pieces)] + [
        "3"
    ] * pieces
    values = {}
    for k, word in enumerate(words):
        if word == "SCALARS":
            values[words[k + 1]] = np.array(words[k + 6 : k + 6 + pieces], float)
    courses = []
    for number in range(3):
        own = values["filament"] == number
        courses.append(points[[*ends[own, 1], ends[own, 2][-1]]])
        np.testing.assert_array_equal(ends[own, 1][1:], ends[own, 2][:-1])
    firsts = [np.flatnonzero(values["filament"] == number)[0] for number in range(3)]
    check(courses, {name: values[name][firsts] for name in VALUES})


# A tetrahedron's surface, in the colours of the sphere.
CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
TUBES = Tubes(CORNERS, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), CORNERS / np.sqrt(3), 1.0, 1)


def test_lines_and_triangles_as_ply_and_obj():
    shape = filament_shape(LINES, WINDING)
    head, body = ply_of(shape).split("end_header\n")
    count, pieces = len(shape.points), sum(len(course) - 1 for course in COURSES)
    assert f"element vertex {count}" in head and f"element face {pieces}" in head and "red" not in head
    rows = body.splitlines()
    np.testing.assert_allclose(np.array([row.split() for row in rows[:count]], float), np.vstack(COURSES), atol=1e-8)
    ends = [tuple(map(int, row.split())) for row in rows[count:]]
    assert ends[0] == (2, 0, 1) and ends[-1] == (2, count - 2, count - 1) and len(ends) == pieces
    words = [row.split() for row in obj_of(shape).splitlines()]
    lines = [list(map(int, rest)) for kind, *rest in words if kind == "l"]
    assert [len(line) for line in lines] == [len(course) for course in COURSES]
    places = np.array([rest for kind, *rest in words if kind == "v"], float)
    for line, course in zip(lines, COURSES, strict=True):
        np.testing.assert_allclose(places[np.array(line) - 1], course, atol=1e-8)
    head, body = ply_of(tube_shape(TUBES)).split("end_header\n")
    assert "property uchar red" in head
    np.testing.assert_allclose(
        np.array([row.split() for row in body.splitlines()[:4]], float)[:, 3:] / 127.5 - 1, TUBES.sphere, atol=1 / 255
    )
    assert obj_of(tube_shape(TUBES)).splitlines()[-1] == "f 2 3 4"


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("library", ["pyvista", "meshio"])
def test_other_libraries_read_what_is_written(tmp_path, library, suffix):
    reader = pytest.importorskip(library)
    if library == "meshio" and suffix == ".vtp":
        pytest.skip("meshio has no .vtp")
    for shape in (filament_shape(LINES, WINDING), tube_shape(TUBES)):
        path = tmp_path / f"vortices{suffix}"
        path.write_text(WRITERS[suffix](shape))
        found = reader.read(path)
        points = np.asarray(found.points)
        np.testing.assert_allclose(points, shape.points, atol=1e-5)
        if library == "meshio":
            cells = [row.tolist() for block in found.cells for row in block.data]
        else:
            whole = found.cast_to_unstructured_grid()
            cells = [whole.get_cell(number).point_ids for number in range(whole.n_cells)]
        expected = shape.segments if suffix in (".ply", ".vtk") else shape
        if not (library == "meshio" and suffix == ".obj" and shape.are_lines):  # it takes no lines of an .obj
            assert sorted(map(list, cells)) == sorted(expected.cells)
        if suffix in (".vtp", ".vtk") and shape.are_lines:
            data = found.cell_data["circulation"]
            wanted = expected.values["circulation", "Float64"]
            np.testing.assert_allclose(np.ravel(np.concatenate(data) if library == "meshio" else data), wanted)


def test_no_filaments_are_files_too():
    none = linking_numbers([], np.zeros(3))
    assert len(table_of([], none).splitlines()) == 1
    assert (
        ElementTree.fromstring(polydata_of(filament_shape([], none))).find("PolyData/Piece").get("NumberOfLines") == "0"
    )
    assert "CELLS 0 0" in legacy_of(filament_shape([], none))


def test_places_far_from_the_origin_keep_their_digits():
    far = np.array([512002.87, 5403003.61, 216.4])
    line = Filament(RING + far, 1.0, True)
    whole = np.vstack([RING, RING[:1]])
    rows = list(csv.reader(table_of([line], None).splitlines()))[1:]
    np.testing.assert_allclose(np.array(rows, float)[:, 1:4] - far, whole, atol=2e-9)
    points = ElementTree.fromstring(polydata_of(filament_shape([line], None))).find(".//Points/DataArray").text
    np.testing.assert_allclose(np.array(points.split(), float).reshape(-1, 3) - far, whole, atol=2e-9)
    lines = legacy_of(filament_shape([line], None)).splitlines()
    np.testing.assert_allclose(np.loadtxt(lines[5 : 5 + len(whole)]) - far, whole, atol=2e-9)
