# SPDX-License-Identifier: GPL-3.0-or-later
"""The first result of a job that goes on, drawn over its object: nothing of the scene is changed for it."""

import time

import bpy

from ..jobs.queue import queue
from .overlay_view import nearer
from .pattern_shader import DrawnPattern

# Seconds that drawing a view may take for a picture to be shown there at once.
_QUICK = 0.025


class _View:
    """Draws the picture of the running job, whose triangles go to the graphics card once."""

    def __init__(self):
        self._handlers, self._picture, self._drawn = [], None, None
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
        self._picture = self._drawn = None

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
            self._picture = self._drawn = None
            return
        obj = work.job.link.present
        if obj is not None and obj.visible_get(view_layer=context.view_layer, viewport=context.space_data):
            region = context.region_data
            self.draw_picture(picture, nearer(region) @ region.view_matrix @ obj.matrix_world, region.window_matrix)
            work.is_seen = True

    def draw_picture(self, picture, view, projection):
        """Draw a picture into the active framebuffer, hidden by what is nearer."""
        if picture is not self._picture:
            self._drawn = DrawnPattern(picture.places, picture.phases, of_quads=picture.of_quads, covers=True)
            self._picture = picture
        self._drawn.draw(view, projection)


view = _View()
register, unregister = view.register, view.unregister
