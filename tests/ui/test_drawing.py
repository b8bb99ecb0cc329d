# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is painted and drawn on the surface, in a real window: maps and guide strokes."""

import numpy as np
import pytest

from .test_window import add_ball, solved, without_overlays

# Runs inside: what the tests look at.
STROKES = """
import numpy as np
from mathutils import Euler, Vector

view().view_rotation, view().view_distance = Euler((1.3, 0, 0.4)).to_quaternion(), 9

def strokes():
    return part("patterns.guide_strokes").strokes_of(active())

def on_ball(right, up):
    towards = view().view_rotation @ Vector((right, up, 0.0)) * 2
    towards += view().view_rotation @ Vector((0, 0, 1)) * 2 * max(1 - right**2 - up**2, 0) ** 0.5
    return pixel(towards)

def unrest(points):
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() / np.linalg.norm(points[-1] - points[0]) - 1)
"""
COUNT = "len(strokes())"


@pytest.fixture
def ball(panel):
    """A ball in the middle of the view, and the panel."""
    add_ball(panel, 5)
    panel.run(STROKES)
    panel.run("active().synch_simple.direction = 'STROKES'; area().tag_redraw(); bpy.ops.ed.undo_push(message='ball')")
    return panel


def line(blender, *places):
    """Pixels on the ball from one place to the next: each to the right and up, from -1 to 1."""
    ways = np.array(places, float)
    steps = np.linspace(0, len(ways) - 1, 6 * (len(ways) - 1) + 1)
    right, up = (np.interp(steps, np.arange(len(ways)), ways[:, axis]) for axis in (0, 1))
    return [blender.value(f"on_ball({x}, {y})") for x, y in zip(right, up, strict=True)]


def test_strokes_are_drawn_erased_smoothed_and_undone(ball, keep):
    ball.click("Draw Strokes")
    ball.wait_for("Done Drawing")
    way = line(ball, (-0.6, -0.2), (0, 0.25), (0.5, 0.1))
    ball.move(way[0])
    ball.hold()
    for place in way[1:]:
        ball.move(place)
    keep("stroke_on_its_way", ball.picture())
    assert ball.reads(ball.picture(), ball.says("Release the button: done   Esc: as before"))
    assert ball.value(COUNT) == 0  # nothing is there before the button is let go
    ball.release()
    ball.until(f"{COUNT} == 1")
    points = np.array(ball.value("strokes()[0].points.tolist()"))
    assert np.abs(np.linalg.norm(points, axis=1) - 2).max() < 0.03
    seen = [ball.value(f"pixel({point.tolist()})") for point in points]
    np.testing.assert_allclose([seen[0], seen[-1]], [way[0], way[-1]], atol=3)
    assert ball.value("[(row.what, row.soft) for row in active().synch.constraints]") == [["ALONG", False]]

    # Esc leaves no trace, and nothing to undo.
    other = line(ball, (-0.5, -0.5), (0.5, -0.4))
    ball.move(other[0])
    ball.hold()
    for place in other[1:]:
        ball.move(place)
    ball.press("ESC")
    ball.release()
    assert ball.value(COUNT) == 1
    ball.drag(other)
    ball.until(f"{COUNT} == 2")
    keep("strokes_drawn", ball.picture())
    ball.press("Z", ctrl=True)
    ball.until(f"{COUNT} == 1")
    ball.press("Z", ctrl=True, shift=True)
    ball.until(f"{COUNT} == 2")

    # A jagged one is smoothed where the pointer passes.
    jagged = line(ball, (-0.4, 0.55), (-0.3, 0.65), (-0.2, 0.55), (-0.1, 0.65), (0, 0.55), (0.1, 0.65), (0.2, 0.55))
    ball.drag(jagged)
    ball.until(f"{COUNT} == 3")
    before = ball.value("unrest(strokes()[2].points)")
    ball.drag(line(ball, (-0.4, 0.6), (0.2, 0.6)), shift=True)
    ball.until(f"unrest(strokes()[2].points) < 0.5 * {before}")
    keep("strokes_smoothed", ball.picture("WINDOW"))

    # A drag across two of them removes these, as one step.
    ball.drag(line(ball, (0, 0.75), (0, 0.1)), ctrl=True)
    ball.until(f"{COUNT} == 1")
    ball.press("Z", ctrl=True)
    ball.until(f"{COUNT} == 3")
    ball.click("Done Drawing")
    ball.wait_for("Draw Strokes")
    ball.drag(other)
    assert ball.value(COUNT) == 3


def test_strokes_behind_the_surface_are_left_alone(ball):
    ball.click("Draw Strokes")
    ball.wait_for("Done Drawing")
    way = line(ball, (-0.4, 0), (0.4, 0))
    ball.drag(way)
    ball.until(f"{COUNT} == 1")
    ball.run("view().view_rotation = view().view_rotation @ Euler((0, np.pi, 0)).to_quaternion()")
    ball.drag(line(ball, (-0.4, 0), (0.4, 0)), ctrl=True)
    assert ball.value(COUNT) == 1


