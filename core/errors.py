# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong, in one line that names the element and the remedy."""

import numpy as np


class SynchError(Exception):
    """Base of every error that a user can act on; its text is one line.

    ``vertices`` are those of the mesh that it names, where it names any.
    """

    vertices: np.ndarray = np.empty(0, int)


class MeshError(SynchError):
    """The mesh cannot carry a field as it is."""


class SettingError(SynchError):
    """A setting is out of range or contradicts another."""


class ContradictionError(SettingError):
    """Two wishes that cannot both be met.

    Attributes
    ----------
    message : with ``{vertices}`` where they are named
    vertices : (k,) where, each once
    """

    def __init__(self, message, vertices):
        self.message, self.vertices = message, np.unique(vertices)
        super().__init__(message.replace("{vertices}", name_elements("vertex", self.vertices)))

    def renumbered(self, numbers):
        """The same error where each vertex has another number, (n,) ``numbers``."""
        return ContradictionError(self.message, numbers[self.vertices])


class AsymmetryError(MeshError):
    """A mesh that is not its own mirror image; ``vertices`` are those without a counterpart."""

    def __init__(self, axis, vertices):
        self.axis, self.vertices = axis, np.unique(vertices)
        super().__init__(
            f"the mesh is not symmetric in {axis}: {name_elements('vertex', self.vertices)} lack a counterpart: "
            f"symmetrize it (Mesh > Symmetrize), or switch the mirror off"
        )

    def renumbered(self, numbers):
        """The same error where each vertex has another number, (n,) ``numbers``."""
        return AsymmetryError(self.axis, numbers[self.vertices])


class Cancelled(SynchError):
    """The user stopped the computation; nothing may be written."""


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
