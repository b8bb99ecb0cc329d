# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Thumbnails of variations: which there are, what they tell, and that a step makes one."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.panels.thumbnails import FRONT, MOST, PIXELS, Gallery, _are_alike, galleries
from synch_fields.synch_addon.patterns import memory

from ..scenes import sphere, torus

pytestmark = pytest.mark.full_search

SOLVES = {
    "stripes": lambda obj: api.stripes(obj, spacing=0.3),
    "quads": lambda obj: api.quads(obj, spacing=0.3),
}


@pytest.mark.parametrize("command", SOLVES)
def test_they_tell_what_the_variations_have(command):
    obj = torus()
    SOLVES[command](obj)
    gallery = galleries.of(obj)
    assert gallery.made == [] and 2 <= gallery.count <= MOST
    steps = 1
    while gallery.make_next():
        steps += 1
    found = memory.solve_of(obj).pattern.solution.variations
    assert steps == 1 + (len(found) if len(gallery.made) < MOST else gallery._tried)  # what is seen, and each one
    best = api.vary(obj, 0)["energy"]
    for variation in gallery.made:
        report = api.vary(obj, variation.number)
        assert variation.energy == pytest.approx(report["energy"])
        assert variation.more == pytest.approx(report["energy"] / best - 1, abs=1e-9)
        assert variation.defects == len(report["dislocations"])
    energies = [variation.energy for variation in gallery.made]
    assert energies == sorted(energies)
    pictures = np.array([variation.picture for variation in gallery.made])
    assert len(np.unique(pictures.reshape(len(pictures), -1), axis=0)) == len(pictures)
    assert galleries.of(obj) is gallery  # what is shown changed, not the solve


def test_variations_that_look_alike_are_one():
    """A field whose line ends lie within half a spacing of those of a better one is not shown again."""
    ends = {1: np.array([[0.0, 0, 0], [5, 0, 0]]), -1: np.array([[0.0, 3, 0]])}
    moved = {sign: places + 0.1 for sign, places in ends.items()}
    assert _are_alike(ends, moved, 0.4) and not _are_alike(ends, moved, 0.1)
    assert not _are_alike(ends, {1: ends[1], -1: np.empty((0, 3))}, 10.0)
    obj = torus()
    api.stripes(obj, spacing=0.3)
    shown = galleries.of(obj).shown
    every, alike = Gallery(shown, -1.0), Gallery(shown, 100.0)
    for one in (every, alike):
        while one.make_next():
            pass
    assert len(alike.made) < len(every.made) == MOST


def test_pictures_are_made_again_as_a_turned_view_sees_the_object():
    """From behind a torus that is half as wide there, its outline is the mirror image of that from the front."""
    obj = torus()
    obj.scale.x = 2.0
    for vertex in obj.data.vertices:
        vertex.co.z *= 1.0 if vertex.co.x > 0 else 0.5
    bpy.context.view_layer.update()
    api.stripes(obj, spacing=0.3)
    views = {"front": FRONT, "behind": FRONT * [[-1], [1], [-1]]}
    seen = {}
    for side, view in views.items():
        gallery = galleries.of(obj, view @ np.array(obj.matrix_world.to_3x3()))
        assert not gallery.is_complete
        while gallery.make_next():
            pass
        assert galleries.of(obj, view @ np.array(obj.matrix_world.to_3x3())).is_complete  # it has not turned since
        seen[side] = np.array([variation.picture[..., 3] > 0 for variation in gallery.made])
    wide = np.flatnonzero(seen["front"][0].any(axis=1))
    assert len(wide) < PIXELS / 2 < seen["front"][0].any(axis=0).sum()  # wider than high, as it is scaled
    assert (seen["behind"][:, :, ::-1] != seen["front"]).mean() < 0.01 < (seen["behind"] != seen["front"]).mean()


def test_there_is_a_gallery_for_each_solve_and_none_without_variations():
    obj = sphere()
    api.stripes(obj, spacing=0.3)
    first = galleries.of(obj)
    api.stripes(obj, spacing=0.4)
    assert galleries.of(obj) is not first
    for solve in (lambda: api.stripes(obj, spacing=0.4, method="spectral"), lambda: api.directions(obj)):
        solve()
        assert memory.holds(obj) and galleries.of(obj) is None


def test_icons_that_are_being_drawn_stay_where_others_make_room():
    obj = torus()
    api.stripes(obj, spacing=0.3)
    gallery = galleries.of(obj)
    while gallery.make_next():
        pass
    kept = len(galleries._icons)
    for number in range(memory.MOST * MOST - kept - 1):  # of objects that nothing is kept of
        name = f"0 {number}"
        galleries._pictured[name] = galleries._icons.new(name)
    for variation in gallery.made:
        galleries.icon(obj, variation)
    assert gallery.count >= 2 and len(galleries._icons) < memory.MOST * MOST
    assert {f"{obj.session_uid} {variation.number}" for variation in gallery.made} <= galleries._icons.keys()
