# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels say of settings whose 0 is no number like others."""

import re
from types import SimpleNamespace

import bpy
import pytest

from synch_fields.core.settings.bake import BakeSettings
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.settings.layers import LayerSettings
from synch_fields.core.settings.lines import LineSettings
from synch_fields.core.settings.setting import records
from synch_fields.core.settings.solver import SolverSettings
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.panels.setting_rows import draw_setting, draw_settings

from ..scenes import sphere

KINDS = SurfaceSettings, LayerSettings, FlowSettings, LineSettings, BakeSettings, SolverSettings


class Layout:
    """Notes what is drawn, in place of Blender's layout."""

    def __init__(self, drawn=None):
        self.drawn = [] if drawn is None else drawn

    def split(self, **_):
        return Layout(self.drawn)

    column = row = split

    def prop(self, _owner, name, **_more):
        self.drawn.append(name)

    def label(self, text, **_more):
        self.drawn.append(f"says {text}")


@pytest.mark.parametrize("kind", KINDS)
def test_each_0_with_a_meaning_of_its_own_has_a_word(kind):
    for name, record in records(kind):
        means_more = re.search(r"\b0 (for|to use|puts|stands)", record.tip)
        assert bool(means_more) == bool(record.zero), name


def test_a_panel_says_what_0_means():
    layers = sphere().synch_layering
    for value, said in ((0.0, ["says Largest Height", "largest_height", "says No limit"]), (0.4, ["largest_height"])):
        layers.largest_height, layout = value, Layout()
        draw_settings(layout, layers, LayerSettings, "layers", {})
        start = layout.drawn.index(said[0])
        assert layout.drawn[start : start + len(said)] == said
        assert ("says No limit" in layout.drawn[start:]) == (value == 0)


def test_a_number_that_is_only_small_has_none():
    obj = sphere()
    obj.synch.smoothing, layout = 0, Layout()
    draw_setting(layout, obj.synch, "smoothing", dict(records(SurfaceSettings))["smoothing"].zero)
    assert layout.drawn == ["smoothing"]


def test_an_operator_says_it_too():
    """Its settings are in its ``properties``, and not among those that all operators have."""
    kind = bpy.ops.synch.layer_toolpaths.get_rna_type()
    operator = SimpleNamespace(bl_rna=bpy.types.Operator.bl_rna, properties=SimpleNamespace(bl_rna=kind), step=0.0)
    draw_setting(layout := Layout(), operator, "step", "As layers")
    assert layout.drawn == ["says Step", "step", "says As layers"]
