# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is asked and found of flows is plain data: it goes through a pipe, and a process without Blender solves it."""

import itertools
import pickle
from functools import partial

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.core.process.ipc import Unpacker, pack_parts
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.flows.job import job_for

from ..plain_data import solved_apart, unpickled
from ..scenes import make_active
from ..vortex_scenes import QUICK, points_of, write_npz, write_vdb

KINDS = ("arrays", "volume", "curves", "surface", "plane", "frames")


def asked(kind, folder):
    """The job of a flow of a kind."""
    settings = QUICK | {"quantum": 0.5, "resolution": 18, "show": "both", "opening": 100.0}
    if kind == "arrays":
        source = write_npz(folder / "ring.npz")
    elif kind == "volume":
        source = write_vdb(folder / "ring.vdb")
    elif kind == "curves":
        bpy.ops.curve.primitive_bezier_circle_add()
        source = make_active(bpy.context.active_object)
    elif kind == "surface":
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
        source = make_active(bpy.context.active_object)
        turning = np.cross([0, 0, 1], [vertex.co for vertex in source.data.vertices]).astype(np.float32)
        source.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", turning.ravel())
    elif kind == "plane":
        x, y = np.meshgrid(np.linspace(-1, 1, 16), np.linspace(-1, 1, 16), indexing="ij")
        np.savez(folder / "plane.npz", velocity=np.stack([-y, x], axis=-1), spacing=2 / 15, origin=-1)
        source = folder / "plane.npz"
    else:
        for frame in (1, 2):
            write_vdb(folder / f"s_{frame}.vdb", 0.1 * frame)
        source, settings = folder / "s_#.vdb", settings | {"frames": (1, 2)}
    return job_for(source, FlowSettings(**settings))


def numbers(result):
    """All arrays that were found."""
    shown = [frame.shown for frame in result.frames] if hasattr(result, "frames") else [result.shown]
    arrays = [] if hasattr(result, "frames") else [result.found.phases, result.seen.phases, result.sphere.lifted]
    for one in filter(None, shown):
        arrays += [one.tubes.vertices, one.tubes.sphere, *(line.points for line in one.lines)]
    return arrays


def are_same(result, other):
    """Whether two results are so bit for bit."""
    compared = np.array_equal
    if np.lib.NumpyVersion(np.__version__) < "2.0.0":  # its complex products depend on where arrays lie in memory
        compared = partial(np.allclose, atol=1e-5)
    return all(itertools.starmap(compared, zip(numbers(result), numbers(other), strict=True)))


@pytest.mark.parametrize("kind", KINDS)
def test_a_request_and_its_result_are_plain_data(kind, tmp_path):
    request = asked(kind, tmp_path).request
    copy = unpickled(request)
    result, again = request.solve(), copy.solve()
    assert len(numbers(result)) > 1 and are_same(unpickled(again), result)
    assert again.warnings == result.warnings


@pytest.mark.full_search
def test_a_process_without_blender_reads_and_solves_a_volume(tmp_path):
    job = asked("volume", tmp_path)
    result = solved_apart(job.request, tmp_path)
    assert are_same(result, job.request.solve())
    tubes, lines = (bpy.data.objects[name] for name in job.write(result)["objects"])
    best = points_of(lines)
    report = api.choose_point(lines, (1.0, 0.0, 0.0))  # of the result that came from there
    assert report["energy"] >= result.found.energy and not np.array_equal(points_of(lines), best)
    assert report["tubes"]["faces"] == len(tubes.data.polygons) > 0


def test_a_damaged_file_is_refused_in_the_solve_in_one_line(tmp_path):
    (tmp_path / "text.vdb").write_text("no volume")
    request = unpickled(job_for(tmp_path / "text.vdb", FlowSettings()).request)
    with pytest.raises(SettingError, match=r"text\.vdb.*choose an OpenVDB file") as caught:
        request.solve()
    assert "\n" not in str(caught.value) and str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_the_mesh_of_a_surface_does_not_travel_back(tmp_path):
    request = asked("surface", tmp_path).request
    result = request.solve()
    alone, shared = (b"".join(pack_parts(result, own)) for own in ((), request.shared))
    (back,) = Unpacker(request.shared).feed(shared)
    assert back.found.grid.mesh is request.given.mesh and len(shared) < len(alone) - request.given.mesh.vertices.nbytes
    assert are_same(back, result)


@pytest.mark.parametrize("kind", ["arrays", "plane"])
def test_a_result_takes_no_selection_from_who_has_gone_on(kind, tmp_path):
    job = asked(kind, tmp_path)
    result = job.request.solve()
    bpy.ops.mesh.primitive_cube_add()
    cube = make_active(bpy.context.active_object)
    made = [bpy.data.objects[name] for name in job.write(result)["objects"]]
    assert bpy.context.active_object == cube and bpy.context.selected_objects == [cube]
    assert all(obj.name in bpy.context.view_layer.objects for obj in made)
    made = [bpy.data.objects[name] for name in asked(kind, tmp_path).write(result)["objects"]]
    assert bpy.context.active_object == made[-1] and set(bpy.context.selected_objects) == set(made)


def test_a_surface_keeps_its_vortices_when_it_is_renamed_and_loses_them_when_it_is_gone(tmp_path):
    job = asked("surface", tmp_path)
    result = job.request.solve()
    obj = job.link.found
    obj.name = "Other"
    assert job.write(result)["object"] == "Other"
    bpy.data.objects.remove(obj)
    with pytest.raises(SynchError, match="is gone: nothing was written"):
        job.write(result)
