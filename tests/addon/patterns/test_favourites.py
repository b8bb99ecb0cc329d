# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Favourites: variations kept as attributes, shown again exactly, also after the file was saved and opened."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns import favourites, memory

from ..run_commands import undo_and_redo
from ..scenes import (
    add_group,
    attribute,
    empties,
    grid,
    make_active,
    mark_edges,
    places,
    quad_sphere,
    save_and_reopen,
    set_numbers,
    snapshot,
    sphere,
    torus,
)

SOLVES = {
    "stripes": (sphere, "stripes", {"spacing": 0.4}),
    "stripes on quads": (quad_sphere, "stripes", {"spacing": 0.5}),
    "stripes along vectors": (torus, "stripes", {"spacing": 0.5, "symmetry": "vector", "angle": 0.3}),
    "quads": (sphere, "quads", {"spacing": 0.8}),
    "quads with a map": (quad_sphere, "quads", {"spacing": 0.8, "spacing_map": "map"}),
}


def solved(kind):
    build, command, settings = SOLVES[kind]
    obj = build()
    set_numbers(obj, "map", 1 + 0.3 * places(obj)[:, 2])
    getattr(api, command)(obj, **settings)
    return obj


def pattern(obj):
    """What shows the pattern: attributes by their names, phases as points on the circle."""
    shown = {}
    for found in obj.data.attributes:
        name = found.name
        if not name.startswith("synch_") or name.startswith("synch_favourite"):
            continue
        values = attribute(obj, name).astype(float)
        shown[name] = np.exp(1j * values) if "phase" in name else values
    return shown


def agree(obj, before):
    now = pattern(obj)
    assert set(now) == set(before)
    for name, values in now.items():
        np.testing.assert_allclose(values, before[name], atol=2e-4, err_msg=name)
    return True


@pytest.mark.parametrize("kind", SOLVES)
def test_favourite_is_shown_again_exactly(kind):
    obj = solved(kind)
    api.vary(obj, 1_000)
    before, energy = pattern(obj), api.vary(obj, 1_000)["energy"]
    defects = sorted((e["synch_kind"], e["synch_face"]) for e in empties(obj))
    assert favourites.keep(obj) == "Variation 1000"
    api.vary(obj, 0)
    result = favourites.show(obj, "Variation 1000")
    assert agree(obj, before) and result["energy"] == pytest.approx(energy, rel=1e-5)
    assert obj.synch_shown.variation == 1000
    assert sorted((e["synch_kind"], e["synch_face"]) for e in empties(obj)) == defects
    # The solve stays in memory: the slider goes on.
    api.vary(obj, 3)
    # And without it.
    memory.forget(obj)
    result = favourites.show(obj, "Variation 1000")
    assert agree(obj, before) and result["energy"] == pytest.approx(energy, rel=1e-5)
    assert not memory.holds(obj)


@pytest.mark.parametrize("kind", ["stripes", "quads with a map"])
def test_favourites_survive_saving(kind, tmp_path):
    obj = solved(kind)
    first = pattern(obj)
    favourites.keep(obj, "first")
    api.vary(obj, 1_000)
    second = pattern(obj)
    favourites.keep(obj, "second")
    obj = save_and_reopen(tmp_path / "kept.blend", obj.name)
    assert not memory.holds(obj) and [f.name for f in obj.synch.favourites] == ["first", "second"]
    for name, before in (("first", first), ("second", second), ("first", first)):
        assert bpy.ops.synch.show_favourite(name=name) == {"FINISHED"}
        assert agree(obj, before)


def test_favourite_of_another_spacing_comes_back_with_it():
    obj = sphere()
    api.stripes(obj, spacing=0.4)
    before = pattern(obj)
    favourites.keep(obj, "fine")
    api.stripes(obj, spacing=0.9)
    favourites.show(obj, "fine")
    assert agree(obj, before) and obj["synch_spacing"] == pytest.approx(0.4)


def test_favourite_of_other_directions_is_no_variation_of_the_last_solve():
    obj = grid()
    api.stripes(obj, spacing=0.4)
    before = pattern(obj)
    favourites.keep(obj, "straight")
    api.stripes(obj, spacing=0.4, angle=0.5)
    favourites.show(obj, "straight")
    assert agree(obj, before)


def test_names_are_told_apart_and_attributes_are_removed():
    obj = solved("stripes")
    names = [favourites.keep(obj, "mine"), favourites.keep(obj, "mine"), favourites.keep(obj)]
    assert names == ["mine", "mine (2)", "Variation 0"]
    kept = [a.name for a in obj.data.attributes if a.name.startswith("synch_favourite_")]
    assert len(kept) == 6
    favourites.remove(obj, "mine (2)")
    left = [a.name for a in obj.data.attributes if a.name.startswith("synch_favourite_")]
    assert len(left) == 4 and not any(name.startswith("synch_favourite_2_") for name in left)
    favourites.keep(obj, "new")
    favourites.show(obj, "mine")
    with pytest.raises(SynchError, match=r"no favourite 'mine \(2\)'"):
        favourites.show(obj, "mine (2)")


