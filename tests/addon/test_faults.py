# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A write that fails, wherever it does, leaves the scene as it was: nothing half made, nothing lost."""

import bpy
import numpy as np
import pytest

from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.settings.layers import LayerSettings
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.flows.job import job_for
from synch_fields.synch_addon.frames.job import AnimationJob, Span
from synch_fields.synch_addon.patterns import favourites
from synch_fields.synch_addon.patterns.job import FieldJob

from .faults import check_faults
from .scenes import add_curve, furnished, places, quad_sphere, set_vectors, sphere
from .solid_objects import block, made
from .vortex_scenes import QUICK, write_npz

ROUGH = {"method": "spectral", "seed": 1}


def written(make):
    """What gives the write of a job's result."""

    def begin():
        job = make()
        if hasattr(job, "advance"):
            while job.advance() is not None:
                pass
        result = job.request.solve()
        return lambda: job.write(result)

    return begin


def field(command, **settings):
    """A field on an object with materials, groups, a twin, and faces that have to be split."""
    obj = furnished()
    return written(lambda: FieldJob(command, obj, SurfaceSettings(**ROUGH, **settings)))


def again():
    """Stripes in place of quads, frames and numbers."""
    obj = sphere(2)
    api.animate(obj, frames=(1, 2), spacing=0.6, **ROUGH)
    api.stripes(obj, spacing=0.6, **ROUGH)
    api.number_stripes(obj)
    return written(lambda: FieldJob("stripes", obj, SurfaceSettings(spacing=0.7, **ROUGH)))


def quads_after_stripes():
    obj = quad_sphere(4)
    api.stripes(obj, spacing=0.6, **ROUGH)
    return written(lambda: FieldJob("quads", obj, SurfaceSettings(spacing=0.7, **ROUGH)))


def surface(before="seen", after="seen"):
    """A pattern on what modifiers make of an object with materials, groups and a twin, in place of another one."""
    obj = furnished()
    subdivision = obj.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels, subdivision.render_levels = 0, 1
    if before:
        api.stripes(obj, spacing=0.6, surface=before, **ROUGH)
        api.relief(obj, level=0)
    return written(lambda: FieldJob("stripes", obj, SurfaceSettings(spacing=0.7, surface=after, **ROUGH)))


def frames():
    obj = sphere(2)
    api.stripes(obj, spacing=0.6, **ROUGH)
    return written(lambda: AnimationJob(obj, SurfaceSettings(spacing=0.6, **ROUGH), Span(1, 2)))


def frames_again():
    obj = sphere(2)
    api.animate(obj, frames=(1, 3), spacing=0.6, **ROUGH)
    return written(lambda: AnimationJob(obj, SurfaceSettings(spacing=0.6, **ROUGH), Span(1, 2)))


def layers():
    obj = block((1, 1, 0.6))
    return written(lambda: api.layer_job(obj, LayerSettings(spacing=0.3, size=0.15, **ROUGH)))


def layers_again():
    obj = block((1, 1, 0.6))
    api.layers(obj, spacing=0.3, size=0.15, **ROUGH)
    return written(lambda: api.layer_job(obj, LayerSettings(spacing=0.25, size=0.12, **ROUGH)))


def flow():
    turn = np.linspace(0, 2 * np.pi, 25)[:-1]
    ring = add_curve(np.column_stack([np.cos(turn), np.sin(turn), 0 * turn]), "Ring", cyclic=True)
    return written(lambda: job_for(ring, FlowSettings(quantum=1.0, resolution=12, target_gap=0.1, show="both")))


def surface_flow():
    obj = sphere(2)
    set_vectors(obj, "velocity", np.cross([0, 0, 1], places(obj)))
    return written(lambda: job_for(obj, FlowSettings(quantum=1.2, target_gap=0.1, show="tubes")))


def rings(folder):
    """A sequence of two frames."""
    for frame in (1, 2):
        write_npz(folder / f"ring_{frame}.npz", 0.1 * frame)
    return written(lambda: job_for(folder / "ring_#.npz", FlowSettings(frames=(1, 2), show="both", **QUICK)))


def chosen(folder):
    """Another point of the sphere for a flow that is shown."""
    report = api.clebsch(write_npz(folder / "ring.npz", circulation=4.0), show="both", **QUICK)
    obj = bpy.data.objects[report["objects"][0]]
    return lambda: lambda: api.choose_point(obj, (0.3, -0.8, 0.4))


def layered(change, times=0):
    """What is called on the object of layers, after some times before."""
    obj = block((1, 1, 0.6))
    api.layers(obj, spacing=0.3, size=0.15, **ROUGH)
    for _ in range(times):
        change(obj)
    return lambda: lambda: change(obj)


def layers_in_edit_mode():
    """Layers again, where those before are being edited."""
    obj = block((1, 1, 0.6))
    report = api.layers(obj, spacing=0.3, size=0.15, **ROUGH)
    before = made(report)

    def begin():
        job = api.layer_job(obj, LayerSettings(spacing=0.25, size=0.12, **ROUGH))
        result = job.request.solve()
        bpy.context.view_layer.objects.active = before
        bpy.ops.object.mode_set(mode="EDIT")
        return lambda: job.write(result)

    return begin


def baked(times=0, **settings):
    """A bake into the file, or into a folder, after some times before."""
    small = {"maps": "colour,height", "size": 32, "margin": 1, "samples": 1, "unwrap": True, "material": True}
    return shown(lambda obj: api.bake(obj, **small | settings), lambda obj: _baked_before(obj, times, small | settings))


