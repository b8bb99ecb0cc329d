# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Knobs and a button, drawn into a picture of floats: rows from the top, linear in what the eye sees, 0 to 1."""

import numpy as np

from synch_fields.docs.make.sheets import NAVY, paint, write

IVORY, WHITE, GREY = np.array([(240, 231, 210), (252, 250, 246), (186, 182, 174)]) / 255
RADIUS = 33
# From where to where a knob turns, in radians to the right of straight up.
FIRST, LAST = np.radians([-135, 135])


def knob(picture, place, name, value):
    """Draw a knob at a value from 0 to 1, with its name below, into a (height, width, 3) picture; its middle is at x
    and y, in pixels from the top left."""
    x, y = _grid(picture, place)
    away, turned = np.hypot(x, y), np.arctan2(x, -y)
    angle = FIRST + value * (LAST - FIRST)
    paint(picture, GREY, 0.8 * _arc(away, turned, FIRST, LAST))
    paint(picture, NAVY, _arc(away, turned, FIRST, angle))
    paint(picture, NAVY, 0.35 * _soft(np.hypot(x, y - 4) - RADIUS, 9))  # the shadow
    shade = np.clip(0.5 - y / (2.2 * RADIUS), 0, 1)[..., None]
    paint(picture, IVORY + shade * (WHITE - IVORY), _soft(away - RADIUS, 0.7))
    along, across = x * np.sin(angle) - y * np.cos(angle), x * np.cos(angle) + y * np.sin(angle)
    beyond = along - np.clip(along, 0.42 * RADIUS, 0.8 * RADIUS)
    paint(picture, NAVY, _soft(np.hypot(beyond, across) - 2.6, 0.7))
    write(picture, (place[0], place[1] + RADIUS + 25), name)


def button(picture, place, name, pressed):
    """Draw a button with its name on it; in the colours of a pressed one or not."""
    x, y = _grid(picture, place)
    half, radius = 36, 15
    away = np.hypot(x - np.clip(x, -half, half), y) - radius
    paint(picture, NAVY, 0.3 * _soft(np.hypot(x - np.clip(x, -half, half), y - 3) - radius, 7))
    paint(picture, NAVY if pressed else WHITE, _soft(away, 0.7))
    write(picture, place, name, WHITE if pressed else NAVY)


def _grid(picture, place):
    height, width = picture.shape[:2]
    return np.arange(width)[None] + 0.5 - place[0], np.arange(height)[:, None] + 0.5 - place[1]


def _arc(away, turned, first, last):
    inside = np.clip((turned - first) * away + 0.5, 0, 1) * np.clip((last - turned) * away + 0.5, 0, 1)
    return inside * _soft(np.abs(away - 1.32 * RADIUS) - 2.2, 0.7)


def _soft(distance, width):
    """1 inside, 0 outside, and between them over a width on both sides."""
    return np.clip(0.5 - distance / (2 * width), 0, 1)
