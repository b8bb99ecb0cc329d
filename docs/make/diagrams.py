# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scatter plots with logarithmic axes, drawn by Blender. Needs it as a module (bpy)."""

from dataclasses import dataclass

import bpy
import numpy as np

from synch_fields.docs.make.flat import flat_scene, glowing
from synch_fields.synch_addon.blender.transaction import only_for_now

# In pixels: the picture, the margins left, right, below and above the frame, a point's radius, letters, lines.
RESOLUTION = (640, 560)
LEFT, RIGHT, BELOW, ABOVE = 92, 22, 78, 50
POINT, LETTER, SMALL_LETTER, LINE = 4.2, 19, 16, 1.2
CORNERS = 20
INK, GRID, BLUE, ROSE, GREEN = (
    (0.015, 0.02, 0.03, 1),
    (0.78, 0.79, 0.8, 1),
    (0.035, 0.16, 0.52, 1),
    (0.62, 0.06, 0.17, 1),
    (0.05, 0.36, 0.2, 1),
)
# Share of a decade that stays free around the points, and bounds for the number of labels.
ROOM, FEWEST_LABELS, MOST_LABELS = 0.15, 3, 6


@dataclass(frozen=True)
class Diagram:
    """Points over two logarithmic axes.

    Attributes
    ----------
    title, across, up : texts: above, of the horizontal and of the vertical axis
    series : tuples of a name, a colour, and (n,) positive values across and up
    has_diagonal : whether both axes have the same range, and a line where both values are the same
    """

    title: str
    across: str
    up: str
    series: tuple
    has_diagonal: bool = False

    @property
    def ranges(self):
        """Least and largest power of ten of both axes."""
        values = [np.log10(np.concatenate([series[place] for series in self.series])) for place in (2, 3)]
        if self.has_diagonal:
            values = 2 * [np.concatenate(values)]
        return [(found.min() - ROOM, found.max() + ROOM) for found in values]


def ticks(low, high):
    """Powers between two, so few that their labels have room: whole ones, and those of 2 and 5 times as much where
    there are few of these."""
    whole = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    inside = [power for power in whole if low <= power <= high]
    if len(inside) < FEWEST_LABELS:
        inside = [power + np.log10(digit) for power in whole for digit in (1, 2, 5)]
        return [power for power in inside if low <= power <= high]
    return inside[:: -(-len(inside) // MOST_LABELS)]


def label(power):
    """A power of ten as it is read."""
    return f"{10.0**power:g}" if -3.5 <= power <= 4 else f"1e{power}"


def draw(diagram, path):
    """Render a diagram; returns the path."""
    with only_for_now():
        scene = flat_scene(path, RESOLUTION[0], RESOLUTION)
        sheet = _Sheet(scene)
        frame = np.array([[LEFT, RESOLUTION[0] - RIGHT], [BELOW, RESOLUTION[1] - ABOVE]], float)
        ranges = np.array(diagram.ranges)

        def at(axis, powers):
            share = (np.asarray(powers, float) - ranges[axis, 0]) / np.ptp(ranges[axis])
            return frame[axis, 0] + share * np.ptp(frame[axis])

        for axis in (0, 1):
            for power in ticks(*ranges[axis]):
                ends = np.array([frame[:, 0], frame[:, 1]])
                ends[:, axis] = at(axis, power)
                sheet.line(*ends, GRID)
                place = frame[:, 0] - (0, 24) if axis == 0 else frame[:, 0] - (10, 6)
                place[axis] = at(axis, power) - (6 if axis else 0)
                sheet.text(label(power), place, SMALL_LETTER, "RIGHT" if axis else "CENTER")
        if diagram.has_diagonal:
            sheet.line(frame[:, 0], frame[:, 1], INK)
        corners = [(frame[0, i], frame[1, j]) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
        for k in range(4):
            sheet.line(corners[k], corners[k - 1], INK)
        middle = frame.mean(axis=1)
        sheet.text(diagram.across, (middle[0], BELOW - 56), LETTER)
        sheet.text(diagram.up, (26, middle[1]), LETTER, turned=True)
        sheet.text(diagram.title, (middle[0], RESOLUTION[1] - 34), LETTER)
        for row, (name, color, x, y) in enumerate(diagram.series):
            sheet.points(np.column_stack([at(0, np.log10(x)), at(1, np.log10(y))]), color)
            if len(diagram.series) > 1:
                place = np.array([frame[0, 0] + 18, frame[1, 1] - 24 * (row + 1)])
                sheet.points(place[None], color)
                sheet.text(name, place + (14, -6), SMALL_LETTER, "LEFT")
        bpy.ops.render.render(write_still=True, scene=scene.name)
    return path


class _Sheet:
    """What is drawn, in pixels from the lower left corner; later things lie on top."""

    def __init__(self, scene):
        self._scene, self._height, self._materials = scene, 0.0, {}

    def line(self, start, end, color):
        start, end = np.array(start, float), np.array(end, float)
        along = (end - start) / np.linalg.norm(end - start)
        across = LINE / 2 * np.array([-along[1], along[0]])
        self._add(np.array([start + across, start - across, end - across, end + across])[None], color)

    def points(self, places, color):
        turns = 2 * np.pi * np.arange(CORNERS) / CORNERS
        circle = POINT * np.column_stack([np.cos(turns), np.sin(turns)])
        self._add(np.asarray(places)[:, None] + circle, color)

    def text(self, words, place, size, align="CENTER", turned=False):
        data = bpy.data.curves.new("Text", "FONT")
        data.body, data.size, data.align_x = words, size, align
        obj = self._link(data, INK)
        obj.location = (*self._from_middle(np.array(place, float)), self._height)
        obj.rotation_euler.z = np.pi / 2 if turned else 0

    def _add(self, polygons, color):
        """Polygons of (k, c, 2) corners."""
        count, corners, _ = polygons.shape
        flat = self._from_middle(polygons.reshape(-1, 2))
        points = np.column_stack([flat, np.full(len(flat), self._height)])
        mesh = bpy.data.meshes.new("Shapes")
        mesh.from_pydata(points.tolist(), [], np.arange(count * corners).reshape(count, corners).tolist())
        self._link(mesh, color)
        self._height += 0.01

    def _link(self, data, color):
        if color not in self._materials:
            self._materials[color] = glowing(color)
        data.materials.append(self._materials[color])
        obj = bpy.data.objects.new("Drawn", data)
        self._scene.collection.objects.link(obj)
        return obj

    @staticmethod
    def _from_middle(places):
        return places - np.array(RESOLUTION) / 2
