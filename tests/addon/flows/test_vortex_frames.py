# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sequences of flows: each frame starts from the one before, its objects are seen at their frame alone."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError, SynchError
from synch_fields.core.fields.quantum import find_quantum
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command.main import main
from synch_fields.synch_addon.flows import sequence_job
from synch_fields.synch_addon.flows.chosen import expected_solve
from synch_fields.synch_addon.flows.job import job_for
from synch_fields.synch_addon.flows.sequence_job import flow_frames
from synch_fields.synch_addon.flows.sources import flow_source

from ..scenes import make_active, snapshot
from ..vortex_scenes import QUICK, RADIUS, SPACING, points_of, write_npz, write_vdb

HEIGHTS = (-0.11, 0.0, 0.1)
SETTINGS = QUICK | {"resolution": 18}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """smoke_0001.vdb ... smoke_0003.vdb, a ring that rises by a cell in each frame."""
    made = tmp_path_factory.mktemp("frames")
    for number, height in enumerate(HEIGHTS, 1):
        write_vdb(made / f"smoke_{number:04d}.vdb", height)
    return made


def places_of(obj):
    return np.array([vertex.co for vertex in obj.data.vertices])


def visible():
    return sorted(obj.name for obj in bpy.data.objects if not obj.hide_viewport and not obj.hide_render)


def volume_of(folder):
    files = sorted(path.name for path in folder.glob("smoke_*.vdb"))
    bpy.ops.object.volume_import(
        filepath=str(folder / files[0]), directory=str(folder), files=[{"name": name} for name in files]
    )
    assert bpy.context.active_object.data.is_sequence
    return bpy.context.active_object


def test_the_filament_follows_the_ring_and_is_seen_at_its_frame(folder):
    report = api.clebsch(folder / "smoke_####.vdb", frames=(1, 3), show="both", **SETTINGS)
    assert [frame["filaments"] for frame in report["frames"]] == [1, 1, 1]
    collection = bpy.data.collections[report["object"]]
    assert len(collection.objects) == 6 and collection.name == "smoke Vortices"
    for frame, height in enumerate(HEIGHTS, 1):
        bpy.context.scene.frame_set(frame)
        assert visible() == [f"smoke Filaments {frame:04d}", f"smoke Tubes {frame:04d}"]
        points = points_of(bpy.data.objects[f"smoke Filaments {frame:04d}"])
        assert np.abs(points[:, 2] - height).max() < SPACING
        assert np.linalg.norm(points[:, :2], axis=1).mean() == pytest.approx(RADIUS, abs=0.5 * SPACING)
    for frame in (0, 4):
        bpy.context.scene.frame_set(frame)
        assert visible() == []


def test_each_frame_shows_another_point_of_the_sphere(folder):
    """Tubes of one frame go to where its map is 100 degrees around the antipode; those of others stay."""
    look = {"show": "both", "opening": 100, "smoothing": 0, "quantum": 0.5}
    api.clebsch(folder / "smoke_####.vdb", frames=(1, 3), **SETTINGS | look)
    tubes = [bpy.data.objects[f"smoke Tubes {frame:04d}"] for frame in (1, 2, 3)]
    before = [places_of(obj) for obj in tubes]
    lines = bpy.data.objects["smoke Filaments 0002"]
    unit = np.array([0.6, 0.0, 0.8])
    report = api.choose_point(lines, tuple(unit))
    sphere = np.empty(3 * len(tubes[1].data.vertices), np.float32)
    tubes[1].data.attributes["synch_sphere"].data.foreach_get("vector", sphere)
    assert len(sphere) > 1000
    np.testing.assert_allclose(sphere.reshape(-1, 3) @ -unit, np.cos(np.radians(100)), atol=1e-6)
    after = [places_of(obj) for obj in tubes]
    assert set(report["objects"]) == {tubes[1].name, lines.name} and after[1].tobytes() != before[1].tobytes()
    assert all(after[k].tobytes() == before[k].tobytes() for k in (0, 2))
    for obj in (lines, tubes[0], tubes[2]):
        api.choose_point(obj)
    assert all(a.tobytes() == b.tobytes() for a, b in zip(map(places_of, tubes), before, strict=True))
    api.clebsch(folder / "smoke_####.vdb", frames=(1, 1), show="both", **SETTINGS)
    with pytest.raises(SynchError, match="has no solve in memory"):
        api.choose_point(lines)


