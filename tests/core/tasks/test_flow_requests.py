# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of arrays, of curves and of sequences, asked for and solved without Blender: the ring that each of them is."""

import re
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError
from synch_fields.core.extract.vortices.filaments import filaments
from synch_fields.core.fields.biot_savart import FilamentCurves, filament_velocity
from synch_fields.core.fields.clebsch import clebsch_map, layer_sums
from synch_fields.core.files.flows import ArrayFile
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.grid import Grid, box_grid
from synch_fields.core.geometry.squares import grid_squares
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.solve import Options
from synch_fields.core.tasks import flows
from synch_fields.core.tasks.flow_costs import solve_seconds
from synch_fields.core.tasks.flow_sequences import FrameFile, SequenceRequest
from synch_fields.core.tasks.flows import FlowRequest, SurfaceFlowRequest, check_grid, extract_vortices

from ..expectation import told_at_once
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
    assert result.linked is not None and not any("core of" in line for line in result.warnings)
    again = result.show_again(FlowSettings(**QUICK, quantum=0.5, point=(0.0, 0.0, -1.0)))
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


def test_a_circulation_that_carries_too_little_after_all_becomes_smaller(ring_file, monkeypatch):
    monkeypatch.setattr(flows, "find_quantum", lambda *_: 4.0)  # twice the ring's
    settings = FlowSettings(resolution=NODES, seed=1, share=0.6)
    result = FlowRequest(ring_file(), settings).solve()
    assert result.shown.share > 0.5 and result.found.quantum == 1
    # Filaments that are left out do not count: none is longer than two boxes.
    monkeypatch.setattr(flows, "_STUB", 1000.0)
    assert FlowRequest(ring_file(), settings).solve().found.quantum < result.found.quantum


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


def test_frames_that_carry_little_or_only_noise_are_warned_of(ring_file):
    noise = np.random.default_rng(0).standard_normal((18, 18, 18, 3))
    files = FrameFile(1, ring_file()), FrameFile(2, ring_file(0.1, velocity=noise))
    result = SequenceRequest(files, FlowSettings(resolution=NODES, quantum=1.5, target_gap=0.1)).solve()
    lines, noise = [frame.facts["vorticity_share"] for frame in result.frames], "velocities change at random"
    warned = [line for line in result.warnings if "less than 60% of the vorticity" in line]
    assert [0 < share < 0.6 for share in lines] == [str(frame) in "".join(warned)[:12] for frame in (1, 2)]
    assert any(
        line.startswith("frame 2: the velocities change at random from node to node") for line in result.warnings
    )


def test_a_flow_without_vorticity_is_warned_of(tmp_path):
    """A potential's gradient, of which sampling makes some vorticity."""
    grid = box_grid(np.full(3, -0.6), np.full(3, 0.6), NODES)
    x, y, z = grid.places.T
    gradient = np.column_stack([3 * x**2 * y + z**3, x**3, 3 * x * z**2]).reshape(*grid.shape, 3)
    np.savez(tmp_path / "still.npz", velocity=gradient, spacing=grid.spacing, origin=grid.origin)
    result = FlowRequest(ArrayFile(tmp_path / "still.npz"), FlowSettings(method="spectral")).solve()
    assert result.warnings[0].startswith("the flow has no vorticity but for what its sampling makes")


def test_tubes_that_are_blobs_and_filaments_of_a_cell_are_told(ring_file):
    """Of one quantum of a thin ring the tube is a blob: a closed surface of Euler characteristic 2."""
    found = FlowRequest(ring_file(), FlowSettings(**QUICK, quantum=2.0)).solve()
    wide = FlowRequest(ring_file(), FlowSettings(**QUICK | {"opening": 30.0}, quantum=0.5)).solve()
    for result in (found, wide):
        tubes = result.shown.tubes
        mesh = TriangleMesh(tubes.vertices, tubes.triangles)
        assert tubes.pieces == len(np.unique(mesh.pieces))
        numbers = []  # brute force: vertices, edges and faces of each piece
        for number in range(tubes.pieces):
            faces = mesh.triangles[mesh.pieces[mesh.triangles[:, 0]] == number]
            edges = {tuple(sorted(pair)) for a, b, c in faces.tolist() for pair in ((a, b), (b, c), (c, a))}
            numbers.append(len(np.unique(faces)) - len(edges) + len(faces))
        assert tubes.blobs == sum(number > 0 for number in numbers)
        assert any("are blobs, around no filament" in line for line in result.warnings) == (tubes.blobs > 0)
    assert found.shown.tubes.blobs or wide.shown.tubes.blobs


