# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes of tetrahedra and spacings fit one another, and those that refusals name are taken."""

import re

import numpy as np
import pytest

from synch_fields.core.errors import SettingError, round_up
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.lengths import (
    EDGES_PER_LAYER,
    FEWEST_EDGES,
    LAYERS_ACROSS,
    MOST_TETS,
    TOGETHER,
    WANTED_ACROSS,
    Lengths,
    Measures,
    estimate,
)
from synch_fields.core.geometry.filling.stuffing import MOST_CUBES, estimated_cubes
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance

from ...meshes import cube


def test_automatic_lengths_fit_one_another():
    distance = SurfaceDistance(cube(2))
    expected = estimate(distance)
    assert expected.tets == pytest.approx(100_000, rel=0.01)
    both = Lengths.of(distance, None, None, divisions=1)
    assert both.spacing == max(1 / LAYERS_ACROSS, EDGES_PER_LAYER * both.size) and both.size == expected.size
    assert Lengths.of(distance, 0.07, None).size == pytest.approx(0.07 / EDGES_PER_LAYER)
    assert Lengths.of(distance, 0.06, None, divisions=1).size == pytest.approx(0.06 / EDGES_PER_LAYER)
    assert Lengths.of(distance, None, 0.1, divisions=1).spacing == pytest.approx(0.3)
    assert Lengths.of(distance, None, 0.1, 0.5, divisions=1).spacing == pytest.approx(0.6)
    assert Lengths.carried(distance, 0.01, 0.1) == (0.01, 0.1, 30)
    # What would take too many tetrahedra is solved for several layers together, at the automatic size.
    fine = Lengths.of(distance, 0.01, None)
    assert fine.size == both.size and fine.divisions == np.ceil(EDGES_PER_LAYER * both.size / 0.01)


@pytest.mark.parametrize("stretch", [1, 2, 5, 20])
@pytest.mark.parametrize("size", [None, 0.05, 0.1])
def test_there_are_as_many_layers_as_wanted_or_as_a_few_in_a_period_give(stretch, size):
    """On a block of any length; along a thin one, whose edges are short, each period carries one layer."""
    block = SurfaceDistance(TriangleMesh(cube(2).vertices * [stretch, 1, 1], cube(2).triangles))
    lengths = Lengths.of(block, None, size)
    layers = stretch / lengths.spacing
    assert layers <= LAYERS_ACROSS * (1 + 1e-9) and lengths.divisions <= TOGETHER
    assert layers >= WANTED_ACROSS * (1 - 1e-9) or lengths.divisions == TOGETHER
    assert lengths.period >= FEWEST_EDGES * lengths.size
    alone = Lengths.of(block, None, size, divisions=1)
    assert lengths.divisions == 1 or stretch / alone.spacing < WANTED_ACROSS


@pytest.mark.parametrize(
    ("spacing", "size", "words"),
    [
        (2.0, None, "the spacing 2 is larger than the object .1.73205.: no layer would fit"),
        (0.1, 0.1, "finer than tetrahedra of size 0.1 can carry: give a size of 0.0333, or 2 divisions, or a"),
        (None, 1e-4, "makes about .* tetrahedra, .* MB: give one from "),
        (None, -0.01, "the tetrahedra's size is -0.01: give a positive length"),
    ],
)
def test_lengths_that_cannot_be_are_refused(spacing, size, words):
    with pytest.raises(SettingError, match=words):
        Lengths.of(SurfaceDistance(cube(2)), spacing, size, divisions=1)


