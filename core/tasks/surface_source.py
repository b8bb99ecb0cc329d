# SPDX-License-Identifier: GPL-3.0-or-later
"""What is read from a scene for a request on a surface: a mesh, and what settings name on it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..errors import AsymmetryError, SettingError
from ..fields import Guide, Row
from ..fields.mirror import Mirror
from ..geometry import TriangleMesh
from ..geometry.mesh_input import MeshInput
from ..geometry.mirror import mirrored_vertices
from ..settings.surface import SurfaceSettings

# Approximate seconds on one core for each vertex, by command, measured on 3,000 to 41,000 vertices; the share of them
# that other methods than the default one take; for each face of a quad mesh; and the factor for closing its loops.
_VERTEX_SECONDS = {"directions": 0.8e-4, "stripes": 2e-4, "quads": 2.5e-4, "quad_mesh": 3.5e-4}
_QUICK, _FACE_SECONDS, _LOOPS = 0.3, 5e-4, 4.0
# The first frame of an animation is a whole solve: it takes this many times the work of another frame.
FIRST_FRAME = 4


@dataclass(frozen=True)
class PendingGuide:
    """A guide whose data has been read but that is not computed yet.

    Attributes
    ----------
    label : its name in errors
    compute : can be pickled
    share : factor of its weights
    has_detail : whether ``compute`` takes ``detail``, the length over which the surface is smoothed; such a guide is
        the partial function of a mesh, and depends on nothing else
    """

    label: str
    compute: Callable[..., Guide]
    share: float
    has_detail: bool = False

    def weighted(self, detail: float) -> tuple[Guide, float]:
        """The guide and its share; SettingError, with the guide's name, if it has no directions."""
        try:
            return self.compute(detail=detail) if self.has_detail else self.compute(), self.share
        except SettingError as error:
            raise SettingError(f"{self.label}: {error}") from None

    def on(self, mesh: TriangleMesh) -> "PendingGuide":
        """The guide on another mesh, if it has ``detail``."""
        assert isinstance(self.compute, partial)
        return replace(self, compute=partial(self.compute.func, mesh, *self.compute.args[1:], **self.compute.keywords))


@dataclass(frozen=True)
class SurfaceSource:
    """A mesh, and what settings name on it, read from a scene.

    Attributes
    ----------
    given : the mesh
    rows : of the constraint list
    guides : for the directions
    directions : (n, 3) vectors that are used as they are, or None
    turns : radians added to the angle, one or (n,)
    factors : on the spacing, one or (n,)
    sharp : edges of the uncut mesh that are marked sharp
    is_fitted : whether the mesh was made as fine as the spacing needs
    """

    given: MeshInput
    rows: tuple[Row, ...] = ()
    guides: tuple[PendingGuide, ...] = ()
    directions: np.ndarray | None = None
    turns: float | np.ndarray = 0.0
    factors: float | np.ndarray = 1.0
    sharp: ArrayLike = ()
    is_fitted: bool = False

    def mirrors(self, axes: str) -> tuple[Mirror, ...]:
        """Mirrors through the object's origin, across the axes that letters name, such as "XZ".

        Raises AsymmetryError where the mesh is not symmetric about one of them.
        """
        given, numbers = self.given, sorted("XYZ".index(letter) for letter in set(axes))
        try:
            return tuple(Mirror.of(given.mesh, mirrored_vertices(given.mesh, given.polygons, n), n) for n in numbers)
        except AsymmetryError as error:
            raise error.renumbered(given.source) from None

    def seconds(self, command: str, settings: SurfaceSettings) -> float:
        """About how long the command takes on one core."""
        return solve_seconds(command, settings, self.given.mesh.vertex_count)


def solve_seconds(command: str, settings: SurfaceSettings, vertex_count: int, frames: int = 1) -> float:
    """Estimate the seconds of a command on one core, by the numbers of vertices and frames."""
    seconds = _VERTEX_SECONDS[command] * vertex_count
    if settings.method != "sdp":
        seconds *= _QUICK
    if command == "quad_mesh":
        seconds += _FACE_SECONDS * (settings.faces or 0)
        seconds *= _LOOPS if settings.loops else 1.0
    return seconds * (FIRST_FRAME + frames - 1) / FIRST_FRAME
