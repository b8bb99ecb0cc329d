# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user of Blender expects of any tool: times of long jobs, the redo panel, the search, and plain words."""

import re

from .test_window import add_ball, solved

QUEUE = "part('jobs.queue').queue"


def type_text(window, text):
    """Type into a field that is being edited."""
    for letter in text:
        window.run(f"event({letter.upper()!r}, 'PRESS', 700, 500, unicode={letter!r})")
        window.run(f"event({letter.upper()!r}, 'RELEASE', 700, 500)")


def test_a_job_tells_from_the_beginning_how_long_it_takes(panel, keep):
    add_ball(panel, 7)
    panel.run("active().synch_simple.kind = 'quad_mesh'; active().synch.faces = 1000; area().tag_redraw()")
    panel.click("Quad Mesh")
    panel.until(f"{QUEUE}.running.expected is not None")
    fraction, line = panel.value(f"[{QUEUE}.running.fraction, {QUEUE}.running.short_line]")
    assert fraction < 0.15
    assert panel.says("about {left} left", left=re.search(r"\d+ (s|min)", line)[0]) in line
    panel.until(f"{QUEUE}.running.stage != ''")
    while not panel.shows(panel.value(f"{QUEUE}.running.short_line")):
        pass
    keep("time_left", panel.picture("UI"))
    panel.click("Cancel" if panel.shows("Cancel") else "Discard")
    panel.until(f"{QUEUE}.running is None")


def test_the_redo_panel_shows_what_one_changes(panel, keep):
    add_ball(panel, 4)
    solved(panel)
    panel.move((600, 500))
    panel.press("F9")
    for text in ("Spacing", "Branching", "Guidance", "Symmetry", "Singularities"):
        panel.wait_for(text, "WINDOW")
    keep("redo", panel.picture())
    panel.press("ESC")


def test_the_redo_panel_shows_what_follows_an_automatic_count(panel, keep):
    add_ball(panel, 3)
    panel.run("active().synch_simple.kind = 'quad_mesh'; area().tag_redraw()")
    panel.click("Quad Mesh")
    panel.until("active().synch.source is not None")
    panel.move((600, 500))
    panel.press("F9")
    for text in ("Face Count", "Spacing", "Guidance", "Singularities", "Smoothing"):
        panel.wait_for(text, "WINDOW")
    keep("redo_quad_mesh", panel.picture())
    panel.press("ESC")


def test_the_search_finds_what_can_be_done_and_not_the_collection(panel, keep):
    add_ball(panel, 4)
    solved(panel)
    panel.move((500, 500))
    panel.press("F3")
    type_text(panel, "syn")
    panel.wait_for("Synch Fields", "WINDOW")
    picture = panel.picture()
    keep("search", picture)
    assert not panel.reads(picture[:, :900], "Synch Defects")
    panel.press("ESC")
    panel.press("ESC")


def test_a_curve_is_told_what_it_is_for(panel, keep):
    panel.run("bpy.ops.curve.primitive_bezier_circle_add(radius=1)")
    panel.wait_for("Vortices: under Make")
    keep("curve", panel.picture("UI"))


def test_the_button_says_when_the_pattern_is_of_other_settings(panel):
    add_ball(panel, 4)
    solved(panel)
    update = panel.says("Update {what}", what=panel.says("Stripes"))
    assert not panel.shows(update)
    panel.run("active().synch.spacing = 0.6; area().tag_redraw()")
    panel.click(update)
    panel.until(f"{QUEUE}.running is None and abs(active().synch.spacing - 0.6) < 1e-4")
    panel.wait_for("Stripes")
    panel.until("not part('patterns.other_settings').shows_other_settings(active(), 'stripes')")