def test_a_volume_plays_the_files_that_blender_shows(folder):
    volume = volume_of(folder)
    data = volume.data
    for mode in ("EXTEND", "REPEAT", "PING_PONG"):
        data.sequence_mode, data.frame_start = mode, 3
        for frame in range(-3, 12):
            bpy.context.scene.frame_set(frame)
            seen = volume.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
            seen.grids.load()
            shown = bpy.path.basename(seen.grids.frame_filepath)
            (file,), name = flow_frames(volume, frame, frame)
            assert (file.source.path.name, name) == (shown, volume.name), (mode, frame)
    data.sequence_mode = "CLIP"
    with pytest.raises(SettingError, match="frame 6 lies outside"):
        flow_frames(volume, 3, 6)


def test_without_frames_a_volume_is_solved_as_it_is_shown_now(folder):
    volume = volume_of(folder)
    volume.data.frame_start = 5
    for frame, height in ((5, HEIGHTS[0]), (7, HEIGHTS[2])):
        bpy.context.scene.frame_set(frame)
        assert flow_source(volume, None).path.name == f"smoke_{frame - 4:04d}.vdb"
        lines = bpy.data.objects[api.clebsch(volume, **SETTINGS)["object"]]
        assert points_of(lines)[:, 2].mean() == pytest.approx(height, abs=0.5 * SPACING)
    make_active(volume)
    (folder / "smoke_0003.vdb").rename(folder / "away.vdb")
    assert expected_solve(bpy.context, bpy.context.scene.synch_vortices) is None  # that file, not the first
    (folder / "away.vdb").rename(folder / "smoke_0003.vdb")
    volume.data.sequence_mode = "CLIP"
    bpy.context.scene.frame_set(9)
    with pytest.raises(SettingError, match="frame 9 lies outside"):
        api.clebsch(volume, **SETTINGS)


def test_a_volume_that_was_moved_gives_moved_filaments(folder):
    volume = volume_of(folder)
    volume.location.z = 5.0
    bpy.context.view_layer.update()
    report = api.clebsch(volume, frames=(1, 1), **SETTINGS)
    (made,) = bpy.data.collections[report["object"]].objects
    assert points_of(made)[:, 2].mean() == pytest.approx(5.0 + HEIGHTS[0], abs=SPACING)


def test_frames_of_different_boxes_get_one_grid(tmp_path):
    write_vdb(tmp_path / "part_1.vdb", 0.0, last=16)
    write_vdb(tmp_path / "part_2.vdb", 0.0, first=1)
    report = api.clebsch(tmp_path / "part_#.vdb", frames=(1, 2), **SETTINGS)
    assert report["shape"] == [18, 18, 14] and [f["filaments"] for f in report["frames"]] == [1, 1]


def test_the_circulation_is_that_of_the_frame_with_most_vorticity(tmp_path):
    for number, circulation in enumerate((1.0, 4.0), 1):
        write_npz(tmp_path / f"grow{number}.npz", circulation=circulation)
    report = api.clebsch(tmp_path / "grow#.npz", frames=(1, 2), target_gap=0.05, count=2)
    most = flow_source(tmp_path / "grow2.npz", None).read()
    grid = most.grid(18)
    assert report["quantum"] == pytest.approx(find_quantum(grid, most.integrals(grid), 0.8, 2))
    first, last = (frame["filaments"] for frame in report["frames"])
    assert first < last


