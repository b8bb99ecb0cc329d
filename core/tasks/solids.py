# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in the solid that a closed surface encloses (paper, Section 3.4)."""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import SettingError
from ..extract.layers.crossings import refuse_too_many_layers
from ..extract.layers.defect_curves import CurveEnd, DefectCurve, curve_ends, defect_curves
from ..extract.layers.surfaces import LayerSurfaces, layer_surfaces
from ..fields.filled_surface import FilledSurface
from ..fields.guidance.solids import extend_directions, have_directions
from ..fields.layers import LayerGroup, LayerPattern, SolidTargetOneForm, choose_levels
from ..fields.limits import ENOUGH, Limits, solve_within
from ..fields.surface_phases import SurfacePhases, surface_phases
from ..geometry import TriangleMesh
from ..geometry.filling.closed_surface import Area, ClosedSurface
from ..geometry.filling.lengths import MOST_TETS, Estimate, Lengths, Measures
from ..geometry.filling.stuffing import estimated_tets
from ..geometry.filling.thin_walls import MOST, SHARE, Filling
from ..geometry.tet_mesh import TetMesh
from ..interpolate import TURN
from ..memory import check_memory
from ..monitor import Callback, Monitor, expect, portion
from ..printing.flush import FAR, far_share
from ..refinement.spacing import COARSE_SHARE
from ..solution import Clock
from ..solve import Options
from .solid_memory import LayerMemory, is_searched, layer_memory

# Shares that are warned of: of the surface's volume that the solid lacks, of an area that it covers, if less, of its
# volume where the guide has no direction, and of the volume of thin walls where tetrahedra are too large.
LOST_VOLUME, COVERED, CONTINUED, COARSE_WALLS = 0.1, 0.95, 0.1, 0.01
# Approximate seconds for each tetrahedron, on one core.
TET_SECONDS = 4e-5
# Where the parts of the work begin, as shares of it.
_GUIDANCE, _PHASES, _SURFACES = 0.15, 0.25, 0.9


@dataclass(frozen=True)
class SolidGuide:
    """What layers follow: its name in errors, and a function that can be pickled (:mod:`..fields.guidance.filled`),
    whose result are (n, 3) vectors at the solid's vertices; ``is_axis`` says that these are all the same."""

    label: str
    compute: Callable[[FilledSurface], np.ndarray]
    is_axis: bool = False

    def directions(self, filled: FilledSurface) -> tuple[np.ndarray, float]:
        """(n, 3) unit vectors at the solid's vertices, and the share of its volume where they continue those around."""
        try:
            vectors = self.compute(filled)
        except SettingError as error:
            raise SettingError(f"{self.label}: {error}") from None
        solid, own = filled.solid, have_directions(filled.solid, vectors)
        return extend_directions(solid, vectors), float(solid.vertex_masses[~own].sum() / solid.vertex_masses.sum())


@dataclass(frozen=True)
class FlushArea:
    """An area of the surface that layers are flush with: on it the phase is constant.

    Attributes
    ----------
    phase : radians, 0 for a layer on the area; None leaves one phase for each piece of the area to the solver
    """

    area: Area
    phase: float | None


