# SPDX-License-Identifier: GPL-3.0-or-later
"""A piece with all that its solve needs, its result, and the fields that are shown before the end."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ..monitor import Monitor
from ..piece import Piece
from ..solution import Clock, Options
from .batched.parts import PartResult, Start
from .methods import rounding
from .methods.manifolds import fields_of


def finish_piece(piece: Piece, columns: np.ndarray, **quality: Any) -> PartResult:
    """Build the result of a piece from (N * width, k) fields, best first, and what is known of them."""
    fields = fields_of(piece).normalize(columns.astype(piece.matrix.dtype))
    return PartResult(piece.rows, piece.node_count, rounding.ground_to_one(piece, fields), **quality)


def rescale(result: PartResult, weight: float) -> PartResult:
    """Build the result of a piece from that of the scaled one, whose energies are smaller by a weight."""
    return replace(result, **{n: weight * getattr(result, n) for n in ("bound", "sdp_value", "spectral_bound")})


class Watch:
    """Shows the fields of a piece before its end.

    Attributes
    ----------
    part : PartResult that is shown, at the piece's own scale
    proof_in : seconds after which a bound may be expected
    """

    def __init__(self, part: PartResult, show_all: Callable[[], None], proof_in: float) -> None:
        self.part, self.proof_in, self._show_all = part, proof_in, show_all
        self._energy = np.inf

    def follow(self, piece: Piece, monitor: Monitor) -> None:
        """Show the fields of a scaled piece that a monitor hears of from now on."""
        self._energy = float(piece.energy(self.part.fields)[0])
        monitor.on_found = partial(self.found, piece)

    def proved(self, piece: Piece, weight: float, **quality: Any) -> None:
        """Show the field of a scaled piece with the bound that was found."""
        self.part = rescale(finish_piece(piece, self.part.fields, **quality), weight)
        self._show_all()

    def found(self, piece: Piece, energy: float, column: np.ndarray) -> None:
        """Show an (N * width, 1) field of a scaled piece where its energy is lower."""
        if energy < self._energy:
            self._energy = energy
            self.part = replace(self.part, fields=finish_piece(piece, column).fields)
            self._show_all()


@dataclass(frozen=True)
class Task:
    """A piece with all that its solve needs.

    Attributes
    ----------
    weight : the ratio of energies to those of the scaled piece
    less_curl : returns the matrix with less curl, divided by a weight, or None without curl to remove
    """

    piece: Piece
    options: Options
    monitor: Monitor
    clock: Clock
    start: Start
    less_curl: Callable[[float], csr_matrix | None] | None = None
    watch: Watch | None = None
    weight: float = 1.0
