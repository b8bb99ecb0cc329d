# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The dots of defects in the view: what they are, a click, a drag, and Esc."""

import numpy as np
import pytest

DOTS = (
    "dots = part('panels.overlay').defect_dots(active())\n"
    "turn = view().view_rotation.to_matrix()\n"
    "answer = [[*pixel(active().matrix_world @ Vector(place)), int(face), (Vector(place) @ turn).z]\n"
    "          for kind, face, place in zip(dots.kinds, dots.faces, dots.places) if kind == {!r}]"
)
FACES = "sorted(e['synch_face'] for e in active().children if e['synch_kind'] == {!r})"
IDLE = "part('jobs.queue').queue.running is None"


@pytest.fixture
def solved(panel):
    """A ball with stripes, seen from above."""
    return ball_with_stripes(panel)


def ball_with_stripes(panel, settings=""):
    """A ball with stripes of some settings, seen from above."""
    panel.run("from mathutils import Vector\nbpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=2)")
    panel.run("bpy.ops.object.shade_smooth(); view().view_rotation = (1, 0, 0, 0); view().view_distance = 7")
    panel.run(f"active().synch.automatic_spacing = False; active().synch.spacing = 0.4; {settings}")
    panel.click("Stripes")
    panel.wait_for("Variation")
    panel.until(IDLE)
    return panel


def front_dot(window, kind, aside=0.0):
    """The dot of a kind that is nearest to the middle of what is seen, farther up than so many pixels: its place in
    the window, and its face."""
    found = np.array([dot for dot in window.run(DOTS.format(kind)) if dot[3] > 0.8])
    middle = window.value("pixel((0, 0, 0))")[1]
    found = found[found[:, 1] > middle + aside] if aside else found
    x, y, width, height = window.region("WINDOW")
    nearest = np.linalg.norm(found[:, :2] - (x + 0.4 * width, y + height / 2), axis=1).argmin()
    return found[nearest, :2], int(found[nearest, 2])


def rest(window, place):
    """Move the mouse away, and to a place."""
    window.move(np.array(place) + (60, 90))
    window.move(place)


def test_a_dot_says_what_it_is_and_a_click_selects_it(solved, keep):
    faces = "[p.index for p in active().data.polygons if p.select]"
    place, face = front_dot(solved, "dislocation")
    rest(solved, place)
    solved.press("LEFTMOUSE")
    solved.until(f"{faces} == [{face}]")
    assert solved.value("active().select_get()")  # the empties are hidden
    solved.click("Empties")
    swirl = solved.says("Swirl point {index}", index="+0.5")
    for kind, words in (("dislocation", "Line end"), ("disclination", swirl)):
        place, face = front_dot(solved, kind)
        rest(solved, place)
        solved.wait_for(words, "WINDOW")
        keep(f"dot_{kind}", solved.picture())
        solved.press("LEFTMOUSE")
        solved.until("len(bpy.context.selected_objects) == 1")
        chosen = solved.value("[(o['synch_kind'], o['synch_face']) for o in bpy.context.selected_objects]")
        assert chosen == [[kind, face]] and solved.value("active().type") == "MESH"


def test_a_line_end_follows_the_mouse_and_esc_puts_it_back(solved, keep):
    place, face = front_dot(solved, "dislocation")
    before = solved.value("state()")
    rest(solved, place)
    solved.hold()
    for step in (10, 20, 30):
        solved.move(place + (step, step))
    solved.until(f"{face} not in {FACES.format('dislocation')}")
    keep("dot_dragged", solved.picture())
    solved.press("ESC")
    solved.release()
    solved.until(f"{face} in {FACES.format('dislocation')}")
    assert solved.value("state()")["attributes"] == before["attributes"]
    solved.drag([place, place + (10, 10), place + (30, 30)])
    solved.until(f"{face} not in {FACES.format('dislocation')}")
    solved.press("Z", ctrl=True)
    solved.until(f"{face} in {FACES.format('dislocation')}")
    assert solved.value("state()")["attributes"] == before["attributes"]


def test_a_swirl_point_is_pinned_where_it_is_let_go_and_the_others_where_they_are(solved, keep):
    place, face = front_dot(solved, "disclination")
    before = solved.value(FACES.format("disclination"))
    rest(solved, place)
    solved.drag([place, place + (15, 0), place + (50, 30)])
    solved.until(f"{IDLE} and {face} not in {FACES.format('disclination')}")
    after = solved.value(FACES.format("disclination"))
    assert len(after) == len(before) and len(set(before) - set(after)) == 1
    pins = dict(pin.split("=") for pin in solved.value("active().synch.pins").split(","))
    assert sorted(map(int, pins)) == after and set(pins.values()) == {"1"}
    keep("dot_pinned", solved.picture())


def test_a_line_end_moves_on_both_sides_of_a_mirror(panel, keep):
    window = ball_with_stripes(panel, "active().synch.mirror = False, True, False")
    place, face = front_dot(window, "dislocation", aside=60)
    before = window.value(FACES.format("dislocation"))
    rest(window, place)
    window.drag([place, place + (10, 10), place + (30, 30)])
    window.until(f"{face} not in {FACES.format('dislocation')}")
    after = window.value(FACES.format("dislocation"))
    assert len(set(before) - set(after)) == len(set(after) - set(before)) == 2
    keep("dot_mirrored", window.picture())
    window.press("Z", ctrl=True)
    window.until(f"{FACES.format('dislocation')} == {before}")


def test_dots_lie_on_the_shape_that_is_shown(solved):
    """Half as wide by a shape key: so are the dots."""
    places = "part('panels.overlay').defect_dots(active()).places"
    wide = np.array(solved.value(f"{places}.tolist()"))
    solved.run("""
active().shape_key_add(name="Basis")
key = active().shape_key_add(name="Narrow")
for point in key.data:
    point.co.x *= 0.5
key.value = 1.0
bpy.context.view_layer.update()
""")
    np.testing.assert_allclose(solved.value(f"{places}.tolist()"), wide * (0.5, 1, 1), atol=1e-4)
