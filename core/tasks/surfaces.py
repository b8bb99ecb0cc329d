# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions, stripes, quads and quad meshes on one surface."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Protocol, TypedDict

import numpy as np

from ..errors import ContradictionError, SettingError
from ..extract.pictures.drawn_phases import drawn_phases
from ..extract.quads.finishing import check_quads, finish_quads
from ..extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from ..fields import (
    DirectionField,
    DirectionWishes,
    Guide,
    Pattern,
    Row,
    direction_field,
    given_directions,
    quad_pattern,
    stripe_pattern,
)
from ..fields.alignment import along_curvature
from ..fields.directions import known_directions
from ..fields.mirror import Mirror
from ..fields.patterns import known_pattern
from ..fields.target_one_form import COARSE_SHARE, TargetOneForm
from ..geometry import TriangleMesh
from ..geometry.mesh_input import MeshInput
from ..monitor import Callback, Monitor, portion
from ..settings.surface import SYMMETRY_ORDERS
from ..solution import FIRST, Clock
from ..solve import Options
from ..solve.warm_start import Follower
from .quad_meshes import draft_quad_mesh, solve_quad_mesh

# The pattern that a command solves for along its directions; "directions" has none.
PATTERNS: dict[str, Callable[..., Pattern]] = {
    "stripes": stripe_pattern,
    "quads": quad_pattern,
    "quad_mesh": quad_pattern,
}
# Commands with pictures of intermediate results.
SHOWN = ("stripes", "quads")
# Curvature that varies over less than this part of a quad's side does not turn the directions of quad meshes.
DETAIL = 0.5
# Share of the work for the draft of a quad mesh.
_DRAFT = 0.15


class _WithPhases(Protocol):
    """A pattern, or another object with (k n,) complex phases."""

    @property
    def phases(self) -> np.ndarray: ...


class _Finished(TypedDict):
    """Fields of a :class:`SurfaceResult`."""

    quads: QuadMesh
    seconds: dict[str, float]


@dataclass(frozen=True)
class PendingGuide:
    """A guide whose data has been read but that is not computed yet.

    Attributes
    ----------
    label : its name in errors
    compute : can be pickled
    share : factor of its weights
    """

    label: str
    compute: Callable[[], Guide]
    share: float

    @property
    def weighted(self) -> tuple[Guide, float]:
        """The guide and its share; SettingError, with the guide's name, if it has no directions."""
        try:
            return self.compute(), self.share
        except SettingError as error:
            raise SettingError(f"{self.label}: {error}") from None


