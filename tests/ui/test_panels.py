# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels at their default width: all of them open in a picture, nothing cut off, nothing that moves while a job
runs."""

import time

import numpy as np
import pytest

from .conftest import SPEAK, _installed
from .test_window import add_ball

# Shows all panels open, as a click on the title of each would.
_OPEN = """
for name in [name for name in dir(bpy.types) if name.startswith("SYNCH_PT_")]:
    kind = getattr(bpy.types, name)
    if hasattr(kind, "bl_options") and name != "SYNCH_PT_presets":
        kind.bl_options = kind.bl_options - {"DEFAULT_CLOSED"}
names = part("panels")
names.unregister(); names.register()
"""
PANEL = "part('settings.preferences').preferences().panel = {!r}; area().tag_redraw()"


@pytest.fixture(scope="module")
def tall(tmp_path_factory):
    """A window that is high enough for all panels at once."""
    with _installed(tmp_path_factory.mktemp("tall"), (800, 2300)) as blender:
        blender.run("bpy.data.objects.remove(bpy.data.objects['Cube'])")
        blender.run(SPEAK)
        blender.run(_OPEN)
        blender.open_panel()
        add_ball(blender, 3)
        yield blender


def panels(blender):
    """The sidebar as far down as it shows something."""
    blender.move((5, 5))
    blender.run("area().tag_redraw()")
    time.sleep(1)
    picture = blender.picture("UI")
    rows = np.flatnonzero(picture[:, :-40].std(axis=1).max(axis=1) > 6)
    return picture[: rows[-1] + 12]


@pytest.mark.parametrize("kind", ["stripes", "quads", "quad_mesh", "directions"])
def test_all_panels(tall, keep, kind):
    tall.run(f"active().synch_simple.kind = {kind!r}; active().synch.automatic_spacing = True")
    tall.run(PANEL.format("SIMPLE"))
    keep(f"panels_simple_{kind}", panels(tall))
    tall.run(PANEL.format("ADVANCED"))
    tall.wait_for("Singularities")
    keep(f"panels_advanced_{kind}", panels(tall))


def test_nothing_moves_while_a_job_runs(tall, keep):
    tall.run("active().synch_simple.kind = 'stripes'")
    tall.run(PANEL.format("ADVANCED"))
    tall.run("active().synch_simple.lines = 8")
    names = ("Direction", "Singularities", "Pattern")
    before = [tall.wait_for(name)[1] for name in names]
    tall.click("Stripes")
    tall.until("part('jobs.queue').queue.running is not None")
    seen = []
    while tall.value("part('jobs.queue').queue.running is not None"):
        seen.append([tall.wait_for(name)[1] for name in names])
        if tall.value("getattr(part('jobs.queue').queue.running, 'picture', None) is not None"):
            keep("panels_running", tall.picture("UI")[:600])
    tall.until("bool(active().synch.result)")
    after = [tall.wait_for(name)[1] for name in names]
    assert seen and all(np.allclose(places, before) for places in (*seen, after))
    for choice in ("SIMPLE", "ADVANCED"):
        tall.run(PANEL.format(choice))
        tall.wait_for("Variation")
        tall.until("(lambda g: g is not None and len(g.made) == g.count)(part('panels.thumbnails').galleries.of(active()))")
        keep(f"panels_solved_{choice.lower()}", panels(tall))
