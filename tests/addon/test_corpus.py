# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every bad mesh of the corpus gets a field or one line, a bound below its energy, and keeps its faces."""

import warnings

import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api

from ..corpus.bad_meshes import MESHES
from .scenes import add_object, snapshot


def places(file, obj):
    """Of the vertices, as a snapshot has them."""
    return file["meshes"][obj.data.name]["position"]


def test_there_are_kinds_enough():
    assert len(MESHES) >= 60


@pytest.mark.parametrize("name", [pytest.param(name, id=name.replace(" ", "-")) for name in MESHES])
def test_bad_meshes_are_solved_or_refused_in_one_line(name):
    vertices, faces = MESHES[name]()
    obj = add_object(vertices, faces)
    before = snapshot()
    for command in ("directions", "stripes"):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                report = getattr(api, command)(obj, time_limit=20.0)
            except SynchError as error:
                assert str(error) and "\n" not in str(error)
                assert snapshot() == before
                continue
        assert report["energy"] is None or report["lower_bound"] <= report["energy"]
        assert places(snapshot(), obj) == places(before, obj)
        before = snapshot()
