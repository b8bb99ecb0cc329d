# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Good enough, and stripes that follow their settings, in a real window."""

import time

import pytest

from .test_window import stripes_are_seen
from .test_worker import RUNNING, add_ball, begin, over_view

LIVE = "part('patterns.live').live"
SHOWN = "part('patterns.memory').state(active())"
ANGLE = f"{SHOWN}.report.settings.angle"


@pytest.mark.parametrize("way", ["Good Enough", "Esc"])
def test_what_is_drawn_can_be_kept(panel, keep, way):
    add_ball(panel, 7)
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.4")
    panel.run("bpy.ops.ed.undo_push(message='ball')")
    begin(panel)
    over_view(panel)
    panel.until(f"{RUNNING}.picture is not None and {RUNNING}.fraction < 0.8")
    panel.wait_for("Good Enough")
    keep("good_enough", panel.picture())
    if way == "Esc":
        over_view(panel)
        panel.press("ESC")
    else:
        panel.click(way)
    panel.until(f"{RUNNING} is None and active().synch.result")
    assert panel.value(f"{SHOWN}.plain['energy'] > 0 and len({SHOWN}.pattern.phases) == 40962")
    assert stripes_are_seen(panel.picture("WINDOW"))
    panel.wait_for("Ended early, before the best")
    assert not panel.shows("The best of this solve")
    keep("ended_early", panel.picture("UI"))
    over_view(panel)
    panel.press("Z", ctrl=True)
    panel.until("not active().synch.result and not active().data.attributes.get('synch_phase')")


def test_stripes_follow_an_angle_that_is_dragged(panel, keep):
    add_ball(panel, 5)
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.4")
    begin(panel)
    panel.until("active().synch.result")
    panel.click("Live")
    assert panel.value("bpy.context.window_manager.synch_live")
    panel.click("Guide")
    panel.scroll_to("Singularities")
    x, y = panel.wait_for("Angle")  # and below it the map's
    panel.move((x + 130, y))
    panel.hold()
    seen = set()
    for step in range(1, 13):
        panel.move((x + 130 + 6 * step, y))
        seen.add(panel.value(ANGLE))
        time.sleep(0.05)
    panel.release()
    assert panel.wait_for("Angle")[1] == y  # the panel has not scrolled under the mouse
    panel.until(f"{LIVE}._work is None and {ANGLE} == active().synch.angle")
    keep("live", panel.picture())
    # It followed on the way, not only in the end.
    assert len(seen) >= 3 and panel.value("active().synch.angle") > 0.01
    assert panel.value(f"{LIVE}.error") == ""
    over_view(panel)
    panel.until(f"{LIVE}._changed is None")  # it has settled on a whole solve
    assert panel.value(f"{LIVE}.error") == "" and panel.value(f"{SHOWN}.plain['certificate']") == "proved"
    panel.scroll_to("Live", up=True)
    panel.click("Live")
    assert not panel.value("bpy.context.window_manager.synch_live")
    panel.scroll_to("Synch Fields", up=True)
    before = panel.value("active().synch.result")
    panel.click("Stripes")
    panel.until(f"{RUNNING} is None and active().synch.result != {before!r}")
    assert panel.value(f"{SHOWN}.plain['certificate']") == "proved"
