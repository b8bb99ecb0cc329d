# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Filaments and tubes as files."""

import re

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command.main import main
from synch_fields.synch_addon.flows.files import SUFFIXES, can_export
from synch_fields.synch_addon.flows.job import clebsch

from ..scenes import grid
from ..vortex_scenes import circle, write_npz


def test_filaments_go_out_with_what_they_are(tmp_path, capfd):
    """Two linked rings: files, linking, helicity; and what is no such file or object is refused."""
    rings = [circle(1.0), circle(1.0, (1, 0, 0), strength=1.0)]
    rings[1].rotation_euler = (np.pi / 2, 0, 0)
    bpy.context.view_layer.update()
    report = clebsch(rings, quantum=1.0, resolution=22, target_gap=0.1)
    assert report["loops"] == [0, 1] and abs(report["linking"][0][1]) == 1 and report["windings"] == 0
    expected = 2 * report["linking"][0][1] + sum(report["writhe"])
    assert report["helicity"] == pytest.approx(expected)
    obj = bpy.data.objects[report["object"]]
    for suffix, words in (
        (".csv", "filament,x,y,z"),
        (".vtp", "PolyData"),
        (".vtk", "DATASET UNSTRUCTURED_GRID"),
        (".ply", "ply"),
        (".obj", "\nl 1 2 3 "),
    ):
        told = api.filament_export(obj, tmp_path / f"rings{suffix}")
        assert told["filaments"] == 2 and words in (tmp_path / f"rings{suffix}").read_text()
    assert bpy.ops.synch.filament_export(filepath=str(tmp_path / "again.vtp")) == {"FINISHED"}
    assert (tmp_path / "again.vtp").read_text() == (tmp_path / "rings.vtp").read_text()
    assert (".abc" in SUFFIXES) == bpy.app.build_options.alembic
    for suffix in {".txt", ".abc"} - {*SUFFIXES}:
        with pytest.raises(SettingError, match=re.escape(" or ".join(SUFFIXES))):
            api.filament_export(obj, tmp_path / f"rings{suffix}")
    with pytest.raises(SynchError, match="has no solve in memory"):
        api.filament_export(rings[0], tmp_path / "rings.csv")
    assert sum(line["vorticity_share"] for line in report["filaments"]) == pytest.approx(report["vorticity_share"])


def test_tubes_go_out_and_come_back_by_blender(tmp_path):
    report = clebsch(circle(), show="both", quantum=0.34, opening=100, resolution=20, target_gap=0.1)
    tubes, lines = (bpy.data.objects[name] for name in report["objects"])
    chosen = [obj for obj in bpy.data.objects if obj.select_get()]
    for suffix in SUFFIXES[1:]:
        told = api.filament_export(tubes, tmp_path / f"tubes{suffix}")
        assert told["tubes"] >= 1 and (tmp_path / f"tubes{suffix}").stat().st_size > 1000
    if ".abc" in SUFFIXES:
        api.filament_export(lines, tmp_path / "lines.abc")
    assert [obj for obj in bpy.data.objects if obj.select_get()] == chosen
    with pytest.raises(SettingError, match="a table holds filaments only: write tubes as"):
        api.filament_export(tubes, tmp_path / "tubes.csv")
    assert [can_export(obj) for obj in (tubes, lines, None, grid())] == [True, True, False, False]
    places = np.array([vertex.co for vertex in tubes.data.vertices])
    for suffix in {".ply", ".abc"} & {*SUFFIXES}:
        read = bpy.ops.wm.ply_import if suffix == ".ply" else bpy.ops.wm.alembic_import
        assert read(filepath=str(tmp_path / f"tubes{suffix}")) == {"FINISHED"}
        again = bpy.context.selected_objects[0]
        found = np.array([again.matrix_world @ vertex.co for vertex in again.data.vertices])
        assert len(again.data.polygons) == len(tubes.data.polygons)
        assert np.abs(np.sort(found, axis=0) - np.sort(places, axis=0)).max() < 1e-4


@pytest.mark.skipif(".abc" not in SUFFIXES, reason="this Blender is built without Alembic")
@pytest.mark.parametrize("is_hidden", [False, True])
def test_alembic_files_hold_the_tubes_around_filaments(tmp_path, is_hidden):
    """Also of an object that is hidden by keys, as those of a sequence are at other frames than their own."""
    report = clebsch(circle(), quantum=0.34, resolution=16, target_gap=0.1)
    obj = bpy.data.objects[report["object"]]
    shown = bpy.data.meshes.new_from_object(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    obj.scale.x = -2
    bpy.context.view_layer.update()
    places = np.sort([obj.matrix_world @ vertex.co for vertex in shown.vertices], axis=0)
    obj.hide_viewport = is_hidden
    obj.keyframe_insert("hide_viewport", frame=bpy.context.scene.frame_current)
    names = set(bpy.data.objects.keys())
    api.filament_export(obj, tmp_path / "tubes.abc")
    assert set(bpy.data.objects.keys()) == names and obj.hide_viewport == is_hidden
    assert bpy.ops.wm.alembic_import(filepath=str(tmp_path / "tubes.abc")) == {"FINISHED"}
    (read,) = [other for other in bpy.data.objects if other.type == "MESH" and other.name not in names]
    assert read.name == obj.name.replace(" ", "_")
    found = np.sort([read.matrix_world @ vertex.co for vertex in read.data.vertices], axis=0)
    assert len(read.data.polygons) == len(shown.polygons) > 100
    assert np.abs(found - places).max() < 1e-4


def test_the_command_writes_filaments(tmp_path, capfd):
    write_npz(tmp_path / "ring.npz")
    run = ["clebsch", str(tmp_path / "ring.npz"), "--quiet", "--method", "spectral", "--export-filaments"]
    assert main([*run, str(tmp_path / "ring.vtp")]) == 0
    assert "wrote" in capfd.readouterr().out and "<Piece" in (tmp_path / "ring.vtp").read_text()
    assert main([*run, str(tmp_path / "ring.stl")]) == 1 and ".vtp" in capfd.readouterr().err
