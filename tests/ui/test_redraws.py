# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast a window is drawn again where a large mesh shows all that there is: overlay, ink, thumbnails and badge."""

from .test_window import solved

# Milliseconds of a redraw at thirty a second, and the part of them that our own drawing may take.
_REDRAW, _OURS = 1000 / 30, 10.0

TIMED = """
import time

spent = []

def timed(owner, name):
    inner = getattr(owner, name)

    def outer(*args, **kwargs):
        start = time.perf_counter()
        try:
            return inner(*args, **kwargs)
        finally:
            spent.append(time.perf_counter() - start)

    setattr(owner, name, outer)

timed(part("panels.overlay_view"), "draw_object")
timed(part("panels.pattern_shader").DrawnPattern, "draw")
timed(part("panels.result").SYNCH_PT_result, "draw")
timed(part("panels.sidebar").SYNCH_PT_fields, "draw")

def redraws(count=20):
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area(), region=window_region()):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=3)
        spent.clear()
        start = time.perf_counter()
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=count)
        return 1000 * (time.perf_counter() - start) / count, 1000 * sum(spent) / count
"""


def test_a_mesh_of_fifty_thousand_vertices_is_drawn_quickly(panel, keep):
    panel.run("bpy.ops.mesh.primitive_uv_sphere_add(segments=224, ring_count=224, radius=2)")
    panel.run("active().synch.automatic_spacing = False; active().synch.spacing = 0.4")
    panel.run(TIMED)
    empty, nothing = panel.value("redraws()")
    solved(panel)
    panel.run("bpy.context.scene.synch_overlay.show = True")
    gallery = "part('panels.thumbnails').galleries.of(active())"
    panel.until(f"len({gallery}.made) == {gallery}.count")
    panel.run("active().data.vertices[0].co.x += 0.01; active().data.update()")
    panel.wait_for("Mesh Changed: Solve Again")
    keep("redraws", panel.picture())
    all_on, ours = panel.value("redraws()")
    count = panel.value("len(active().data.vertices)")
    print(
        f"{count} vertices: a redraw takes {empty:.1f} ms before anything is solved ({nothing:.2f} ms ours), "
        f"{all_on:.1f} ms with all ({ours:.2f} ms ours)"
    )
    assert ours < _OURS
    assert all_on < _REDRAW or all_on < empty + _OURS
