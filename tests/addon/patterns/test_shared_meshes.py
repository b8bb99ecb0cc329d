# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every real mesh goes through stripes and directions."""

import pytest

from synch_fields.synch_addon import api

from ..quad_meshes import is_closed
from ..rebuilt_pattern import largest_jump
from ..scenes import empties, save_and_reopen
from ..shared_meshes import MARKS, MESHES, opened

pytestmark = MARKS


def check(obj, report):
    """What holds for every result."""
    assert report["status"] == "certified" and report["sdp_gap"] <= 1.1e-2
    # The relaxation is solved to its gap: where it is tight, polishing may go below its value.
    assert 0 <= report["lower_bound"] <= report["sdp_value"] <= report["energy"] * (1 + 2e-2)
    assert len(empties(obj)) == len(report["disclinations"]) + len(report["dislocations"])


@pytest.mark.parametrize("name", MESHES)
def test_stripes(name, tmp_path):
    obj = opened(name)
    report = api.stripes(obj)
    check(obj, report)
    if is_closed(obj):
        assert sum(d["index"] for d in report["disclinations"]) == report["euler_characteristic"]
    obj = save_and_reopen(tmp_path / "striped.blend", obj.name)
    jump, compared = largest_jump(obj)
    assert compared > len(obj.data.loop_triangles)
    assert jump < 1e-4


@pytest.mark.parametrize("symmetry", ["vector", "line", "cross"])
@pytest.mark.parametrize("name", MESHES)
def test_directions(name, symmetry):
    obj = opened(name)
    report = api.directions(obj, symmetry=symmetry)
    check(obj, report)
    if is_closed(obj):
        assert sum(d["index"] for d in report["disclinations"]) == report["euler_characteristic"]
