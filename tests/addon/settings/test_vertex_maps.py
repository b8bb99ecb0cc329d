# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Angles, spacings and phases given from vertex to vertex."""

import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main

from ..run_commands import WAYS, add_weights, solve
from ..scenes import (
    add_group,
    attribute,
    directions,
    grid,
    places,
    ring,
    set_numbers,
    set_vectors,
    snapshot,
    sphere,
    tube,
)


@pytest.mark.parametrize("way", WAYS)
def test_an_attribute_of_angles_is_added_to_the_angle(way):
    obj = grid()
    x = places(obj)[:, 0]
    set_numbers(obj, "swirl", 0.5 * x)
    solve(way, obj, guidance="axis:X", symmetry="vector", angle=0.2, angle_attribute="swirl")
    angles = 0.2 + 0.5 * x
    np.testing.assert_allclose(directions(obj), np.column_stack([np.cos(angles), np.sin(angles), 0 * x]), atol=1e-4)


def test_angles_that_are_no_numbers_are_refused():
    obj = grid()
    angles = np.zeros(len(obj.data.vertices))
    angles[[4, 7]] = np.nan, np.inf
    set_numbers(obj, "swirl", angles)
    with pytest.raises(SynchError, match="'swirl' of Grid is of no use at vertices 4, 7: give a finite angle"):
        api.directions(obj, angle_attribute="swirl")
    with pytest.raises(SynchError, match="has no attribute 'absent'"):
        api.directions(obj, angle_attribute="absent")


def asked_phase(obj, x, spacings):
    """Phase that grows across stripes along Y, from the left side on: the integral of 2 pi / spacing."""
    values, first = np.unique(np.round(x, 6), return_index=True)
    rates = 2 * np.pi / spacings[first]
    grown = np.append(0, np.cumsum(np.diff(values) * (rates[1:] + rates[:-1]) / 2))
    return np.interp(x, values, grown)


@pytest.mark.parametrize("way, kind", [("api", "group"), ("operator", "group"), ("command line", "attribute")])
def test_stripes_are_twice_as_wide_on_one_side(way, kind):
    obj = grid(40)
    x = places(obj)[:, 0]
    right = x > 1e-6
    if kind == "group":
        add_group(obj, "wide", np.flatnonzero(right))
    else:
        set_numbers(obj, "wide", np.where(right, 2.0, 1.0))
    solve(way, obj, "stripes", guidance="axis:Y", symmetry="vector", spacing=0.25, spacing_map="wide")
    expected = asked_phase(obj, x, np.where(right, 0.5, 0.25))
    phase = attribute(obj, "synch_vertex_phase").astype(float)
    # The phase grows to the left of stripes along Y: against X.
    turned = np.exp(1j * (phase + expected))
    assert np.abs(turned - turned[0]).max() < 2e-3
    row = np.abs(places(obj)[:, 1]) < 1e-6
    pattern = attribute(obj, "synch_pattern")[row][np.argsort(x[row])]
    crossings = np.flatnonzero(np.diff(np.sign(pattern)))
    assert np.count_nonzero(crossings < 20) == 8 and np.count_nonzero(crossings >= 20) == 4
    assert not attribute(obj, "synch_index").any()


def test_weights_between_give_spacings_between_and_the_range_says_how_far():
    obj = grid(30)
    x = places(obj)[:, 0]
    add_weights(obj, "ramp", (x + 1) / 2)
    api.stripes(obj, guidance="axis:Y", symmetry="vector", spacing=0.6, spacing_map="ramp", spacing_range=0.4)
    turned = np.exp(1j * (attribute(obj, "synch_vertex_phase") + asked_phase(obj, x, 0.6 * 0.4 ** ((x + 1) / 2))))
    assert np.abs(turned - turned[0]).max() < 2e-3


