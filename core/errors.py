# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors that a user can act on: one line names the element and the remedy."""

import unicodedata
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

# Number of characters of a value that errors show.
_LONGEST = 60


class SynchError(Exception):
    """Base of every error that a user can act on.

    ``source``: the file or data that a reader's error is about, otherwise "".

    Parameters
    ----------
    text : one line; line ends in quoted names are escaped
    vertices : (k,) mesh vertices that the text names; kept ascending, each once
    """

    source = ""

    def __init__(self, text: str, vertices: ArrayLike = ()) -> None:
        super().__init__(one_line(text))
        self.vertices = np.unique(np.asarray(vertices, int))


def one_line(text: object) -> str:
    """Escape control characters and lone surrogates, so that any stream accepts the text as one line."""
    text = str(text).strip()
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or unicodedata.category(c) == "Zs" else ascii(c)[1:-1] for c in text)


def round_up(value: float, digits: int = 3) -> str:
    """Round a positive value up to a number of digits, so that the limit that a message names is valid."""
    text = f"{value:.{digits}g}"
    if float(text) < value:
        exponent = int(f"{value:.{digits - 1}e}".split("e")[1])
        text = f"{float(text) + 10.0 ** (exponent - digits + 1):.{digits}g}"
    return text


class MeshError(SynchError):
    """The mesh cannot carry a field."""


class SettingError(SynchError):
    """A setting is out of range or contradicts another."""


class WriteError(SettingError):
    """A file cannot be written; an earlier version of it is unchanged."""


class ContradictionError(SettingError):
    """Two constraints at the same vertices contradict each other; ``{vertices}`` in the message names them."""

    def __init__(self, message: str, vertices: ArrayLike) -> None:
        super().__init__(message.replace("{vertices}", name_elements("vertex", np.unique(vertices))), vertices)
        self.message = message

    def __reduce__(self) -> tuple[type[Self], tuple[str, np.ndarray]]:
        return type(self), (self.message, self.vertices)

    def renumbered(self, numbers: np.ndarray) -> Self:
        """The same error with (n,) new vertex numbers."""
        return type(self)(self.message, numbers[self.vertices])


class AsymmetryError(MeshError):
    """The mesh is not symmetric; ``vertices`` lack a counterpart."""

    def __init__(self, axis: str, vertices: ArrayLike) -> None:
        super().__init__(
            f"the mesh is not symmetric in {axis}: {name_elements('vertex', np.unique(vertices))} lack a counterpart: "
            "symmetrize it (Mesh > Symmetrize), join triangles with other diagonals (Face > Tris to Quads), or switch "
            "the mirror off",
            vertices,
        )
        self.axis = axis

    def __reduce__(self) -> tuple[type[Self], tuple[str, np.ndarray]]:
        return type(self), (self.axis, self.vertices)

    def renumbered(self, numbers: np.ndarray) -> Self:
        """The same error with (n,) new vertex numbers."""
        return type(self)(self.axis, numbers[self.vertices])


class Cancelled(SynchError):
    """The user stopped the computation; nothing may be written."""


def quote_value(value: object) -> str:
    """Format a value for an error message, cut off where it is long."""
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print numbers of several thousand digits
        text = "a number of thousands of digits"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."


def plural(noun: str) -> str:
    """The plural of a noun: "edges", "vertices", "irregular vertices"."""
    return noun[:-2] + "ices" if noun.endswith(("vertex", "vortex")) else noun + "s"


def name_elements(kind: str, indices: ArrayLike) -> str:
    """Name elements for a message: ``"vertex 7"``, ``"vertices 7, 9, 12 and 40 more"``."""
    indices = np.atleast_1d(indices)
    shown = ", ".join(str(i) for i in indices[:3])
    if len(indices) == 1:
        return f"{kind} {shown}"
    return f"{plural(kind)} {shown}" + (f" and {len(indices) - 3} more" if len(indices) > 3 else "")
