# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every bad mesh of the corpus that has a face with an area gets a certified field and keeps its faces; the others get
one line."""

import warnings

import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.geometry.manifold_repair import KINDS
from synch_fields.synch_addon import api

from ..corpus.bad_meshes import MESHES
from .scenes import add_object, snapshot

# What there is nothing to solve on, and what is said of it.
NOTHING = {
    "very far from the origin": "coordinates of 1e.07 leave steps of 1",
    "nothing": "the mesh is empty",
    "vertices alone": "has no faces",
    "all nan": "no finite position",
    "all in one place": "no area",
    "on a line": "no area",
    "everything collapsed but one": "no area",
    "collinear polygon": "no area",
}
# What is found on the others, and how often; on those that are not here nothing.
FOUND = {
    "two triangles at a vertex": {"pinched_vertices": 1},
    "nan in a corner": {"lost_vertices": 1},
    "nan in a loose vertex": {"lost_vertices": 1},
    "one coordinate nan": {"lost_vertices": 1},
    "inf": {"lost_vertices": 1},
    "minus inf": {"lost_vertices": 1},
    "slivers": {"flat_faces": 6, "pinched_vertices": 2},
    "slivers without area": {"flat_faces": 7, "pinched_vertices": 2},
    "collapsed faces": {"flat_faces": 12},
    "three fans on an edge": {"non_manifold_edges": 4, "turned_faces": 4},
    "four fans on an edge": {"non_manifold_edges": 4, "turned_faces": 8},
    "nine fans on an edge": {"non_manifold_edges": 4, "turned_faces": 16},
    "hourglass": {"pinched_vertices": 1},
    "three caps at a vertex": {"pinched_vertices": 1},
    "boxes at an edge": {"non_manifold_edges": 1},
    "boxes at a corner": {"pinched_vertices": 1},
    "boxes at a face": {"doubled_faces": 1, "non_manifold_edges": 4},
    "doubled face": {"doubled_faces": 1},
    "doubled and turned face": {"doubled_faces": 1},
    "pillow of two triangles": {"doubled_faces": 1},
    "doubled mesh": {"doubled_faces": 36},
    "double-sided mesh": {"doubled_faces": 36},
    "flipped face": {"turned_faces": 1},
    "flipped patch": {"turned_faces": 10},
    "every other face flipped": {"turned_faces": 18},
    "sheet in a torus": {"non_manifold_edges": 3},
    "wall in a box": {"non_manifold_edges": 4},
    "many holes": {"pinched_vertices": 98},
    "Moebius strip": {"one_sided_edges": 3},
    "narrow Moebius strip": {"one_sided_edges": 1},
    "Klein bottle": {"one_sided_edges": 8},
}


def places(file, obj):
    """Of the vertices, as a snapshot has them."""
    return file["meshes"][obj.data.name]["position"]


def test_there_are_kinds_enough():
    assert len(MESHES) >= 60 and {*NOTHING, *FOUND} <= MESHES.keys()
    assert {kind for found in FOUND.values() for kind in found} | {"joined_vertices"} == KINDS.keys()


@pytest.mark.parametrize("name", [pytest.param(name, id=name.replace(" ", "-")) for name in MESHES])
def test_bad_meshes_are_solved_where_they_have_an_area(name):
    vertices, faces = MESHES[name]()
    obj = add_object(vertices, faces)
    before = snapshot()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if name in NOTHING:
            for command in (api.directions, api.stripes):
                with pytest.raises(SynchError, match=NOTHING[name]) as caught:
                    command(obj, time_limit=20.0)
                assert "\n" not in str(caught.value) and snapshot() == before
            return
        report = api.stripes(obj, time_limit=20.0)
    assert report["carrier"] == FOUND.get(name, {})
    for solved in (report, report["directions"]):
        assert solved["certificate"] == "proved" and 0 <= solved["lower_bound"] <= solved["energy"]
    assert report["status"] == "certified"
    if report["closed"]:
        assert sum(d["index"] for d in report["disclinations"]) == report["euler_characteristic"]
    assert places(snapshot(), obj) == places(before, obj)
