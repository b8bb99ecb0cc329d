# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of G-code for travels and beads, and the state of the machine between them."""

import numpy as np

from .kinematics import to_part
from .machine import Machine

# A comment with the bead's size is repeated where its width or height has changed by more than this share; travels may
# pass over beads that are higher than their ends by less than this share of a bead's height.
_LIKE, _LEVEL = 0.05, 0.05
# Degrees that the table turns at most between places of a travel whose places are those of the tip on the part.
_TURN = 5.0


class ProgramWriter:
    """Lines of moves, and where the machine is."""

    def __init__(self, machine: Machine) -> None:
        self._machine, self._letters = machine, machine.axes.upper() if machine.turns else ""
        self._is_timed = machine.turns and machine.moves == "inverse"
        self._is_tcp = machine.turns and machine.moves == "tcp"
        self._plain = "G94 " if self._is_timed else ""
        self._place, self._angles, self._is_home = np.zeros(3), np.zeros(len(self._letters)), True
        self._drawn, self._total, self._written = False, 0.0, 0.0
        self._last_z, self._kind, self._width, self._height = "", "", 0.0, 0.0

    def travel(
        self, place: np.ndarray, angles: np.ndarray, top: float, is_same_layer: bool, reach: float, clearance: float
    ) -> list[str]:
        """Moves to the start of a bead: straight, above the last bead by the lift and a clearance, or above everything
        printed so far if the clearance is infinite."""
        machine = self._machine
        if self._is_home:
            self._is_home = False
            safe = np.array([0.0, 0.0, max(place[2] + machine.lift, 5.0)])
            self._place = safe
            return [*self._rapid(safe, self._angles, "Z"), *self._rapid(np.append(place[:2], safe[2]), angles),
                    *self._rapid(place, angles)]  # fmt: skip
        distance = np.linalg.norm(place - self._place)
        turned = np.radians(np.abs(angles - self._angles).max(initial=0))
        is_level = clearance <= _LEVEL * self._height
        if is_same_layer and is_level and distance <= machine.hop and turned * reach < 2 * machine.lift:
            return self._rapid(place, angles)
        up = np.array([0, 0, machine.lift + (clearance if np.isfinite(clearance) else 0)])
        # A turn lets the tip leave the straight way by so much.
        is_far = not is_same_layer or np.isinf(clearance) or reach * turned**2 / 8 > machine.lift / 2
        rows = self._draw_back()
        high = top + machine.lift
        if is_far:
            rows += self._rapid(np.append(self._place[:2], high), self._angles)
            rows += self._rapid(np.append(place[:2], high), angles)
        else:
            rows += self._rapid(self._place + up, self._angles)
        return [*rows, *self._rapid(place + up, angles), *self._rapid(place, angles)]

    def start(self, kind: str) -> list[str]:
        """A comment with the kind of bead where it changes; pushes retracted filament back."""
        rows = [] if kind == self._kind else [f";TYPE:{kind}"]
        self._kind = kind
        return [*rows, *self._push()]

    def bead(
        self,
        places: np.ndarray,
        angles: np.ndarray,
        points: np.ndarray,
        filament: np.ndarray,
        feeds: np.ndarray,
        sizes: np.ndarray,
    ) -> list[str]:
        """Moves along a bead, and comments where its width and height change."""
        rows, shown = [], points if self._is_tcp else places
        for place, turned, amount, feed, size in zip(
            shown.tolist(), angles.tolist(), filament.tolist(), feeds.tolist(), sizes.tolist(), strict=True
        ):
            width, height = size
            if abs(width - self._width) > _LIKE * self._width or abs(height - self._height) > _LIKE * self._height:
                self._width, self._height = size
                rows += [f";WIDTH:{width:.3f}", f";HEIGHT:{height:.3f}"]
            words = self._words(place, turned)
            rows.append(f"{'G93 ' if self._is_timed else ''}G1 {words} {self._extruded(amount)} F{feed:.6g}")
        if len(places):
            self._place, self._angles = places[-1], angles[-1]
        return rows

    def finish(self, top: float) -> list[str]:
        """Away from the part, upright."""
        rows = self._draw_back()
        high = max(top, self._place[2]) + self._machine.lift
        rows += self._rapid(np.append(self._place[:2], high), self._angles)
        if self._machine.turns:
            rows += self._rapid(np.append(self._place[:2], high), np.array([0.0, self._angles[1]]))
        return [*rows, *(["G49"] if self._is_tcp else [])]

    def _draw_back(self) -> list[str]:
        if not self._machine.retraction or self._drawn:
            return []
        self._drawn = True
        return [f"{self._plain}G1 {self._extruded(-self._machine.retraction)} F{self._machine.retraction_feed:g}"]

    def _push(self) -> list[str]:
        if not self._drawn:
            return []
        self._drawn = False
        return [f"{self._plain}G1 {self._extruded(self._machine.retraction)} F{self._machine.retraction_feed:g}"]

    def _rapid(self, place: np.ndarray, angles: np.ndarray, only: str = "") -> list[str]:
        """Lines of a travel, in several parts where the tip's place on the part is written and the table turns."""
        angles = np.asarray(angles, float)
        parts = 1
        if self._is_tcp:
            parts = max(1, int(np.ceil(np.abs(angles - self._angles).max(initial=0) / _TURN)))
        rows = []
        for share in np.arange(1, parts + 1) / parts:
            here = self._place + share * (place - self._place)
            turned = self._angles + share * (angles - self._angles)
            shown = to_part(here[None], turned[None], self._machine)[0] if self._is_tcp else here
            words = self._words(shown.tolist(), turned.tolist(), only)
            rows.append(f"{self._plain}G0 {words} F{self._machine.travel_feed:g}")
        self._place, self._angles = np.asarray(place, float), angles
        return rows

    def _words(self, place: list[float], angles: list[float], only: str = "") -> str:
        x, y, z = place
        height = f"Z{z:.4f}"
        words = [height] if only else [f"X{x:.4f} Y{y:.4f}", *([height] if height != self._last_z else [])]
        self._last_z = height
        return " ".join(
            [*words, *(f"{letter}{angle:.4f}" for letter, angle in zip(self._letters, angles, strict=True))]
        )

    def _extruded(self, amount: float) -> str:
        """The E word; what rounding leaves out comes with the next one."""
        self._total += amount
        now = round(self._total, 5)
        step, self._written = now - self._written, now
        return f"E{now:.5f}" if self._machine.extrusion == "absolute" else f"E{step:.5f}"
