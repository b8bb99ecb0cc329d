# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The look of a pattern without the shader editor."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.looks.presets import PRESETS
from synch_fields.synch_addon.nodes.materials import pattern_node
from synch_fields.synch_addon.nodes.stripes import INK_BLUE, WARM_IVORY
from synch_fields.synch_addon.panels import look
from synch_fields.synch_addon.panels.pattern_shader import edge

from ..scenes import grid, sphere


class Layout:
    """Notes what is drawn."""

    def __init__(self, drawn):
        self.drawn = drawn

    def column(self, **_):
        return self

    row = column

    def prop(self, owner, name, **_):
        self.drawn.append(owner.name if isinstance(owner, bpy.types.NodeSocket) else name)


def drawn(obj):
    names = []
    look.draw_look(Layout(names), obj)
    return names


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_the_look_is_the_nodes_own(command):
    obj = sphere()
    assert drawn(obj) == [] and look.look_of(obj) == (INK_BLUE, WARM_IVORY, 0.5)
    getattr(api, command)(obj, spacing=0.5)
    assert drawn(obj) == ["Color", "Background", command, "Width", "Softness"]
    node = pattern_node(obj, command)
    setattr(obj.synch_look, command, "CHECKER" if command == "quads" else "ROUNDED")
    assert node.inputs["Profile"].default_value == (1 if command == "quads" else 3)
    node.inputs["Color"].default_value, node.inputs["Width"].default_value = (1, 0.5, 0.25, 1), 0.25
    assert look.look_of(obj) == ((1, 0.5, 0.25, 1), pytest.approx(WARM_IVORY), 0.25)


def test_what_a_preset_leads_to_the_node_is_left_to_it():
    obj = sphere()
    api.preset(obj, "zebra")
    assert "Width" not in drawn(obj) and "Softness" in drawn(obj)
    assert look.look_of(obj)[2] == pytest.approx(0.53)


@pytest.mark.parametrize("name", PRESETS)
def test_the_swatches_of_a_preset_are_its_colours(name, tmp_path):
    """Green lines on red, as Cycles bakes them; before, each look has colours of its own."""
    obj = sphere()
    api.preset(obj, name, spacing=1.0, method="spectral")
    color, background, _ = look.look_of(obj)
    assert color != INK_BLUE and background != pytest.approx(WARM_IVORY)
    sockets = []
    layout = Layout([])
    layout.prop = lambda owner, name, **_: sockets.append(owner)
    look.draw_look(layout, obj)
    for socket, value in zip(sockets, ((0.0, 0.5, 0.0, 1), (0.5, 0.0, 0.0, 1)), strict=False):
        socket.default_value = value
    assert look.look_of(obj)[:2] == ((0.0, 0.5, 0.0, 1), (0.5, 0.0, 0.0, 1))
    report = api.bake(obj, maps="colour", size=64, samples=1, unwrap=True, folder=str(tmp_path))
    (entry,) = report["maps"].values()
    image = bpy.data.images.load(entry["file"])
    red, green, blue = np.array(image.pixels).reshape(-1, 4)[:, :3].T
    assert blue.max() < 0.01 and green.max() > 0.2 and red.max() > 0.05


def test_other_materials_have_no_look():
    obj = grid()
    api.stripes(obj, spacing=0.5)
    obj.data.materials[0] = bpy.data.materials.new("Plain")
    assert drawn(obj) == [] and pattern_node(obj, "stripes") is None


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.8, 1.0])
def test_stripes_and_lines_fill_their_share(share):
    """By counting: of places in a period, and in a cell."""
    phase = (np.arange(4000) + 0.5) / 4000 * 2 * np.pi
    assert (np.cos(phase) > edge(share, False)).mean() == pytest.approx(share, abs=2e-3)
    lines = np.abs(np.sin(phase)) < edge(share, True)
    assert (lines[:, None] | lines).mean() == pytest.approx(share, abs=2e-3)
