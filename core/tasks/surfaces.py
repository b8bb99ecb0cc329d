# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions, stripes, quads and quad meshes on one surface."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ContradictionError, SettingError
from ..extract.pictures.drawn_phases import drawn_phases
from ..extract.quads.finishing import finish_quads, sound_quads
from ..extract.quads.mirror import MirrorSide, plane_edges
from ..extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from ..fields import (
    DirectionField,
    DirectionWishes,
    Guide,
    Pattern,
    PatternWishes,
    Row,
    direction_field,
    given_directions,
)
from ..fields.constraints.crowded import without_crowded_lines
from ..fields.constraints.features import feature_edges, feature_row
from ..fields.directions import along_curvature, known_directions
from ..fields.mirror import Reflection, Seam
from ..fields.patterns import KnownPattern, known_pattern, next_pattern, solve_pattern
from ..fields.target_one_form import TargetOneForm
from ..geometry import TriangleMesh
from ..geometry.cut import edges_after_cut
from ..geometry.mesh_input import MeshInput
from ..geometry.mirror import mirror_planes
from ..monitor import Callback, Monitor, expect, portion
from ..refinement.spacing import (
    COARSE_SHARE,
    asked_spacings,
    lines_in_period,
    smallest_sides,
    spacing_on_faces,
    wished_spacing,
)
from ..settings.pins import parse_pins
from ..settings.surface import SYMMETRY_ORDERS, SurfaceSettings
from ..solution import GLANCE, Clock
from ..solve import Options
from ..solve.warm_start import Follower
from .glimpse import Picture, glimpse
from .quad_meshes import draft_quad_mesh, solve_quad_mesh
from .surface_result import PatternResult, SurfaceResult
from .surface_source import SurfaceSource

# Commands with a pattern, and those with pictures of intermediate results.
PATTERNS = ("stripes", "quads", "quad_mesh")
SHOWN = ("stripes", "quads")
# Curvature that varies over less than this part of a quad's side does not turn the directions of quad meshes.
DETAIL = 0.5
# Share of the work for the draft of a quad mesh.
_DRAFT = 0.15


class _Finished(TypedDict):
    """Fields of a :class:`SurfaceResult`."""

    quads: QuadMesh
    seconds: dict[str, float]


