# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of flows in Blender: files, volumes and curves go in, curves and meshes come out."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import edge_integrals, faces_of_filament
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.tasks.flows import extract_vortices
from synch_fields.synch_addon.command.main import main
from synch_fields.synch_addon.flows import sources
from synch_fields.synch_addon.flows.chosen import expected_solve
from synch_fields.synch_addon.flows.job import clebsch

from ..vortex_scenes import RADIUS, circle, write_npz, write_vdb


def spline_points(obj, number=0):
    points = obj.data.splines[number].points
    places = np.empty(4 * len(points), np.float32)
    points.foreach_get("co", places)
    return places.reshape(-1, 4)[:, :3]


def test_a_curve_comes_back_as_a_filament():
    obj = circle(location=(0.3, 0, 1.0), strength=2.5)
    report = clebsch(obj, quantum=2.5, resolution=28, smoothing=0)
    made = bpy.data.objects[report["object"]]
    assert made.type == "CURVE" and made[sources.STRENGTH] == 2.5 and bpy.context.active_object == made
    (spline,) = made.data.splines
    assert spline.use_cyclic_u and report["filaments"][0]["closed"] and report["filaments"][0]["strength"] == 2.5
    away = spline_points(made) - [0.3, 0, 1.0]
    cell = 3.4 / 27
    assert np.abs(np.hypot(away[:, 0], away[:, 1]) - 1).max() < cell and np.abs(away[:, 2]).max() < 0.5 * cell
    turn = np.cross(away[:-1], away[1:])[:, 2]
    assert turn.sum() > 0  # in its direction
    assert report["lower_bound"] <= report["energy"] and report["status"] != "failed"
    # One filament of the same circulation: loops miss only those parts of the core that they cut.
    assert 0 < report["circulation_error"] < 0.1


def test_arrays_and_a_volume_give_the_same_vortex(tmp_path):
    array, volume = write_npz(tmp_path / "ring.npz", 0.02), write_vdb(tmp_path / "ring.vdb", 0.02)
    bpy.ops.object.volume_import(filepath=str(volume))
    found = bpy.context.active_object
    found.location.z = 3.0
    bpy.context.view_layer.update()
    for source, height in ((array, 0.02), (volume, 0.02), (found, 3.02)):
        report = clebsch(source, quantum=1.3, resolution=18)
        points = spline_points(bpy.data.objects[report["object"]])
        assert [line["closed"] for line in report["filaments"]] == [True]
        assert np.abs(points[:, 2] - height).max() < 0.1
        assert np.linalg.norm(points[:, :2], axis=1) == pytest.approx(RADIUS, abs=0.12)


def test_tubes_are_a_closed_surface_in_the_colours_of_the_sphere(tmp_path):
    write_npz(tmp_path / "ring.npz", circulation=6.0)
    report = clebsch(tmp_path / "ring.npz", show="tubes", quantum=2.0, opening=80)
    made = bpy.data.objects[report["object"]]
    assert (
        made.type == "MESH" and not made.data.validate() and report["tubes"]["faces"] == len(made.data.polygons) > 100
    )
    shown = np.empty(3 * len(made.data.vertices), np.float32)
    made.data.attributes["synch_sphere"].data.foreach_get("vector", shown)
    shown = shown.reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(shown, axis=1), 1, atol=1e-3)
    assert (shown[:, 2] < -np.cos(np.radians(80)) + 0.1).all()  # around the antipode of the point
    assert report["lower_bound"] <= report["sphere_energy"] <= report["energy"]


@pytest.mark.parametrize("radius", [0.65, 0.71, 0.75])
def test_tubes_have_no_faces_that_fold(radius):
    """A ball that nearly touches nodes of the grid, where slivers would turn inwards and show as dark specks."""
    grid = Grid((21, 22, 23), spacing=0.1, origin=(-1, -1.05, -1.1))
    distance = np.linalg.norm(grid.places, axis=1)
    turn = np.arctan2(grid.places[:, 1], grid.places[:, 0])
    sphere = np.column_stack([np.sin(distance) * np.cos(turn), np.sin(distance) * np.sin(turn), -np.cos(distance)])
    found = SimpleNamespace(grid=grid, regular_grid=grid, quantum=1.0)
    settings = SimpleNamespace(show="tubes", point=None, opening=np.degrees(radius), smoothing=4, unwrapped=False)
    tubes = extract_vortices(found, SimpleNamespace(found=found, sphere=sphere), settings).tubes
    corners = tubes.vertices[tubes.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(corners.mean(axis=1), axis=1)
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0.8 * lengths).all()


def test_of_several_grids_of_vectors_the_velocity_is_solved(tmp_path):
    mine = {name: write_vdb(tmp_path / f"{name}.vdb", name=name, before=["Cd"]) for name in ("vel", "v", "wind")}
    rough = {"resolution": 18, "quantum": 1.0, "method": "spectral"}
    ring = clebsch(write_vdb(tmp_path / "alone.vdb", name="anything"), **rough)
    assert ring["shape"] == [18, 18, 14] and not ring["warnings"]
    for path, attribute in ((mine["vel"], "velocity"), (mine["v"], "velocity"), (mine["wind"], "wind")):
        report = clebsch(path, attribute=attribute, **rough)
        assert report["filaments"] == ring["filaments"] and not report["warnings"]
        stored = bpy.context.scene.synch_vortices
        stored.filepath, stored.resolution, stored.attribute = str(path), 18, attribute
        assert expected_solve(bpy.context, stored).shape == (18, 18, 14)
    with pytest.raises(SettingError, match="no vorticity"):  # of the colours
        clebsch(mine["vel"], attribute="Cd", resolution=18)
    with pytest.raises(SettingError, match=r"has no vectors 'speed' \(it has Cd \(vec3s\), vel \(vec3s\)\)"):
        clebsch(mine["vel"], attribute="speed")
    flow = sources.flow_source(mine["wind"], None).read()
    assert flow.warnings[0].startswith("Cd is used as the velocity (there are Cd (vec3s), wind (vec3s))")