def test_what_is_no_sequence_is_refused_in_one_line(folder, tmp_path):
    before = snapshot()
    write_npz(tmp_path / "a1.npz")
    np.savez(tmp_path / "a2.npz", velocity=np.ones((5, 5, 5, 3)))
    (tmp_path / "b1.vdb").write_text("no volume")
    for source, frames, message in (
        (folder / "smoke_####.vdb", (2, 5), "smoke_0004.vdb: no such file: frame 4 of the sequence is missing"),
        (folder / "smoke_0001.vdb", (1, 2), "mark where the number of a frame stands"),
        (folder / "smoke_####.vdb", (3, 1), "the frames are 3 to 1: give the first and the last, in order"),
        (tmp_path / "a#.npz", (1, 2), "its grid is not that of a1.npz"),
        (tmp_path / "b#.vdb", (1, 1), "b1.vdb.*choose an OpenVDB file"),
    ):
        with pytest.raises(SettingError, match=message) as caught:
            api.clebsch(source, frames=frames, **SETTINGS)
        assert "\n" not in str(caught.value)
    with pytest.raises(SettingError, match="use the method sdp"):
        api.clebsch(folder / "smoke_####.vdb", frames=(1, 2), method="spectral")
    assert snapshot() == before
    volume = volume_of(folder)
    volume.data.frame_duration = 0  # as after a script has declared a sequence
    for mode in ("CLIP", "EXTEND", "REPEAT", "PING_PONG"):
        volume.data.sequence_mode = mode
        with pytest.raises(SettingError, match="has 0 frames: set how many"):
            api.clebsch(volume, frames=(1, 2))
    volume.data.is_sequence = False
    with pytest.raises(SettingError, match="is not a sequence"):
        api.clebsch(volume, frames=(1, 2))
    bpy.ops.curve.primitive_bezier_circle_add()
    with pytest.raises(SettingError, match="frames are solved of numbered files"):
        api.clebsch(bpy.context.active_object, frames=(1, 2))


@pytest.mark.parametrize("mode", ["EXTEND", "REPEAT", "PING_PONG"])
def test_a_range_without_end_of_a_volume_that_repeats_is_refused_at_once(folder, mode):
    volume = volume_of(folder)
    volume.data.sequence_mode = mode
    with pytest.raises(SettingError, match="give 10000 frames or fewer at once"):
        flow_frames(volume, -(2**20) + 1, 2**20 - 1)
    files, _ = flow_frames(volume, 1, 9)
    assert len(files) == 9


def test_cancelling_between_frames_writes_nothing(folder):
    before = snapshot()
    with pytest.raises(Cancelled):
        api.clebsch(folder / "smoke_####.vdb", lambda stage, _: "frame 2, " not in stage, frames=(1, 3), **SETTINGS)
    assert snapshot() == before


def test_what_fails_while_it_is_written_leaves_nothing(folder, monkeypatch):
    make, asked = sequence_job.make_filaments, []

    def breaking(name, shown):
        asked.append(name)
        if len(asked) == 2:
            raise MemoryError
        return make(name, shown)

    job = job_for(folder / "smoke_####.vdb", FlowSettings(frames=(1, 2), show="both", **SETTINGS))
    result = job.request.solve()
    before, counts = snapshot(), (len(bpy.data.curves), len(bpy.data.actions))
    monkeypatch.setattr(sequence_job, "make_filaments", breaking)
    with pytest.raises(MemoryError):
        job.write(result)
    assert snapshot() == before and (len(bpy.data.curves), len(bpy.data.actions)) == counts
    assert len(bpy.data.collections[job.write(result)["object"]].objects) == 4


def test_the_command_line_solves_frames(folder, tmp_path, capfd):
    out, report = tmp_path / "out.blend", tmp_path / "report.json"
    arguments = [
        "clebsch",
        str(folder / "smoke_####.vdb"),
        "--frames",
        "1",
        "2",
        "--quantum",
        "1",
        "--resolution",
        "18",
    ]
    arguments += ["--target-gap", "0.05", "--quiet", "--output", str(out), "--report", str(report)]
    assert main(arguments) == 0
    assert [frame["frame"] for frame in json.loads(report.read_text())["frames"]] == [1, 2] and out.is_file()
    assert "2 frames, filaments in each: 1" in capfd.readouterr().out
    assert main([*arguments[:2], "--frames", "3", "4", "--quiet"]) == 1
    assert "frame 4 of the sequence is missing" in capfd.readouterr().err
