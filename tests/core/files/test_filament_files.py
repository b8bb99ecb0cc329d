# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Filaments in files, read back by readers of their own."""

import csv
from xml.etree import ElementTree

import numpy as np

from synch_fields.core.extract.vortices.filaments import Filament
from synch_fields.core.extract.vortices.linking_numbers import linking_numbers
from synch_fields.core.files.filaments import legacy_of, polydata_of, table_of

from ..flows import ring_curve

RING = ring_curve(1.0)[:-1]
LINES = [
    Filament(RING, 2.0, True),
    Filament(np.array([[0, 0, 0], [0, 0, 0.25], [0, 0, 0.75]]), 1.0, True, (0, 0, 1), np.array([0, 0, 1.0])),
    Filament(np.array([[3.0, 0, 0], [4, 0, 0]]), 1.0, False),
]
WINDING = linking_numbers(LINES, np.zeros(3))
COURSES = [np.vstack([RING, RING[:1]]), np.array([[0, 0, 0], [0, 0, 0.25], [0, 0, 0.75], [0, 0, 1.0]]), LINES[2].points]
VALUES = {
    "circulation": [2, 1, 1],
    "length": [LINES[0].length, 1, 1],
    "writhe": [0, np.nan, np.nan],
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
    piece = ElementTree.fromstring(polydata_of(LINES, WINDING)).find("PolyData/Piece")
    points = np.array(piece.find("Points/DataArray").text.split(), float).reshape(-1, 3)
    assert piece.get("NumberOfPoints") == str(len(points)) and piece.get("NumberOfLines") == "3"
    arrays = {found.get("Name"): found.text.split() for found in piece.iter("DataArray") if found.get("Name")}
    ends = np.array(arrays["offsets"], int)
    order = np.array(arrays["connectivity"], int)
    courses = [points[run] for run in np.split(order, ends[:-1])]
    check(courses, {name: np.array(arrays[name], float) for name in VALUES})


def test_the_older_form_says_the_same():
    words = legacy_of(LINES, WINDING).split("ASCII\n", 1)[1].split()
    assert words[:3] == ["DATASET", "POLYDATA", "POINTS"]
    count = int(words[3])
    points = np.array(words[5 : 5 + 3 * count], float).reshape(-1, 3)
    words = words[5 + 3 * count :]
    assert words[:2] == ["LINES", "3"]
    numbers, courses = [int(word) for word in words[3 : 3 + int(words[2])]], []
    while numbers:
        courses.append(points[numbers[1 : numbers[0] + 1]])
        numbers = numbers[numbers[0] + 1 :]
    values = {}
    for k, word in enumerate(words):
        if word == "SCALARS":
            values[words[k + 1]] = [float(value) for value in words[k + 6 : k + 9]]
    check(courses, values)


def test_no_filaments_are_files_too():
    none = linking_numbers([], np.zeros(3))
    assert len(table_of([], none).splitlines()) == 1
    assert ElementTree.fromstring(polydata_of([], none)).find("PolyData/Piece").get("NumberOfLines") == "0"
    assert "LINES 0 0" in legacy_of([], none)


def test_places_far_from_the_origin_keep_their_digits():
    far = np.array([512002.87, 5403003.61, 216.4])
    line = Filament(RING + far, 1.0, True)
    whole = np.vstack([RING, RING[:1]])
    rows = list(csv.reader(table_of([line], None).splitlines()))[1:]
    np.testing.assert_allclose(np.array(rows, float)[:, 1:4] - far, whole, atol=2e-9)
    points = ElementTree.fromstring(polydata_of([line], None)).find(".//Points/DataArray").text
    np.testing.assert_allclose(np.array(points.split(), float).reshape(-1, 3) - far, whole, atol=2e-9)
    lines = legacy_of([line], None).splitlines()
    np.testing.assert_allclose(np.loadtxt(lines[5 : 5 + len(whole)]) - far, whole, atol=2e-9)
