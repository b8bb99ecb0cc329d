# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user does in the window: solve, watch, cancel, undo, vary, place defects, bake, save and find it all again."""

import json

import pytest

# Seconds within which a job is gone once the window hears that it is cancelled.
SOON = 0.2
# What is blue on the screen as a progress bar is, at least by this much.
_BLUE = 40


def add_ball(blender, subdivisions):
    """A ball of a radius of 2; a coarse one carries its stripes itself, so that they are solved in a moment."""
    blender.run(f"bpy.ops.mesh.primitive_ico_sphere_add(subdivisions={subdivisions}, radius=2)")
    if subdivisions < 5:
        blender.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.8")


def solved(blender):
    """The result of the stripes that the button makes."""
    blender.click("Stripes")
    blender.wait_for("Variation")
    return result(blender)


def without_overlays(names):
    """Code that hides some of the view's overlays, for a picture of the rest."""
    return f"[setattr(area().spaces[0].overlay, f'show_{{name}}', False) for name in {names.split()}]"


def result(blender):
    return json.loads(blender.value("active().synch.result"))


def figures(blender, found):
    """What the box "Details" of "Result" shows of a result, which is opened where it is not yet."""
    blender.scroll_to("Details")
    energy = blender.says("Energy {energy:.4g}", energy=found["energy"])
    if not blender.shows(energy):
        blender.click("Details", last=True)
        blender.scroll_to("Overlay")
    return blender.counts(found["disclinations"], "swirl point"), energy


def bar_length(picture):
    """Pixels of the longest blue run of any line, where a progress bar is."""
    blue = picture[..., 2].astype(int) - picture[..., 0] > _BLUE
    return int(blue.sum(axis=1).max())


def test_panel_opens_by_a_key_and_a_click(panel, keep):
    assert panel.shows("Select a mesh object")
    add_ball(panel, 3)
    for text in ("Stripes", "Kind", "Lines Across", "Direction", "Branching", "Guide", "Pattern", "Not solved yet"):
        panel.wait_for(text)
    keep("panel", panel.picture("UI"))
    for text in ("Look", "Overlay", "Make"):
        panel.scroll_to(text)


def test_stripes_show_progress_and_then_their_result(panel, keep):
    add_ball(panel, 6)
    panel.click("Stripes")
    seen = []
    while panel.value("part('jobs.queue').queue.running is not None"):
        seen.append(panel.picture("UI"))
    panel.wait_for("Variation")
    seen = [
        picture[:160] for picture in seen if any(panel.reads(picture[:160], text) for text in ("Cancel", "Discard"))
    ]
    lengths = {bar_length(picture) for picture in seen}
    assert len(lengths) >= 3, f"the bar was seen at the lengths {sorted(lengths)}"
    keep("progress", max(seen, key=bar_length)[:112, :262])
    found = result(panel)
    for text in figures(panel, found):
        assert panel.shows(text), text
    kinds = panel.value("[child.get('synch_kind') for child in active().children]")
    assert kinds.count("disclination") == found["disclinations"]
    assert kinds.count("dislocation") == found["dislocations"]


def test_cancelled_job_is_gone_soon_and_leaves_everything_as_it_was(panel):
    add_ball(panel, 6)
    before = panel.value("state()")
    panel.run("time_cancelling()")
    for _ in range(3):  # a busy machine may be late
        panel.click("Stripes")
        panel.until("part('jobs.queue').queue.running is not None")
        panel.press("ESC")
        panel.press("ESC")  # the first one keeps what is drawn, if anything is
        panel.wait_for("Stripes")
        assert panel.value("state()") == before
    assert min(panel.value("seconds")) < SOON


def test_button_cancels(panel):
    add_ball(panel, 6)
    before = panel.value("state()")
    panel.click("Stripes")
    panel.run("queue = part('jobs.queue').queue")
    panel.until("queue.running is not None and queue.running.picture is not None")
    panel.click("Discard")
    panel.wait_for("Stripes")
    assert panel.value("state()") == before


