# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as plain data: requests go through a pipe and give the same bits, and results take nothing from the user."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SynchError
from synch_fields.core.process.ipc import Unpacker, pack_parts
from synch_fields.core.settings.layers import LayerSettings
from synch_fields.core.tasks.layer_outputs import PathSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.jobs.job import run
from synch_fields.synch_addon.solids import memory, objects, outputs, volume

from ...core.solids import block as tetrahedra
from ..plain_data import solved_apart, unpickled
from ..scenes import add_curve, add_object, attribute, make_active, set_numbers, set_vectors, snapshot, sphere
from ..solid_objects import bent_bar, block, layers_of, made

COARSE = {"spacing": 0.38, "size": 0.18}
GUIDANCE = ("axis:Z", "harmonic:Bottom:Top", "distance:Bed", "around:Line", "attribute:up")


def asked(guidance="axis:Z", **settings):
    """A job of layers in a block, with all that guides may be read from."""
    obj = block()
    add_curve([(0, 0, -2), (0, 0, 2)], "Line")
    add_object([(-3, -3, -0.7), (3, -3, -0.7), (3, 3, -0.7), (-3, 3, -0.7)], [(0, 1, 2, 3)], "Bed")
    set_vectors(obj, "up", np.tile([0, 0, 3.0], (len(obj.data.vertices), 1)))
    set_numbers(obj, "wider", 1.5 + 0.5 * attribute(obj, "position")[:, 2])
    return api.layer_job(make_active(obj), LayerSettings(guidance=guidance, **COARSE | settings))


def numbers(result):
    """All that was found but seconds, as bytes."""
    pattern, surfaces, phases = result.pattern, result.surfaces, result.phases.edge_phases
    arrays = [pattern.mesh.vertices, pattern.mesh.tets, pattern.solution.phases, pattern.edge_phases.changes]
    arrays += [surfaces.vertices, surfaces.triangles, surfaces.layers, surfaces.weights]
    arrays += [phases.mesh.vertices, phases.arguments, phases.changes]
    arrays += [array for curve in result.curves for array in (curve.points, curve.tets)]
    return [array.tobytes() for array in arrays] + [end.position for end in result.ends]


@pytest.mark.parametrize("guidance", GUIDANCE)
def test_requests_and_results_are_plain_data(guidance):
    request = asked(guidance, groups="Bottom=layer,Top=constant", spacing_map="wider").request
    copy = unpickled(request)
    result, again = request.solve(), copy.solve()
    assert len(numbers(result)) >= 11 and numbers(unpickled(again)) == numbers(result)
    assert again.warnings == result.warnings


def test_layers_that_end_inside_and_given_solids_are_plain_data():
    bar = api.layer_job(
        bent_bar(), LayerSettings(guidance="harmonic:Begin:End", groups="Begin=layer", spacing=0.22, size=0.1)
    )
    result = unpickled(bar.request).solve()
    assert result.curves and result.ends and numbers(result) == numbers(bar.request.solve())
    solid = tetrahedra((5, 5, 5))
    boundary = solid.boundary_surface[0]
    obj = make_active(add_object(boundary.vertices, boundary.triangles))
    given = api.layer_job(obj, LayerSettings(spacing=0.4), solid).request
    result = unpickled(given).solve()
    assert numbers(result) == numbers(given.solve())
    np.testing.assert_array_equal(result.solid.tets, solid.tets)


def test_a_process_without_blender_solves_and_this_one_writes(tmp_path):
    job = asked(groups="Bottom=layer")
    result = solved_apart(job.request, tmp_path)
    assert numbers(result) == numbers(job.request.solve())
    layers = layers_of(made(job.write(result)))
    assert len(layers) == 3 and layers[0][:, 2] == pytest.approx(-0.5, abs=1e-6)


