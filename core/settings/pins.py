# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins, the faces whose disclinations are prescribed, as text such as ``120=1,133=-1``.

Each is a face and the turns of the directions around it, in halves for lines and quarters for crosses.
"""

from collections.abc import Mapping

from ..errors import SettingError
from ..spec_parser import items


def parse_pins(text: str) -> dict[int, int]:
    """The turns by face; SettingError for a text that cannot be read."""
    pins = {}
    for face, turns in items(text, "pins", "FACE=TURNS") if text else ():
        try:
            pins[int(face)] = int(turns or "")
        except ValueError:
            raise SettingError(
                f"the pin {face}={turns or ''} cannot be read: write a face's number and its turns, such as 120=1"
            ) from None
    return pins


def text_of_pins(pins: Mapping[int, int]) -> str:
    """The text that :func:`parse_pins` reads."""
    return ",".join(f"{face}={turns}" for face, turns in pins.items())
