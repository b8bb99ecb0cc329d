# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What follows a solve acts on what the object shows: after undo and redo, on shared meshes, after favourites."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns import favourites, memory
from synch_fields.synch_addon.patterns import numbers as stripe_numbers

from ..scenes import add_group, attribute, make_active, sphere, torus


def step(message):
    bpy.ops.ed.undo_push(message=message)


def active():
    return bpy.context.active_object


def shown(obj):
    """Phases that the object shows against those in memory: angles between them."""
    phases = memory.recall(obj).pattern.vertex_phases[:, 0]
    return np.abs(np.sin((attribute(obj, "synch_vertex_phase") - phases) / 2)).max()


def made(obj):
    """Figures that every further step takes from what is shown."""
    lines = api.isolines(obj)
    bpy.data.objects.remove(bpy.data.objects[lines["object"]])
    make_active(obj)
    return lines["lines"], pytest.approx(lines["length"]), api.number_stripes(obj), memory.state(obj).plain["energy"]


def test_undo_and_redo_bring_back_the_state_in_memory():
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    step("solve")
    first = made(obj)
    api.place_defects(obj, [11])
    step("place")
    placed = made(obj)
    for number in range(310, 320):  # as the slider does while it is dragged
        api.vary(obj, number)
    step("slider")
    varied = made(obj)
    assert first != placed != varied != first
    bpy.ops.ed.undo()
    assert shown(active()) < 1e-4 and made(active()) == placed
    bpy.ops.ed.undo()
    assert shown(active()) < 1e-4 and made(active()) == first and active().synch_shown.variation == 0
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert shown(active()) < 1e-4 and made(active()) == varied and active().synch_shown.variation == 319
    # The slider goes on from there, and so do placed defects.
    api.vary(active(), 0)
    assert made(active()) == first


def test_undo_of_a_second_solve_brings_back_the_first_in_memory():
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    step("first")
    first = made(obj)
    api.stripes(obj, spacing=0.7)
    step("second")
    bpy.ops.ed.undo()
    assert made(active()) == first and memory.recall(active()).request.spacing == pytest.approx(0.4)
    assert api.vary(active(), 200)["settings"]["spacing"] == pytest.approx(0.4)


def test_beyond_what_is_kept_lines_are_read_back_and_the_rest_asks_for_a_solve():
    obj = sphere(3)
    reports = []
    for spacing in (0.4, 0.5, 0.6):
        api.stripes(obj, spacing=spacing)
        step(f"{spacing}")
        reports.append(api.isolines(obj))
        make_active(obj)
    bpy.ops.ed.undo()
    bpy.ops.ed.undo()
    found = active()
    assert not memory.holds(found) and api.isolines(found)["lines"] == reports[0]["lines"]
    with pytest.raises(SynchError, match="no longer in memory: solve it again"):
        api.vary(found, 1)


def test_quads_are_traced_as_they_are_shown_after_undo():
    obj = torus()
    api.quads(obj, spacing=0.5)
    step("solve")
    before = memory.recall(obj).plain["energy"]
    api.vary(obj, 900)
    step("vary")
    bpy.ops.ed.undo()
    assert api.trace_quads(active())["energy"] == before


def test_objects_that_share_a_mesh_are_told_apart():
    obj = sphere(3)
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    bpy.context.view_layer.update()
    api.stripes(obj, spacing=0.4)
    api.stripes(other, spacing=0.7)
    for ask in (api.isolines, api.number_stripes, lambda found: api.vary(found, 1)):
        with pytest.raises(SynchError, match="shows another pattern than Icosphere was given: solve it again"):
            ask(obj)
    assert shown(other) < 1e-4


def test_the_report_is_copied_in_edit_mode_and_after_an_edit():
    obj = sphere()
    report = api.stripes(obj, spacing=0.5)
    add_group(obj, "some", [0])
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.synch.copy_report() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.data.vertices[0].co *= 1.1
    assert bpy.ops.synch.copy_report() == {"FINISHED"} and memory.state(obj).plain == report


# Of one state nothing of another stays


@pytest.mark.parametrize("kept", [True, False])
def test_numbers_follow_favourites_and_what_comes_back(kept):
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    api.number_stripes(obj)
    numbers, before = np.abs(attribute(obj, "synch_number")), memory.recall(obj)
    favourites.keep(obj, "mine")
    api.vary(obj, 700)
    assert not np.array_equal(np.abs(attribute(obj, "synch_number")), numbers)
    if kept:
        api.show_again(obj, before)
    else:
        memory.forget(obj)
        favourites.show(obj, "mine")
    # But for corners half way between two numbers: a favourite is kept in single precision. They also decide which way
    # stripes run, the sign, where not all neighbours can agree.
    assert (np.abs(np.abs(attribute(obj, "synch_number")) - numbers) > 1e-4).mean() < 5e-3


def test_numbers_can_wait_until_the_last_state_is_shown():
    obj = sphere(3)
    api.stripes(obj, spacing=0.4)
    api.number_stripes(obj)
    numbers = attribute(obj, "synch_number")
    api.place_defects(obj, [11], renumber=False)
    np.testing.assert_array_equal(attribute(obj, "synch_number"), numbers)
    stripe_numbers.renew_shown(obj)
    renewed = attribute(obj, "synch_number")
    assert not np.array_equal(renewed, numbers)
    api.place_defects(obj, [11])
    np.testing.assert_array_equal(attribute(obj, "synch_number"), renewed)


def test_a_favourite_takes_an_animation_out():
    obj = sphere()
    api.stripes(obj, spacing=0.5)
    favourites.keep(obj, "mine")
    api.animate(obj, frames=(1, 2), spacing=0.5)
    assert len(obj.modifiers) == 1
    favourites.show(obj, "mine")
    assert not obj.modifiers and "synch_phase.1" not in obj.data.attributes
    assert api.number_stripes(obj) == api.isolines(obj)["lines"]


# One line where something is not there


def test_defect_faces_are_selected_from_both_modes_and_asked_for_anew_once_faces_are_gone():
    obj = sphere()
    report = api.stripes(obj, spacing=0.5)
    faces = sorted({defect["face"] for kind in ("disclinations", "dislocations") for defect in report[kind]})
    for mode in ("OBJECT", "EDIT"):
        bpy.ops.object.mode_set(mode=mode)
        assert bpy.ops.synch.select_defects() == {"FINISHED"} and obj.mode == "EDIT"
        bpy.ops.object.mode_set(mode="OBJECT")
        assert [face.index for face in obj.data.polygons if face.select] == faces
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="INVERT")
    bpy.ops.mesh.delete(type="FACE")
    with pytest.raises(RuntimeError, match="faces of Icosphere were deleted since its defects were found"):
        bpy.ops.synch.select_defects()
    assert obj.mode == "EDIT"


def test_defects_are_placed_and_varied_in_edit_mode():
    obj = sphere()
    api.stripes(obj, spacing=0.5)
    bpy.ops.object.mode_set(mode="EDIT")
    assert api.place_defects(obj, [7])["dislocations"] and obj.mode == "EDIT"
    assert bpy.ops.synch.draw_variation() == {"FINISHED"} and obj.mode == "EDIT"
