# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that solves for a window: the window lives on beside it, and whatever happens to either is mended."""

import os
import signal
import time

import pytest

from .blender import PATIENCE
from .test_window import stripes_are_seen

# Inside: the longest time between two calls of a timer that asks to be called every hundredth of a second, apart
# from it that in which a first picture was drawn; and the sidebar drawn again as often as a progress bar may be.
WATCH = """
import time
class Watch:
    last, longest, at_picture, redraw = time.monotonic(), 0.0, None, False
def tick():
    now, work = time.monotonic(), part('jobs.queue').queue.running
    gap, Watch.last = now - Watch.last, now
    if work is not None and work.picture is not None and (Watch.at_picture is None or now < Watch.pictured + 1):
        Watch.pictured = now if Watch.at_picture is None else Watch.pictured
        Watch.at_picture = max(Watch.at_picture or 0.0, gap)
    else:
        Watch.longest = max(Watch.longest, gap)
    if Watch.redraw:
        next(r for r in area().regions if r.type == 'UI').tag_redraw()
    return 0.01
bpy.app.timers.register(tick, persistent=True)
"""
QUEUE = "part('jobs.queue').queue"
RUNNING = f"{QUEUE}.running"


def add_ball(blender, subdivisions, undo=True):
    blender.run(f"bpy.ops.mesh.primitive_ico_sphere_add(subdivisions={subdivisions}, radius=2)")
    if undo:
        blender.run("bpy.ops.ed.undo_push(message='ball')")


def begin(panel, reached="fraction > 0"):
    """Click on Stripes and wait until the solve is so far; returns the child's process number."""
    panel.click("Stripes")
    panel.until(f"{RUNNING} is not None or active().synch.result")
    number = panel.value(f"{QUEUE}._worker.number")
    panel.until(f"{RUNNING} is None or {RUNNING}.{reached}")
    return number


def over_view(panel):
    x, y, width, height = panel.region("WINDOW")
    panel.move((x + 0.3 * width, y + height / 2))


def is_alive(number):
    """Whether a process is there, and not only its entry."""
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def ends(number, seconds=1.0):
    """Whether a process ends within a time."""
    end = time.monotonic() + seconds
    while is_alive(number) and time.monotonic() < end:
        time.sleep(0.01)
    return not is_alive(number)


def solves_again(panel):
    panel.press("ESC")  # what Blender shows of an error goes
    over_view(panel)
    add_ball(panel, 3)
    panel.click("Stripes")
    panel.until(f"{RUNNING} is None and active().synch.result")


@pytest.mark.slow
def test_a_large_solve_does_not_hold_the_window_up(panel):
    """The bar is drawn, which alone takes its time without a graphics card; so it is in the window that waits, too."""
    panel.run("bpy.ops.mesh.primitive_grid_add(x_subdivisions=450, y_subdivisions=450, size=4)")  # 203,401 vertices
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.05")
    panel.run(WATCH)
    panel.run("Watch.redraw = True")
    time.sleep(5)
    panel.run("Watch.longest = 0.0")
    time.sleep(60)
    idle = panel.value("Watch.longest")
    panel.run("Watch.redraw = False")
    begin(panel, "fraction > 0.01")
    panel.run("Watch.longest = 0.0")
    end = time.monotonic() + 60
    while time.monotonic() < end and panel.value(f"{RUNNING} is not None and {RUNNING}.fraction < 0.8"):
        time.sleep(1)
    solving, pictured = panel.value("Watch.longest, Watch.at_picture")
    print(f"longest gap idle {1000 * idle:.0f} ms, solving {1000 * solving:.0f} ms, at the picture {pictured} s")
    assert panel.value(f"{RUNNING} is not None"), "the solve was over too soon to tell"
    over_view(panel)
    panel.press("ESC")
    panel.until(f"{RUNNING} is None")
    assert solving <= idle + 0.05 and pictured < 1


@pytest.mark.parametrize(
    "reached",
    [
        "stage == ''",
        "fraction > 0.1",
        "stage.startswith('relaxation')",
        "stage.startswith('continuation')",
        "fraction > 0.85",
    ],
)
def test_escape_is_answered_at_once_in_every_stage(panel, reached):
    add_ball(panel, 7)
    before = panel.value("state()")
    panel.run("time_cancelling()")
    number = begin(panel, reached)
    over_view(panel)
    assert panel.value(f"{RUNNING} is not None"), "the solve was over too soon to be cancelled"
    panel.press("ESC")
    panel.until(f"{RUNNING} is None")
    (seconds,) = panel.value("seconds")
    assert seconds < 0.2 and panel.value("state()") == before and ends(number)


def test_all_else_goes_on_during_a_solve(panel):
    add_ball(panel, 7)
    panel.run("ball = active().name; bpy.ops.mesh.primitive_cube_add(location=(5, 0, 0)); cube = active().name")
    panel.run("bpy.ops.ed.undo_push(message='cube')")
    panel.run("bpy.context.view_layer.objects.active = bpy.data.objects[ball]")
    begin(panel)
    panel.run("bpy.ops.object.select_all(action='DESELECT'); bpy.data.objects[cube].select_set(True)")
    panel.run("bpy.context.view_layer.objects.active = None")
    assert panel.shows("Cancel")  # whatever is active
    panel.run("bpy.context.view_layer.objects.active = bpy.data.objects[cube]")
    over_view(panel)
    panel.press("X")  # deletes, after a question that Enter answers
    panel.press("RET")
    panel.until("cube not in bpy.data.objects")
    panel.press("Z", ctrl=True)
    panel.until("cube in bpy.data.objects")
    panel.until(f"{RUNNING} is None")
    assert panel.value("bpy.data.objects[ball].synch.result") and panel.value("cube in bpy.data.objects")


