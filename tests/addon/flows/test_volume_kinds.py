# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways in which programs write a flow into volumes: centred, staggered, and each component apart."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.errors import SettingError
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import circulations
from synch_fields.core.files.flows import flow_file
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.tasks.flows import FlowRequest
from synch_fields.synch_addon.blender import openvdb

from ...core.files.test_flow_grids import vti

GRID = Grid((26, 26, 18), 0.1, (-1.25, -1.25, -0.85))
# Where flows are solved: the same box.
COARSE = Grid((16, 16, 12), 0.16, (-1.2, -1.2, -0.88))


def ring(places):
    turn = np.linspace(0, 2 * np.pi, 161)
    curve = np.column_stack([0.7 * np.cos(turn), 0.7 * np.sin(turn), 0.03 + 0 * turn])
    return filament_velocity(places, [(curve, 2.0)], 0.2)


def sampled(flow, kind, grid=GRID):
    """(nx, ny, nz, 3) values as a program of a kind stores them."""
    if kind == "staggered":  # each component half a voxel before its centre
        shifts = -0.5 * np.diag(grid.spacing)
        values = np.column_stack([flow(grid.places + shifts[k])[:, k] for k in range(3)])
    else:
        values = flow(grid.places)
    return values.reshape(*grid.shape, 3)


def write(path, values, kind="centred", name="velocity", grid=GRID, shift=(0, 0, 0)):
    """A .vdb file with these voxels; split ones with each component's grid moved by a row of ``shift``."""
    vdb = openvdb.openvdb_module()
    rows = np.eye(4)
    rows[:3, :3] = np.diag(grid.spacing)

    def finished(volume, called, part, away):
        volume.name = called
        volume.copyFromArray(np.ascontiguousarray(part, np.float32))
        volume.transform = vdb.createLinearTransform(np.vstack([rows[:3], [*(grid.origin + away), 1]]).tolist())
        return volume

    if kind == "split":
        ends = ("x", "y", "z")
        grids = [finished(vdb.FloatGrid(), f"{name}.{e}", values[..., k], shift[k]) for k, e in enumerate(ends)]
        vdb.write(str(path), grids=[finished(vdb.FloatGrid(), "density", values[..., 0], 0), *grids])
        return path
    volume = finished(vdb.Vec3SGrid(), name, values, 0)
    if kind == "staggered":
        volume.gridClass = vdb.GridClass.STAGGERED
    vdb.write(str(path), grids=[volume])
    return path


def read(path, attribute="velocity"):
    return flow_file(path, attribute, openvdb.module_file())


def dense(lines):
    """Points along filaments, a tenth of a segment apart."""
    return np.concatenate(
        [(1 - s) * w[:-1] + s * w[1:] for w in (x.whole for x in lines) for s in np.arange(0, 1, 0.1)]
    )


def test_one_flow_has_the_same_filaments_in_every_kind_of_file(tmp_path):
    """One quantum has one filament. Of several, another solve may lead them another way; staggered components that are
    read as centred move it by a quarter of a voxel."""
    centred = sampled(ring, "centred", COARSE).astype(np.float32)
    own = {"spacing": COARSE.spacing, "origin": COARSE.origin}
    np.savez(tmp_path / "flow.npz", velocity=centred, **own)
    staggered = sampled(ring, "staggered", COARSE)
    files = {
        "npz": tmp_path / "flow.npz",
        "vti": vti(tmp_path / "flow.vti", {"velocity": centred}, "raw", shape=COARSE.shape, **own),
        "split": write(tmp_path / "split.vdb", centred, "split", "vel", grid=COARSE),
        "staggered": write(tmp_path / "staggered.vdb", staggered, "staggered", grid=COARSE),
    }
    flows = {kind: read(path).read() for kind, path in files.items()}
    for kind in ("vti", "split"):
        np.testing.assert_allclose(flows[kind].integrals(COARSE), flows["npz"].integrals(COARSE), atol=1e-6)
    settings = FlowSettings(resolution=16, target_gap=0.05, quantum=1.0)
    (first,), (second,) = (
        FlowRequest(read(files[kind]), settings).solve().shown.lines for kind in ("npz", "staggered")
    )
    assert cKDTree(dense([first])).query(dense([second]))[0].max() < 0.04 * 0.16


def test_staggered_components_are_where_they_were_measured(tmp_path):
    """A linear flow, which is exact between voxels; read as centred it would be off by half its change in a voxel."""
    turn = np.array([[0.3, -1.0, 0.5], [0.7, 0.2, -0.4], [-0.6, 0.9, 0.1]])
    linear = lambda places: places @ turn.T  # noqa: E731
    flow = read(write(tmp_path / "flow.vdb", sampled(linear, "staggered"), "staggered")).read()
    inside = Grid((11, 11, 9), 0.13, (-0.7, -0.8, -0.6))
    np.testing.assert_allclose(flow.at(inside.places), linear(inside.places), atol=1e-5)
    curl = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    normals = 3 - inside.face_planes.sum(axis=1)
    np.testing.assert_allclose(circulations(inside, flow.integrals(inside)), curl[normals] * 0.13**2, atol=1e-5)


