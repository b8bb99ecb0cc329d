# SPDX-License-Identifier: GPL-3.0-or-later
"""CPU time in a real Blender window: from a click to the first picture, and of what we draw in each redraw.

``click`` is what reading the mesh takes, ``came`` when the first picture has come from the process that solves, and
``first`` when it has been drawn: meanwhile that process goes on.

    SYNCH_BLENDER=blender python bench/window.py [quad_mesh]     (Xvfb on the PATH; see tests/ui/conftest.py)

Of quad meshes only the first picture is measured.

Without a graphics card Blender's own rendering takes most of the time. So the times are counted apart: of the process
that solves, of our code in Blender's process (drawing handlers, panels, what a timer does), and, for comparison, of all
of Blender's process.
"""

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.ui import conftest

# Segments of tori, by their numbers of vertices. Blender's own torus has 256 segments at most.
# The small one starts the process that solves, whose imports count only once.
TORI = {"5k": (100, 50), "35k": (350, 100), "50k": (420, 120), "140k": (700, 200)}
REDRAWS = 60
# Wraps what Blender calls of ours in a redraw, so that `spent` sums up the CPU time of it.
_WRAP = """
import time
spent, first = {"ours": 0.0}, {}
def timed(function):
    def call(*arguments):
        start = time.thread_time()
        try:
            return function(*arguments)
        finally:
            spent["ours"] += time.thread_time() - start
    return call
def timed_panel(function):
    def call(self, context):  # Blender counts the arguments
        return timed(function)(self, context)
    return call
for name, method in (("solid_view", "_draw"), ("overlay_view", "_draw"), ("early_view", "draw"), ("strokes", "_draw")):
    view = part(f"panels.{name}").view
    view.unregister()
    setattr(view, method, timed(getattr(view, method)))
    view.register()
for name in [name for name in dir(bpy.types) if name.startswith("SYNCH_PT_")]:
    kind = getattr(bpy.types, name)
    for method in ("draw", "draw_header", "draw_header_preset"):
        if method in vars(kind):
            setattr(kind, method, timed_panel(vars(kind)[method]))
def child_time():
    worker = part("jobs.queue").queue._worker
    if worker is None:
        return 0.0
    fields = open(f"/proc/{worker.number}/stat").read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
Work, came = part("jobs.queue").Work, {}
heard = Work.hear
def hear(self, word, *rest):
    if word == "shown" and not came:
        came.update(wall=time.monotonic() - begun[0], child=child_time() - begun[1])
    return heard(self, word, *rest)
Work.hear = hear
early = part("panels.early_view")._View
shown = early.draw_picture
def draw_picture(self, *arguments):
    result = shown(self, *arguments)
    if not first:
        first.update(wall=time.monotonic() - begun[0], child=child_time() - begun[1])
        first.update(blender=time.process_time() - begun[2], ours=spent["ours"])
    return result
early.draw_picture = draw_picture
"""
_TORUS = """
import numpy as np
def add_torus(major, minor):
    u, v = np.meshgrid(*(2 * np.pi * np.arange(count) / count for count in (major, minor)), indexing="ij")
    out = 1.5 + 0.6 * np.cos(v)
    places = np.stack([out * np.cos(u), 0.8 * out * np.sin(u), 0.78 * np.sin(v)], -1).reshape(-1, 3)
    own = np.arange(major * minor).reshape(major, minor)
    ahead = np.roll(own, -1, 0)
    faces = np.stack([own, ahead, np.roll(ahead, -1, 1), np.roll(own, -1, 1)], -1).reshape(-1, 4)
    data = bpy.data.meshes.new("Torus")
    data.from_pydata(places.tolist(), [], faces.tolist(), shade_flat=False)
    bpy.context.scene.collection.objects.link(obj := bpy.data.objects.new("Torus", data))
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
"""
_CLICK = """
first.clear(); came.clear(); spent["ours"] = 0.0
begun, click = (time.monotonic(), child_time(), time.process_time()), time.thread_time()
with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area(), region=window_region()):
    bpy.ops.synch.COMMAND("INVOKE_DEFAULT")
click = time.thread_time() - click
"""
_REDRAW = f"""
spent["ours"] = 0.0
start = time.process_time()
for _ in range({REDRAWS}):
    for region in area().regions:
        region.tag_redraw()
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
answer = spent["ours"] / {REDRAWS}, (time.process_time() - start) / {REDRAWS}
"""
IDLE = "part('jobs.queue').queue.running is None"


def main():
    """Print two lines of JSON for each torus: the first picture, and the redraws after a solve of stripes too."""
    command = sys.argv[1] if len(sys.argv) > 1 else "stripes"
    with tempfile.TemporaryDirectory() as folder, conftest._installed(Path(folder), (1000, 700)) as blender:
        blender.run("bpy.data.objects.remove(bpy.data.objects['Cube'])")
        blender.open_panel()
        blender.run(_WRAP)
        blender.run(_TORUS)
        for name, (major, minor) in TORI.items():
            blender.run(f"add_torus({major}, {minor})")
            assert blender.value("len(active().data.vertices)") == major * minor
            blender.run(_CLICK.replace("COMMAND", command))
            blender.until(f"bool(first) or ({IDLE})")
            row = {"torus": name} | {part: blender.value(part) for part in ("click", "came", "first")}
            print(json.dumps(row), flush=True)  # the whole solve of the largest one takes minutes
            if command != "stripes":
                blender.until(IDLE)
                blender.run("bpy.data.batch_remove(list(bpy.context.scene.objects))")
                continue
            blender.until(f"{IDLE} and part('patterns.memory').holds(active())")  # written, too
            blender.run("bpy.context.scene.synch_overlay.show = True; area().tag_redraw()")
            gallery = "part('panels.thumbnails').galleries.of(active())"
            blender.until(f"{gallery} is None or len({gallery}.made) == {gallery}.count")
            blender.run(_REDRAW)
            row["redraw_ours"], row["redraw_all"] = blender.run(_REDRAW)
            print(json.dumps(row), flush=True)
            blender.run("bpy.data.objects.remove(active())")


if __name__ == "__main__":
    main()