def test_undo_during_a_solve_is_safe(panel):
    add_ball(panel, 7)
    panel.run("active().location.x = 1; bpy.ops.ed.undo_push(message='moved')")
    begin(panel)
    over_view(panel)
    panel.press("Z", ctrl=True)
    panel.until("active().location.x == 0")
    panel.until(f"{RUNNING} is None and active().synch.result")
    panel.press("Z", ctrl=True)
    panel.until("not active().synch.result")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_a_child_that_dies_gives_one_line(panel, number):
    add_ball(panel, 6)
    before = panel.value("state()")
    os.kill(begin(panel), number)
    panel.until(f"{RUNNING} is None")
    assert panel.value("state()") == before
    solves_again(panel)


def test_a_memory_limit_gives_one_line(panel):
    panel.run("preferences = bpy.context.preferences.addons['bl_ext.user_default.synch_fields'].preferences")
    panel.run("preferences.memory_limit = 300")
    add_ball(panel, 8)
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.05")
    before = panel.value("state()")
    try:
        panel.click("Stripes")
        panel.until(f"{RUNNING} is None")
        assert panel.value("state()") == before
    finally:
        panel.run("preferences.memory_limit = 0")
    solves_again(panel)


def test_a_child_that_says_nonsense_gives_one_line(panel):
    add_ball(panel, 5)
    before = panel.value("state()")
    panel.run(f"worker = part('jobs.worker'); {QUEUE}.stop(); begin = worker._BEGIN")
    panel.run("worker._BEGIN = 'import os, time\\nos.write(1, os.urandom(1 << 20)); time.sleep(60)'")
    try:
        panel.click("Stripes")
        panel.until(f"{RUNNING} is None")
        assert panel.value("state()") == before
    finally:
        panel.run("worker._BEGIN = begin")
    solves_again(panel)


def test_deleting_the_object_ends_its_job(panel):
    add_ball(panel, 6)
    number = begin(panel)
    panel.run("bpy.data.objects.remove(active())")
    panel.until(f"{RUNNING} is None")
    assert ends(number) and panel.value("len(bpy.data.objects)") == 2  # camera and light
    solves_again(panel)


def test_saving_during_a_solve_saves_what_was(panel):
    add_ball(panel, 7)
    path = str(panel.folder / "meanwhile.blend")
    before = panel.value("state()")
    begin(panel)
    panel.run(f"bpy.ops.wm.save_as_mainfile(filepath={path!r}, copy=True)")
    panel.until(f"{RUNNING} is None and active().synch.result")
    panel.run(f"bpy.ops.wm.open_mainfile(filepath={path!r})")
    panel.until("region('UI')[2] > 1")
    assert panel.value("state()") == before


def test_opening_another_file_ends_job_and_child(panel):
    add_ball(panel, 6)
    number = begin(panel)
    panel.run("bpy.ops.wm.read_homefile()")
    panel.until(f"region('WINDOW')[2] > 1 and {RUNNING} is None")
    assert ends(number) and panel.value("active().name") == "Cube"


def test_disabling_the_extension_ends_job_and_child(panel):
    add_ball(panel, 6)
    number = begin(panel)
    name = "bl_ext.user_default.synch_fields"
    panel.run(f"import addon_utils; addon_utils.disable({name!r})")
    assert ends(number) and panel.value("not hasattr(bpy.types, 'SYNCH_OT_stripes')")
    panel.run(f"addon_utils.enable({name!r})")
    over_view(panel)
    panel.until("not bpy.context.window_manager.windows[0].modal_operators")
    panel.wait_for("Synch Fields")
    solves_again(panel)


@pytest.mark.parametrize("end", ["quit", "kill"])
def test_the_child_goes_with_blender(window_of_its_own, end):
    panel = window_of_its_own
    add_ball(panel, 6)
    panel.open_panel()
    number = begin(panel)
    if end == "kill":
        panel.kill()
    else:
        panel.quit()
    assert ends(number, 1.0 if end == "kill" else PATIENCE)


def test_a_first_result_is_drawn_over_the_object_and_changes_nothing(panel, keep):
    add_ball(panel, 7)
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.4")
    before = panel.value("state()")
    assert not stripes_are_seen(panel.picture("WINDOW"))
    begin(panel)
    panel.until(f"{RUNNING}.picture is not None")
    keep("first", panel.wait_to_see(stripes_are_seen, "WINDOW"))
    assert panel.value(f"{RUNNING} is not None") and panel.value("state()") == before
    assert panel.value("active().visible_get() and active().select_get() and len(bpy.data.objects) == 3")
    over_view(panel)
    panel.press("ESC")
    panel.until(f"{RUNNING} is None")
    assert panel.value("state()") == before


def test_a_result_waits_for_the_end_of_a_transform_in_edit_mode(panel):
    add_ball(panel, 7)
    panel.run("bpy.ops.object.mode_set(mode='EDIT')")
    begin(panel)
    over_view(panel)
    panel.press("G")
    panel.until(f"{RUNNING} is None")
    time.sleep(1)
    assert not panel.value("active().synch.result") and panel.value("active().mode") == "EDIT"
    panel.press("ESC")
    panel.until("active().synch.result")
    assert panel.value("active().mode") == "EDIT"
