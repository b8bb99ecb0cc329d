# SPDX-License-Identifier: GPL-3.0-or-later
"""The first result of a job that goes on, drawn over its object: nothing of the scene is changed for it."""

import time

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from ..jobs.queue import queue
from .overlay_view import nearer

_VERTEX = """
void main()
{
  vec4 place = view * vec4(pos, 1.0);
  at = place.xyz;
  phases = phase;
  gl_Position = projection * place;
}
"""
# Lit from the eye; the lines have soft edges one pixel wide.
_FRAGMENT = """
const vec3 ink = vec3(0.05, 0.09, 0.2), paper = vec3(0.87, 0.79, 0.66);

void main()
{
  float height = cos(phases.x) * cos(phases.y);
  float line = smoothstep(-0.5, 0.5, height / max(fwidth(height), 1e-4));
  vec3 normal = normalize(cross(dFdx(at), dFdy(at)));
  float light = 0.35 + 0.65 * abs(normal.z);
  color = vec4(mix(ink, paper, line) * light, 1.0);
}
"""
# Seconds that drawing a view may take for a picture to be shown there at once.
_QUICK = 0.025


class _View:
    """Draws the picture of the running job, whose triangles go to the graphics card once."""

    def __init__(self):
        self._handlers, self._shader = [], None
        self._picture, self._batch = None, None
        self._start = self._seconds = 0.0

    def register(self):
        """Begin to draw in all 3D views."""
        steps = {"PRE_VIEW": self._begin, "POST_VIEW": self.draw, "POST_PIXEL": self._end}
        add = bpy.types.SpaceView3D.draw_handler_add
        self._handlers = [add(step, (), "WINDOW", place) for place, step in steps.items()]

    def unregister(self):
        """Draw no longer."""
        for handler in self._handlers:
            bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
        self._shader = self._picture = self._batch = None

    @property
    def is_quick(self):
        """Whether a view was last drawn so fast that drawing it again does not hold the window up.

        Without a graphics card any drawing of a view takes a tenth of a second or more, whatever it shows.
        """
        return self._seconds < _QUICK

    def _begin(self):
        self._start = time.perf_counter()

    def _end(self):
        self._seconds = time.perf_counter() - self._start

    def draw(self):
        """Draw over the object of the running job, where that has a picture and can be seen."""
        work, context = queue.running, bpy.context
        picture = None if work is None else work.picture
        if picture is None:
            self._picture = self._batch = None
            return
        obj = work.job.link.present
        if obj is not None and obj.visible_get(view_layer=context.view_layer, viewport=context.space_data):
            region = context.region_data
            self.draw_picture(picture, nearer(region) @ region.view_matrix @ obj.matrix_world, region.window_matrix)
            work.is_seen = True

    def draw_picture(self, picture, view, projection):
        """Draw a picture into the active framebuffer, hidden by what is nearer."""
        shader = self._shader = self._shader or _shader()
        if picture is not self._picture:
            self._batch = batch_for_shader(shader, "TRIS", {"pos": picture.places, "phase": picture.phases})
            self._picture = picture
        gpu.state.depth_test_set("LESS_EQUAL")
        shader.uniform_float("view", view)
        shader.uniform_float("projection", projection)
        self._batch.draw(shader)
        gpu.state.depth_test_set("NONE")


def _shader():
    between = gpu.types.GPUStageInterfaceInfo("synch_early")
    between.smooth("VEC3", "at")
    between.smooth("VEC2", "phases")
    info = gpu.types.GPUShaderCreateInfo()
    info.push_constant("MAT4", "view")
    info.push_constant("MAT4", "projection")
    info.vertex_in(0, "VEC3", "pos")
    info.vertex_in(1, "VEC2", "phase")
    info.vertex_out(between)
    info.fragment_out(0, "VEC4", "color")
    info.vertex_source(_VERTEX)
    info.fragment_source(_FRAGMENT)
    return gpu.shader.create_from_info(info)


view = _View()
register, unregister = view.register, view.unregister
