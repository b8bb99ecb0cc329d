# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Everyday actions at random in a real window, for SYNCH_SOAK minutes: Blender prints no error meanwhile."""

import os
import random
import re
import time

import pytest

MINUTES, SEED = float(os.environ.get("SYNCH_SOAK", 2)), int(os.environ.get("SYNCH_SEED", 0))
# Runs inside: each action is a function without arguments. What an operator refuses is an answer, not an error.
ACTIONS = """
import math, random

def over_view(operator, **settings):
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=area(), region=window_region()):
        try:
            operator("INVOKE_DEFAULT", True, **settings)  # with its undo step: Blender crashes where modes lack theirs
        except RuntimeError as refusal:
            if "Traceback" in str(refusal):
                raise

def meshes():
    return [obj for obj in bpy.context.view_layer.objects if obj.type == "MESH" and obj.visible_get()]

def add():
    if bpy.context.mode == "OBJECT":
        place = [random.uniform(-4, 4) for _ in range(3)]
        mesh = bpy.ops.mesh
        kind = random.choice([mesh.primitive_ico_sphere_add, mesh.primitive_torus_add, mesh.primitive_uv_sphere_add,
                              mesh.primitive_monkey_add, mesh.primitive_cube_add, mesh.primitive_grid_add])
        more = {"subdivisions": random.randint(2, 5)} if kind == mesh.primitive_ico_sphere_add else {}
        over_view(kind, location=place, **more)

def choose():
    if meshes() and bpy.context.mode == "OBJECT":
        bpy.context.view_layer.objects.active = random.choice(meshes())
        for obj in meshes():
            obj.select_set(obj == active() or random.random() < 0.2)

def solve():
    over_view(getattr(bpy.ops.synch, random.choice(["stripes", "stripes", "quads", "directions", "quad_mesh"])))

def settings():
    if active() and active().type == "MESH":
        synch = active().synch
        synch.automatic_spacing = random.random() < 0.5
        synch.spacing, synch.angle = random.uniform(0.15, 1), random.uniform(-1, 1)
        synch.seed = random.randint(0, 5)

def vary():
    if active() and active().type == "MESH":
        active().synch_shown.variation = random.randint(0, 8)

def favour():
    over_view(random.choice([bpy.ops.synch.keep_favourite, bpy.ops.synch.show_favourite]))

def live():
    manager = bpy.context.window_manager
    manager.synch_live = not manager.synch_live

def drag():
    if active() and active().type == "MESH":
        for step in range(8):
            active().synch.angle += 0.02
            bpy.context.view_layer.update()

def cancel():
    over_view(bpy.ops.synch.cancel)

def delete():
    if bpy.context.mode == "OBJECT" and len(meshes()) > 2:
        over_view(bpy.ops.object.delete, confirm=False)

def duplicate():
    if bpy.context.mode == "OBJECT" and len(meshes()) < 8:
        over_view(bpy.ops.object.duplicate)

def frame():
    bpy.context.scene.frame_set(random.randint(1, 50))

def shade():
    area().spaces[0].shading.type = random.choice(["SOLID", "SOLID", "MATERIAL", "WIREFRAME"])

def preset():
    names = [item.identifier for item in bpy.ops.synch.preset.get_rna_type().properties["preset"].enum_items]
    over_view(bpy.ops.synch.preset, preset=random.choice(names))

def made():
    operators = bpy.ops.synch
    over_view(random.choice([operators.carry, operators.isolines, operators.relief, operators.number_stripes,
                             operators.trace_quads, operators.refine]))

def change():
    if bpy.context.mode == "OBJECT" and active() and active().type == "MESH" and active().data.vertices:
        random.choice(active().data.vertices).co.x += 0.05
        active().data.update()

def modify():
    if active() and active().type == "MESH":
        if active().modifiers and random.random() < 0.6:
            active().modifiers.remove(active().modifiers[-1])
        else:
            active().modifiers.new("", random.choice(["MIRROR", "SOLIDIFY", "TRIANGULATE", "BEVEL"]))

def edit():
    if active() and active().type == "MESH":
        over_view(bpy.ops.object.mode_set, mode="EDIT" if active().mode == "OBJECT" else "OBJECT")

def language():
    bpy.context.preferences.view.language = random.choice(["en_US", "de_DE", "ja_JP", "fr_FR"])

def panel():
    chosen = part("settings.preferences").preferences()
    chosen.panel = "SIMPLE" if chosen.panel == "ADVANCED" else "ADVANCED"

def hide():
    if active():
        active().hide_set(not active().hide_get())

def record(action):
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=area(), region=window_region()):
        bpy.ops.ed.undo_push(message=action)

def unhide():
    for obj in bpy.context.view_layer.objects:
        obj.hide_set(False)

def new_file():
    bpy.ops.wm.read_homefile()

def save_and_open():
    path = os.path.join(os.environ["SYNCH_UI_FOLDER"], "soak.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
"""
# How often actions are chosen; the others of a user's are keys and the mouse.
WEIGHTS = {
    "add": 5, "choose": 6, "solve": 12, "settings": 6, "vary": 6, "favour": 3, "live": 3, "drag": 6, "cancel": 2,
    "delete": 3, "duplicate": 2, "frame": 4, "shade": 4, "preset": 3, "made": 5, "change": 3, "modify": 3, "edit": 3,
    "language": 2, "panel": 2, "hide": 1, "unhide": 2, "new_file": 0.4, "save_and_open": 0.6, "undo": 8,
    "redo": 4, "orbit": 4, "escape": 2, "scroll": 4, "wait": 6,
}  # fmt: skip
# Those that set properties by a script; in the window each is an undo step. Without it, what they made is gone after an
# undo, and objects that the undo leaves as they are still point to it: Blender crashes.
SET = {"choose", "settings", "vary", "drag", "frame", "change", "modify", "hide", "unhide"}
# Lines that Blender prints when something is wrong, and what it says of refusals that a user reads in the window.
WRONG = re.compile(r"traceback|exception|\w*error\b|rna_ui|not found|failed|assert|segmentation|invalid", re.IGNORECASE)
HARMLESS = re.compile(r"^(Error|Warning|Info): (?!Python)|error console|mounted file-systems|libEGL|^\s*$")


