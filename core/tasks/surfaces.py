# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions, stripes, quads and quad meshes on one surface."""

import dataclasses
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, replace

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
from ..geometry.mesh_input import MeshInput
from ..monitor import Monitor, portion
from ..settings.surface import SYMMETRY_ORDERS
from ..solution import FIRST, Clock
from ..solve import Options
from .quad_meshes import draft_quad_mesh, solve_quad_mesh

# What a command solves along its directions; "directions" stops before.
PATTERNS: dict[str, Callable[..., Pattern]] = {
    "stripes": stripe_pattern,
    "quads": quad_pattern,
    "quad_mesh": quad_pattern,
}
# Of these there are pictures on the way.
SHOWN = ("stripes", "quads")
# Share of the work that the draft of a quad mesh is.
_DRAFT = 0.15


@dataclass(frozen=True)
class PendingGuide:
    """A guide whose data has been read and that has still to be computed.

    Attributes
    ----------
    label : what errors call it
    compute : callable without arguments that can be pickled, makes the Guide
    share : how much of its weights counts
    """

    label: str
    compute: Callable[[], Guide]
    share: float

    @property
    def weighted(self):
        """The guide, and the share of its weights that counts.

        Raises
        ------
        SettingError
            naming the guide, when it gives no directions
        """
        try:
            return self.compute(), self.share
        except SettingError as error:
            raise SettingError(f"{self.label}: {error}") from None