def test_filaments_that_were_shown_induce_the_flow_that_they_carry():
    obj = circle(strength=2.0)
    rough = {"resolution": 20, "method": "spectral", "quantum": 1.0}
    lines = bpy.data.objects[clebsch(obj, **rough, smoothing=0)["object"]]
    points = np.ones((100, 4), np.float32)
    points[:, :3] = spline_points(obj)
    lines.data.splines.clear()
    spline = lines.data.splines.new("POLY")
    spline.points.add(99)
    spline.points.foreach_set("co", points.ravel())
    spline.points.foreach_set("radius", np.full(100, np.sqrt(2), np.float32))  # two quanta
    spline.use_cyclic_u = True
    one, other = (sources.flow_source(found, 0.5) for found in (obj, lines))
    grid = one.grid(20)
    np.testing.assert_allclose(other.integrals(grid), one.integrals(grid), atol=1e-6)


def test_a_map_that_shows_nothing_says_what_to_do(tmp_path, capfd):
    write_npz(tmp_path / "ring.npz")
    assert main(["clebsch", str(tmp_path / "ring.npz"), "--quantum", "50", "--show", "both", "--quiet"]) == 0
    out = capfd.readouterr().out
    for words in ("has no filaments: ", "with a circulation of", "make the tubes wider", "0 filaments"):
        assert words in out


def test_curves_have_a_core_that_tubes_can_be_seen_in():
    obj = circle()
    report = clebsch(obj, show="both", quantum=0.34, opening=100, resolution=24, target_gap=0.05)
    assert report["tubes"]["pieces"] == 1 and report["tubes"]["faces"] > 1000
    tubes = bpy.data.objects[report["objects"][0]]
    places = np.array([vertex.co for vertex in tubes.data.vertices])
    off = np.hypot(np.hypot(places[:, 0], places[:, 1]) - 1, places[:, 2])  # from the circle
    cell = 3.4 / 2 / 11.5
    assert 0.5 * cell < np.median(off) < 3 * cell
    thin = clebsch(obj, show="tubes", quantum=0.34, opening=100, resolution=24, target_gap=0.05, core=0.5)
    area = lambda made: sum(face.area for face in bpy.data.objects[made].data.polygons)  # noqa: E731
    assert area(thin["object"]) < area(report["objects"][0])


@pytest.mark.parametrize("core, is_thin", [(1.0, True), (2.0, False)])
def test_thin_cores_in_files_are_found_and_warned_of(tmp_path, core, is_thin):
    """A quantum of a core that is a cells wide has 3 pi a^2 faces: the circulation squared over the integral of
    (a^2 / (pi (r^2 + a^2)^2))^2, and a little more between nodes."""
    grid = Grid((28, 28, 12), 0.1, [-1.35, -1.35, -0.55])
    turn = np.linspace(0, 2 * np.pi, 121)
    ring = np.column_stack([0.9 * np.cos(turn), 0.9 * np.sin(turn), 0 * turn])
    velocity = filament_velocity(grid.places, [(ring, 1.0)], core * 0.1)
    faces = faces_of_filament(grid, edge_integrals(grid, velocity), 1.0)
    assert 1 < faces / (3 * np.pi * core**2) < 1.6
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    report = clebsch(tmp_path / "ring.npz", show="tubes", quantum=1.0, target_gap=0.1)
    assert any("faces of the grid" in line for line in report["warnings"]) == is_thin
    assert (report["tubes"]["pieces"] > 3) == is_thin


def test_filaments_around_a_periodic_box_close(tmp_path):
    """A shear flow, sin(z) along x: its vorticity runs along y, both ways, around the box."""
    count = 12
    z = 2 * np.pi * np.arange(count) / count
    velocity = np.zeros((count, count, count, 3))
    velocity[..., 0] = np.sin(z)
    np.savez(tmp_path / "shear.npz", velocity=velocity, spacing=2 * np.pi / count, periodic=True)
    report = clebsch(tmp_path / "shear.npz", count=4, target_gap=0.1)
    around = [line for line in report["filaments"] if any(line["winding"])]
    assert report["windings"] == len(around) > 0 and all(line["closed"] for line in report["filaments"])
    assert all(line["winding"][2] == 0 for line in around)
    obj = bpy.data.objects[report["object"]]
    inside = np.array([point.co[:3] for spline in obj.data.splines for point in spline.points])
    assert inside.max() < 2 * np.pi + 0.6
    unwrapped = clebsch(tmp_path / "shear.npz", count=4, target_gap=0.1, unwrapped=True)
    splines = bpy.data.objects[unwrapped["object"]].data.splines
    assert len(splines) == len(unwrapped["filaments"])
    longest = max(np.ptp([point.co[1] for point in spline.points]) for spline in splines)
    assert longest == pytest.approx(2 * np.pi, rel=0.2)
