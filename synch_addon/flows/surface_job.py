# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow on a surface, written to its mesh: phases with their vortices, and the map to the sphere."""

import time
from dataclasses import replace

import numpy as np

from ...core.extract.filaments import vortices
from ...core.fields.clebsch import clebsch_map, quantum_for, spherical_map
from ...core.interpolate import EdgePhases
from ..blender import attributes, meshes
from ..blender.defect_empties import Defect, write_defects
from ..blender.transaction import whole_or_nothing
from ..jobs.jobs import portion
from ..nodes.globe import SPHERE
from ..nodes.materials import pattern_material
from ..nodes.vortices import COLOR, STRENGTH
from ..patterns.write import write_phases
from .choice import remember
from .objects import present, seen
from .report import SolvedFlow, report_of


class SurfaceJob:
    """One run on a :class:`SurfaceFlow`: :meth:`solve` may run in another thread, :meth:`write` changes the mesh."""

    def __init__(self, source, settings):
        self._start = time.perf_counter()
        self._source, self.settings = source, settings

    def solve(self, callback=None):
        """Solve for the map and, where the method can, the sphere; errors as :meth:`ClebschJob.solve`."""
        settings, surface = self.settings, self._source.surface
        integrals = self._source.integrals(surface)
        quantum = settings.quantum
        if quantum is None:
            quantum = quantum_for(surface, integrals, settings.count)
        found = clebsch_map(surface, integrals, quantum, settings.options, portion(callback, 0.0, 0.8))
        sphere = spherical_map(found, portion(callback, 0.8, 0.2)) if settings.method == "sdp" else None
        self._solved = SolvedFlow(self._source.name, found, sphere, settings, list(self._source.warnings))

    def write(self):
        """Write the map to the mesh, which is made for a plane; returns the report.

        Raises
        ------
        SettingError
            when the object is gone or has changed since it was read; nothing is written
        """
        solved = self._solved
        shown = seen(solved.found, solved.sphere, solved.settings.point)
        with whole_or_nothing():
            obj = self._source.target()
            facts = self._fill(solved, shown, [obj])
        if not obj.users_collection:
            present([obj])
        report = report_of(solved, shown, [obj], self._start) | facts
        remember(solved, [obj], report, self._fill)
        return report

    def _fill(self, solved, shown, objects):
        """Show a map of the solve on the mesh; returns the facts."""
        source, warnings = self._source, solved.warnings
        obj, given, sphere = source.of_object(objects[0]), source.given, solved.sphere
        changes, matchings = shown.changes[:, None], np.zeros(len(given.mesh.edges), int)
        phases = EdgePhases(given.mesh, np.angle(shown.phases)[:, None], changes, matchings)
        polygons = write_phases(obj, given, phases, warnings.append)
        source.given = replace(given, polygons=polygons)
        period = _period(given.mesh, shown)
        facts = {"vortices": _write_vortices(obj, given, shown, polygons, period)}
        if sphere is not None:
            _write_sphere(obj, sphere.sphere)
            facts["coverage"] = float(np.abs(sphere.face_areas).sum())  # either way
        pattern_material(obj, "stripes" if solved.settings.show == "filaments" else "globe", spacing=period)
        meshes.update(obj)
        return facts


def _write_sphere(obj, points):
    attributes.write_attribute(obj, SPHERE, "POINT", "FLOAT_VECTOR", points)
    colors = np.column_stack([0.5 + 0.5 * points, np.ones(len(points))])
    attributes.write_attribute(obj, COLOR, "POINT", "FLOAT_COLOR", colors)


def _write_vortices(obj, given, shown, polygons, period):
    """An empty for every vortex, and the circulation within each face; returns them for the report."""
    triangles, places, strengths = vortices(shown)
    faces = meshes.faces_of_triangles(polygons, given.mesh.triangles[triangles])
    attributes.write_attribute(obj, STRENGTH, "FACE", "FLOAT", np.bincount(faces, strengths, len(polygons.starts)))
    normals = given.mesh.face_normals[triangles] @ given.stretch  # they go the other way round than points
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    numbers = shown.face_numbers[triangles]
    records = zip(faces, numbers, places @ np.linalg.inv(given.stretch), normals, strict=True)
    found = [
        Defect("vortex", int(face), int(number), tuple(place.tolist()), tuple(normal.tolist()))
        for face, number, place, normal in records
    ]
    empties = write_defects(obj, found, kinds=("dislocation", "vortex"), length=period)
    plain = []
    for defect, empty, strength in zip(found, empties, strengths.tolist(), strict=True):
        empty[STRENGTH] = strength
        position = list(obj.matrix_world @ empty.location)
        plain.append({"face": defect.face, "strength": strength, "position": position})
    return plain


def _period(mesh, shown):
    """A usual distance between two stripes of the phase, but no more than a quarter of the surface."""
    speeds = shown.integrals / mesh.edge_lengths
    usual = shown.quantum / np.sqrt(2 * np.mean(speeds**2))
    return float(min(usual, 0.25 * np.ptp(mesh.vertices, axis=0).max()))
