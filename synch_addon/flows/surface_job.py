# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow on a surface, written to its mesh: phases with their vortices, and the map to the sphere."""

import time
from dataclasses import replace
from functools import partial

import numpy as np

from ...core.errors import SettingError
from ...core.extract.vortices.filaments import vortices
from ...core.interpolate import EdgePhases
from ...core.tasks.flows import SurfaceFlowRequest
from ...core.unit_vectors import unit_vectors
from ..blender import attributes, meshes, schema
from ..blender.defect_empties import DefectEmpty, write_defects
from ..blender.objects import Selection
from ..blender.transaction import whole_or_nothing
from ..nodes.materials import pattern_material
from ..patterns.former_pattern import remove_former
from ..patterns.write import write_phases
from .choice import finish
from .memory import Filled, SolvedFlow
from .objects import present, write_sphere
from .surfaces import plane_object


class SurfaceJob:
    """The map of a :class:`SurfaceFlow`; see :mod:`..jobs.job`."""

    def __init__(self, surface, settings):
        self._start, self._selection = time.perf_counter(), Selection.now()
        self._surface, self.link = surface, surface.link
        self.request = SurfaceFlowRequest(surface.given, surface.velocity, settings)

    def write(self, result):
        """Write the map to the mesh, which is made for a plane; returns the report.

        Raises SynchError when the object is gone or has changed since it was read; nothing is written.
        """
        surface = self._surface
        result = replace(result, warnings=surface.warnings)
        if self.link is None:
            with whole_or_nothing():
                obj = plane_object(surface)
                present([obj], self._selection)
                return self._filled(obj, result)
        obj = self.link.found
        with meshes.object_mode(obj), whole_or_nothing():
            return self._filled(obj, result)

    def _filled(self, obj, result):
        """Fill an object; returns the report."""
        surface, settings = self._surface, self.request.settings
        filled = _fill(surface.given, result, settings, [obj])
        solved = SolvedFlow(surface.name, settings, result, filled.fill, (obj.session_uid,))
        return finish(solved, filled, [obj], self._start)


def _fill(given, result, settings, objects):
    """Show a map on the object whose mesh was read as ``given``; returns the :class:`Filled`."""
    (obj,) = objects
    if not meshes.is_unchanged(obj, given):
        raise SettingError(f"the mesh {obj.name} has changed since its flow was read: run it again")
    shown, warnings = result.seen, []
    remove_former(obj)
    changes, matchings = shown.changes[:, None], np.zeros(len(given.mesh.edges), int)
    phases = EdgePhases(given.mesh, np.angle(shown.phases)[:, None], changes, matchings)
    given = replace(given, polygons=write_phases(obj, given, phases, warnings.append))
    period = _period(given.mesh, shown)
    facts = {"carrier": given.finding_counts, "vortices": _write_vortices(obj, given, shown, period)}
    if result.sphere is not None:
        write_sphere(obj, given.at_object(result.sphere.sphere))
        facts["coverage"] = float(np.abs(result.sphere.face_areas).sum())  # either way
    pattern_material(obj, "stripes" if settings.show == "filaments" else "globe", spacing=period)
    meshes.update(obj)
    return Filled(facts, partial(_fill, given), tuple(warnings))


def _write_vortices(obj, given, shown, period):
    """An empty for every vortex, and the circulation within each face; returns them for the report."""
    triangles, places, strengths = vortices(shown)
    polygons = given.polygons
    faces = meshes.faces_of_triangles(polygons, given.mesh.triangles[triangles])
    attributes.write(obj, schema.STRENGTH, np.bincount(faces, strengths, len(polygons.starts)))
    normals = unit_vectors(given.mesh.face_normals[triangles] @ given.stretch)  # the other way round than points
    numbers = shown.face_numbers[triangles]
    records = zip(faces, numbers, places @ np.linalg.inv(given.stretch), normals, strict=True)
    found = [
        DefectEmpty("vortex", int(face), int(number), tuple(place.tolist()), tuple(normal.tolist()))
        for face, number, place, normal in records
    ]
    empties = write_defects(obj, found, kinds=("dislocation", "vortex"), length=period)
    plain = []
    for defect, empty, strength in zip(found, empties, strengths.tolist(), strict=True):
        empty[schema.STRENGTH.name] = strength
        position = list(obj.matrix_world @ empty.location)
        plain.append({"face": defect.face, "strength": strength, "position": position})
    return plain


def _period(mesh, shown):
    """A usual distance between two stripes of the phase, but no more than a quarter of the surface."""
    speeds = shown.integrals / mesh.edge_lengths
    usual = shown.quantum / np.sqrt(2 * np.mean(speeds**2))
    return float(min(usual, 0.25 * np.ptp(mesh.vertices, axis=0).max()))
