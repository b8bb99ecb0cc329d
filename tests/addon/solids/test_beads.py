# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads in Blender: what tubes have, and the slider that shows them as they are printed."""

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.printing.machine import read_machine
from synch_fields.synch_addon import api
from synch_fields.synch_addon.nodes.beads import PRINTED, SLIDER, beads_modifier
from synch_fields.synch_addon.nodes.canvas import set_inputs
from synch_fields.synch_addon.solids import beads as beads_module
from synch_fields.synch_addon.solids.beads import LOOKS
from synch_fields.synch_addon.solids.files import beads_of

from ..solid_objects import attribute, block, placed


def shown_beads(obj):
    """(n, 3) points of the beads that an object shows, in the world, and the numbers of its instances' tubes."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    places, tubes = [], 0
    for one in depsgraph.object_instances:
        if one.is_instance and one.parent.original == obj:
            tubes += 1
        elif one.object.original != obj:
            continue
        data = one.object.data
        co = np.empty((len(data.vertices), 3), np.float32)
        data.vertices.foreach_get("co", co.ravel())
        places.append(co @ np.array(one.matrix_world)[:3, :3].T + np.array(one.matrix_world)[:3, 3])
    return np.concatenate(places), tubes


def test_beads_are_tubes_with_what_they_have():
    obj = block()
    api.layers(obj, spacing=0.25, size=0.12)
    for look in LOOKS:
        api.layer_toolpaths(obj, 0.2, machine="marlin", beads=look)
        beads = beads_of(obj)
        places, _ = shown_beads(beads)
        world = placed(obj)
        assert (places.min(axis=0) > world.min(axis=0) - 0.05).all()
        assert (places.max(axis=0) < world.max(axis=0) + 0.05).all()
        (made,) = bpy.data.collections[beads.name].objects
        assert set(LOOKS) <= {one.name for one in made.data.attributes}
        colors = np.empty(4 * len(made.data.vertices), np.float32)
        made.data.color_attributes.active_color.data.foreach_get("color", colors)
        values = {name: attribute(made, name) for name in LOOKS}
        assert len(np.unique(colors.reshape(-1, 4), axis=0)) == len(np.unique(values[look])) or look != "layer"
        assert set(values["layer"]) == {0, 1, 2, 3}
        # The first layer is printed at the machine's first_feed.
        slow = values["speed"] < 1.01 * read_machine("marlin").first_feed / 60
        assert set(values["layer"][slow]) == {0} and set(values["layer"][~slow]) == {1, 2, 3}
        assert np.abs(values["tilt"]).max() < 1e-3
        np.testing.assert_allclose(np.quantile(values["height"], [0.1, 0.5, 0.9]), 0.25, rtol=0.05)
    with pytest.raises(Exception, match="the beads 'size' are unknown: use one of layer"):
        api.layer_toolpaths(obj, 0.2, beads="size")


def test_a_slider_shows_the_beads_that_are_printed_by_then(monkeypatch):
    """In the order of the program, with one object of tubes being cut and the others as they are."""
    monkeypatch.setattr(beads_module, "_POINTS", 30)
    obj = block()
    obj.location, obj.rotation_euler = (1, 2, 3), (0, 0, 0.5)
    api.layers(obj, spacing=0.25, size=0.12)
    api.layer_toolpaths(obj, 0.2, machine="marlin", beads="layer")
    beads = beads_of(obj)
    tubes = sorted(bpy.data.collections[beads.name].objects, key=lambda one: one.name)
    printed = np.concatenate([attribute(tube, PRINTED) for tube in tubes])
    everything = np.concatenate([placed(tube) for tube in tubes])
    assert len(tubes) > 5 and (np.diff(printed) >= 0).all() and printed[0] < 0.05 and printed[-1] == 1
    for share in (0.0, 0.3, 0.7, 1.0):
        set_inputs(beads_modifier(beads), {SLIDER: share})
        places, whole = shown_beads(beads)
        wanted = everything[printed <= share] @ np.array(obj.matrix_world)[:3, :3].T + np.array(obj.location)
        assert len(places) == len(wanted) and whole >= (len(tubes) - 1) * share - 1.5
        if len(places):
            assert cKDTree(wanted).query(places)[0].max() < 1e-5


def test_beads_that_are_made_again_replace_those_before():
    obj = block()
    api.layers(obj, spacing=0.25, size=0.12)

    def made():
        return sorted(one.name for data in (bpy.data.objects, bpy.data.collections, bpy.data.meshes) for one in data)

    api.layer_toolpaths(obj, 0.2, beads="layer")
    before = made()
    api.layer_toolpaths(obj, 0.2, beads="tilt")
    assert made() == before
    copy = beads_of(obj).copy()
    bpy.context.scene.collection.objects.link(copy)
    points, _ = shown_beads(copy)
    api.layer_toolpaths(obj, 0.2, beads="height")
    np.testing.assert_array_equal(shown_beads(copy)[0], points)