@dataclass(frozen=True)
class SolidRequest:
    """Layers to solve for.

    Attributes
    ----------
    solid : the given solid whose boundary is the surface; None for one that fills it
    factors : (n,) at the surface's vertices, by which the spacing is multiplied; None for 1
    branching : share of the target one-form's curl that is kept (:func:`core.fields.layers.layer_problem`)
    limits : of the distance of layers, in scene units
    by_level : number levels instead of connected pieces
    """

    surface: ClosedSurface
    solid: TetMesh | None
    guide: SolidGuide
    flush_areas: tuple[FlushArea, ...]
    lengths: Lengths
    factors: np.ndarray | None
    options: Options
    branching: float = 1.0
    limits: Limits = dataclasses.field(default_factory=Limits)
    by_level: bool = False

    @property
    def shared(self) -> tuple[TriangleMesh | TetMesh, ...]:
        """The surface's mesh, and the solid where it was given."""
        return (self.surface.mesh,) if self.solid is None else (self.surface.mesh, self.solid)

    def solve(self, progress: Callback | None = None) -> "SolidResult":
        """Fill the surface, solve and extract; Cancelled when ``progress`` returns False, SynchError for everything
        else, insufficient memory included."""
        monitor, clock = Monitor(progress), Clock()
        tets = self.estimate.tets
        _check_memory(self.memory, tets)
        expect(progress, TET_SECONDS * tets)
        monitor.at("filling the surface", 0.0)
        with clock("fill"):
            solid, coarse = monitor.during(self._fill)
        if solid.tet_count > tets:  # thin walls have smaller ones than was estimated
            _check_memory(self._memory_in(solid.tet_count), solid.tet_count)
        filled = FilledSurface(self.surface, solid)
        monitor.at("guidance", _GUIDANCE)
        with clock("build"):
            directions, continued, spacings, groups = monitor.during(lambda: self._follow_guide(filled))
            divisions = self.lengths.divisions
            one_form = SolidTargetOneForm.of(solid, directions, divisions * spacings)
            refuse_too_many_layers(divisions * one_form.changes)
            groups = choose_levels(one_form, groups, divisions)
        solving = portion(progress, _PHASES, _SURFACES - _PHASES)
        limits = Limits(divisions * self.limits.smallest, divisions * self.limits.largest)
        pattern, one_form = solve_within(one_form, limits, groups, self.options, solving, self.branching)
        outside = limits.outside_share(pattern)
        pattern, one_form = pattern.divided(divisions).start_half_a_layer_up(groups), one_form.divided(divisions)
        monitor.at("layers", _SURFACES)
        with clock("extract"):
            surfaces = monitor.during(
                lambda: layer_surfaces(pattern.edge_phases, pattern.heights, by_level=self.by_level)
            )
            if surfaces.count == 0:
                raise SettingError(_no_layer(self.lengths.spacing * float(np.ptp(pattern.heights)) / TURN))
            curves = tuple(defect_curves(solid, pattern.face_numbers))
            ends = curve_ends(solid, surfaces, curves)
            phases = monitor.during(lambda: surface_phases(self.surface.mesh, pattern, one_form))
            far = monitor.during(lambda: self._far_shares(surfaces))
        warnings = (
            *self._about_loss(solid),
            *self._about_holes(solid),
            *self._about_walls(coarse),
            *self._about_rims(filled, groups),
            *self._about_far(far),
            *self._about_directions(continued),
            *self._about_limits(outside),
            *_about_edges(one_form, divisions),
            *_about_divisions(divisions, curves),
        )
        return SolidResult(pattern, surfaces, curves, ends, phases, outside, continued, far, warnings, clock.seconds)

    @property
    def estimate(self) -> Estimate:
        """The :class:`Estimate` of the solid and its solve, with a proof where one is tried."""
        distance, size = self.surface.distance, self.lengths.size
        tets = estimated_tets(distance.volume, size, distance.area) if self.solid is None else self.solid.tet_count
        return Estimate(size, tets, self.memory.expected)

    @property
    def memory(self) -> LayerMemory:
        """Memory that the solve takes, without the further tetrahedra in thin walls, which are counted once made."""
        return self._memory_in(None if self.solid is None else self.solid.tet_count)

    def _memory_in(self, tets: int | None) -> LayerMemory:
        """Memory that the solve takes in ``tets`` tetrahedra; None for the estimated number."""
        searched = is_searched(self.guide.is_axis, self.factors is None, len(self.flush_areas))
        mesh = self.surface.distance.mesh
        return layer_memory(Measures.of(mesh.vertices, mesh.triangles), self.lengths, searched, tets)

    def _fill(self) -> Filling:
        if self.solid is not None:
            return Filling(self.solid)
        return self.surface.filled(self.lengths.size, [flush.area for flush in self.flush_areas])

    def _follow_guide(self, filled: FilledSurface) -> tuple[np.ndarray, float, float | np.ndarray, list[LayerGroup]]:
        """Directions at the solid's vertices, the share of them that is extrapolated, spacings, and groups."""
        directions, continued = self.guide.directions(filled)
        spacings: float | np.ndarray = self.lengths.spacing
        if self.factors is not None:
            spacings = self.limits.clipped(spacings * filled.inside(self.factors))
        return directions, continued, spacings, [filled.group_on(flush.area, flush.phase) for flush in self.flush_areas]

    def _far_shares(self, surfaces: LayerSurfaces) -> dict[str, float]:
        """By their names, the share of each area that should carry a layer which is far from all layers."""
        mesh, spacing = self.surface.mesh, self.lengths.spacing
        held = [flush.area for flush in self.flush_areas if flush.phase == 0]
        return {area.name: far_share(mesh, area.triangles, surfaces, spacing) for area in held}

    def _about_loss(self, solid: TetMesh) -> Iterator[str]:
        lost = self.surface.lost_share(solid)
        if lost > LOST_VOLUME:
            yield (
                f"the solid lacks {lost:.0%} of the surface's volume: what is thinner than {self.lengths.size:.3g} is "
                "lost, reduce the size of its tetrahedra"
            )

    def _about_holes(self, solid: TetMesh) -> Iterator[str]:
        more = self.surface.more_holes(solid)
        if more:
            number = f"{abs(more)} hole" + "s" * (abs(more) > 1)
            has = f"has {number} that the surface has not, where it closes narrow gaps"
            lacks = f"lacks {number} of the surface, too narrow for it"
            yield f"the solid {has if more > 0 else lacks}: reduce the size of its tetrahedra, {self.lengths.size:.3g}"

    def _about_walls(self, coarse: float) -> Iterator[str]:
        if coarse > COARSE_WALLS:
            yield (
                f"in {coarse:.0%} of the thin walls between groups, tetrahedra are longer than {SHARE:.0%} of the "
                f"thickness: smaller ones would be more than {MOST:g} times as many, or than {MOST_TETS:,}; reduce the "
                f"size of the tetrahedra, {self.lengths.size:.3g}"
            )

    def _about_far(self, far: dict[str, float]) -> Iterator[str]:
        for name, share in far.items():
            if share > 1 - COVERED:
                yield (
                    f"{share:.0%} of {name} is farther than {FAR:g} spacings from the layers: reduce the size of the "
                    f"tetrahedra, {self.lengths.size:.3g}"
                )

    def _about_directions(self, continued: float) -> Iterator[str]:
        if continued > CONTINUED:
            yield (
                f"{self.guide.label} has no direction of its own in {continued:.0%} of the solid, where those around "
                f"go on: reduce the size of its tetrahedra, {self.lengths.size:.3g}"
            )

    def _about_limits(self, outside: float) -> Iterator[str]:
        if outside > ENOUGH:
            yield (
                f"in {outside:.1%} of the solid layers end, or are not between {self.limits} high: give limits that "
                "are farther apart, or another spacing"
            )

    def _about_rims(self, filled: FilledSurface, groups: Sequence[LayerGroup]) -> Iterator[str]:
        for flush, group in zip(self.flush_areas, groups, strict=True):
            covered = filled.covered_share(flush.area, group.triangles)
            if covered < COVERED:
                yield (
                    f"the solid's triangles cover {covered:.0%} of {flush.area.name}, where they do not cut off its "
                    f"rim: reduce the size of its tetrahedra, {self.lengths.size:.3g}"
                )


