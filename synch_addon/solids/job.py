# SPDX-License-Identifier: GPL-3.0-or-later
"""One run of layers in a solid: read the object, fill it and solve, write objects (paper, Section 3.4)."""

import time
from dataclasses import asdict
from typing import NamedTuple

import bpy
import numpy as np

from ...core.errors import SettingError, SynchError
from ...core.extract.defect_curves import defect_curves
from ...core.extract.layer_surfaces import layer_surfaces
from ...core.fields.layers import SolidGrowth, solve_layers
from ...core.geometry.tet_mesh import TetMesh
from ...core.interpolate import TURN
from ...core.monitor import Monitor, portion
from ...core.solve.solution import Clock
from ...core.tasks.surfaces import COARSE_SHARE
from ..blender import meshes
from ..blender.vertex_maps import read_factors
from ..patterns.reading import LINES_ACROSS
from . import memory, objects
from .carried import Carried
from .guides import read_area, read_guide
from .phases import surface_phases
from .report import layer_report
from .settings import HELD
from .surface import LOST_VOLUME, Layering, estimate, read_surface, refuse_size

# Edges of the solid to a layer: where one of spacing and size follows from the other, and at least.
EDGES_PER_LAYER = 3.0
FEWEST_EDGES = 2.0
# How far the boundary of a given solid may be from the object's surface, as a share of its size.
_FITTING = 1e-3
# Groups of which the solid covers less are told about.
COVERED = 0.95
# Where the parts of the work begin, as shares of it.
_GUIDANCE, _PHASES, _SURFACES = 0.15, 0.25, 0.9


class Lengths(NamedTuple):
    """Distance between layers and longest edge of the tetrahedra, in scene units."""

    spacing: float
    size: float