def by_hand(blender, action):
    """What a user does with keys and the mouse."""
    x, y, width, height = blender.region("UI" if action == "scroll" else "WINDOW")
    blender.move((x + width * random.uniform(0.2, 0.7), y + height * random.uniform(0.3, 0.7)))
    match action:
        case "undo":
            blender.press("Z", ctrl=True)
        case "redo":
            blender.press("Z", ctrl=True, shift=True)
        case "orbit":
            blender.press(random.choice(["NUMPAD_4", "NUMPAD_8", "NUMPAD_1", "HOME"]))
        case "escape":
            blender.press("ESC")
        case "scroll":
            blender.press(random.choice(["WHEELDOWNMOUSE", "WHEELUPMOUSE"]))
        case "wait":
            time.sleep(random.uniform(0.5, 3))


def errors(log):
    """Lines of what Blender printed that tell of an error, each with what follows."""
    lines = log.splitlines()
    wrong = [k for k, line in enumerate(lines) if WRONG.search(line) and not HARMLESS.search(line)]
    return ["\n".join(lines[max(k - 3, 0) : k + 12]) for k in wrong]


def check(blender, done):
    found = errors(blender.log.read_text(errors="replace"))
    assert not found, f"after {len(done)} actions, the last ones {done[-12:]}:\n" + "\n\n".join(found)


@pytest.mark.parametrize(
    ("log", "count"),
    [
        ("Blender 5.2.2\nError: the mesh is empty: add some geometry first\nInfo: 3 line ends\n", 0),
        ('Error: Python: Traceback (most recent call last):\n  File "x"\nKeyError: 1\n', 2),
        ("ReferenceError: StructRNA of type Object has been removed\n", 1),
        ("rna_uiItemR: property not found: SynchSettings.spacings\n", 1),
    ],
)
def test_errors_are_told_from_refusals(log, count):
    assert len(errors(log)) == count


def test_an_error_of_a_timer_would_be_found(window_of_its_own):
    window = window_of_its_own
    window.run("bpy.app.timers.register(lambda: 1 / 0)")
    end = time.monotonic() + 60
    while not errors(window.log.read_text(errors="replace")) and time.monotonic() < end:
        time.sleep(0.1)
    assert "ZeroDivisionError" in "".join(errors(window.log.read_text(errors="replace")))


@pytest.mark.slow
def test_no_error_is_printed_while_a_user_works(window_of_its_own):
    blender = window_of_its_own
    blender.open_panel()
    random.seed(SEED)
    blender.run(ACTIONS + f"random.seed({SEED})")
    end, done = time.monotonic() + 60 * MINUTES, []
    while time.monotonic() < end:
        done += random.choices(list(WEIGHTS), list(WEIGHTS.values()))
        if done[-1] in ("undo", "redo", "orbit", "escape", "scroll", "wait"):
            by_hand(blender, done[-1])
        else:
            blender.run(f"{done[-1]}()" + (f"; record({done[-1]!r})" if done[-1] in SET else ""))
        if done[-1] == "new_file":  # whose sidebar is closed
            blender.until("region('WINDOW')[2] > 1")
            blender.open_panel()
        check(blender, done)
    blender.quit()  # it prints the rest then
    check(blender, done)
    print(f"{len(done)} actions in {MINUTES:g} minutes, seed {SEED}")