@dataclass(frozen=True)
class SurfaceRequest:
    """Asks for a field, a pattern or a quad mesh.

    Attributes
    ----------
    command : "directions", or one of :data:`PATTERNS`
    given : the mesh
    symmetry : "vector", "line" or "cross"
    options : of each solve
    directions : (n, 3) vectors that are used as they are, or None
    guides : for the directions
    turn : radians by which the directions are turned, one or (n,)
    rows : of the constraint list
    mirrors : reflections that leave the field unchanged
    spacing : in scene units
    spacings : the spacing times its map, (n,), or (n, 2) for quads with an aspect, or the spacing alone
    mirror_axes : the axes of the mirrors in the object's space, 0, 1 or 2
    smoothing : of quad meshes, number of smoothing steps
    singularities : share of the disclinations by which the directions adapt to the shape
    branching : share of the dislocations that even spacing needs; None for directions alone
    faces : of quad meshes, their number, whatever the spacing; None for the number that the spacing gives
    loops : of quad meshes, how much energy is given up for short loops, from 0, none, to 1, any
    pins : triangles and the indices of the disclinations wanted there
    start : (n,) radians of directions before they are turned, and (k n,) complex phases along them, from which the
        whole solve starts and near which it stays; None for a search
    strict : whether a result with faults is refused
    """

    command: str
    given: MeshInput
    symmetry: str
    options: Options
    directions: np.ndarray | None
    guides: tuple[PendingGuide, ...]
    turn: float | np.ndarray
    rows: tuple[Row, ...]
    mirrors: tuple[Mirror, ...]
    spacing: float
    spacings: float | np.ndarray
    mirror_axes: tuple[int, ...] = ()
    smoothing: int = 0
    singularities: float = 1.0
    branching: float | None = 1.0
    faces: int | None = None
    loops: float = 0.0
    pins: tuple[tuple[int, float], ...] = ()
    start: tuple[np.ndarray, np.ndarray] | None = None
    strict: bool = False

    @property
    def shared(self) -> tuple[TriangleMesh, TriangleMesh]:
        """The meshes that fields and patterns are on."""
        return self.given.mesh, self.given.uncut

    def solve(self, progress: Callback | None = None) -> "SurfaceResult":
        """The result; Cancelled if the callback answers False, and ContradictionError with vertices of the object."""
        if self.command not in PATTERNS:
            return SurfaceResult(self.directed(progress))
        if self.command == "quad_mesh":
            return solve_quad_mesh(self, progress)
        return self.along(self.directed(portion(progress, 0.0, 0.4)), portion(progress, 0.4, 0.55))

    def solve_showing(
        self, show: Callable[["SurfaceResult"], object], progress: Callback | None = None
    ) -> "SurfaceResult":
        """:meth:`solve` with intermediate results.

        For stripes and quads by the default method, ``show`` is called with a first result after a small part of the
        time, then with each one that is better or has a bound; for a quad mesh, with one draft.
        """
        if self.command == "quad_mesh" and self.options.method == "sdp":
            draft = draft_quad_mesh(self, portion(progress, 0.0, _DRAFT))
            if draft is not None:
                show(draft)
            return self.solve(portion(progress, _DRAFT, 1.0 - _DRAFT))
        if self.command not in SHOWN or self.options.method != "sdp":
            return self.solve(progress)
        quick = replace(self, options=replace(self.options, method=FIRST))
        show(quick.solve(portion(progress, 0.0, 0.05)))
        directions = self.directed(portion(progress, 0.05, 0.35))
        return self.along(directions, portion(progress, 0.4, 0.55), show=show)

    def picture(self, result: "PatternResult") -> "Picture":
        polygons, inverse = self.given.polygons, np.linalg.inv(self.given.stretch)
        vertices = self.given.mesh.vertices @ inverse.T
        places, phases = drawn_phases(result.pattern.on_faces(polygons), polygons, vertices)
        return Picture(places, phases, self.command != "stripes")

    def directed(
        self, progress: Callback | None = None, before: DirectionField | None = None, follower: Follower | None = None
    ) -> DirectionField:
        """The directions, turned by their angle; solved from the field of the previous frame if there is one."""
        mesh, symmetry = self.given.mesh, SYMMETRY_ORDERS[self.symmetry]
        if self.directions is not None:
            return given_directions(mesh, symmetry, self.directions).turned(self.turn)
        start = None if self.start is None else self.start[0]
        with self._renumber_errors():
            guides = tuple(guide.weighted for guide in self.guides)
            wishes = DirectionWishes(guides, self.rows, self.mirrors, self.singularities, self.pins, self._detail)
            field = direction_field(mesh, symmetry, wishes, self.options, progress, before, follower, start)
        if self.command == "quad_mesh":
            field = along_curvature(field)
        return field.turned(self.turn)

    @property
    def _detail(self) -> float:
        """Length over which curvature has to vary to turn the directions of a quad mesh: a share of a quad's side."""
        if self.command != "quad_mesh":
            return 0.0
        mesh = self.given.mesh
        side = np.mean(self.spacings) / 2 if self.faces is None else np.sqrt(mesh.areas.sum() / self.faces)
        return float(DETAIL * side)

    def along(
        self,
        directions: DirectionField,
        progress: Callback | None = None,
        before: _WithPhases | None = None,
        hold: float = 0.0,
        show: Callable[["SurfaceResult"], object] | None = None,
        follower: Follower | None = None,
    ) -> "PatternResult":
        """The result with the pattern along a field; solved from that of the previous frame if there is one.

        ``show`` as of :meth:`solve_showing`.
        """
        growth = TargetOneForm.of(self.given.mesh, directions, self.spacings)
        # Tell the number of dislocations before the solve.
        forced = growth.forced_dislocations
        Monitor(progress).at(f"pattern, {forced:.0f} dislocations asked for", 0.0)
        warnings = self.accept_faults(self._coarse_faults(growth.coarse_share))

        def result(pattern: Pattern) -> "PatternResult":
            return PatternResult(directions, pattern, None, forced, warnings)

        with self._renumber_errors():
            pattern = PATTERNS[self.command](
                self.given.mesh,
                directions,
                self.spacings,
                self.rows,
                self.mirrors,
                self.options,
                progress,
                before=before,
                hold=hold,
                branching=self.branching,
                show=None if show is None else lambda pattern: show(result(pattern)),
                follower=follower,
                start=None if self.start is None else self.start[1],
            )
        return result(pattern)

    def known(self, vectors: np.ndarray, phases: np.ndarray) -> tuple[DirectionField, Pattern]:
        """Directions and pattern of an earlier solution's (n, 3) directions and (k n,) complex phases."""
        mesh, symmetry = self.given.mesh, SYMMETRY_ORDERS[self.symmetry]
        wishes = DirectionWishes((), self.rows, self.mirrors, self.singularities, self.pins, self._detail)
        field = known_directions(mesh, symmetry, vectors, wishes)
        assert self.branching is not None  # there are phases
        return field, known_pattern(mesh, field, self.spacings, phases, self.rows, self.mirrors, self.branching)

    @property
    def has_only_quads(self) -> bool:
        """Whether all faces of the quad mesh become quads."""
        return self.command == "quad_mesh" and self.branching == 0

    def trace(self, pattern: Pattern) -> tuple[QuadMesh, dict[str, float]]:
        """The quad mesh of a pattern's grid lines before finishing, and the seconds; errors as :func:`check_quads`."""
        clock = Clock()
        with clock("extract"):
            quads = quad_mesh(pattern.edge_phases)
            check_quads(quads, self.given.mesh)
        return quads, clock.seconds

    def finish(self, quads: QuadMesh, seconds: dict[str, float]) -> _Finished:
        """The finished mesh of a traced one, and the seconds of tracing and finishing."""
        clock = Clock()
        clock.add(seconds)
        with clock("extract"):
            planes = np.linalg.inv(self.given.stretch)[list(self.mirror_axes)]
            quads = finish_quads(quads, self.given.mesh, self.rows, planes, self.smoothing, self.has_only_quads)
        return {"quads": quads, "seconds": clock.seconds}

    def accept_faults(self, faults: Sequence[str]) -> tuple[str, ...]:
        """Faults of a result as warnings; raises SettingError with the first one if the request is strict."""
        if self.strict and faults:
            raise SettingError(faults[0])
        return tuple(faults)

    def _coarse_faults(self, coarse_share: float) -> tuple[str, ...]:
        if coarse_share <= COARSE_SHARE:
            return ()
        finest = np.min(self.spacings)
        return (
            f"the spacing {finest:g} is finer than the mesh can carry on {coarse_share:.0%} of its edges: "
            f"it needs edges shorter than {finest / 2:.3g}, set the surface to automatic",
        )

    @contextmanager
    def _renumber_errors(self) -> Iterator[None]:
        """Renumber the vertices of errors as vertices of the object, of which those at cuts have copies."""
        try:
            yield
        except ContradictionError as error:
            raise error.renumbered(self.given.source) from None


@dataclass(frozen=True)
class Picture:
    """Triangles to draw.

    Attributes
    ----------
    places : (3 t, 3) float32 corners of the triangles, in the object's space
    phases : (3 t, 2) float32 radians there; the second is 0 for stripes
    of_quads : whether there are two phases
    """

    places: np.ndarray
    phases: np.ndarray
    of_quads: bool


@dataclass(frozen=True)
class SurfaceResult:
    """The result of a :class:`SurfaceRequest`.

    Attributes
    ----------
    field, pattern, quads : as far as the command has them
    forced_dislocations : number of dislocations that exact directions and spacing would need
    warnings : for the user
    seconds : times of parts of the work other than solves, by name
    settled : settings, by name, that replaced the wanted ones
    loops_before : figures of the loops before more of them were closed (:attr:`QuadLoops.figures`)
    """

    field: DirectionField
    pattern: Pattern | None = None
    quads: QuadMesh | None = None
    forced_dislocations: float | None = None
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)
    settled: dict[str, float] = dataclasses.field(default_factory=dict)
    loops_before: dict[str, float] | None = None


@dataclass(frozen=True)
class PatternResult(SurfaceResult):
    """A result with a pattern."""

    pattern: Pattern
