# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo are exact, and a run that fails or is cancelled changes nothing at all."""

import bpy
import pytest

from synch_fields.core.errors import Cancelled, SynchError
from synch_fields.core.tasks.surfaces import SurfaceRequest
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.undo_steps import undo_steps

from ..run_commands import step, undo_and_redo
from ..scenes import furnished, snapshot, sphere


def everything():
    return snapshot() | {"shown": {obj.name: (obj.hide_get(), obj.hide_render) for obj in bpy.data.objects}}


def run(operator, **settings):
    return step(lambda: getattr(bpy.ops.synch, operator)(**settings))


@pytest.mark.parametrize("operator", ["directions", "stripes", "quads", "quad_mesh"])
def test_undo_restores_everything_and_redo_brings_it_back(operator):
    furnished()

    def work():
        return getattr(bpy.ops.synch, operator)(**({} if operator == "directions" else {"spacing": 0.5}))

    after = undo_and_redo(work, everything)
    bpy.ops.ed.undo()
    assert work() == {"FINISHED"}
    assert everything() == after


@pytest.mark.parametrize("operator", ["directions", "stripes"])
def test_undo_in_edit_mode(operator):
    sphere()
    bpy.ops.ed.undo_push(message="add")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.ed.undo_push(message="edit mode")
    objects = set(bpy.data.objects.keys())
    assert getattr(bpy.ops.synch, operator)() == {"FINISHED"}
    bpy.ops.ed.undo_push(message=operator)
    bpy.ops.ed.undo()
    (obj,) = bpy.data.objects
    assert obj.mode == "EDIT" and {obj.name} == objects
    assert not bpy.data.collections and not bpy.data.materials and not obj.material_slots
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not [a.name for a in obj.data.attributes if a.name.startswith("synch_")]


@pytest.mark.any_surface
@pytest.mark.parametrize("could_redo", [False, True])
def test_undo_takes_back_what_was_written_without_a_step(could_redo):
    """Else the object, which is the same in both steps, keeps a modifier that points to its surface, which is gone."""
    obj = sphere(1)
    bpy.ops.ed.undo_push(message="add")
    before = everything()
    if could_redo:
        obj.location.x = 1.0
        bpy.ops.ed.undo_push(message="move")
        bpy.ops.ed.undo()
    api.stripes(bpy.context.object, spacing=0.5)
    undo_steps.owe("Stripes")
    assert not bpy.ops.ed.redo.poll()  # after any change, the other future is gone
    bpy.context.view_layer.update()
    after = everything()
    assert len(after["objects"]) > len(before["objects"])
    bpy.ops.ed.undo()
    assert everything() == before and not bpy.context.object.modifiers
    bpy.ops.ed.redo()
    assert everything() == after


def test_undo_of_a_second_run_restores_the_first():
    sphere()
    run("stripes", spacing=0.4)
    first, second = run("stripes", spacing=0.9)
    bpy.ops.ed.undo()
    assert snapshot() == first
    bpy.ops.ed.redo()
    assert snapshot() == second


@pytest.mark.parametrize(
    ("operator", "calls", "striped"),
    [
        ("directions", 1, False),
        ("directions", 20, True),
        ("stripes", 2, False),
        ("stripes", 60, True),
        ("quads", "second problem", True),
        ("quad_mesh", 1, False),
        ("quad_mesh", "second problem", False),
    ],
)
def test_cancelled_run_changes_nothing(operator, calls, striped):
    obj = furnished()
    if striped:
        bpy.ops.synch.stripes()
    before, asked = everything(), []

    def callback(stage, fraction):
        asked.append(fraction)
        return not ("dislocations asked for" in stage if calls == "second problem" else len(asked) == calls)

    with pytest.raises(Cancelled):
        getattr(api, operator)(obj, callback=callback, spacing=0.4, seed=5)
    assert calls in (len(asked), "second problem"), "the run goes on after it was cancelled"
    assert asked == sorted(asked) and 0 <= asked[0] <= asked[-1] <= 1
    assert everything() == before


def test_cancelling_in_edit_mode_stays_there():
    obj = sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(Cancelled):
        api.stripes(obj, callback=lambda stage, fraction: False)
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not [a.name for a in obj.data.attributes if a.name.startswith("synch_")]


def test_progress_runs_to_the_end_of_the_work():
    fractions = []
    api.stripes(sphere(), callback=lambda stage, fraction: fractions.append(fraction) is None)
    assert fractions == sorted(fractions)
    assert fractions[0] < 0.1 and fractions[-1] > 0.8


REFUSED = [
    {"spacing": 0.0},
    {"spacing": 99.0},
    {"spacing": float("nan")},
    {"symmetry": "cross"},
    {"symmetry": "hexagonal"},
    {"guidance": "attribute"},
    {"guidance": "attribute:absent"},
    {"boundary": "phase"},
    {"target_gap": 0.0},
    {"time_limit": -1.0},
    {"seed": -1},
    {"angle": float("inf")},
    {"spice": 1},
]


@pytest.mark.parametrize("striped", [False, True])
def test_refused_settings_change_nothing(striped):
    obj = furnished()
    if striped:
        bpy.ops.synch.stripes()
    before = snapshot()
    for settings in REFUSED:
        with pytest.raises(SynchError) as refusal:
            api.stripes(obj, **settings)
        assert "\n" not in str(refusal.value) and ":" in str(refusal.value), "one line: what is wrong, what to do"
        assert snapshot() == before, settings


def test_interrupted_solver_changes_nothing(monkeypatch):
    """Whatever goes wrong while solving: writing has not begun."""
    obj = furnished()
    before = snapshot()

    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(SurfaceRequest, "along", fail)
    with pytest.raises(MemoryError):
        api.stripes(obj)
    assert snapshot() == before


@pytest.mark.parametrize("method", ["sdp", "spectral", "diffusion"])
def test_time_limit_gives_a_result_or_changes_nothing(method):
    obj = furnished()
    before = snapshot()
    try:
        report = api.stripes(obj, method=method, time_limit=1e-6)
    except SynchError:
        assert snapshot() == before
    else:
        assert report["status"] == "time limit" and "synch_phase" in obj.data.attributes
