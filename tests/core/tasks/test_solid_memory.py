# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory of layers, for surfaces that were not checked before, and for thin walls."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from synch_fields.core import memory
from synch_fields.core.errors import SynchError
from synch_fields.core.fields.guidance.filled import along_axis
from synch_fields.core.geometry.filling.lengths import Lengths, Measures
from synch_fields.core.memory import Room
from synch_fields.core.solve import Options
from synch_fields.core.tasks.solid_memory import layer_memory
from synch_fields.core.tasks.solids import FlushArea, SolidGuide, SolidRequest

from ..geometry.filling.test_thin_walls import plate


def test_the_memory_is_estimated_for_any_triangles():
    """A panel asks for it before the surface is checked: open surfaces, and surfaces that intersect themselves."""
    rng = np.random.default_rng(0)
    shares = []
    for _ in range(300):
        points = rng.normal(size=(rng.integers(3, 40), 3))
        measures = Measures.of(points, rng.integers(0, len(points), (rng.integers(1, 60), 3)))
        if measures.volume > 0:
            needed, expected = layer_memory(measures, Lengths.of(measures, None, None))
            shares.append(expected / needed)
    assert len(shares) > 250 and min(shares) >= 1


def plate_request():
    """A plate whose sides carry layers, 0.12 thick, with tetrahedra that would have to be several times as many."""
    surface, areas = plate(0.12)
    asked = tuple(FlushArea(area, np.pi) for area in areas)
    guide = SolidGuide("axis:Z", partial(along_axis, np.array([0.0, 0.0, 1.0])), is_axis=True)
    return SolidRequest(surface, None, guide, asked, Lengths(0.04, 0.1, 10), None, Options())


def test_walls_that_stay_coarse_are_warned_of():
    """Until the tetrahedra are as small as the warning asks for."""
    request = plate_request()
    (warning,) = (line for line in request.solve().warnings if "thin walls" in line)
    assert "longer than 50% of the thickness" in warning and "reduce the size of the tetrahedra, 0.1" in warning
    finer = replace(request, lengths=Lengths(0.04, 0.06, 10))
    assert not any("thin walls" in line for line in finer.solve().warnings)


def test_the_tetrahedra_in_thin_walls_need_memory_too(monkeypatch):
    request = plate_request()
    estimated, divided = request.estimate.tets, request.surface.filled(0.1, [f.area for f in request.flush_areas])
    assert divided.solid.tet_count > 1.5 * estimated
    monkeypatch.setattr(memory, "room", lambda *_: Room(1.0 * request.memory.needed, 1.0, "memory", "buy it"))
    with pytest.raises(SynchError, match=rf"^a solve of layers in {divided.solid.tet_count:,} tetrahedra takes about"):
        request.solve()
