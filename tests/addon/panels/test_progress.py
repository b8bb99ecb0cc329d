# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of a job is shown once: where the button is that began it."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import pytest

from synch_fields.synch_addon.blender.objects import ObjectLink
from synch_fields.synch_addon.jobs.queue import Work, queue
from synch_fields.synch_addon.panels import bakes, frames, jobs, layers, progress, sidebar, vortices

from ..scenes import sphere

BOXES = {
    "Animate": frames.SYNCH_PT_animation,
    "Bake": bakes.SYNCH_PT_bake,
    "Layers": layers.SYNCH_PT_layers,
    "Vortices": vortices.SYNCH_PT_vortices,
}


@pytest.mark.parametrize("is_simple", [False, True])
@pytest.mark.parametrize("label", ["Stripes", *BOXES])
def test_progress_is_shown_once(label, is_simple, monkeypatch):
    obj = sphere()
    link = None if label == "Vortices" else ObjectLink.to(obj)
    monkeypatch.setattr(progress, "is_simple", lambda: is_simple)
    work = Work(SimpleNamespace(link=link), label)
    work.begin()
    monkeypatch.setattr(queue, "works", [work])
    panels = {"top": sidebar.SYNCH_PT_fields, "jobs": jobs.SYNCH_PT_jobs} | ({} if is_simple else BOXES)
    shown = []
    for name, panel in panels.items():
        layout = MagicMock()
        if name != "jobs" or panel.poll(bpy.context):
            panel.draw(SimpleNamespace(layout=layout), bpy.context)
        shown += [name for call in layout.mock_calls if call[0].endswith("progress")]
    elsewhere = "jobs" if link is None else "top"
    assert shown == [label if label in BOXES and not is_simple else elsewhere]
