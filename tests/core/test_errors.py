# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors keep what they say and where through a pipe to another process, and through new numbers."""

import pickle

import numpy as np
import pytest

from synch_fields.core.errors import AsymmetryError, ContradictionError, MeshError, SynchError

ERRORS = {
    "plain": SynchError("nothing is chosen: choose a vertex"),
    "vertices": MeshError("vertices 4 and 2 have no faces: remove them", [4, 2, 4]),
    "contradiction": ContradictionError("row A and row B fix {vertices} to different phases", [9, 3, 9]),
    "asymmetry": AsymmetryError("Y", [5, 1]),
}


@pytest.mark.parametrize("name", ERRORS)
def test_errors_come_through_a_pipe_as_they_are(name):
    error = ERRORS[name]
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error) and str(again) == str(error)
    np.testing.assert_array_equal(again.vertices, error.vertices)


def test_vertices_are_named_once_and_ascending():
    assert ERRORS["plain"].vertices.tolist() == []
    assert ERRORS["vertices"].vertices.tolist() == [2, 4]
    assert str(ERRORS["contradiction"]) == "row A and row B fix vertices 3, 9 to different phases"


@pytest.mark.parametrize("name", ["contradiction", "asymmetry"])
def test_renumbered_errors_name_the_new_vertices(name):
    error = pickle.loads(pickle.dumps(ERRORS[name])).renumbered(np.arange(10) + 100)
    np.testing.assert_array_equal(error.vertices, ERRORS[name].vertices + 100)
    assert str(error.vertices[0]) in str(error)


def test_errors_are_one_line_whatever_they_name():
    error = SynchError("a\nb\r\u2028\ud800\x1b\u00a0·ü: cannot be read")
    assert str(error) == "a\\nb\\r\\u2028\\ud800\\x1b\u00a0·ü: cannot be read"