def test_what_both_sides_have_does_not_travel_back():
    """A fine surface carries the phase itself: its mesh comes back as a place."""
    request = api.layer_job(sphere(4), LayerSettings(spacing=0.5, size=0.2)).request
    result = request.solve()
    parcel = b"".join(map(bytes, pack_parts(result, request.shared)))
    (back,) = Unpacker(request.shared).feed(parcel)
    assert not back.phases.is_own and back.phases.mesh is request.surface.mesh
    assert numbers(back) == numbers(result)
    whole = b"".join(map(bytes, pack_parts(result)))
    assert len(whole) - len(parcel) > request.surface.mesh.vertices.nbytes


def test_paths_and_voxels_are_plain_data(tmp_path):
    obj = bent_bar()
    api.layers(obj, guidance="harmonic:Begin:End", spacing=0.25, size=0.12)
    jobs = [outputs.PathsJob(obj, PathSettings(fill=fill)) for fill in ("contour", "across-y")]
    for job in jobs:
        paths, again = job.request.solve(), unpickled(unpickled(job.request).solve())
        for name in ("points", "normals", "sizes", "ends"):
            np.testing.assert_array_equal(getattr(again.lines, name), getattr(paths.lines, name))
        np.testing.assert_array_equal(again.layers, paths.layers)
        assert again.lines.lengths.sum() == paths.lines.lengths.sum() > 0
        (back,) = Unpacker(job.request.shared).feed(b"".join(map(bytes, pack_parts(paths, job.request.shared))))
        assert back.lines.mesh is job.request.surfaces.mesh
    job = outputs.VolumeJob(obj, tmp_path / "bar.vdb", 20)
    voxels, again = job.request.solve(), unpickled(unpickled(job.request).solve())
    assert voxels.values.dtype == np.float32 and (voxels.values > -1).sum() > 100
    np.testing.assert_array_equal(again.values, voxels.values)
    assert job.write(again)["voxels"] == (voxels.values > -1).sum()


@pytest.mark.parametrize("stage", ["tool paths", "voxels"])
def test_outputs_that_are_cancelled_leave_nothing(stage, tmp_path):
    obj = block()
    api.layers(obj, **COARSE)
    before = snapshot()
    job = outputs.PathsJob(obj, PathSettings(), tmp_path / "paths.csv")
    if stage == "voxels":
        job = outputs.VolumeJob(obj, tmp_path / "block.vdb", 20)
    with pytest.raises(Cancelled):
        run(job, lambda now, fraction: now != stage)
    assert snapshot() == before and not list(tmp_path.iterdir())


def test_paths_of_layers_that_were_solved_again_are_not_written():
    obj = block()
    api.layers(obj, **COARSE)
    job = outputs.PathsJob(obj, PathSettings())
    paths = job.request.solve()
    api.layers(obj, spacing=0.4, size=0.19)
    before = snapshot()
    with pytest.raises(SynchError, match="the layers of Block were solved again meanwhile: run again"):
        job.write(paths)
    assert snapshot() == before


def test_the_object_is_found_under_another_name():
    job = asked()
    result = job.request.solve()
    obj = bpy.data.objects["Block"]
    obj.name = "Renamed"
    other = block()
    other.name = "Block"
    report = job.write(result)
    assert report["layers_object"] == "Renamed Layers" and memory.holds_layers(obj) and not memory.holds_layers(other)


@pytest.mark.parametrize("change", ["gone", "position", "scale"])
def test_what_does_not_fit_any_more_is_not_written(change):
    job = asked()
    result = job.request.solve()
    obj = bpy.data.objects["Block"]
    if change == "gone":
        bpy.data.objects.remove(obj)
    elif change == "position":
        obj.data.vertices[3].co.x += 0.1
    else:
        obj.scale.x = 2.0
        bpy.context.view_layer.update()
    before = snapshot()
    with pytest.raises(SynchError, match=r"the object Block is gone|of Block changed while it was solved: run again"):
        job.write(result)
    assert snapshot() == before


