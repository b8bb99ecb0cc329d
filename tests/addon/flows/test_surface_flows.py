# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows on meshes and in planes: vortices as empties, the map itself on the mesh."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SettingError, SynchError
from synch_fields.core.files.flows import ArrayFile
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.blender.defect_empties import defect_empties
from synch_fields.synch_addon.command.main import main
from synch_fields.synch_addon.flows import memory, surface_job
from synch_fields.synch_addon.flows.job import clebsch, job_for
from synch_fields.synch_addon.flows.surfaces import surface_flow
from synch_fields.synch_addon.nodes.vortices import STRENGTH

from ...corpus.makers import moebius_strip
from ..scenes import add_object, places, set_vectors, snapshot
from ..vortex_scenes import circle

QUANTUM = np.pi / 5


@pytest.fixture
def disk(tmp_path):
    """A file with rigid rotation inside the unit disk, of curl 1, and no curl outside."""
    axis = np.linspace(-1.6, 1.6, 41)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    squares = np.maximum(x**2 + y**2, 1)
    velocity = np.stack([-y / squares, x / squares], axis=-1) / 2
    np.savez(tmp_path / "disk.npz", velocity=velocity, spacing=axis[1] - axis[0], origin=-1.6)
    return tmp_path / "disk.npz"


def turning_sphere(scale=1.0):
    """A mesh object on which everything turns once about its own z axis."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1.0)
    obj = bpy.context.active_object
    places = values(obj, "position", 3)
    velocity = obj.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    velocity.data.foreach_set("vector", np.cross([0, 0, 1], places).astype(np.float32).ravel())
    obj.scale = (scale,) * 3
    obj.rotation_euler.x = np.pi / 2
    bpy.context.view_layer.update()
    return obj


def values(obj, name, width):
    attribute = obj.data.attributes[name]
    found = np.empty(width * len(attribute.data), np.float32)
    attribute.data.foreach_get({1: "value", 3: "vector", 4: "color"}[width], found)
    return found.reshape(-1, width) if width > 1 else found


def test_a_plane_becomes_a_mesh_that_shows_its_map(disk):
    report = clebsch(disk, quantum=QUANTUM, show="tubes")
    obj = bpy.data.objects[report["object"]]
    assert len(obj.data.vertices) == 41**2 and len(obj.data.polygons) == 40**2
    assert bpy.context.active_object == obj and obj.material_slots[0].material.name == "Synch Globe"
    assert report["lower_bound"] <= report["sphere_energy"] <= report["energy"]
    sphere = values(obj, "synch_sphere", 3)
    np.testing.assert_allclose(np.linalg.norm(sphere, axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(values(obj, "synch_color", 4)[:, :3], 0.5 + 0.5 * sphere, atol=1e-6)
    for point in ((0, 0, 1), (1, 0, 0)):
        seen = clebsch(obj, quantum=QUANTUM, point=point)
        assert seen["object"] == obj.name and abs(len(seen["vortices"]) - seen["coverage"]) < 1.1
        assert seen["coverage"] == pytest.approx(report["coverage"], abs=1e-3)
    # The mesh that was solved before it was made is the one that Blender draws.
    np.testing.assert_array_equal(
        meshes.read_polygons(obj).triangle_corners, surface_flow(disk, "").given.polygons.triangle_corners
    )
    assert obj.material_slots[0].material.name == "Synch Stripes"


def test_vortices_are_empties_and_strengths_of_faces(disk):
    report = clebsch(disk, quantum=QUANTUM)
    obj = bpy.data.objects[report["object"]]
    empties = defect_empties(obj)
    assert len(empties) == len(report["vortices"]) >= 3
    strengths = values(obj, STRENGTH, 1)
    assert strengths.sum() == pytest.approx(QUANTUM * len(empties), rel=1e-5)
    for empty, facts in zip(empties, report["vortices"], strict=True):
        assert empty["synch_kind"] == "vortex" and empty["synch_index"] == 1
        assert empty[STRENGTH] == pytest.approx(QUANTUM) and strengths[empty["synch_face"]] == pytest.approx(QUANTUM)
        centre = np.array(obj.data.polygons[facts["face"]].center)
        assert np.abs(np.array(facts["position"]) - centre).max() <= 0.5 * 3.2 / 40 + 1e-6
        assert np.linalg.norm(facts["position"]) < 1.2
    # The phase is that of a stripe pattern whose dislocations are the vortices.
    index = values_int(obj, "synch_index") + (
        values_int(obj, "synch_index_2") if "synch_index_2" in obj.data.attributes else 0
    )
    np.testing.assert_array_equal(index, np.rint(strengths / QUANTUM))


def values_int(obj, name):
    found = np.empty(len(obj.data.polygons), np.int32)
    obj.data.attributes[name].data.foreach_get("value", found)
    return found


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_a_turning_sphere_has_vortices_of_both_signs(scale):
    obj = turning_sphere(scale)
    report = clebsch(obj, quantum=1.2 * scale**2)  # lengths and velocities grow alike
    strengths = np.array([vortex["strength"] for vortex in report["vortices"]])
    places = np.array([vortex["position"] for vortex in report["vortices"]])
    assert len(places) >= 4 and strengths.sum() == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(np.abs(strengths), 1.2 * scale**2)
    # The object's z axis points along -y of the world.
    assert (np.sign(-places[:, 1]) == np.sign(strengths)).all()
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), scale, rtol=0.02)


def test_a_pattern_takes_the_place_of_vortices():
    obj = turning_sphere()
    clebsch(obj, quantum=1.2)
    assert {empty["synch_kind"] for empty in defect_empties(obj)} == {"vortex"}
    api.stripes(obj, spacing=0.4)
    assert "vortex" not in {empty["synch_kind"] for empty in defect_empties(obj)}
    clebsch(obj, quantum=1.2)
    assert "dislocation" not in {empty["synch_kind"] for empty in defect_empties(obj)}


def test_the_command_and_the_operator(tmp_path, capfd):
    obj = turning_sphere()
    obj.data.attributes["velocity"].name = "wind"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "sphere.blend"))
    assert bpy.ops.synch.clebsch(attribute="wind", count=3) == {"FINISHED"}
    assert defect_empties(obj)
    report = tmp_path / "report.json"
    arguments = ["clebsch", str(tmp_path / "sphere.blend"), "--object", obj.name, "--quantum", "1.2", "--quiet"]
    assert main([*arguments, "--attribute", "wind", "--point", "1", "0", "0", "--report", str(report)]) == 0
    facts = json.loads(report.read_text())
    assert f"{len(facts['vortices'])} vortices, the sphere is covered" in capfd.readouterr().out
    assert main(arguments) == 1
    assert "has no attribute 'velocity'" in capfd.readouterr().err


def test_what_is_no_flow_is_refused_and_changes_nothing(tmp_path):
    obj = turning_sphere()
    before = {attribute.name for attribute in obj.data.attributes}
    with pytest.raises(SettingError, match="no attribute 'speed'"):
        clebsch(obj, attribute="speed")
    bpy.ops.mesh.primitive_plane_add()
    other = bpy.context.active_object
    with pytest.raises(SettingError, match="choose it alone"):
        clebsch([obj, other])
    job = job_for(obj, FlowSettings(quantum=2.0))
    result = job.request.solve()
    obj.data.vertices[0].co.x += 0.1
    with pytest.raises(SettingError, match="has changed since"):
        job.write(result)
    obj.data.attributes["velocity"].data[7].vector = (np.nan, 0, 0)
    with pytest.raises(SettingError, match="vertex 7 is not a number"):
        clebsch(obj)
    assert {attribute.name for attribute in obj.data.attributes} == before and not defect_empties(obj)
    flat = bpy.data.meshes.new("Flat")
    flat.from_pydata([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [], [(0, 1, 2)])
    bad = bpy.data.objects.new("Flat", flat)
    bpy.context.scene.collection.objects.link(bad)
    with pytest.raises(MeshError):
        clebsch(bad)
    np.savez(tmp_path / "inf.npz", velocity=np.full((9, 9, 2), np.inf))
    with pytest.raises(SettingError, match="is not a number"):
        clebsch(tmp_path / "inf.npz")


def test_a_plane_that_fails_while_it_is_written_leaves_nothing(disk, monkeypatch):
    bpy.ops.mesh.primitive_cube_add()
    job = job_for(disk, FlowSettings(quantum=QUANTUM, method="spectral"))
    result = job.request.solve()
    before = snapshot()
    paint = surface_job.pattern_material
    monkeypatch.setattr(surface_job, "pattern_material", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        job.write(result)
    assert snapshot() == before
    monkeypatch.setattr(surface_job, "pattern_material", paint)
    obj = bpy.data.objects[job.write(result)["object"]]
    assert obj.name == "disk" and bpy.context.active_object == obj and obj.select_get()


def test_only_the_header_of_a_flow_in_space_is_read_at_first(tmp_path, disk, monkeypatch):
    np.savez_compressed(tmp_path / "space.npz", velocity=np.ones((5, 5, 5, 3)))
    assert ArrayFile(disk).is_plane and surface_flow(disk, "").name == "disk"
    monkeypatch.setattr(np, "load", None)
    assert surface_flow(tmp_path / "space.npz", "") is None
    assert job_for(tmp_path / "space.npz", FlowSettings())


def test_a_periodic_plane_is_shown_open_and_said_so(tmp_path):
    x = np.arange(24) / 24
    velocity = np.zeros((24, 24, 2))
    velocity[..., 1] = np.sin(2 * np.pi * x)[:, None]
    np.savez(tmp_path / "waves.npz", velocity=velocity, spacing=1 / 24, periodic=True)
    report = clebsch(tmp_path / "waves.npz", count=3)
    assert "shown open" in report["warnings"][0] and len(bpy.data.objects[report["object"]].data.polygons) == 23**2


def test_a_flow_around_a_one_sided_surface_goes_on_across_its_seam():
    """And a mesh that is no surface is refused where it is asked for."""
    obj = add_object(*moebius_strip(60, 8))
    set_vectors(obj, "velocity", np.cross([0, 0, 1], places(obj)) * [1, 1, 0])
    report = clebsch(obj, quantum=2.0, show="filaments")
    assert report["carrier"].keys() == {"one_sided_edges"}
    given = meshes.read_mesh(obj)
    phases = memory.flows.get(obj).result.found.phases
    np.testing.assert_allclose(*phases[given.seam.T], atol=1e-12)
    with pytest.raises(SynchError, match="the surface is one-sided"):
        clebsch(obj, quantum=2.0, strict=True)


def test_a_mesh_in_edit_mode_is_read_as_it_was_edited():
    obj = turning_sphere()
    expected = clebsch(obj)
    obj = turning_sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    report = clebsch(obj)
    assert obj.mode == "EDIT" and report["quantum"] == pytest.approx(expected["quantum"], rel=1e-5)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(defect_empties(obj)) == len(report["vortices"]) > 0


@pytest.mark.parametrize("make", [turning_sphere, circle])
def test_what_a_script_has_scaled_just_now_counts(make):
    options = {} if make is turning_sphere else {"resolution": 16, "core": 1.0}
    obj = make(2.0)
    bpy.context.view_layer.update()
    expected = clebsch(obj, **options)["quantum"]
    obj = make(1.0)
    bpy.context.view_layer.update()
    obj.scale = (2, 2, 2)
    assert clebsch(obj, **options)["quantum"] == pytest.approx(expected, rel=1e-4)