def test_new_file_while_a_job_runs_is_safe(panel):
    add_ball(panel, 6)
    panel.click("Stripes")
    panel.until("part('jobs.queue').queue.running is not None")
    panel.run("bpy.ops.wm.read_homefile()")
    panel.until("region('WINDOW')[2] > 1 and part('jobs.queue').queue.running is None")
    assert panel.value("active().name, active().synch.result") == ["Cube", ""]
    panel.open_panel()
    add_ball(panel, 4)
    solved(panel)


def test_a_mesh_that_is_hidden_in_edit_mode_is_worked_on(panel):
    add_ball(panel, 3)
    solved(panel)
    panel.run("bpy.ops.object.mode_set(mode='EDIT'); active().hide_set(True)")
    in_view = "with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area(), "
    in_view += "region=window_region()):\n    bpy.ops.synch."
    panel.run(in_view + "keep_favourite()")
    assert panel.value("[active().mode, len(active().synch.favourites)]") == ["EDIT", 1]
    panel.run(in_view + "paint_map(target='SPACING')")
    assert panel.value("active().mode") == "WEIGHT_PAINT"


def test_undo_and_redo(panel):
    add_ball(panel, 4)
    panel.run("bpy.ops.ed.undo_push(message='ball')")
    before = panel.value("state()")
    solved(panel)
    after = panel.value("state()")
    assert "synch_phase" in after["attributes"] and "synch_phase" not in before["attributes"]
    panel.move((700, 500))
    panel.press("Z", ctrl=True)
    panel.until("not active().synch.result")
    assert panel.value("state()") == before
    panel.press("Z", ctrl=True, shift=True)
    panel.until("active().synch.result")
    assert panel.value("state()") == after


def test_variation_slider_shows_other_patterns_without_a_solve(panel):
    add_ball(panel, 4)
    panel.run("active().synch.seed = 1")
    solved(panel)
    before = panel.value("state()")
    place = panel.wait_for("Variation") + (90, 0)
    panel.move(place)
    panel.hold()
    for step in (10, 20, 30):
        panel.move(place + (step, 0))
    panel.release()
    number = panel.until("active().synch_shown.variation")
    after = panel.value("state()")
    assert after["attributes"]["synch_phase"] != before["attributes"]["synch_phase"]
    assert after["attributes"]["position"] == before["attributes"]["position"]
    assert result(panel)["lower_bound"] == json.loads(before["result"])["lower_bound"] <= result(panel)["energy"]
    for text in figures(panel, result(panel)):
        panel.wait_for(text)
    panel.run("active().synch_shown.variation = 0")
    assert panel.value("state()['attributes']") == before["attributes"]
    assert number > 0


def test_variations_that_are_not_ready_are_searched_for_beside_the_window(panel):
    add_ball(panel, 4)
    solved(panel)
    ready = panel.value("len(part('patterns.memory').solve_of(active()).shown.solution.variations)")
    panel.run("draw, queue = part('operators.variations').SYNCH_OT_draw_variation, part('jobs.queue').queue")
    panel.run("begun, start = [], draw._start")
    panel.run("draw._start = lambda self, context: (begun.append(self.number), start(self, context))[1]")
    before = panel.value("active().synch_shown.variation")
    panel.run(f"active().synch_shown.variation = {ready + 40}; active().synch_shown.variation = {ready + 50}")
    assert panel.value("active().synch_shown.variation") == before  # at once, and the search has not begun
    panel.until(f"queue.running is None and active().synch_shown.variation == {ready + 50}")
    assert panel.value("begun") == [ready + 50]  # only where the slider came to rest
    panel.run("draw._start = start")
    panel.move((700, 500))
    panel.press("Z", ctrl=True)
    panel.until(f"active().synch_shown.variation == {before}")