def test_a_stripe_lies_on_a_stroke_and_follows_it_live(ball, keep):
    ball.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.3")
    ball.click("Draw Strokes")
    ball.click("Line Here")
    ball.drag(line(ball, (-0.6, -0.3), (0, 0.2), (0.6, -0.1)))
    ball.until(f"{COUNT} == 1")
    assert ball.value("active().synch.constraints[0].what") == "PHASE"
    solved(ball)
    keep("stripe_on_stroke", ball.picture())
    directions = ball.value("state()['attributes']['synch_direction']")
    ball.scroll_to("Live", up=True)
    ball.click("Live")
    ball.drag(line(ball, (-0.3, 0.6), (0.3, 0.5)))
    ball.until(f"state()['attributes']['synch_direction'] != {directions!r}")
    ball.until("part('patterns.live').live._work is None")
    keep("stroke_live", ball.picture())
    ball.run("bpy.ops.object.shade_smooth(); view().view_distance = 7.1")
    ball.run(without_overlays("floor axis_x axis_y cursor extras outline_selected relationship_lines object_origins"))
    ball.run("area().spaces[0].show_gizmo = False")
    x, y, _, height = ball.region("WINDOW")
    middle, across = np.array(ball.value("pixel((0, 0, 0))")), 270
    left, row = middle[0] - x, y + height - middle[1]
    picture = ball.wait_to_see(lambda picture: True, "WINDOW", still=2)
    keep("strokes", picture[int(row) - across : int(row) + across, int(left) - across : int(left) + across])
    ball.run("bpy.context.window_manager.synch_live = False")


def test_strokes_and_maps_on_a_quad_mesh_are_those_of_its_source(ball, keep):
    ball.run("active().synch_simple.kind = 'quad_mesh'; active().synch.faces = 300; area().tag_redraw()")
    ball.click("Quad Mesh")
    ball.until("active().synch.source is not None")
    update = ball.says("Update {what}", what=ball.says("Quad Mesh"))
    assert not ball.shows(update)
    ball.click("Draw Strokes")
    ball.wait_for("Done Drawing")
    ball.drag(line(ball, (-0.6, -0.2), (0, 0.25), (0.5, 0.1)))
    ball.until("len(part('patterns.guide_strokes').strokes_of(active().synch.source)) == 1")
    keep("stroke_on_quads", ball.picture())
    ball.click("Done Drawing")
    ball.wait_for(update)
    ball.press("Z", ctrl=True)
    ball.until("len(part('patterns.guide_strokes').strokes_of(active().synch.source)) == 0")
    before = ball.value("active().data.session_uid")
    ball.click("Paint Density")
    ball.wait_for("Done Painting")
    ball.drag(line(ball, (-0.5, 0), (0.5, 0.1)))
    keep("painting_on_quads", ball.picture())
    ball.click(update)
    ball.until("'Spacing' in active().synch.source.vertex_groups")
    ball.until(f"active().mode == 'OBJECT' and active().data.session_uid != {before}")
    ball.wait_for("Density")
    keep("painted_on_quads", ball.picture())


def test_panels_are_not_cut_off(ball, keep):
    ball.click("Draw Strokes")
    ball.wait_for("Line Here")
    keep("drawing_panel", ball.picture("UI"))
    ball.run("bpy.ops.synch.paint_map(target='SPACING')")
    ball.wait_for("Done Painting")
    keep("painting_panel", ball.picture("UI"))


def test_a_map_is_painted_and_solved(ball, keep):
    ball.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.4")
    ball.click("Pattern")
    ball.scroll_to("Spacing Map")
    keep("paint_button", ball.picture("UI"))
    y = ball.wait_for("Spacing Map")[1]
    left, _, width, _ = ball.region("UI")
    ball.click((left + width - 45, y))
    ball.until("bpy.context.mode == 'PAINT_WEIGHT'")
    ball.run("active().synch.spacing_range = 0.5; bpy.context.window_manager.synch_brush.factor = 0.5")
    ball.scroll_to("Done Painting", up=True)
    ball.wait_for(ball.says("Paints {factor:.2f} × spacing", factor=0.5) + " = 0.2 m")
    ball.drag(line(ball, (-0.5, 0), (0.5, 0.1)))
    ball.drag(line(ball, (-0.5, 0.2), (0.5, 0.3)))
    keep("painting", ball.picture())
    weights = np.array(ball.value("[vertex.groups[0].weight for vertex in active().data.vertices]"))
    assert weights.max() > 0.9 and 0.02 < (weights > 0.5).mean() < 0.4
    ball.click("Done Painting")
    ball.until("bpy.context.mode == 'OBJECT'")
    ball.click("Stripes")
    ball.wait_for("Variation")
    assert ball.value("active().synch.spacing_map") == "Spacing"
    keep("painted", ball.picture())