def test_automatic_spacing_is_the_maps_factor_one():
    obj = grid(30)
    plain = api.stripes(obj, guidance="axis:Y")["settings"]["spacing"]
    set_numbers(obj, "wide", np.full(len(obj.data.vertices), 3.0))
    report = api.stripes(obj, guidance="axis:Y", symmetry="vector", spacing_map="wide")
    assert report["settings"]["spacing"] == plain and report["settings"]["spacing_map"] == "wide"
    turned = np.exp(1j * (attribute(obj, "synch_vertex_phase") + 2 * np.pi / (3 * plain) * places(obj)[:, 0]))
    assert np.abs(turned - turned[0]).max() < 2e-3


def test_spacing_maps_do_not_count_for_directions():
    obj = grid()
    api.directions(obj, spacing_map="absent")
    assert "synch_direction" in obj.data.attributes


def test_spacing_maps_that_are_of_no_use_are_refused(capfd):
    obj = grid()
    factors = np.ones(len(obj.data.vertices))
    factors[[3, 5]] = 0, -1
    set_numbers(obj, "map", factors)
    obj.data.attributes.new("of faces", "FLOAT", "FACE")  # which cannot be chosen
    before = snapshot()
    for settings, message in (
        ({"spacing_map": "map"}, "'map' of Grid is of no use at vertices 3, 5: give a positive factor on the spacing"),
        ({"spacing_map": "absent"}, "has no attribute 'absent': choose a float attribute (it has map)"),
        ({"spacing_map": "map", "spacing_range": 0.0}, "the spacing range is 0.0: give a number from 0.001 on"),
        ({"spacing_range": "wide"}, "the spacing range is 'wide': give a number"),
    ):
        with pytest.raises(SynchError) as refused:
            api.stripes(obj, **settings)
        assert message in str(refused.value)
    assert main.main(["stripes", "--quiet", "--spacing-range", "3"], loaded=True) == 1
    assert "the spacing range belongs to a spacing map: add --spacing-map NAME" in capfd.readouterr().err
    assert snapshot() == before


def test_spokes_ask_for_as_many_dislocations_as_the_rims_differ_in_stripes(capfd):
    obj = ring(np.linspace(0.4, 1.0, 18), 90)
    set_vectors(obj, "spokes", places(obj))
    for spacing in (0.15, 0.3):
        report = api.stripes(obj, guidance="attribute:spokes", spacing=spacing)
        assert report["forced_dislocations"] == pytest.approx(2 * np.pi * 0.6 / spacing, rel=0.01)
    # As wide in turns as in length: nothing is left to ask for.
    set_numbers(obj, "wider", np.linalg.norm(places(obj), axis=1))
    report = api.stripes(obj, guidance="attribute:spokes", spacing=2 * np.pi / 40, spacing_map="wider")
    assert report["forced_dislocations"] < 0.1 * 2 * np.pi * 0.6 / (2 * np.pi / 40) and report["dislocations"] == []
    assert api.stripes(obj, guidance="attribute:spokes", angle=np.pi / 2, spacing=0.15)["forced_dislocations"] < 1
    assert api.directions(obj)["forced_dislocations"] is None
    capfd.readouterr()
    assert main.main(["stripes", "--quiet", "--guidance=attribute:spokes", "--spacing=0.3"], loaded=True) == 0
    assert "(exact directions and spacing ask for 13)" in capfd.readouterr().out


@pytest.mark.parametrize("symmetry", ["vector", "line"])
@pytest.mark.parametrize("build", [sphere, tube])
def test_phases_are_read_back(build, symmetry):
    obj = build()
    api.stripes(obj, spacing=0.5, seed=3, symmetry=symmetry)
    first = attribute(obj, "synch_vertex_phase").astype(float)
    np.testing.assert_allclose(np.cos(first), attribute(obj, "synch_pattern"), atol=1e-6)
    set_numbers(obj, "kept", first + 0.3)
    for name, shift in (("synch_vertex_phase", 0.0), ("kept", 0.3)):
        row = {"where": "attribute", "what": "phase", "name": name}
        guidance = "attribute:synch_direction"
        api.stripes(obj, spacing=0.5, guidance=guidance, symmetry=symmetry, constraints=[row])
        found = attribute(obj, "synch_vertex_phase").astype(float)
        np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * (first + shift)), atol=1e-5)