@pytest.mark.parametrize(
    ("spacing", "size", "divisions", "named"),
    [
        (0.1, 0.1, 1, ["size", "divisions", "spacing"]),
        (0.12343, 0.12343, 1, ["size", "divisions", "spacing"]),
        (0.0012, 0.1, 3, ["divisions", "spacing"]),  # tetrahedra for these would be too many
        (None, 1e-4, None, ["from"]),
        (0.003, 1e-4, None, ["from"]),
        (0.3, 1e-4, 1, ["from"]),
        (0.001, None, 1, ["divisions", "spacing"]),
        (0.001, 2e-4, 1, ["from divisions", "from spacing"]),
    ],
)
def test_each_length_that_a_refusal_names_is_taken(spacing, size, divisions, named):
    distance = SurfaceDistance(cube(2))
    with pytest.raises(SettingError) as caught:
        Lengths.of(distance, spacing, size, divisions=divisions)
    text = str(caught.value).partition(": give ")[2]
    patterns = {
        "size": r"a size of ([\d.e-]+)",
        "divisions": r"(\d+) divisions",
        "spacing": r"a spacing from ([\d.e-]+) on",
        "from": r"^one from ([\d.e-]+) on",
    }
    told = {name: float(found[1]) for name, pattern in patterns.items() if (found := re.search(pattern, text))}
    assert told.keys() == set(" ".join(named).split())
    for names in named:
        given = {"spacing": spacing, "size": size, "divisions": divisions}
        given |= {"size" if name == "from" else name: told[name] for name in names.split()}
        given["divisions"] = given["divisions"] and int(given["divisions"])
        found = Lengths.of(distance, **given)
        assert estimate(distance, found.size).tets <= MOST_TETS


def test_all_remedies_work_for_boxes_of_any_shape():
    """Sizes, divisions and spacings that refusals name, one after the other, with the size that is named first."""
    random, tried = np.random.default_rng(2), 0
    for _ in range(4000):
        edges = np.sort(10 ** random.uniform(-1.5, 1, 3))[::-1]
        around = 2 * (edges[0] * edges[1] + edges[1] * edges[2] + edges[0] * edges[2])
        box = Measures(random.uniform(0.02, 1) * edges.prod(), around, np.array([-edges / 2, edges / 2]), edges)
        spacing, size = edges[0] * 10 ** random.uniform([-3, -3.2], [0, 0])
        lowest, divisions = random.uniform(0.2, 1), int(random.integers(1, 6))
        try:
            Lengths.of(box, spacing, size, lowest, divisions)
            continue
        except SettingError as error:
            text = str(error).split("give")[1]
        least = re.findall(r"one from ([0-9.e+-]+) on", text)
        size = float(least[0]) if least else size
        ways = [(spacing, float(found), divisions) for found in re.findall(r"a size of ([0-9.e+-]+)(?:,|$)", text)]
        ways += [(spacing, size, int(found)) for found in re.findall(r"([0-9]+) divisions", text)]
        ways += [(float(found), size, divisions) for found in re.findall(r"a spacing from ([0-9.e+-]+) on", text)]
        for way in ways or [(spacing, size, divisions)]:
            Lengths.of(box, *way[:2], lowest, way[2])
            tried += 1
    assert tried > 1000


@pytest.mark.parametrize("width", [0.01, 0.002, 0.0005])
@pytest.mark.parametrize("layers", [0.5, 1, 2])
def test_layers_of_a_slanting_rod_are_in_longer_periods_where_its_box_has_too_many_cubes(width, layers):
    length = np.sqrt(3.0)
    box, extents = np.array([[0.0, 0, 0], [1, 1, 1]]), np.array([length, width, width])
    rod = Measures(length * width**2, 4 * length * width, box, extents)
    lengths = Lengths.of(rod, width / layers, None)
    assert estimated_cubes(box, lengths.size) <= MOST_CUBES
    assert lengths.period >= EDGES_PER_LAYER * lengths.size * (1 - 1e-6)


def test_limits_are_rounded_upwards():
    random = np.random.default_rng(0)
    for value, digits in zip(10 ** random.uniform(-12, 12, 500), random.integers(1, 7, 500).tolist(), strict=True):
        text = round_up(value, digits)
        assert value <= float(text) <= value * (1 + 1.01 * 10.0 ** (1 - digits))
        assert len(text.partition("e")[0].replace(".", "").strip("0")) <= digits
    assert (round_up(0.25), round_up(0.9996), round_up(12345.0), round_up(1e-4, 1)) == (
        "0.25",
        "1",
        "1.24e+04",
        "0.0001",
    )


def test_the_smallest_size_makes_the_most_tetrahedra():
    distance = SurfaceDistance(cube(2))
    with pytest.raises(SettingError) as caught:
        Lengths.of(distance, None, 1e-4)
    smallest = float(str(caught.value).split("from ")[1].split(" ")[0])
    assert estimate(distance, smallest).tets == pytest.approx(MOST_TETS, rel=0.02)
    Lengths.of(distance, None, smallest)