@dataclass(frozen=True)
class SurfaceRequest:
    """A field, a pattern or a quad mesh that is asked for.

    Attributes
    ----------
    command : "directions", or one of :data:`PATTERNS`
    given : the mesh
    symmetry : "vector", "line" or "cross"
    options : of each solve
    directions : (n, 3) vectors that are taken exactly as they are, or None
    guides : what the directions follow
    turn : radians by which the directions are turned, one or (n,)
    rows : Rows of the constraint list
    mirrors : reflections that leave the field as it is
    spacing : the spacing, in scene units
    spacings : that times its map, (n,), and for quads with an aspect (n, 2), or the spacing alone
    mirror_axes : the axes of the mirrors in the object's space, 0, 1 or 2
    smoothing : of quad meshes, how often vertices move to where faces are nearer to squares
    singularities : share of the shape's unevenness that the directions answer with disclinations
    branching : share of the dislocations that even spacing asks for; None for directions alone
    faces : of quad meshes, how many there should be, whatever the spacing; None for as many as it gives
    loops : of quad meshes, how much is given up for short loops, from 0, nothing, to 1, any energy
    pins : triangles and the indices of the disclinations that are to be there
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
    def shared(self):
        """The meshes that fields and patterns are on."""
        return self.given.mesh, self.given.uncut

    def solve(self, progress=None):
        """The :class:`SurfaceResult`.

        Raises
        ------
        Cancelled
            when the progress is answered with False
        ContradictionError
            naming vertices of the object
        """
        if self.command not in PATTERNS:
            return SurfaceResult(self.directed(progress))
        if self.command == "quad_mesh":
            return solve_quad_mesh(self, progress)
        return self.along(self.directed(portion(progress, 0.0, 0.4)), portion(progress, 0.4, 0.55))

    def solve_showing(self, show, progress=None):
        """What :meth:`solve` gives, and what there is on the way; errors as there.

        ``show(result)`` is called with a first :class:`SurfaceResult` after a small part of the time, and then with
        each one that is better or whose bound is known; for stripes and quads by the default method. Of a quad mesh it
        is one draft.
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

    def picture(self, result):
        """The :class:`Picture` of a result with a pattern."""
        polygons, inverse = self.given.polygons, np.linalg.inv(self.given.stretch)
        vertices = self.given.mesh.vertices @ inverse.T
        places, phases = drawn_phases(result.pattern.on_faces(polygons), polygons, vertices)
        return Picture(places, phases, self.command != "stripes")

    def directed(self, progress=None, before=None, follower=None):
        """The :class:`DirectionField`, turned by its angle; from the one of the frame before, if there is one."""
        mesh, symmetry = self.given.mesh, SYMMETRY_ORDERS[self.symmetry]
        if self.directions is not None:
            return given_directions(mesh, symmetry, self.directions).turned(self.turn)
        start = None if self.start is None else self.start[0]
        with self._own_vertices():
            guides = tuple(guide.weighted for guide in self.guides)
            wishes = DirectionWishes(guides, self.rows, self.mirrors, self.singularities, self.pins)
            field = direction_field(mesh, symmetry, wishes, self.options, progress, before, follower, start)
        if self.command == "quad_mesh":
            field = along_curvature(field)
        return field.turned(self.turn)

    def along(self, directions, progress=None, before=None, hold=0.0, show=None, follower=None):
        """The :class:`SurfaceResult` of the pattern along a field; from that of the frame before, if there is one.

        ``show`` as of :meth:`solve_showing`.
        """
        growth = TargetOneForm.of(self.given.mesh, directions, self.spacings)
        # What the map asks for is seen before the stripes are there.
        Monitor(progress).at(f"pattern, {growth.forced_dislocations:.0f} dislocations asked for", 0.0)
        warnings = self.refused_faults(self._judged(growth.coarse_share))

        def result(pattern):
            return SurfaceResult(directions, pattern, None, growth.forced_dislocations, warnings)

        with self._own_vertices():
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

    def known(self, vectors, phases):
        """The DirectionField and the Pattern of (n, 3) directions and (k n,) complex phases that were solved for."""
        mesh, symmetry = self.given.mesh, SYMMETRY_ORDERS[self.symmetry]
        wishes = DirectionWishes((), self.rows, self.mirrors, self.singularities, self.pins)
        field = known_directions(mesh, symmetry, vectors, wishes)
        assert self.branching is not None  # there are phases
        return field, known_pattern(mesh, field, self.spacings, phases, self.rows, self.mirrors, self.branching)

    @property
    def has_only_quads(self):
        """Whether other faces are to become quads."""
        return self.command == "quad_mesh" and self.branching == 0

    def trace(self, pattern):
        """The :class:`QuadMesh` of a pattern's grid lines as they are, and the seconds that it took.

        Raises
        ------
        SettingError
            for quads that are too large for a mesh
        """
        clock = Clock()
        with clock("extract"):
            quads = quad_mesh(pattern.edge_phases)
            check_quads(quads, self.given.mesh)
        return quads, clock.seconds

    def finish(self, quads, seconds):
        """A traced quad mesh on its lines and smoothed, and the seconds of both, as fields of a result."""
        clock = Clock()
        clock.add(seconds)
        with clock("extract"):
            inverse = np.linalg.inv(self.given.stretch)
            planes = [inverse[axis] for axis in self.mirror_axes]
            quads = finish_quads(quads, self.given.mesh, self.rows, planes, self.smoothing, self.has_only_quads)
        return {"quads": quads, "seconds": clock.seconds}

    def refused_faults(self, faults):
        """Lines about faults of a result, which are warnings where it need not be without any.

        Raises
        ------
        SettingError
            with the first one
        """
        if self.strict and faults:
            raise SettingError(faults[0])
        return tuple(faults)

    def _judged(self, coarse_share):
        if coarse_share <= COARSE_SHARE:
            return ()
        finest = np.min(self.spacings)
        return (
            f"the spacing {finest:g} is finer than the mesh can carry on {coarse_share:.0%} of its edges: "
            f"it needs edges shorter than {finest / 2:.3g}, set the surface to automatic",
        )

    @contextmanager
    def _own_vertices(self):
        """Errors name vertices of the object, whose second sides at cuts are the same."""
        try:
            yield
        except ContradictionError as error:
            raise error.renumbered(self.given.source) from None


@dataclass(frozen=True)
class Picture:
    """Triangles to draw.

    Attributes
    ----------
    places : (3 t, 3) float32 corners of the triangles one after the other, in the object's space
    phases : (3 t, 2) float32 radians there; of stripes the second is 0
    of_quads : whether there are two
    """

    places: np.ndarray
    phases: np.ndarray
    of_quads: bool


@dataclass(frozen=True)
class SurfaceResult:
    """What was found on a surface.

    Attributes
    ----------
    field : DirectionField
    pattern : Pattern, None after directions alone
    quads : QuadMesh, or None
    forced_dislocations : how many exact directions and spacing ask for, None without a pattern
    warnings : lines that the user should read
    seconds : that parts of the work took which solutions do not tell, by their names
    settled : settings, by their names, with which the result was made in place of those that were asked for
    loops_before : figures of the loops before more of them were closed (:mod:`..extract.quads.measure.loops`)
    """

    field: DirectionField
    pattern: Pattern | None = None
    quads: QuadMesh | None = None
    forced_dislocations: float | None = None
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)
    settled: dict[str, float] = dataclasses.field(default_factory=dict)
    loops_before: dict[str, int] | None = None
