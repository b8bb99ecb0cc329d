# SPDX-License-Identifier: GPL-3.0-or-later
"""The first result of a job that goes on, drawn over its object: nothing of the scene is changed for it."""

import bpy

from ..jobs.queue import queue
from .overlay_view import nearer
from .pattern_shader import DrawnPattern


class _View:
    """Draws the picture of the running job, whose triangles go to the graphics card once."""

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
