# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are no flow: each is refused in one line."""

import struct
import sys

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.files import flows, volumes
from synch_fields.core.memory import used_bytes
from synch_fields.synch_addon.blender import openvdb
from synch_fields.synch_addon.flows.job import clebsch

from ..vortex_scenes import write_vdb


@pytest.mark.skipif(sys.platform != "linux", reason="address space is limited on Linux alone")
def test_a_damaged_volume_cannot_take_the_machines_memory(tmp_path, monkeypatch):
    path = tmp_path / "flow.vdb"
    write_vdb(path)
    content = path.read_bytes()
    place = content.index(b"_count") + len("_count") + 3  # the length of the next name, of two bytes more now
    path.write_bytes(content[:place] + b"-1" + content[place:])
    monkeypatch.setattr(volumes, "SOUND_BYTES", 2**28)
    before = used_bytes()
    with pytest.raises(SettingError, match=r"it promises \d+ bytes and has \d+"):
        flows.flow_file(path, module=openvdb.module_file()).read()
    assert used_bytes() < before + 2**29


def refuse_files(tmp_path):
    """Files that are no flow, and what has to be said about each."""
    vdb = openvdb.openvdb_module()
    scalar, nothing, broken, far = vdb.FloatGrid(), vdb.Vec3SGrid(), vdb.Vec3SGrid(), vdb.Vec3SGrid()
    scalar.name, nothing.name, broken.name, far.name = "density", "velocity", "velocity", "velocity"
    scalar.fill((0, 0, 0), (4, 4, 4), 1.0)
    broken.fill((0, 0, 0), (4, 4, 4), (1.0, 2.0, 3.0))
    broken.getAccessor().setValueOn((2, 2, 2), (np.nan, 0.0, 0.0))
    for corner in (0, 10**6):
        far.fill((corner,) * 3, (corner + 4,) * 3, (1.0, 2.0, 3.0))
    for name, grid in (("scalar", scalar), ("empty", nothing), ("nan", broken), ("far", far)):
        vdb.write(str(tmp_path / f"{name}.vdb"), grids=[grid])
    (tmp_path / "text.vdb").write_text("no volume")
    content = write_vdb(tmp_path / "sound.vdb").read_bytes()
    scale = content.index(b"TranslateMap") + len("TranslateMap") + 3 * 8  # behind the three numbers of the place
    for name, number in (("nowhere", np.nan), ("endless", 1e300), ("flat", 0.0)):
        damaged = content[:scale] + struct.pack("<d", number) + content[scale + 8 :]
        (tmp_path / f"{name}.vdb").write_bytes(damaged)
    np.savez(tmp_path / "other.npz", speed=np.ones(3))
    np.savez(tmp_path / "shape.npz", velocity=np.ones((4, 4, 3)))
    bad = np.ones((5, 5, 5, 3))
    bad[1, 2, 3, 0] = np.inf
    np.savez(tmp_path / "inf.npz", velocity=bad)
    np.savez(tmp_path / "still.npz", velocity=np.ones((5, 5, 5, 3)))
    good = np.ones((5, 5, 5, 3))
    (tmp_path / "none.npz").write_bytes(b"")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "still.npz").read_bytes()[:900])
    with (tmp_path / "single.npz").open("wb") as file:
        np.save(file, good)
    np.savez(tmp_path / "complex.npz", velocity=good + 1j)
    np.savez(tmp_path / "words.npz", velocity=good.astype(str))
    np.savez(tmp_path / "two.npz", velocity=good, spacing=[1.0, 2.0])
    np.savez(tmp_path / "text.npz", velocity=good, spacing="wide")
    np.savez(tmp_path / "nowhere.npz", velocity=good, origin=[0, np.nan, 0])
    np.savez(tmp_path / "around.npz", velocity=good, periodic="no")
    return {
        "none.npz": "write it with numpy.savez",
        "cut.npz": "write it with numpy.savez",
        "single.npz": "a single array without a name: write it with numpy.savez",
        "complex.npz": "velocity holds complex128 values",
        "words.npz": "velocity holds <U.* values",
        "two.npz": r"spacing is \[1.0, 2.0\]: give one positive number, or 3 of them",
        "text.npz": "spacing is 'wide'",
        "nowhere.npz": r"origin is \[0.0, nan, 0.0\]",
        "around.npz": "periodic is 'no'",
        "scalar.vdb": r"has no vectors \(it has density",
        "empty.vdb": "is empty",
        "nan.vdb": "not numbers",
        "far.vdb": "spans 1000005 x 1000005 x 1000005 voxels, more than memory holds: remove what lies far away",
        "nowhere.vdb": "choose an OpenVDB file",
        "endless.vdb": "a transform that is not finite: export it again",
        "flat.vdb": "choose an OpenVDB file",
        "text.vdb": "choose an OpenVDB file",
        "missing.vdb": "no such file",
        "other.npz": "no array 'velocity' .it has speed",
        "shape.npz": r"shape \(4, 4, 3\)",
        "inf.npz": r"node \(1, 2, 3\) \(1 in all\) is not a number",
        "still.npz": "no vorticity",
        "flow.txt": "read from .vdb, .npz, .vti, ",
    }


def test_what_is_no_flow_is_refused_in_one_line(tmp_path):
    for name, message in refuse_files(tmp_path).items():
        with pytest.raises(SettingError, match=message) as caught:
            clebsch(tmp_path / name, resolution=12)
        assert "\n" not in str(caught.value)
    assert not bpy.data.objects
