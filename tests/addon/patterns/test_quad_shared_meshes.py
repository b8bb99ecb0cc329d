# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every real mesh gets a continuous quad pattern and a sound mesh of quads, even from the roughest solve."""

import numpy as np
import pytest

from synch_fields.synch_addon import api

from ..quad_meshes import distances, euler_characteristic, is_closed, is_manifold, made_from, surface
from ..rebuilt_pattern import largest_jump
from ..scenes import empties, places
from ..shared_meshes import MARKS, MESHES, opened

REFUSED = {"teapot"}  # vertices at which pieces only touch
SOUND = [name for name in MESHES if name not in REFUSED]

pytestmark = MARKS


@pytest.mark.parametrize("name", SOUND)
def test_quads(name):
    obj = opened(name)
    report = api.quads(obj, method="spectral")
    assert len(empties(obj)) == len(report["disclinations"]) + len(report["dislocations"])
    if is_closed(obj):
        assert sum(d["index"] for d in report["disclinations"]) == report["euler_characteristic"]
    jump, compared = largest_jump(obj)
    assert compared > len(obj.data.loop_triangles)
    assert jump < 1e-4


@pytest.mark.parametrize("smoothing", [0, 3])
@pytest.mark.parametrize("name", SOUND)
def test_quad_meshes(name, smoothing):
    obj = opened(name)
    made, report = made_from(obj, method="spectral", smoothing=smoothing)
    assert not made.data.validate(verbose=True), "Blender finds something to mend"
    assert is_manifold(made)
    assert is_closed(made) == is_closed(obj) == report["quad_mesh"]["closed"]
    assert euler_characteristic(made) == report["euler_characteristic"] == report["quad_mesh"]["euler_characteristic"]
    assert report["quad_mesh"]["quad_share"] > 0.7
    tree, normals = surface(obj)
    assert distances(tree, places(made)).max() < 1e-6 * max(np.ptp(places(obj), axis=0))
    turned = 0
    for polygon in made.data.polygons:
        _, _, triangle, _ = tree.find_nearest(polygon.center)
        turned += normals[triangle] @ np.array(polygon.normal) < 0
    assert turned < 0.01 * len(made.data.polygons)