# Runs inside: a vertex of the mesh that carries the pattern, which the view shows to the right of its middle by about
# x, and whether a dislocation is there.
DEFECTS = """
from mathutils import Vector

def pattern_mesh():
    return part("blender.pattern_surface").surface_of(active()).data

def shown_vertex(x):
    towards = view().view_rotation @ Vector((x, 0.3, 1))
    vertex = max(pattern_mesh().vertices, key=lambda vertex: vertex.co @ towards)
    return vertex.index, pixel(vertex.co)

def has_dislocation(vertex):
    faces = [child["synch_face"] for child in active().children if child.get("synch_kind") == "dislocation"]
    return any(vertex in pattern_mesh().polygons[face].vertices for face in faces)
"""


@pytest.mark.parametrize("end", ["Enter", "Esc"])
def test_defect_is_placed_where_the_mouse_is(panel, end, keep):
    add_ball(panel, 5)
    solved(panel)
    if end == "Enter":  # a click finds the mesh itself under what a modifier makes of it
        panel.run("active().modifiers.new('Finer', 'SUBSURF').levels = 2")
    panel.run("bpy.ops.ed.undo_push(message='solved')")
    before = panel.value("state()")
    panel.run(DEFECTS)
    (vertex, place), (other, there) = panel.value("shown_vertex(-0.4)"), panel.value("shown_vertex(-0.1)")
    assert not panel.value(f"has_dislocation({vertex}) or has_dislocation({other})")
    panel.click("Place Defects")
    panel.move(place)
    panel.hold()
    panel.until(f"has_dislocation({vertex})")
    panel.move(there)
    panel.until(f"has_dislocation({other})")
    panel.release()
    after = panel.value("state()")
    panel.press("RET" if end == "Enter" else "ESC")
    panel.until("not bpy.context.window_manager.windows[0].modal_operators")
    if end == "Enter":
        assert panel.value("state()") == after
        panel.press("Z", ctrl=True)
        panel.until(f"not has_dislocation({other})")
    assert panel.value("state()") == before


LOOP = """
from mathutils import Vector

def shown_edge():
    mesh = active().data
    towards = view().view_rotation @ Vector((-0.3, 0.2, 1))
    middles = [sum((mesh.vertices[v].co for v in edge.vertices), Vector()) / 2 for edge in mesh.edges]
    edge = max(range(len(middles)), key=lambda edge: middles[edge] @ towards)
    return edge, pixel(middles[edge])
"""


@pytest.mark.parametrize("end", ["Enter", "Esc"])
def test_a_click_shows_the_loop_through_an_edge(panel, end, keep):
    panel.run("bpy.ops.mesh.primitive_torus_add(major_radius=2, minor_radius=0.8)")
    panel.run(LOOP)
    panel.wait_for("Stripes")
    panel.scroll_to("Overlay")
    panel.click("Overlay")
    panel.scroll_to("Loop")
    edge, place = panel.value("shown_edge()")
    # The button beside the word: its picture cannot be read.
    panel.run("bpy.context.scene.synch_overlay.show = False")
    before = panel.picture("WINDOW").astype(int)
    panel.move(place)
    panel.run(
        "with bpy.context.temp_override(area=area(), region=window_region()):\n"
        "    bpy.ops.synch.show_loop('INVOKE_DEFAULT')"
    )
    panel.hold()
    panel.until(f"active().synch_loop.edge == {edge}")
    panel.release()

    def is_orange(shown):
        """a loop in orange"""
        orange = (shown[..., 0].astype(int) - shown[..., 2] > 60) & (before[..., 0] - before[..., 2] < 40)
        return orange.sum() > 500

    panel.wait_to_see(is_orange, "WINDOW")
    keep(f"loop_{end}", panel.picture("WINDOW"))
    panel.press("RET" if end == "Enter" else "ESC")
    panel.until("not bpy.context.window_manager.windows[0].modal_operators")
    overlay = panel.value("[bpy.context.scene.synch_overlay.show, active().synch_loop.edge]")
    assert overlay == ([True, edge] if end == "Enter" else [False, -1])