def _baked_before(obj, times, settings):
    api.stripes(obj, spacing=0.6, seed=1)
    for layer in list(obj.data.uv_layers)[times:]:
        obj.data.uv_layers.remove(layer)
    for _ in range(times):
        api.bake(obj, **settings)


def imported(folder):
    obj = sphere(2)
    api.directions(obj, **ROUGH)
    api.export_field(obj, folder / "field.rosy", "line")
    api.directions(obj, angle=0.7, **ROUGH)
    return lambda: lambda: api.import_field(obj, folder / "field.rosy")


def shown(change, solve=lambda obj: api.stripes(obj, spacing=0.6, seed=1)):
    """What is called on an object with a pattern."""
    obj = sphere(2)
    solve(obj)
    return lambda: lambda: change(obj)


def kept(change):
    """The same for favourites, one of which there is."""

    def solve(obj):
        api.stripes(obj, spacing=0.6, seed=1)
        favourites.keep(obj, "first")
        api.vary(obj, 2)

    return shown(change, solve)


def rerun(change):
    """The same where it has been done before."""
    return shown(change, lambda obj: (api.stripes(obj, spacing=0.6, seed=1), change(obj)))


SCENES = {
    "stripes": lambda: field("stripes", spacing=0.6),
    "quads": lambda: field("quads", spacing=0.8),
    "directions": lambda: field("directions"),
    "quad mesh": lambda: field("quad_mesh", spacing=0.8),
    "stripes again": again,
    "quads after stripes": quads_after_stripes,
    "surface of its own": lambda: surface(None),
    "surface of its own again": surface,
    "surface of its own after own faces": lambda: surface("faces"),
    "own faces after a surface of its own": lambda: surface(after="faces"),
    "frames": frames,
    "frames again": frames_again,
    "layers": layers,
    "layers again": layers_again,
    "flow": flow,
    "surface flow": surface_flow,
    "layers in edit mode": layers_in_edit_mode,
    "vary": lambda: shown(lambda obj: api.vary(obj, 1)),
    "relief": lambda: shown(api.relief),
    "relief again": lambda: rerun(lambda obj: api.relief(obj, height=0.3)),
    "carry": lambda: shown(api.carry),
    "lines": lambda: shown(api.isolines),
    "numbers": lambda: shown(api.number_stripes),
    "preset": lambda: shown(lambda obj: api.preset(obj, "corduroy")),
    "refine": lambda: shown(lambda obj: api.refine(obj, 1)),
    "placed": lambda: shown(lambda obj: api.place_defects(obj, [3])),
    "traced": lambda: shown(api.trace_quads, lambda obj: api.quads(obj, spacing=0.8, seed=1)),
    "bake": baked,
    "bake again": lambda: baked(1),
    "favourite": lambda: kept(lambda obj: favourites.keep(obj, "second")),
    "favourite shown": lambda: kept(lambda obj: favourites.show(obj, "first")),
    "favourite removed": lambda: kept(lambda obj: favourites.remove(obj, obj.synch.favourites[0].name)),
}


def exported(folder):
    """Filaments as a file, in place of an earlier one."""
    report = api.clebsch(write_npz(folder / "ring.npz", circulation=4.0), **QUICK)
    obj = bpy.data.objects[report["object"]]
    api.filament_export(obj, folder / "lines.csv")
    return lambda: lambda: api.filament_export(obj, folder / "lines.csv")


# Those that read or write files, too, in a folder, which stays as it was.
FILES = {
    "sequence": rings,
    "point": chosen,
    "tool paths": lambda folder: layered(lambda obj: api.layer_toolpaths(obj, path=folder / "paths.csv")),
    "tool paths again": lambda folder: layered(lambda obj: api.layer_toolpaths(obj, path=folder / "paths.csv"), 1),
    "volume": lambda folder: layered(lambda obj: api.layer_volume(obj, folder / "layers.vdb", 8)),
    "volume again": lambda folder: layered(lambda obj: api.layer_volume(obj, folder / "layers.vdb", 8), 1),
    "bake to files": lambda folder: baked(folder=str(folder)),
    "bake to files again": lambda folder: baked(1, folder=str(folder), maps="height", displacement=True),
    "import": imported,
}


def test_a_fault_leaves_a_file_of_filaments_as_it_was(tmp_path):
    assert check_faults(exported(tmp_path), folder=tmp_path, everywhere=True) > 10


def old_groups():
    """Node groups of an earlier version, which a write draws anew, with a value that a user has set."""
    for group in bpy.data.node_groups:
        group["synch_stamp"] = "earlier"


@pytest.mark.parametrize("name", SCENES)
def test_a_fault_leaves_the_scene_as_it_was(name):
    assert check_faults(SCENES[name](), stride=101) > 0


@pytest.mark.parametrize("name", FILES)
def test_a_fault_leaves_the_scene_and_the_files_as_they_were(name, tmp_path):
    assert check_faults(FILES[name](tmp_path), stride=101, folder=tmp_path) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SCENES, *FILES])
def test_a_fault_anywhere_leaves_the_scene_and_the_files_as_they_were(name, tmp_path, record_property):
    begin = FILES[name](tmp_path) if name in FILES else SCENES[name]()
    count = check_faults(begin, folder=tmp_path)
    record_property("faults", count)  # with pytest --junitxml
    assert count > 20


def test_groups_of_an_earlier_version_come_back():
    begin = shown(lambda obj: api.vary(obj, 1))
    old_groups()
    assert check_faults(begin, stride=31) > 0
