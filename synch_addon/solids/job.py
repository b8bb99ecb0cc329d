# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in a solid as a job: the surface and what is asked are read, objects written (paper, Section 3.4)."""

import numpy as np

from ...core.errors import SynchError
from ...core.fields.limits import Limits
from ...core.geometry.filling.lengths import Lengths
from ...core.solve import Options
from ...core.tasks.layer_outputs import Layering
from ...core.tasks.solids import FlushArea, SolidGuide, SolidRequest
from ..blender import meshes
from ..blender.attributes import read_factors
from ..blender.modifiers import foreign_modifiers
from ..blender.objects import ObjectLink, Selection
from ..blender.transaction import whole_or_nothing
from ..jobs.report import Report
from . import memory, objects
from .guides import read_guide
from .report import layer_facts
from .surface import fit_solid, read_area, read_surface


class LayerJob:
    """Layers in the solid of an object; see :mod:`..jobs.job`.

    Parameters
    ----------
    obj : bpy.types.Object
    settings : LayerSettings
    solid : TetMesh in the object's space whose boundary is its surface, None to fill the surface
    """

    def __init__(self, obj, settings, solid=None):
        meshes.refuse(obj)
        self.link, self._report = ObjectLink.to(obj), Report("layers", obj, settings)
        with meshes.object_mode(obj), self._report.clock("read"):
            self.request = _read(obj, settings, solid)
            for finding in self.request.surface.given.findings:
                self._report.warn(finding.line)
            self._report.warn_of_users(obj, "the phase")
            self._report.warn_of_modifiers(foreign_modifiers(obj), "layers are")
        self._hidden, self._selection = objects.hidden(obj), Selection.now()

    def write(self, result):
        """Write a :class:`SolidResult` at once; returns the report."""
        obj, given, report = self.link.found, self.request.surface.given, self._report
        spacing = self.request.lengths.spacing
        report.take(result)
        with meshes.object_mode(obj), whole_or_nothing():
            if not meshes.is_unchanged(obj, given):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            layering = Layering(result.pattern, result.surfaces, result.curves, memory.solid_matrix(obj, given))
            with report.clock("write"):
                made = objects.write_all(obj, layering, result, given, report.warn, spacing)
                objects.show_layers(obj, made, self._hidden, self._selection)
            # Writing the phase may have split faces.
            memory.remember_layers(obj, meshes.read_mesh(obj) if made["surface"] == obj else given, layering)
        solution, names = result.pattern.solution, {f"{kind}_object": one and one.name for kind, one in made.items()}
        facts = (
            report.opening_entries(solution, layering.solid)
            | names
            | layer_facts(layering)
            | {
                "outside_limits": result.outside,
                "continued_directions": result.continued,
                "far_from_layers": result.far,
            }
            | {"carrier": given.finding_counts}
        )
        return facts | report.closing_entries([solution], self.request.lengths._asdict())


def _read(obj, settings, solid):
    """The :class:`SolidRequest`."""
    surface = read_surface(obj, settings.strict)
    given, distance, factors, lowest = surface.given, surface.distance, None, 1.0
    solid = None if solid is None else fit_solid(obj, surface, solid)
    guide = SolidGuide(settings.guidance, read_guide(obj, given, settings.guide), settings.guide.kind == "axis")
    flush_areas = [FlushArea(read_area(obj, given, row.group), row.phase) for row in settings.flush]
    if settings.spacing_map:
        factors = read_factors(obj, given, settings.spacing_map, settings.spacing_range)
        lowest = float(factors.min())
    lengths = _lengths(distance, settings, settings.spacing, solid, lowest)
    limits = Limits(*settings.heights)
    within = float(limits.clipped(lengths.spacing))
    if within != lengths.spacing:
        lengths = _lengths(distance, settings, within, solid, lowest)
    return SolidRequest(
        surface,
        solid,
        guide,
        tuple(flush_areas),
        lengths,
        factors,
        Options.of(settings),
        settings.branching,
        limits,
        settings.numbers == "levels",
    )


def _lengths(distance, settings, spacing, solid, lowest):
    """The :class:`Lengths` for a spacing, None for an automatic one."""
    if solid is None:
        return Lengths.of(distance, spacing, settings.size, lowest, settings.divisions)
    return Lengths.carried(distance, spacing, float(np.median(solid.edge_lengths)), lowest, settings.divisions)
