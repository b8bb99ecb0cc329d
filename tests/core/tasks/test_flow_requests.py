# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of arrays, of curves and of sequences, asked for and solved without Blender: the ring that each of them is."""

import re

import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError
from synch_fields.core.fields.biot_savart import FilamentCurves, filament_velocity
from synch_fields.core.fields.clebsch import layer_sums
from synch_fields.core.files.flows import ArrayFile
from synch_fields.core.geometry.grid import Grid, box_grid
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.tasks.flow_sequences import FrameFile, SequenceRequest
from synch_fields.core.tasks.flows import FlowRequest, check_grid

from ..flows import ring_curve

RADIUS, NODES = 0.3, 18
QUICK = {"resolution": NODES, "seed": 1, "show": "both", "opening": 100.0}


@pytest.fixture
def ring_file(tmp_path):
    """Writes a ring around the z axis at a height as arrays: ring_file(height, **others) -> ArrayFile."""
    grid = box_grid(np.full(3, -0.6), np.full(3, 0.6), NODES)

    def written(height=0.0, shift=0.0, **others):
        path = tmp_path / f"ring_{height}_{shift}.npz"
        ring = ring_curve(RADIUS, centre=(0.0, 0.0, height))
        velocity = filament_velocity(grid.places, [(ring, 2.0)], 2 * grid.spacing[0]).reshape(*grid.shape, 3)
        arrays = {"velocity": velocity, "spacing": grid.spacing, "origin": grid.origin + shift}
        np.savez(path, **arrays | others)
        return ArrayFile(path)

    return written


def distance(points, height=0.0):
    """How far points are from the ring at a height, at most, in cells."""
    across = np.hypot(points[:, 0], points[:, 1]) - RADIUS
    return np.hypot(across, points[:, 2] - height).max() * (NODES - 1) / 1.2


def test_filaments_and_tubes_of_arrays_are_around_their_ring(ring_file):
    result = FlowRequest(ring_file(0.1), FlowSettings(**QUICK, quantum=0.5)).solve()
    assert 1 <= len(result.shown.lines) <= 4  # the ring's circulation is 2
    assert all(distance(line.points, 0.1) < 3 for line in result.shown.lines)
    assert len(result.shown.tubes.vertices) and distance(result.shown.tubes.vertices, 0.1) < 4
    assert result.linked is not None
    again = result.again(FlowSettings(**QUICK, quantum=0.5, point=(0.0, 0.0, -1.0)))
    assert again.found is result.found and again.linked is None
    assert distance(again.shown.tubes.vertices, 0.1) < 4
    assert not np.array_equal(again.shown.tubes.vertices, result.shown.tubes.vertices)
    assert np.array_equal(result.lean.found.phases, result.found.phases)


def test_curves_are_solved_as_the_flow_around_them():
    curves = FilamentCurves("Ring", ((ring_curve(RADIUS), 1.0),), 2.0)
    settings = FlowSettings(resolution=NODES, seed=1, count=2.0)
    result = FlowRequest(curves, settings).solve()
    # As many as are wanted, each with no more than its part of the curve's circulation.
    assert layer_sums(result.found.grid, result.found.face_numbers) >= 2 and result.found.quantum < 0.5
    points = np.concatenate([line.points for line in result.shown.lines])
    assert np.abs(np.hypot(*points[:, :2].T) - RADIUS).max() < 0.1 and np.abs(points[:, 2]).max() < 0.1


def test_thin_cores_few_filaments_and_many_are_warned_of(ring_file):
    thin = FilamentCurves("Ring", ((ring_curve(RADIUS), 1.0),), 0.5)
    found = FlowRequest(thin, FlowSettings(**QUICK, core=0.5)).solve()
    assert [w for w in found.warnings if w.startswith("tubes have an inside from a core of 2 cells on, and it is 0.5")]
    alone = FlowRequest(ring_file(), FlowSettings(resolution=NODES, quantum=40.0)).solve()
    (line,) = [warning for warning in alone.warnings if "of the vorticity: with a circulation of " in warning]
    suggested, share = re.search(r"a circulation of (\S+) they carry (\d+)%", line).groups()
    tried = FlowRequest(ring_file(), FlowSettings(resolution=NODES, quantum=float(suggested))).solve()
    assert f"{tried.found.vorticity_share:.0%}" == f"{share}%" and tried.found.vorticity_share > 0.6
    assert "the map has no filaments: ask for more filaments, or a smaller circulation of each" in alone.warnings


