# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong, in one line that names the element and the remedy."""

import unicodedata

import numpy as np

# Characters of a value that errors show.
_LONGEST = 60


class SynchError(Exception):
    """Base of every error that a user can act on.

    Parameters
    ----------
    text : one line; ends of lines in names that it quotes are escaped
    vertices : (k,) those of the mesh that the text names, where it names any; kept ascending, each once

    Attributes
    ----------
    source : the file or the data that the text names, where it comes from a reader; else ""
    """

    source = ""

    def __init__(self, text, vertices=()):
        super().__init__(one_line(text))
        self.vertices = np.unique(np.asarray(vertices, int))


def one_line(text):
    """A text in one line that every stream takes: control characters and halves of characters are escaped."""
    text = str(text).strip()
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or unicodedata.category(c) == "Zs" else ascii(c)[1:-1] for c in text)


class MeshError(SynchError):
    """The mesh cannot carry a field as it is."""


class SettingError(SynchError):
    """A setting is out of range or contradicts another."""


class WriteError(SettingError):
    """A file cannot be written; what was there before is as it was."""


class ContradictionError(SettingError):
    """Two wishes that cannot both be met.

    Attributes
    ----------
    message : with ``{vertices}`` where they are named
    vertices : (k,) where, each once
    """

    def __init__(self, message, vertices):
        super().__init__(message.replace("{vertices}", name_elements("vertex", np.unique(vertices))), vertices)
        self.message = message

    def __reduce__(self):
        return ContradictionError, (self.message, self.vertices)

    def renumbered(self, numbers):
        """The same error where each vertex has another number, (n,) ``numbers``."""
        return ContradictionError(self.message, numbers[self.vertices])


class AsymmetryError(MeshError):
    """A mesh that is not its own mirror image; ``vertices`` are those without a counterpart."""

    def __init__(self, axis, vertices):
        super().__init__(
            f"the mesh is not symmetric in {axis}: {name_elements('vertex', np.unique(vertices))} lack a counterpart: "
            f"symmetrize it (Mesh > Symmetrize), or switch the mirror off",
            vertices,
        )
        self.axis = axis

    def __reduce__(self):
        return AsymmetryError, (self.axis, self.vertices)

    def renumbered(self, numbers):
        """The same error where each vertex has another number, (n,) ``numbers``."""
        return AsymmetryError(self.axis, numbers[self.vertices])


class Cancelled(SynchError):
    """The user stopped the computation; nothing may be written."""


def quote_value(value):
    """A value as errors show it, cut off where it is long."""
    try:
        text = repr(value)
    except ValueError:  # Python writes no number of more than some thousand digits
        text = "a number of thousands of digits"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."


def plural(noun):
    """ "edges", "vertices", "irregular vertices" """
    return noun[:-2] + "ices" if noun.endswith(("vertex", "vortex")) else noun + "s"


def name_elements(kind, indices):
    """Name elements for a message: ``"vertex 7"``, ``"vertices 7, 9, 12 and 40 more"``."""
    indices = np.atleast_1d(indices)
    shown = ", ".join(str(i) for i in indices[:3])
    if len(indices) == 1:
        return f"{kind} {shown}"
    return f"{plural(kind)} {shown}" + (f" and {len(indices) - 3} more" if len(indices) > 3 else "")