def test_a_name_that_is_taken_is_changed_when_it_is_edited():
    obj = solved("stripes")
    for _ in range(3):
        favourites.keep(obj, "mine")
    kept = obj.synch.favourites
    kept[0].name = "mine (3)"
    assert [favourite.name for favourite in kept] == ["mine (3) (2)", "mine (2)", "mine (3)"]
    kept[0].name = "mine"
    kept[2].name = ""
    assert [favourite.name for favourite in kept] == ["mine", "mine (2)", "Variation 0"]
    favourites.remove(obj, "mine")
    assert [(favourite.number, favourite.name) for favourite in kept] == [(2, "mine (2)"), (3, "Variation 0")]


def of_favourites(obj):
    return {a.name: attribute(obj, a.name).tobytes() for a in obj.data.attributes if "favourite" in a.name}


def test_objects_of_one_mesh_keep_favourites_of_their_own():
    obj = solved("stripes")
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    favourites.keep(obj, "first")
    first = of_favourites(obj)
    make_active(other)
    api.stripes(other, spacing=0.7)
    favourites.keep(other, "second")
    assert first.items() < of_favourites(obj).items() and len(of_favourites(obj)) == 4
    favourites.remove(other, "second")
    assert of_favourites(obj) == first


def test_a_linked_copy_still_has_its_favourite_when_the_original_loses_it():
    obj = solved("stripes")
    favourites.keep(obj, "kept")
    before = pattern(obj)
    copy = obj.copy()
    bpy.context.scene.collection.objects.link(copy)
    favourites.remove(obj, "kept")
    make_active(copy)
    favourites.show(copy, "kept")
    assert agree(copy, before)
    favourites.remove(copy, "kept")
    assert not of_favourites(copy)


def test_a_later_solve_leaves_favourites_alone():
    obj = solved("stripes")
    before = pattern(obj)
    favourites.keep(obj, "stripes")
    api.quads(obj, spacing=0.9)
    assert len(obj.synch.favourites) == 1
    favourites.show(obj, "stripes")
    agree(obj, {name: values for name, values in before.items()})


def test_undo_and_redo_of_keeping():
    solved("stripes")
    undo_and_redo(bpy.ops.synch.keep_favourite, lambda: (snapshot(), len(bpy.context.active_object.synch.favourites)))
    assert len(bpy.context.active_object.synch.favourites) == 1


def test_what_cannot_be_kept_is_refused():
    obj = grid()
    with pytest.raises(SynchError, match="shows no stripes or quads"):
        favourites.keep(obj)
    assert not bpy.ops.synch.keep_favourite.poll() and not bpy.ops.synch.show_favourite.poll()
    mark_edges(obj, "seams", np.abs(places(obj)[:, 0]) < 1e-6)
    api.stripes(obj, constraints=[{"where": "seams", "what": "cut"}])
    before = snapshot()
    with pytest.raises(SynchError, match="has cuts"):
        favourites.keep(obj)
    assert snapshot() == before
    api.stripes(obj, spacing=0.5)
    favourites.keep(obj, "kept")
    obj.data.attributes.remove(obj.data.attributes["synch_favourite_1_phase"])
    before = snapshot()
    with pytest.raises(SynchError, match="no attribute 'synch_favourite_1_phase'"):
        favourites.show(obj, "kept")
    assert snapshot() == before


@pytest.mark.parametrize("kind", ["stripes", "stripes on quads", "quads"])
def test_lines_as_curves_after_opening_the_file_again(kind, tmp_path):
    obj = solved(kind)
    before = api.isolines(obj)
    obj = save_and_reopen(tmp_path / "lines.blend", obj.name)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.synch.isolines.poll()
    now = api.isolines(obj)
    assert (now["lines"], now["closed"], now["ends"]) == (before["lines"], before["closed"], before["ends"])
    assert now["length"] == pytest.approx(before["length"], rel=1e-4)


def test_lines_of_a_pattern_with_cuts_need_its_solve(tmp_path):
    obj = grid()
    add_group(obj, "some", range(4))
    mark_edges(obj, "seams", np.abs(places(obj)[:, 0]) < 1e-6)
    api.stripes(obj, spacing=0.5, constraints=[{"where": "seams", "what": "cut"}])
    api.isolines(obj)
    obj = save_and_reopen(tmp_path / "cut.blend", obj.name)
    with pytest.raises(SynchError, match="has cuts, which its attributes cannot store: solve it again"):
        api.isolines(obj)