def test_results_are_found_again_after_bake_save_and_load(panel, keep):
    add_ball(panel, 4)
    found = solved(panel)
    panel.run("bake = bpy.context.scene.synch_bake; bake.size = 128; bake.samples = 1; bake.unwrap = True")
    panel.scroll_to("Bake")
    panel.click("Bake")
    panel.scroll_to("Bake", count=2)  # the box and the button at its end
    panel.click("Bake", last=True)
    panel.until("part('jobs.queue').queue.running is None and any(image.size[0] == 128 for image in bpy.data.images)")
    before, images = panel.value("state()"), panel.value("sorted(image.name for image in bpy.data.images)")
    turns = "[c for item in active().data.attributes['synch_disclination'].data for c in item.color]"
    turned = panel.value(turns)
    keep("bake", panel.picture("UI"))
    path = str(panel.folder / "found.blend")
    panel.run(f"bpy.ops.wm.save_as_mainfile(filepath={path!r})")
    panel.run("bpy.ops.wm.read_homefile()")
    panel.run(f"bpy.ops.wm.open_mainfile(filepath={path!r})")
    panel.until("region('UI')[2] > 1")
    assert panel.value("state()") == before
    assert panel.value("sorted(image.name for image in bpy.data.images)") == images
    assert {"synch_phase", "synch_direction", "synch_index"} <= before["attributes"].keys()
    assert "Synch Stripes" in before["materials"] and len(before["children"]) > 0
    panel.scroll_to("Synch Fields", up=True)
    for text in figures(panel, found):
        assert panel.shows(text), text
    panel.scroll_to("Synch Fields", up=True)
    panel.wait_for("Variations are not saved in files")
    keep("opened", panel.picture("UI"))
    panel.click("Find Variations Again")
    panel.until("part('patterns.memory').holds(active())")
    gallery = "part('panels.thumbnails').galleries.of(active())"
    panel.until(f"{gallery}.is_complete and len({gallery}.made) == {gallery}.count > 1")
    after = panel.value("state()")
    assert after["attributes"].keys() == before["attributes"].keys()  # values differ in their last digits
    assert panel.value(turns) == pytest.approx(turned, abs=1e-5)


def stripes_are_seen(picture):
    """Whether a picture has much of both colours that stripes have: a dark blue and a warm white."""
    red, _, blue = (picture[..., channel].astype(int) for channel in range(3))
    dark, light = (blue - red > 8) & (blue < 140), (red - blue > 3) & (red > 90)
    return min(dark.sum(), light.sum()) > 2000


def test_four_clicks_from_suzanne_to_a_striped_render(as_delivered, keep):
    """With nothing but what the panel says: the click list of the README. The last picture is of the monkey alone."""
    blender = as_delivered
    blender.run("bpy.ops.mesh.primitive_monkey_add(); bpy.ops.object.shade_smooth()")
    blender.run("bpy.ops.object.subdivision_set(level=2)")
    blender.run("from mathutils import Euler; view().view_rotation = Euler((1.4, 0, 0.35)).to_quaternion()")
    blender.run("view().view_distance = 4.6")
    assert not stripes_are_seen(blender.picture("WINDOW"))
    blender.open_panel()  # 1: the key N; 2: the tab
    keep("click_2", blender.picture("UI")[:333])
    blender.click("Stripes")  # 3
    blender.wait_for("Variation")
    gallery = "part('panels.thumbnails').galleries.of(active())"
    blender.until(f"len({gallery}.made) == {gallery}.count")
    blender.wait_to_see(lambda picture: True, "UI", still=2)
    last = blender.wait_for("Variation")
    _, y, _, height = blender.region("UI")
    keep("click_3", blender.picture("UI")[: y + height - int(last[1]) + 14])
    blender.click("Preview")  # 4
    blender.until("area().spaces[0].shading.type in ('MATERIAL', 'RENDERED')")
    blender.wait_to_see(stripes_are_seen, "WINDOW", still=5)
    blender.run(without_overlays("overlays") + "; area().spaces[0].show_gizmo = False")
    picture = blender.wait_to_see(stripes_are_seen, "WINDOW", still=2)
    blender.run("area().spaces[0].overlay.show_overlays = area().spaces[0].show_gizmo = True")
    keep("click_4", picture[220:690, 320:])