@dataclass(frozen=True)
class SolidResult:
    """Layers of a solid.

    Attributes
    ----------
    pattern : its mesh is the solid in scene units, along the object's axes
    surfaces, curves, ends : in the solid's space
    outside : share of the volume in which layers end or their distance is outside the limits, 0 without limits
    continued : share of the volume in which the guide has no direction
    far : by its name, the share of each area that should carry a layer which is far from all layers
    warnings : lines that the user should read
    seconds : of the parts of the work, by their names
    """

    pattern: LayerPattern
    surfaces: LayerSurfaces
    curves: tuple[DefectCurve, ...]
    ends: tuple[CurveEnd, ...]
    phases: SurfacePhases
    outside: float = 0.0
    continued: float = 0.0
    far: dict[str, float] = dataclasses.field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    seconds: dict[str, float] = dataclasses.field(default_factory=dict)

    @property
    def solid(self) -> TetMesh:
        return self.pattern.mesh


def _check_memory(memory: LayerMemory, tets: int) -> None:
    check_memory(memory.needed, f"a solve of layers in {tets:,} tetrahedra")


def _about_edges(one_form: SolidTargetOneForm, divisions: int) -> Iterator[str]:
    coarse = float((np.abs(one_form.changes) > np.pi * divisions).mean())
    if coarse > COARSE_SHARE:
        yield (
            f"the spacing is finer than the solid can carry on {coarse:.0%} of its edges: "
            "increase it, or make the solid of smaller tetrahedra"
        )


def _about_divisions(divisions: int, curves: Sequence[DefectCurve]) -> Iterator[str]:
    if divisions > 1 and curves:
        yield (
            f"the phase is solved for {divisions} layers together, which end together at dislocation curves: give "
            "smaller tetrahedra, a larger spacing, or fewer divisions"
        )


def _no_layer(depth: float) -> str:
    if depth > 0:
        return f"no layer lies in the solid, which is about {depth:.2g} deep for them: give a spacing below that"
    return "no layer lies in the solid, whose phase is the same everywhere: change the guidance or the groups"