def test_progress_says_from_the_beginning_how_long_a_solve_takes(ring_file):
    settings = FlowSettings(target_gap=0.1, method="spectral")
    assert told_at_once(FlowRequest(ring_file(), settings)) == pytest.approx(solve_seconds(NODES**3, settings))


@pytest.mark.parametrize("quantum, nodes, seconds", [(None, 14336, 1.7), (0.25, 27200, 10.6), (None, 73008, 6.8)])
def test_curves_take_about_the_time_that_was_measured(quantum, nodes, seconds):
    """Of a circle at two resolutions, and of two linked ones, on one core."""
    told = solve_seconds(nodes, FlowSettings(quantum=quantum), is_of_curves=True)
    assert seconds / 3 < told < 3 * seconds


def test_frames_take_a_share_of_the_time_of_the_first(ring_file):
    settings = FlowSettings(target_gap=0.1)
    files = tuple(FrameFile(frame, ring_file(0.05 * frame)) for frame in (1, 2))
    one = solve_seconds(NODES**3, settings, 1)
    # No other circulation is tried after the first.
    assert one < told_at_once(SequenceRequest(files, settings)) < 2 * one < 2 * solve_seconds(NODES**3, settings)


def test_flows_on_surfaces_say_how_long_they_take_too():
    grid = Grid((12, 10), 0.1)
    velocity = np.column_stack([-grid.places[:, 1], grid.places[:, 0], 0 * grid.places[:, 0]])
    settings = FlowSettings(quantum=1.0, target_gap=0.1)
    told = told_at_once(SurfaceFlowRequest(grid_squares(grid), velocity, settings))
    assert told == pytest.approx(solve_seconds(grid.node_count, settings, is_surface=True))
    assert told < solve_seconds(grid.node_count, FlowSettings(), is_surface=True)


@pytest.mark.parametrize("spacing", [1.0, (1.0, 1.0, 40.0)])
def test_stubs_are_left_out_and_counted(spacing):
    grid = Grid((12, 12, 12), spacing)
    phases = np.ones(grid.node_count, complex)
    phases[grid.numbers[5, 5, 5]] = -1
    phases[grid.numbers[6, 5, 5]] = np.exp(2.1j)
    found = clebsch_map(grid, np.zeros(len(grid.edges)), 1.0, Options(method="spectral")).with_phases(phases)
    turned = replace(found, integrals=np.random.default_rng(0).uniform(-0.3, 0.3, len(grid.edges)))
    every, shown = filaments(turned), extract_vortices(turned, None, FlowSettings(smoothing=0))
    small = [line for line in every if (np.ptp(line.whole, axis=0) / spacing).max() < 2]
    assert len(small) > 0 and shown.stubs == len(small) and len(shown.lines) == len(every) - len(small)
    assert any("left out, no longer than two cells" in line for line in shown.missing)


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


@pytest.mark.parametrize("quantum", [None, 0.5])
def test_filaments_of_a_coarse_grid_are_shown_first_and_those_of_the_result_before_its_sphere(ring_file, quantum):
    request, shown = FlowRequest(ring_file(), FlowSettings(seed=1, quantum=quantum)), []
    result = request.solve_showing(shown.append)
    first, *_, last = shown
    assert max(first.found.grid.shape) == NODES // 2 and "ended early" in first.warnings[0]
    assert first.shown.lines and all(distance(line.points) < 6 for line in first.shown.lines)
    assert last.found is result.found and last.sphere is None and last.warnings == ()
    # Their picture has a segment from each point to the next one, closed.
    ends = request.picture(last).places.reshape(-1, 2, 3)
    points = np.concatenate([line.points for line in last.shown.lines])
    np.testing.assert_allclose(ends[:, 0], points, atol=1e-6)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max() < 2 * last.found.grid.spacing.max()


def test_tubes_alone_have_nothing_to_show_first(ring_file):
    shown = []
    FlowRequest(ring_file(), FlowSettings(**QUICK | {"show": "tubes"}, quantum=0.5)).solve_showing(shown.append)
    assert shown == []