class LayerJob:
    """One run in three steps, of which only the middle one takes long and touches no Blender data.

    Parameters
    ----------
    obj : bpy.types.Object
    settings : LayerSettings
    solid : TetMesh in the object's space whose boundary is its surface, None to fill the surface
    """

    def __init__(self, obj, settings, solid=None):
        self._clock, self.warnings, self.settings = Clock(), [], settings
        self._start = time.perf_counter()
        bpy.context.view_layer.update()  # a script may have scaled the object just now
        with meshes.object_mode(obj), self._clock("read"):
            self._surface = read_surface(obj)
            given = self._surface.given
            self._solid = None if solid is None else _fitting(obj, self._surface, solid)
            self._guide = read_guide(obj, self._surface, settings.guide)
            self._areas = [(row, read_area(obj, self._surface, row.group)) for row in settings.flush]
            self._factors = None
            if settings.spacing_map:
                self._factors = read_factors(obj, given, settings.spacing_map, settings.spacing_range)
            self.lengths = self._checked_lengths()
            users = obj.data.users - obj.data.use_fake_user
            if users > 1:
                self.warn(f"the mesh {obj.data.name} is shared by {users} users, which all get the phase")
            changing = [m.name for m in obj.modifiers if m.show_viewport]
            if changing:
                self.warn(
                    f"layers are solved in the mesh before its modifiers ({', '.join(changing)}): apply them first"
                )

    def warn(self, line):
        """Add a line that the user should read although the run succeeds."""
        self.warnings.append(line)

    def _checked_lengths(self):
        distance, settings = self._surface.distance, self.settings
        lowest = 1.0 if self._factors is None else float(self._factors.min())
        if self._solid is not None:
            lengths = _automatic(settings.spacing, float(np.median(self._solid.edge_lengths)), distance, lowest)
        elif settings.size is not None:
            lengths = _automatic(settings.spacing, settings.size, distance, lowest)
        else:
            size = estimate(distance).size
            if settings.spacing is not None:
                size = min(size, settings.spacing * lowest / EDGES_PER_LAYER)
            lengths = _automatic(settings.spacing, size, distance, lowest)
        if lengths.spacing > self._surface.reach:
            raise SettingError(
                f"the spacing {lengths.spacing:g} is larger than the object ({self._surface.reach:g}): "
                "no layer would fit, reduce it"
            )
        if self._solid is None and lengths.spacing * lowest < FEWEST_EDGES * lengths.size:
            finest = lengths.spacing * lowest
            raise SettingError(
                f"the spacing {finest:g} is finer than tetrahedra of size {lengths.size:g} can carry: give a size of "
                f"{finest / EDGES_PER_LAYER:.3g}, or a spacing from {FEWEST_EDGES * lengths.size / lowest:.3g} on"
            )
        if self._solid is None:
            refuse_size(distance, lengths.size)
        return lengths

    def solve(self, callback=None):
        """Fill the surface and solve on arrays alone.

        Parameters
        ----------
        callback : callable(stage, fraction) -> bool, optional; False cancels

        Raises
        ------
        Cancelled
            when the callback returns False
        SynchError
            with one line that says what is wrong and the remedy
        """
        monitor, clock, surface = Monitor(callback), self._clock, self._surface
        monitor.at("filling the surface", 0.0)
        with clock("fill"):
            solid = self._solid
            if solid is None:
                solid = monitor.during(lambda: surface.filled(self.lengths.size, self._labels))
        self._warn_about_loss(solid)
        monitor.at("guidance", _GUIDANCE)
        with clock("build"):
            directions, spacings, groups = monitor.during(lambda: self._asked(Carried(surface, solid)))
            growth = SolidGrowth.of(solid, directions, spacings)
        if growth.coarse_share > COARSE_SHARE:
            self.warn(
                f"the spacing is finer than the solid can carry on {growth.coarse_share:.0%} of its edges: "
                "increase it, or make the solid of smaller tetrahedra"
            )
        solving = portion(callback, _PHASES, _SURFACES - _PHASES)
        pattern = solve_layers(solid, directions, spacings, groups, self.settings.options, solving)
        monitor.at("layers", _SURFACES)
        with clock("extract"):
            surfaces = monitor.during(lambda: layer_surfaces(pattern.edge_phases, pattern.heights))
            if surfaces.count == 0:
                raise SettingError(_no_layer(self.lengths.spacing * float(np.ptp(pattern.heights)) / TURN))
            curves = tuple(defect_curves(solid, pattern.face_numbers))
            self._phases = monitor.during(lambda: surface_phases(surface.mesh, pattern, growth))
        self._found = solid, pattern, surfaces, curves

    @property
    def _labels(self):
        """(m,) of the surface's triangles: which groups each lies in."""
        labels = np.zeros(self._surface.mesh.triangle_count, int)
        for number, (_, area) in enumerate(self._areas):
            labels[area.triangles] += 1 << number
        return labels

    def _asked(self, carried):
        """Directions, spacings and groups on the solid."""
        try:
            directions = self._guide(carried)
        except SettingError as error:
            raise SettingError(f"{self.settings.guidance}: {error}") from None
        spacings = self.lengths.spacing
        if self._factors is not None:
            spacings = spacings * carried.inside(self._factors)
        groups = []
        for row, area in self._areas:
            groups.append(carried.group_on(area, 0.0 if row.wish == HELD else None))
            self._warn_about_rim(area, carried.covered_share(area, groups[-1].triangles))
        return directions, spacings, groups

    def _warn_about_rim(self, area, covered):
        if covered < COVERED:
            finer = self.lengths.size * (1 - COVERED) / (1 - covered)
            self.warn(
                f"the solid's triangles cover {covered:.0%} of {area.name}, where they do not cut off its rim: "
                f"tetrahedra of a size of about {finer:.2g} would do"
            )

    def _warn_about_loss(self, solid):
        lost = self._surface.lost_share(solid)
        if lost > LOST_VOLUME:
            self.warn(
                f"the solid lacks {lost:.0%} of the surface's volume: what is thinner than {self.lengths.size:.3g} is "
                "lost, reduce the size of its tetrahedra"
            )

    def write(self, obj):
        """Write the result at once; returns the report."""
        with meshes.object_mode(obj):
            return self._write(obj)

    def _write(self, obj):
        given = self._surface.given
        if not meshes.is_unchanged(obj, given):
            raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
        objects.leave_modes(obj)
        spacing = self.lengths.spacing
        layering = Layering(*self._found, memory.solid_matrix(obj, given))
        with self._clock("write"):
            shown = objects.write_surface(obj, layering, given, self._phases, self.warn, spacing)
            curves = objects.write_curves(obj, layering, spacing)
            made = objects.write_layers(obj, layering, spacing)
            objects.show_layers(obj, made, [shown] if shown != obj else [])
        if shown != obj:  # writing the phase may have split faces
            memory.remember_layers(obj, given, layering)
        else:
            memory.remember_layers(obj, meshes.read_mesh(obj), layering)
        names = {
            "layers_object": made.name,
            "curves_object": curves.name if curves else None,
            "surface_object": shown.name,
        }
        settings = asdict(self.settings) | self.lengths._asdict()
        report = layer_report(layering, obj, names, settings, self._clock, self.warnings)
        report["times"]["total"] = time.perf_counter() - self._start
        return report


def _automatic(spacing, size, distance, lowest):
    """Lengths with the spacing that a size can carry, where none is given."""
    if spacing is None:
        extent = float(np.ptp(distance.bounds, axis=0).max())
        spacing = max(extent / LINES_ACROSS, EDGES_PER_LAYER * size / lowest)
    return Lengths(float(spacing), float(size))


def _no_layer(depth):
    if depth > 0:
        return f"no layer lies in the solid, which is about {depth:.2g} deep for them: give a spacing below that"
    return "no layer lies in the solid, whose phase is the same everywhere: change the guidance or the groups"


def _fitting(obj, surface, solid):
    """A given solid in the measured space; refuses one that is not the object's."""
    solid = TetMesh(solid.vertices @ surface.given.stretch.T, solid.tets)
    apart = np.abs(surface.distance(solid.vertices[solid.boundary_vertices])).max()
    if apart > _FITTING * surface.reach:
        raise SettingError(
            f"the solid's boundary is up to {apart:.3g} from the surface of {obj.name}: give the solid of this object"
        )
    return solid