def selected():
    return [obj.name for obj in bpy.context.selected_objects], bpy.context.view_layer.objects.active


def test_layers_are_selected_where_nobody_has_gone_on():
    job = asked()
    layers = made(job.write(job.request.solve()))
    assert selected() == ([layers.name], layers) and bpy.data.objects["Block"].hide_get()
    job = asked(spacing=0.4)
    result = job.request.solve()
    bpy.context.view_layer.objects.active = None
    assert selected()[1] is None
    layers = made(job.write(result))
    assert selected() == ([layers.name], layers)


def test_layers_take_no_selection_from_a_user_who_has_gone_on():
    job = asked()
    result = job.request.solve()
    make_active(bpy.data.objects["Bed"])
    before = selected()
    layers = made(job.write(result))
    assert selected() == before and layers.visible_get() and bpy.data.objects["Block"].hide_get()


def test_what_the_user_has_hidden_or_shown_meanwhile_stays_so():
    obj = block()
    layers = made(api.layers(obj, **COARSE))
    make_active(obj)
    job = api.layer_job(obj, LayerSettings(spacing=0.4, size=0.19))
    result = job.request.solve()
    obj.hide_set(False)
    obj.hide_render = False
    layers.hide_set(True)
    job.write(result)
    assert obj.visible_get() and not obj.hide_render and layers.hide_get()
    run(api.layer_job(obj, LayerSettings(spacing=0.4, size=0.19)))
    assert obj.hide_get() and obj.hide_render and not layers.hide_get()


@pytest.mark.parametrize("again", [False, True])
def test_layers_are_written_whole_or_not_at_all(again, monkeypatch):
    obj = bent_bar()
    settings = {"guidance": "harmonic:Begin:End", "spacing": 0.3, "size": 0.13}
    if again:
        api.layers(obj, **settings | {"spacing": 0.28})
    make_active(obj)

    def fails(*arguments, **options):
        raise MemoryError

    job = api.layer_job(obj, LayerSettings(**settings))
    result = job.request.solve()
    assert result.curves and result.phases.is_own
    before = snapshot()
    for step in ("layer_material", "curve_material", "write_defects", "pattern_material"):
        with monkeypatch.context() as patched, pytest.raises(MemoryError):
            patched.setattr(objects, step, fails)
            job.write(result)
        assert snapshot() == before and memory.holds_layers(obj) == again
    assert made(job.write(result)).name == "Block Layers"


def test_paths_and_volumes_are_written_whole_or_not_at_all(tmp_path, monkeypatch):
    obj = block()
    api.layers(obj, **COARSE)
    for _ in range(2):
        before = snapshot()
        for module, step, call in (
            (outputs.files, "add_splines", lambda: api.layer_toolpaths(obj, 0.2)),
            (volume, "_show", lambda: api.layer_volume(obj, tmp_path / "block.vdb", 16)),
        ):
            with monkeypatch.context() as patched, pytest.raises(MemoryError):
                patched.setattr(module, step, lambda *arguments: (_ for _ in ()).throw(MemoryError))
                call()
            assert snapshot() == before
        api.layer_toolpaths(obj, 0.2)
        api.layer_volume(obj, tmp_path / "block.vdb", 16)


def test_warnings_name_what_the_layers_do_not_follow_and_leave_out_our_own():
    obj = sphere(4)
    api.stripes(obj, spacing=0.3)
    api.relief(obj)
    assert obj.modifiers and api.layers(obj, spacing=0.5, size=0.2)["warnings"] == []
    other = block()
    other.modifiers.new("Bend", "SIMPLE_DEFORM")
    twin = other.copy()
    bpy.context.scene.collection.objects.link(twin)
    users, modifiers = api.layers(other, **COARSE)["warnings"]
    assert users.endswith("is shared by 2 users, which all get the phase")
    assert modifiers.startswith("layers are solved on the mesh before its modifiers (Bend): apply them first")
