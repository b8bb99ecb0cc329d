# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a solved field to the object at once: attributes, material and defect empties."""

from dataclasses import replace

import numpy as np
from mathutils import Vector

from . import scene_io
from .defect_empties import Defect, write_defects
from .materials import stripes_material

# Attributes of a stripe pattern that only some meshes need: absent means zero to a shader.
_OPTIONAL = ("synch_index_2", "synch_disclination")


def results(obj, task, field, pattern, report):
    """Write directions and, where there is one, the stripe pattern.

    Returns the defects as dicts of plain values for the report, faces numbered as they are afterwards.
    """
    given, spacing = task.given, task.spacing
    polygons = given.polygons
    if pattern is not None:
        polygons = _write_pattern(obj, given, pattern, report)
    found = field.disclinations + (pattern.dislocations if pattern is not None else [])
    triangles = given.mesh.triangles[[d.triangle for d in found]] if found else np.empty((0, 3), int)
    faces = scene_io.faces_of_triangles(polygons, triangles)
    _write_field(obj, given, field, polygons, faces)
    defects = [_defect(given, d, face) for d, face in zip(found, faces, strict=True)]
    kinds = ("disclination",) if pattern is None else ("disclination", "dislocation")
    write_defects(obj, defects, kinds=kinds, length=spacing)
    if pattern is not None:
        stripes_material(obj, spacing=spacing, assign_faces=task.settings.assign_material or _has_one_material(obj))
    scene_io.update(obj)
    return [_plain(obj, d) for d in defects]


def _write_field(obj, given, field, polygons, faces):
    scene_io.write_attribute(obj, "synch_direction", "POINT", "FLOAT_VECTOR", given.to_object(field.vectors))
    singularity = np.zeros(len(polygons.starts))
    disclinations = field.disclinations
    np.add.at(singularity, faces[: len(disclinations)], [d.index for d in disclinations])
    scene_io.write_attribute(obj, "synch_singularity", "FACE", "FLOAT", singularity)


def _write_pattern(obj, given, pattern, report):
    """Write the phases; returns the faces as they are now."""
    polygons = given.polygons
    phases = pattern.on_faces(polygons)
    if len(phases.unfit):
        report.warn(
            f"{len(phases.unfit)} faces with a defect were split into triangles, first face "
            f"{phases.unfit[0]}: corner values carry one disclination, or two dislocations, in at most four corners"
        )
        old_corners = scene_io.split_faces(obj, polygons, phases.unfit)
        polygons = replace(scene_io.read_polygons(obj), corner_vertices=polygons.corner_vertices[old_corners])
        phases = pattern.on_faces(polygons)
    vertex_phases = np.angle(pattern.solution.phases)[: given.uncut.vertex_count]
    for name, domain, data_type, values in (
        ("synch_phase", "CORNER", "FLOAT", phases.corner_phase),
        ("synch_index", "FACE", "INT", phases.index),
        ("synch_index_2", "FACE", "INT", phases.index_2),
        ("synch_barycentric", "CORNER", "FLOAT_VECTOR", phases.corner_place),
        ("synch_disclination", "FACE", "FLOAT_COLOR", phases.disclination),
        ("synch_vertex_phase", "POINT", "FLOAT", vertex_phases),
        ("synch_pattern", "POINT", "FLOAT", np.cos(vertex_phases)),
    ):
        if name in _OPTIONAL and not values.any():
            scene_io.remove_attribute(obj, name)
        else:
            scene_io.write_attribute(obj, name, domain, data_type, values)
    return polygons


def _defect(given, defect, face):
    inverse = np.linalg.inv(given.stretch)
    normal = given.stretch @ defect.normal  # normals go the other way round than points
    return Defect(
        defect.kind,
        int(face),
        defect.index,
        tuple((inverse @ defect.position).tolist()),
        tuple((normal / np.linalg.norm(normal)).tolist()),
    )


def _plain(obj, defect):
    """A defect for the report, at its place in the world."""
    position = obj.matrix_world @ Vector(defect.position)
    return {"kind": defect.kind, "face": defect.face, "index": defect.index, "position": list(position)}


def _has_one_material(obj):
    """Whether showing the pattern on all faces loses no assignment of the user's."""
    used = np.empty(len(obj.data.polygons), np.int32)
    obj.data.polygons.foreach_get("material_index", used)
    return len(np.unique(used)) <= 1