def test_edges_of_a_staggered_grid_are_as_near_to_the_flow_as_those_of_a_centred_one(tmp_path):
    """The integrals of sines along edges in closed form; both are straight between voxels, off by h^2 / 8."""
    flow = lambda p: np.column_stack([np.sin(2 * p[:, 0]), np.cos(3 * p[:, 1]), np.sin(p[:, 2])])  # noqa: E731
    whole = lambda p: np.column_stack([-np.cos(2 * p[:, 0]) / 2, np.sin(3 * p[:, 1]) / 3, -np.cos(p[:, 2])])  # noqa: E731
    i, j = GRID.edges.T
    rows = np.arange(len(i))
    exact = (whole(GRID.places[j]) - whole(GRID.places[i]))[rows, GRID.edge_axes]
    away = {}
    for kind in ("centred", "staggered"):
        found = read(write(tmp_path / f"{kind}.vdb", sampled(flow, kind), kind)).read()
        assert np.allclose(found.box, [GRID.places[0], GRID.places[-1]])
        ends = np.array(GRID.shape)[GRID.edge_axes] - 2
        last = np.array(np.unravel_index(i, GRID.shape))[GRID.edge_axes, rows] == ends  # half a voxel of it is missing
        away[kind] = (found.integrals(GRID) - exact)[~last] / 0.1
    assert np.abs(away["centred"]).max() < 0.01 and np.abs(away["staggered"]).max() < 0.01
    assert np.abs(away["staggered"] - away["centred"]).max() < 0.1 * np.abs(away["centred"]).max()


def test_components_on_faces_of_their_own_grids(tmp_path):
    """As Houdini samples them: three transforms, half a voxel apart."""
    turn = np.array([[0.3, -1.0, 0.5], [0.7, 0.2, -0.4], [-0.6, 0.9, 0.1]])
    linear = lambda places: places @ turn.T  # noqa: E731
    path = write(tmp_path / "f.vdb", sampled(linear, "staggered"), "split", "vel", shift=-0.05 * np.eye(3))
    inside = Grid((11, 11, 9), 0.13, (-0.7, -0.8, -0.6))
    np.testing.assert_allclose(read(path).read().at(inside.places), linear(inside.places), atol=1e-5)


def test_vorticity_in_place_of_the_velocity(tmp_path):
    """That of a Lamb-Oseen vortex along z: it is carried by one filament on its axis."""

    def vortex(places):
        squares = (places[:, :2] ** 2).sum(axis=1)
        return np.outer(np.exp(-squares / 0.15**2) / (np.pi * 0.15**2), [0, 0, 1])

    voxels = sampled(vortex, "centred", COARSE)
    path = write(tmp_path / "curl.vdb", voxels, name="vorticity", grid=COARSE)
    np.savez(tmp_path / "curl.npz", vorticity=voxels, spacing=COARSE.spacing, origin=COARSE.origin)
    for source in (path, tmp_path / "curl.npz"):
        result = FlowRequest(read(source), FlowSettings(resolution=16, target_gap=0.05, quantum=1.0)).solve()
        (line,) = result.shown.lines
        assert np.abs(line.points[:, :2]).max() < 0.03 and line.strength == 1
        assert result.shown.share == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("move", [3 * np.eye(3), np.diag([-1.0, 1, 1]), -2 * np.roll(np.eye(3), 1, axis=0)])
def test_the_vorticity_of_a_moved_volume_is_the_curl_of_its_velocity(tmp_path, move):
    """Scaled, mirrored and turned: a rotation about a slanted axis that fades out, and its curl in closed form."""
    axis = np.array([0.3, -0.7, 0.5])

    def swirl(places):
        return np.exp(-4 * (places**2).sum(axis=1))[:, None] * np.cross(axis, places)

    def curl(places):
        fading = np.exp(-4 * (places**2).sum(axis=1))[:, None]
        return fading * (2 * axis - 8 * np.cross(places, np.cross(axis, places)))

    matrix, found = np.eye(4), []
    matrix[:3, :3] = move
    for name, flow in (("velocity", swirl), ("vorticity", curl)):
        path = write(tmp_path / f"{name}.vdb", sampled(flow, "centred"), name=name)
        moved = dataclasses.replace(read(path), matrix=matrix).read()
        grid = moved.grid(26)
        found.append(circulations(grid, moved.integrals(grid)))
    assert found[0] @ found[1] / (found[0] @ found[0]) == pytest.approx(1, abs=0.03)


def test_what_is_missing_of_components_is_said(tmp_path):
    values = sampled(ring, "centred")
    path = write(tmp_path / "wind.vdb", values, "split", "wind")
    (warning,) = read(path).read().warnings or ("",)
    assert warning == "" and read(path, "wind").read().box[0] == pytest.approx(GRID.origin, abs=1e-6)
    with pytest.raises(SettingError, match=r"has no vectors 'speed' \(it has density \(float\), wind.x"):
        read(path, "speed").read()
    empty = write(tmp_path / "calm.vdb", 0 * values, "split", "vel")
    with pytest.raises(SettingError, match="is empty"):
        read(empty).read()