def test_a_sequence_follows_the_ring_and_keeps_its_quantum(ring_file):
    files = tuple(FrameFile(frame, ring_file(0.05 * frame)) for frame in (1, 2, 3))
    stages = []
    result = SequenceRequest(files, FlowSettings(**QUICK, count=4.0)).solve(
        lambda stage, fraction: stages.append((stage, fraction)) or True
    )
    assert [frame.frame for frame in result.frames] == [1, 2, 3]
    for frame in result.frames:
        assert frame.shown.lines and all(distance(x.points, 0.05 * frame.frame) < 3 for x in frame.shown.lines)
        assert frame.shown.quantum == result.quantum
        assert frame.result.found.phases.shape == (result.grid.node_count,)
    assert any("frame 3" in stage for stage, _ in stages)
    fractions = [fraction for _, fraction in stages]
    assert fractions == sorted(fractions) and fractions[-1] <= 1


def test_warnings_of_a_sequence_name_their_frames(ring_file):
    files = tuple(FrameFile(frame, ring_file(0.05 * frame)) for frame in (4, 5))
    result = SequenceRequest(files, FlowSettings(resolution=NODES, quantum=40.0)).solve()
    assert [line for line in result.warnings if line.startswith("frames 4, 5: the map has no filaments")]


def test_a_sequence_is_cancelled_on_its_way(ring_file):
    files = tuple(FrameFile(frame, ring_file(0.05 * frame)) for frame in (1, 2))
    with pytest.raises(Cancelled):
        SequenceRequest(files, FlowSettings(**QUICK)).solve(lambda stage, fraction: "frame 2" not in stage)


def test_frames_need_the_same_grid_and_some_vorticity(ring_file, tmp_path):
    files = FrameFile(1, ring_file()), FrameFile(2, ring_file(shift=0.5))
    with pytest.raises(SettingError, match=r"ring_0.0_0.5.npz: its grid is not that of ring_0.0_0.0.npz"):
        SequenceRequest(files, FlowSettings(**QUICK)).solve()
    still = ring_file(0.4, velocity=np.ones((9, 9, 9, 3)))
    with pytest.raises(SettingError, match="no frame has vorticity"):
        SequenceRequest((FrameFile(1, still),), FlowSettings(**QUICK)).solve()


def test_what_cannot_be_asked_of_sequences_is_refused(ring_file):
    files = (FrameFile(1, ring_file()),)
    with pytest.raises(SettingError, match="use the method sdp"):
        SequenceRequest(files, FlowSettings(resolution=NODES, method="spectral"))
    with pytest.raises(SettingError, match="a resolution of 7 nodes shows no vortex"):
        SequenceRequest(files, FlowSettings(resolution=7))


def test_grids_in_a_plane_and_too_large_ones_are_refused():
    with pytest.raises(SettingError, match="Flow: a flow in a plane has no filaments"):
        check_grid(Grid((8, 8)), "Flow")
    with pytest.raises(SettingError, match=r"the grid has 300 x 300 x 300 nodes, which take about \d+ GB"):
        check_grid(Grid((300, 300, 300)), "Flow")


@pytest.mark.parametrize(
    "settings, told",
    [
        ({"frames": (1, 2, 3)}, "the frames are (1, 2, 3): give the first and the last one, whole numbers"),
        ({"frames": (3, 2)}, "the frames are 3 to 2: give the first and the last, in order"),
        ({"opening": 180.0}, "to 179.9"),
        ({"point": (0, 0, 0)}, "the point of the sphere is (0, 0, 0)"),
        ({"point": (0, 0, np.nan)}, "the point of the sphere is (0, 0, nan)"),
        ({"show": "tubes", "method": "spectral"}, "come from the relaxation"),
        ({"point": (0, 0, 1), "method": "spectral"}, "come from the relaxation"),
        ({"show": "all"}, "is unknown: use one of"),
        ({"count": 0.0}, "give a positive number"),
    ],
)
def test_settings_that_contradict_or_are_none_are_refused(settings, told):
    with pytest.raises(SettingError) as error:
        FlowSettings(**settings)
    assert told in str(error.value)


def test_a_point_is_numbers_and_cores_are_wider_where_tubes_are_shown():
    assert FlowSettings(point=[1, 0, 0]).point == (1.0, 0.0, 0.0)
    assert [FlowSettings(show=show).core_cells for show in ("filaments", "tubes")] == [0.5, 2.0]
    assert FlowSettings(core=3.0).core_cells == 3.0
