# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins, faces whose disclinations are chosen, as text such as ``120=1,133=-1``.

Each is a face and by how many of the smallest turns its directions turn around it: halves for lines, quarters for
crosses; 0 for none.
"""

from ...core.errors import SettingError
from ...core.fields.directions import SYMMETRIES
from ...core.texts import items


def parsed(text):
    """The pins of a text: a dict of turns by faces.

    Raises
    ------
    SettingError
        naming what cannot be read
    """
    pins = {}
    for face, turns in items(text, "pins", "FACE=TURNS") if text else ():
        try:
            pins[int(face)] = int(turns or "")
        except ValueError:
            raise SettingError(
                f"the pin {face}={turns or ''} is none: write a face's number and its turns, such as 120=1"
            ) from None
    return pins


def as_text(pins):
    """The text of a dict of turns by faces."""
    return ",".join(f"{face}={turns}" for face, turns in pins.items())


def on_triangles(pins, polygons, symmetry):
    """What :class:`DirectionWishes` is asked: pairs of a triangle and an index.

    Parameters
    ----------
    pins : dict of turns by faces
    polygons : Polygons
    symmetry : "vector", "line" or "cross"

    Raises
    ------
    SettingError
        for a face that is not there
    """
    for face in pins:
        if not (0 <= face < len(polygons.starts) and polygons.drawn[face]):
            raise SettingError(f"there is no face {face} to pin: clear the pins, or pin again")
    return tuple((int(polygons.first_triangles[face]), turns / SYMMETRIES[symmetry]) for face, turns in pins.items())