@dataclass(frozen=True)
class SurfaceRequest:
    """Asks for a field, a pattern or a quad mesh; :meth:`of` derives all that follows from source and settings.

    Attributes
    ----------
    command : "directions", or one of :data:`PATTERNS`
    source : what was read
    settings : for the command
    options : of each solve
    spacing : in scene units
    spacings : the spacing times its map, (n,), or (n, 2) for quads with an aspect, or the spacing alone
    rows : of the constraint list, and of features
    mirrors : reflections that leave the field unchanged
    pins : triangles and the indices of the disclinations wanted there
    detail : part of a quad's side over which curvature has to vary to turn the directions of a quad mesh
    start : (n,) radians of directions before they are turned, and (k n,) complex phases along them, from which the
        whole solve starts and near which it stays; None for a search
    closes_tunnels : whether quads may be too large for handles, which are then closed
    """

    command: str
    source: SurfaceSource
    settings: SurfaceSettings
    options: Options
    spacing: float
    spacings: float | np.ndarray
    rows: tuple[Row, ...]
    mirrors: tuple[Reflection, ...]
    pins: tuple[tuple[int, float], ...] = ()
    detail: float = DETAIL
    start: tuple[np.ndarray, np.ndarray] | None = None
    closes_tunnels: bool = False

    @classmethod
    def of(cls, command: str, source: SurfaceSource, settings: SurfaceSettings) -> "SurfaceRequest":
        """The request of settings as of :meth:`SurfaceSettings.for_command`; SettingError for what cannot be."""
        given, spacing, lines = source.given, settings.spacing, lines_in_period(command)
        mesh = given.mesh
        if spacing is None:
            # A mesh that was made for the spacing is as fine as that needs.
            spacing = wished_spacing(mesh.areas.sum(), lines) if source.is_fitted else spacing_on_faces(mesh, lines)
        spacing, spacings = asked_spacings(command, mesh, settings, spacing, source.factors)
        rows = source.rows
        if command == "quad_mesh":
            rows += _feature_rows(given, settings, smallest_sides(mesh, spacings), source.sharp)
        mirrors: tuple[Reflection, ...] = source.mirrors(settings.mirror)
        if given.seam is not None:
            mirrors += (Seam.of(mesh, given.seam, rows),)
        request = cls(command, source, settings, Options.of(settings), spacing, spacings, rows, mirrors)
        return request.with_pins(parse_pins(settings.pins or ""))

    def with_pins(self, pins: Mapping[int, int]) -> "SurfaceRequest":
        """The request with other pins, turns by face; SettingError for a face that does not exist."""
        polygons, order = self.given.polygons, SYMMETRY_ORDERS[self.settings.symmetry]
        for face in pins:
            if not (0 <= face < len(polygons.starts) and polygons.drawn[face]):
                raise SettingError(f"there is no face {face} to pin: clear the pins, or pin again")
        pinned = [(int(polygons.first_triangles[face]), turns / order) for face, turns in pins.items()]
        return replace(self, pins=tuple(pinned))

    def smoothed(self, rounds: int) -> "SurfaceRequest":
        """The request with another number of smoothing steps of quad meshes."""
        return replace(self, settings=replace(self.settings, smoothing=rounds))

    def uncrowded(self, spacing: float) -> "SurfaceRequest":
        """The request without the sharp edges that leave no room for quads of a spacing between them and others."""
        mesh = self.given.mesh
        sides = smallest_sides(mesh, spacing / self.spacing * np.asarray(self.spacings))
        rows = _feature_rows(self.given, self.settings, sides, self.source.sharp, is_uncrowded=True)
        return replace(self, rows=self.source.rows + rows)

    def on_source(self, source: SurfaceSource, spacings: float | np.ndarray) -> "SurfaceRequest":
        """The request with the same settings on another mesh, with its sharp edges as constraints."""
        sides = smallest_sides(source.given.mesh, spacings)
        rows = _feature_rows(source.given, self.settings, sides, source.sharp)
        return replace(self, source=source, spacings=spacings, rows=source.rows + rows)

    def on_mesh(self, given: MeshInput) -> "SurfaceRequest":
        """The request on the same mesh in another object, or with other polygons."""
        return replace(self, source=replace(self.source, given=given))

    @property
    def given(self) -> MeshInput:
        """The mesh."""
        return self.source.given

    @property
    def turn(self) -> float | np.ndarray:
        """Radians by which the directions are turned, one or (n,)."""
        return self.settings.angle + self.source.turns

    @property
    def shared(self) -> tuple[TriangleMesh, TriangleMesh]:
        """The meshes that fields and patterns are on."""
        return self.given.mesh, self.given.uncut

    def solve(self, progress: Callback | None = None) -> "SurfaceResult":
        """The result; Cancelled if the callback answers False, and ContradictionError with vertices of the object."""
        expect(progress, self.source.seconds(self.command, self.settings))
        if self.command not in PATTERNS:
            return SurfaceResult(self.directed(progress))
        if self.command == "quad_mesh":
            return solve_quad_mesh(self, progress)
        return self.along(self.directed(portion(progress, 0.0, 0.4)), portion(progress, 0.4, 0.55))

    def solve_showing(
        self, show: Callable[["SurfaceResult | Picture"], object], progress: Callback | None = None
    ) -> "SurfaceResult":
        """:meth:`solve` with intermediate results.

        By the default method, ``show`` is called for stripes and quads with a first result after a small part of the
        time, then with each one that is better or has a bound; for a quad mesh with one draft. On fine meshes it is
        called first with the picture of a :func:`.glimpse.glimpse`.
        """
        expect(progress, self.source.seconds(self.command, self.settings))
        if self.command not in PATTERNS or self.options.method != "sdp":
            return self.solve(progress)
        early = glimpse(self)
        if early is not None:
            show(early)
        if self.command == "quad_mesh":
            draft = draft_quad_mesh(self, portion(progress, 0.0, _DRAFT))
            if draft is not None:
                show(draft)
            return self.solve(portion(progress, _DRAFT, 1.0 - _DRAFT))
        quick = replace(self, options=replace(self.options, method=GLANCE))
        show(quick.solve(portion(progress, 0.0, 0.05)))
        directions = self.directed(portion(progress, 0.05, 0.35))
        return self.along(directions, portion(progress, 0.4, 0.55), show=show)

    def picture(self, result: "PatternResult | Picture") -> "Picture":
        """What to draw of something shown."""
        if isinstance(result, Picture):
            return result
        polygons, inverse = self.given.polygons, np.linalg.inv(self.given.stretch)
        vertices = self.given.mesh.vertices @ inverse.T
        places, phases = drawn_phases(result.pattern.on_faces(polygons), polygons, vertices)
        return Picture(places, phases, self.command != "stripes")

    def directed(
        self, progress: Callback | None = None, before: DirectionField | None = None, follower: Follower | None = None
    ) -> DirectionField:
        """The directions, turned by their angle; solved from the field of the previous frame if there is one."""
        mesh, symmetry = self.given.mesh, SYMMETRY_ORDERS[self.settings.symmetry]
        if self.source.directions is not None:
            return given_directions(mesh, symmetry, self.source.directions).turned(self.turn)
        start = None if self.start is None else self.start[0]
        with self._renumber_errors():
            wishes = self._direction_wishes(tuple(guide.weighted(self.side) for guide in self.source.guides))
            field: DirectionField = direction_field(
                mesh, symmetry, wishes, self.options, progress, before, follower, start
            )
        if self.command == "quad_mesh":
            field = along_curvature(field)
        return field.turned(self.turn)

    @property
    def _detail(self) -> float:
        """Length over which curvature has to vary to turn the directions of a quad mesh."""
        return self.detail * self.side

    @property
    def side(self) -> float:
        """The side of a quad of a quad mesh, 0 for other patterns."""
        if self.command != "quad_mesh":
            return 0.0
        faces = self.settings.faces
        return float(np.sqrt(self.given.mesh.areas.sum() / faces) if faces else np.mean(self.spacings) / 2)

    def along(
        self,
        directions: DirectionField,
        progress: Callback | None = None,
        show: Callable[["SurfaceResult"], object] | None = None,
    ) -> "PatternResult":
        """The result with the pattern along a field; ``show`` as of :meth:`solve_showing`."""
        result, wishes = self._pose(directions, progress)
        start = None if self.start is None else self.start[1]
        shows = None if show is None else lambda pattern: show(result(pattern))
        mesh = self.given.mesh
        with self._renumber_errors():
            return result(solve_pattern(mesh, directions, wishes, self.options, progress, start, shows))

    def next_along(
        self,
        directions: DirectionField,
        before: np.ndarray,
        progress: Callback | None = None,
        hold: float = 0.0,
        follower: Follower | None = None,
    ) -> "PatternResult":
        """The result with the pattern along a field, from the (k n,) phases before (see :func:`next_pattern`)."""
        (result, wishes), mesh = self._pose(directions, progress), self.given.mesh
        with self._renumber_errors():
            return result(next_pattern(mesh, directions, wishes, before, self.options, progress, hold, follower))

    def _pose(
        self, directions: DirectionField, progress: Callback | None
    ) -> tuple[Callable[[Pattern], "PatternResult"], PatternWishes]:
        """A function that makes the result of a pattern along a field, and what is asked of the pattern.

        The progress line shows the number of dislocations, and faults are found, before the solve.
        """
        one_form = TargetOneForm.of(self.given.mesh, directions, self.spacings)
        forced = one_form.forced_dislocations
        Monitor(progress).at(f"pattern, {forced:.0f} dislocations asked for", 0.0)
        warnings = self.accept_faults(self._coarse_faults(one_form.coarse_share))
        wishes = replace(self._pattern_wishes, one_form=one_form)
        return lambda pattern: PatternResult(directions, pattern, None, forced, warnings), wishes

    def known(self, vectors: np.ndarray, phases: np.ndarray) -> tuple[DirectionField, KnownPattern]:
        """Directions and pattern of an earlier solution's (n, 3) directions and (k n,) complex phases."""
        mesh, symmetry = self.given.mesh, SYMMETRY_ORDERS[self.settings.symmetry]
        field = known_directions(mesh, symmetry, vectors, self._direction_wishes(()))
        return field, known_pattern(mesh, field, self._pattern_wishes, phases)

    def _direction_wishes(self, guides: tuple[tuple[Guide, float], ...]) -> DirectionWishes:
        singularities = self.settings.singularities
        assert singularities is not None  # SurfaceSettings.for_command sets it
        return DirectionWishes(guides, self.rows, self.mirrors, singularities, self.pins, self._detail)

    @property
    def _pattern_wishes(self) -> PatternWishes:
        assert self.settings.branching is not None  # as above
        return PatternWishes(self.spacings, self.rows, self.mirrors, self.settings.branching)

    @property
    def has_only_quads(self) -> bool:
        """Whether all faces of the quad mesh become quads."""
        return self.command == "quad_mesh" and self.settings.branching == 0

    @cached_property
    def mirror_side(self) -> MirrorSide | None:
        """The part of the surface on which mirrored quad meshes are made; None for the whole of it."""
        return None if self.given.seam is not None else MirrorSide.of(self.given.mesh, self.mirror_planes)

    @property
    def mirror_planes(self) -> np.ndarray:
        """(k, 3) unit normals of the planes through the origin in which the pattern is mirrored."""
        return mirror_planes(self.given.stretch, self.settings.mirror)

    def trace(self, pattern: Pattern) -> tuple[QuadMesh, dict[str, float]]:
        """The quad mesh of a pattern's grid lines before finishing, and the seconds; errors as :func:`sound_quads`.

        It is on :attr:`mirror_side`.
        """
        clock, side = Clock(), self.mirror_side
        with clock("extract"):
            quads = quad_mesh(pattern.edge_phases) if side is None else side.trace(pattern.edge_phases)
            quads = sound_quads(quads, self.given.mesh if side is None else side.mesh, self.closes_tunnels)
        return quads, clock.seconds

    def finish(
        self,
        quads: QuadMesh,
        seconds: dict[str, float],
        wanted: float = 0,
        later: list[Callable[[], QuadMesh]] | None = None,
    ) -> _Finished:
        """The finished mesh of a traced one, and the seconds of tracing and finishing; ``wanted`` and ``later`` as of
        :func:`finish_quads`, the latter without mirror planes only."""
        clock, side = Clock(), self.mirror_side
        clock.add(seconds)
        with clock("extract"):
            rules = self.rows, self.settings.smoothing, self.has_only_quads, self.closes_tunnels
            if side is None:
                quads = finish_quads(quads, self.given.mesh, *rules, wanted=wanted, later=later)
            else:
                quads = side.finish(quads, *rules, wanted)
        return {"quads": quads, "seconds": clock.seconds}

    def accept_faults(self, faults: Sequence[str]) -> tuple[str, ...]:
        """Faults of a result as warnings; raises SettingError with the first one if the request is strict."""
        if self.settings.strict and faults:
            raise SettingError(faults[0])
        return tuple(faults)

    def _coarse_faults(self, coarse_share: float) -> tuple[str, ...]:
        # The spacing of a quad mesh differs a little from the one that its surface was made for.
        if coarse_share <= COARSE_SHARE or (self.command == "quad_mesh" and self.source.is_fitted):
            return ()
        finest = np.min(self.spacings)
        remedy = "set the surface to automatic" if self.settings.surface == "faces" else "subdivide it, or solve again"
        return (
            f"the spacing {finest:g} is finer than the mesh can carry on {coarse_share:.0%} of its edges: "
            f"it needs edges shorter than {finest / 2:.3g}, {remedy}",
        )

    @contextmanager
    def _renumber_errors(self) -> Iterator[None]:
        """Renumber the vertices of errors as vertices of the object, of which those at cuts have copies."""
        try:
            yield
        except ContradictionError as error:
            raise error.renumbered(self.given.source) from None


def _feature_rows(
    given: MeshInput, settings: SurfaceSettings, sides: np.ndarray, sharp: ArrayLike, is_uncrowded: bool = False
) -> tuple[Row, ...]:
    """The row for the boundary, the sharp edges of the uncut mesh, and mirror planes; empty without such edges.

    Edges between two faces at more than the angle of ``features``, and those in ``sharp``, are sharp, unless the angle
    is 0; ``sides`` are the (n,) lengths of a quad's side at each vertex, a few of which make a feature. Without
    crowded lines, those are left out that run beside others.
    """
    uncut, edges = given.uncut, np.empty(0, int)
    if settings.features > 0:
        sides = sides[: uncut.vertex_count]
        edges = feature_edges(uncut, settings.features, sides, sharp, given.polygons.triangle_faces)
        edges = without_crowded_lines(uncut, edges, sides) if is_uncrowded else edges
        edges = edges_after_cut(uncut, given.mesh, edges)
    if settings.mirror:
        edges = np.union1d(edges, plane_edges(given.mesh, mirror_planes(given.stretch, settings.mirror)))
    return (feature_row(given.mesh, edges),) if len(edges) else ()
