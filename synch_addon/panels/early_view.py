# SPDX-License-Identifier: GPL-3.0-or-later
"""Early pictures: the first result of a running job, drawn over its object or as lines; the scene is not changed."""

import bpy
import gpu
from gpu_extras.batch import batch_for_shader

from ...core.tasks.flows import FilamentPicture
from ..jobs.queue import queue
from .overlay_view import NEARER, nearer
from .pattern_shader import DrawnPattern

# Width of filaments in pixels, and their colour.
_WIDTH, _COLOR = 2.5, (1.0, 0.45, 0.0, 1.0)

# Share of the distance by which a picture is nearer than a quad mesh that it is drawn over, whose faces are flat where
# the surface bends.
_BEFORE_QUADS = 0.03


class _View:
    """Draws the picture of the running job, which goes to the graphics card once."""

    def __init__(self):
        self._handler = self._picture = self._drawn = None

    def register(self):
        """Begin to draw in all 3D views."""
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self.draw, (), "WINDOW", "POST_VIEW")

    def unregister(self):
        """Draw no longer."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")
        self._picture = self._drawn = None

    def draw(self):
        """Draw over the object of the running job, where that has a picture and can be seen."""
        work, context = queue.running, bpy.context
        picture = None if work is None else work.picture
        if picture is None:
            self._picture = self._drawn = None
            return
        region, replaced = context.region_data, getattr(work.job, "replaced", None)
        link = replaced or work.job.link
        view = nearer(region, _BEFORE_QUADS if replaced else NEARER) @ region.view_matrix
        if link is not None:
            obj = link.present
            if obj is None or not obj.visible_get(view_layer=context.view_layer, viewport=context.space_data):
                return
            view = view @ obj.matrix_world
        self.draw_picture(picture, view, region.window_matrix)
        work.is_seen = True

    def draw_picture(self, picture, view, projection):
        """Draw a picture into the active framebuffer, hidden by what is nearer."""
        if picture is not self._picture:
            if isinstance(picture, FilamentPicture):
                self._drawn = _DrawnFilaments(picture.places)
            else:
                self._drawn = DrawnPattern(picture.places, picture.phases, of_quads=picture.of_quads)
            self._picture = picture
        self._drawn.draw(view, projection)


class _DrawnFilaments:
    """Filaments on the graphics card, of (2 k, 3) ends of segments."""

    def __init__(self, places):
        self._shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
        self._batch = batch_for_shader(self._shader, "LINES", {"pos": places})

    def draw(self, view, projection):
        """Draw into the active framebuffer, hidden by what is nearer; the matrices as of :class:`DrawnPattern`."""
        gpu.state.depth_test_set("LESS_EQUAL")
        with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_matrix(view)
            gpu.matrix.load_projection_matrix(projection)
            self._shader.uniform_float("color", _COLOR)
            self._shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            self._shader.uniform_float("lineWidth", _WIDTH * bpy.context.preferences.system.pixel_size)
            self._batch.draw(self._shader)
        gpu.state.depth_test_set("NONE")


view = _View()
register, unregister = view.register, view.unregister
