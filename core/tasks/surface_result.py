# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a request on a surface."""

import dataclasses
from dataclasses import dataclass
from typing import Self

from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields import DirectionField, Pattern
from ..geometry.mesh_input import MeshInput


@dataclass(frozen=True)
class SurfaceResult:
    """The result of a :class:`~.surfaces.SurfaceRequest`.

    Attributes
    ----------
    field, pattern, quads : as far as the command has them
    forced_dislocations : number of dislocations that exact directions and spacing would need
    warnings : for the user
    seconds : times of parts of the work other than solves, by name
    settled : settings, by name, that replaced the wanted ones
    loops_before : figures of the loops before more of them were closed (:attr:`QuadLoops.figures`)
    given : the mesh of field and pattern, where narrow tunnels were closed for them; None for the request's
    """

    field: DirectionField
    pattern: Pattern | None = None
    quads: QuadMesh | None = None
    forced_dislocations: float | None = None
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)
    settled: dict[str, float | None] = dataclasses.field(default_factory=dict)
    loops_before: dict[str, float] | None = None
    given: MeshInput | None = None


@dataclass(frozen=True)
class PatternResult(SurfaceResult):
    """A result with a pattern."""

    pattern: Pattern

    def with_figures(self) -> Self:
        """The result, with what is shown of it computed already: in the solving process, not in the window's."""
        _ = self.pattern.edge_phases.dislocations, self.pattern.evenness.figures, self.pattern.evenness.errors
        return self
