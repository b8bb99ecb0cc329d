# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of animations: how long the frames take, before they are solved and from their beginning."""

import re
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import pytest

from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.frames.job import AnimationJob
from synch_fields.synch_addon.jobs.queue import Work
from synch_fields.synch_addon.panels.frames import SYNCH_PT_animation, span_of
from synch_fields.synch_addon.panels.result import draw_nothing_found

from ...core.expectation import told_at_once
from ..moving_meshes import swaying
from ..scenes import make_active, tube


def about():
    """Seconds that the panel tells, None where it tells none."""
    layout = MagicMock()
    SYNCH_PT_animation.draw(SimpleNamespace(layout=layout), bpy.context)
    texts = [call.kwargs["text"] for call in layout.mock_calls if call[0].endswith("label")]
    found = re.search(r"About (\d+) s", "\n".join(texts))
    return None if found is None else int(found[1])


def test_the_panel_says_what_the_solve_tells(monkeypatch):
    obj = make_active(swaying(tube()))
    stored = obj.synch_animation
    stored.scene_frames, stored.first, stored.last = False, 1, 3
    job = AnimationJob(obj, SurfaceSettings(spacing=0.5), span_of(stored, bpy.context.scene))
    while job.advance() is not None:
        pass
    told = told_at_once(job.request)
    monkeypatch.setattr(Work, "_paces", {"Animate": 20 / told})
    assert about() == 20
    stored.last = 15
    assert about() == pytest.approx(20 * 18 / 6, abs=1)
    stored.last = 0
    assert about() is None


def test_the_result_box_says_that_the_pattern_is_animated():
    obj, layout = make_active(swaying(tube(), 2)), MagicMock()
    draw_nothing_found(layout, obj)
    api.animate(obj, frames=(1, 2), spacing=0.7)
    draw_nothing_found(layout, obj)
    texts = [call.kwargs["text"] for call in layout.label.call_args_list]
    assert texts == ["Not solved yet", "Animated: a new solve replaces it"]
