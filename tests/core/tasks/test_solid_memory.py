# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory that layers take: estimated for any surface, refused where there is too little, and measured."""

import re
import sys
import tracemalloc
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from synch_fields.core import memory
from synch_fields.core.errors import Cancelled, SettingError, SynchError
from synch_fields.core.extract.layers.crossings import refuse_too_many_layers
from synch_fields.core.fields.guidance.filled import along_axis
from synch_fields.core.fields.layers import SolidTargetOneForm
from synch_fields.core.geometry.filling.lengths import Lengths, Measures
from synch_fields.core.memory import Room
from synch_fields.core.solve import Options
from synch_fields.core.tasks.solid_memory import is_searched, layer_memory
from synch_fields.core.tasks.solids import FlushArea, SolidGuide, SolidRequest

from ..geometry.filling.test_thin_walls import plate
from ..memory_peak import numbers_of_child
from ..meshes import cube
from .test_layer_requests import UP, closed, flat_area, request_in


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


@pytest.mark.parametrize("is_axis", [False, True])
@pytest.mark.parametrize("is_even", [False, True])
def test_only_an_even_axis_with_one_area_at_most_is_integrated(is_axis, is_even):
    assert [is_searched(is_axis, is_even, areas) for areas in range(3)] == [not (is_axis and is_even)] * 2 + [True]


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


@pytest.mark.parametrize("is_given", [False, True])
def test_what_takes_more_memory_than_there_is_is_refused_before_it_begins(is_given, monkeypatch):
    request = request_in(closed(cube(2)))
    if is_given:
        request = replace(request, solid=request.surface.filled(0.1).solid)
    expected = request.estimate
    assert expected.tets == pytest.approx(15_000, rel=0.2)

    def begun_with(share):
        monkeypatch.setattr(memory, "room", lambda *_: Room(share * request.memory.needed, 1.0, "memory", "buy it"))
        request.solve(lambda *_: False)

    with pytest.raises(Cancelled):
        begun_with(0.8)  # estimates may be a third too high
    with pytest.raises(
        SynchError, match=rf"^a solve of layers in {expected.tets:,} tetrahedra takes about .* GB of memory"
    ):
        begun_with(0.7)


# What layers take at the peak beyond what there was, as the system measures it, over what was estimated.
MEASURE = """
import sys
from dataclasses import replace
import numpy as np
from synch_fields.core.geometry.filling.lengths import Lengths
from synch_fields.core.memory import peak_megabytes, used_bytes
from synch_fields.core.tasks.solids import SolidGuide
from synch_fields.tests.core.tasks.test_layer_requests import UP, closed, flattened, request_in
from synch_fields.tests.core.meshes import icosphere
shape, size, spacing, guide = sys.argv[1], *map(float, sys.argv[2:4]), sys.argv[4]
whirl = SolidGuide("whirl", lambda filled: np.cross([0, 0, 1], filled.solid.vertices) + [0, 0, 0.3])
surface = closed(icosphere(3) if shape == "ball" else flattened(*map(float, shape.split())))
divisions = max(round(3 * size / spacing), 1)
guide = replace(UP, is_axis=True) if guide == "up" else whirl
request = request_in(surface, divisions * spacing, size, guide=guide)
request = replace(request, lengths=Lengths(spacing, size, divisions))
before = used_bytes()
result = request.solve(lambda *_: None)
taken = 2**20 * peak_megabytes() - before
print(taken / request.estimate.bytes)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere what a process has is told otherwise")
@pytest.mark.parametrize(
    ("shape", "size", "spacing", "guide"),
    [
        pytest.param("ball", 0.13, 0.3, "whirl", marks=pytest.mark.slow),
        ("ball", 0.1, 0.3, "whirl"),
        pytest.param("ball", 0.085, 0.3, "whirl", marks=pytest.mark.slow),
        ("6 6 0.5", 0.16, 0.3, "whirl"),
        pytest.param("8 1 1", 0.12, 0.3, "whirl", marks=pytest.mark.slow),
        ("1 1 1", 0.055, 0.01, "up"),  # many layers across an edge
    ],
)
def test_layers_take_as_much_memory_as_was_estimated(shape, size, spacing, guide):
    """Within 30 %, of several shapes and sizes, with proofs."""
    (share,) = numbers_of_child(MEASURE, shape, str(size), str(spacing), guide)
    assert 1 / 1.3 <= share <= 1.3


def test_directions_that_are_integrated_need_less_memory():
    surface = closed(cube(2))
    axis = replace(UP, is_axis=True)
    floor, lid = (FlushArea(flat_area(surface, height, "end"), 0.0) for height in (0, 1))
    request = request_in(surface, guide=axis, flush_areas=(floor,))
    assert request.memory.expected < request_in(surface).memory.needed
    for searched in (
        replace(request, flush_areas=(floor, lid)),
        replace(request, factors=np.ones(surface.mesh.vertex_count)),
    ):
        assert searched.memory == request_in(surface).memory


@pytest.mark.parametrize("spacing", [1e-5, 1e-8])
def test_more_layers_than_are_drawn_are_refused_before_they_take_memory(spacing):
    """In given tetrahedra, where no spacing is too fine; with one that is not refused."""
    request = request_in(closed(cube(2)), 0.5, 0.2)
    solid = request.surface.filled(0.2).solid

    def with_spacing(given):
        return replace(request, solid=solid, lengths=Lengths.carried(request.surface.distance, given, 0.2))

    tracemalloc.start()
    try:
        with pytest.raises(SettingError, match=r"^the layers cross the solid's edges .* times") as caught:
            with_spacing(spacing).solve()
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()
    factor = float(re.search(r"make the spacing (\S+) times as large", str(caught.value))[1])
    growth = SolidTargetOneForm.of(solid, np.tile([0.0, 0.0, 1.0], (solid.vertex_count, 1)), factor * spacing)
    refuse_too_many_layers(growth.changes)
