# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a solved field to the object at once: attributes, material and defect empties."""

import bpy
import numpy as np
from mathutils import Vector

from ...core.interpolate import face_phases
from ..blender import attributes, meshes, schema
from ..blender.defect_empties import KINDS, DefectEmpty, write_defects
from ..blender.pattern_surface import shows_vertices_first, surface_of
from ..blender.transaction import assign, at_the_end, store
from ..nodes.materials import SPACING, pattern_material

# How far attributes may be off what was solved to be the same: single precision.
SAME = 1e-4
# Blender's time for making and removing objects grows with the square of their number.
MOST_EMPTIES = 10_000


def results(obj, request, field, pattern, report):
    """Write directions and, where there is one, the pattern.

    Returns the defects as dicts of plain values for the report, and the faces as they are afterwards.
    """
    given, spacing = request.given, request.spacing
    polygons, surface = given.polygons, surface_of(obj)
    if pattern is not None:
        polygons = write_phases(surface, given, pattern.edge_phases, report.warn)
        attributes.write(surface, schema.SPACING_ERROR, _at_faces(given, polygons, pattern.evenness.errors))
    defects = _defects(given, field, pattern, polygons)
    _write_field(surface, given, field, polygons, [d for d in defects if d.kind == "disclination"])
    kinds = ("disclination",) if pattern is None else KINDS
    if len(defects) > MOST_EMPTIES:
        report.warn(
            f"{len(defects)} defects, and an empty for none of them (from {MOST_EMPTIES} on Blender takes long for "
            "each): the overlay draws them, the report lists them"
        )
    mesh = surface.data if shows_vertices_first(obj) else None
    shown = defects if len(defects) <= MOST_EMPTIES else []
    # In the window dots show the same.
    write_defects(obj, shown, kinds=kinds, length=spacing, mesh=mesh, hidden=not bpy.app.background)
    if pattern is not None:
        all_faces = report.settings.assign_material or has_one_material(surface)
        pattern_material(surface, request.command, spacing=spacing, assign_faces=all_faces)
        store(obj, SPACING, float(spacing))
    meshes.update(surface)
    return [_plain(obj, d) for d in defects], polygons


def is_written(obj, request, field, pattern):
    """Whether an object's attributes are those of a field or a pattern, up to single precision."""
    given, obj = request.given, surface_of(obj)
    if pattern is None:
        values = attributes.read(obj, schema.DIRECTION)
        return values is not None and np.abs(values - given.to_object(field.vectors)).max(initial=0) < SAME
    phases = given.at_object(pattern.edge_phases.arguments)
    for own, column in zip(_phase_attributes(phases.shape[1]), phases.T, strict=True):
        values = attributes.read(obj, own.vertex_phase)
        if values is None or np.abs(np.sin((values - column) / 2)).max(initial=0) > SAME:
            return False
    return True


def clear(obj):
    """Remove the pattern and defects of other faces; directions stay, as guidance."""
    for name in [a.name for a in obj.data.attributes if a.name.startswith(schema.PREFIX)]:
        if name != schema.DIRECTION.name:
            attributes.remove_attribute(obj, name)
    write_defects(obj, [])
    if hasattr(obj, "synch"):  # as long as the extension is registered
        assign(obj.synch, "result", "")
        at_the_end(obj.synch.favourites.clear)


def reported_defects(obj, given, field, pattern):
    """The defects of a solved pattern on a MeshInput for the report, without writing anything."""
    return [_plain(obj, d) for d in _defects(given, field, pattern, given.polygons)]


def _defects(given, field, pattern, polygons):
    """All defects as records for the scene, in object space, with the faces that they are in."""
    found = field.disclinations + (pattern.dislocations if pattern is not None else [])
    triangles = given.mesh.triangles[[d.triangle for d in found]] if found else np.empty((0, 3), int)
    faces = meshes.faces_of_triangles(polygons, triangles)
    return [_defect(given, pattern, d, face) for d, face in zip(found, faces, strict=True)]


def _write_field(obj, given, field, polygons, disclinations):
    attributes.write(obj, schema.DIRECTION, given.to_object(field.vectors))
    singularity = np.zeros(len(polygons.starts))
    np.add.at(singularity, [d.face for d in disclinations], [d.index for d in disclinations])
    attributes.write(obj, schema.SINGULARITY, singularity)


def write_phases(obj, given, edge_phases, warn):
    """Write the phases that an :class:`EdgePhases` of the measured mesh has; returns the faces as they are now.

    ``warn`` is called with a line about the faces that had to be split, if any.
    """
    polygons = given.polygons
    phases = face_phases(edge_phases, polygons)
    unfit = meshes.can_be_split(obj, phases[0].unfit, polygons)
    if len(unfit):
        polygons = polygons.after_split(*split_faces(obj, unfit, polygons, warn))
        phases = face_phases(edge_phases, polygons)
    pattern_attributes(obj, attribute_values(phases, given.at_object(edge_phases.arguments)))
    return polygons


def split_faces(obj, faces, surface, warn):
    """Split (k,) faces into triangles, and say so; the Polygons now, and (c,) the corner that each corner was before.

    ``surface`` are the Polygons as they were read; faces that double one that is split are removed.
    """
    doubles = meshes.doubles_of(faces, surface)
    line = f"{len(faces)} faces with a defect were split into triangles, first face {faces[0]}"
    line += f", and {len(doubles)} that doubled them removed" if len(doubles) else ""
    warn(f"{line}: corner values carry one disclination, or two dislocations, in at most four corners")
    old_corners = meshes.split_faces(obj, faces, doubles)
    return meshes.read_polygons(obj), old_corners


def _phase_attributes(count):
    """The attributes of each phase, for a number of phases at a vertex."""
    return schema.PHASES["stripes" if count == 1 else "quads"]


def attribute_values(phases, vertex_phases):
    """Values of a pattern's attributes by their names, without those that only some meshes need, from a FacePhases for
    each of k phases, and (n, k) radians at the vertices."""
    values = {schema.BARYCENTRIC: phases[0].corner_place, schema.PATTERN: np.cos(vertex_phases).prod(axis=1)}
    for own, phase, at_vertices in zip(_phase_attributes(len(phases)), phases, vertex_phases.T, strict=True):
        values |= {own.phase: phase.corner_phase, own.index: phase.index, own.vertex_phase: at_vertices}
        if phase.index_2.any():  # absent means zero to a shader
            values[own.index_2] = phase.index_2
        # A face may be singular for the other phase alone: its values here have to be zero, not absent.
        if phase.disclination.any() or len(phases) == 2:
            values[own.disclination] = phase.disclination
    if len(phases) == 2:
        values[schema.CLOSING] = np.column_stack([phase.closing for phase in phases])
    return {attribute.name: array for attribute, array in values.items()}


def pattern_attributes(obj, values):
    """Write a pattern's attributes, and remove those of another pattern that it lacks."""
    for attribute in (*schema.PATTERNS["stripes"], *schema.PATTERNS["quads"]):
        if attribute.name not in values:
            attributes.remove_attribute(obj, attribute.name)
    for name, array in values.items():
        attributes.write_attribute(obj, name, *schema.layout_of(name), array)


def _defect(given, pattern, defect, face):
    """The :class:`DefectEmpty` of a defect of the measured mesh, in object space, in a face of the object."""
    inverse = np.linalg.inv(given.stretch)
    normal = given.stretch @ defect.normal  # normals go the other way round than points
    length = np.linalg.norm(normal)
    normal = normal / length if length > 0 else np.array([0.0, 0.0, 1.0])  # a face without area has none
    of_two = defect.kind == "dislocation" and pattern.edge_phases.phase_count == 2
    return DefectEmpty(
        defect.kind,
        int(face),
        defect.index,
        tuple((inverse @ defect.position).tolist()),
        tuple(normal.tolist()),
        "xy"[defect.phase] if of_two else "",
    )


def _plain(obj, defect):
    """A defect for the report, at its place in the world."""
    position = obj.matrix_world @ Vector(defect.position)
    plain = {"kind": defect.kind, "face": defect.face, "index": defect.index, "position": list(position)}
    return plain | {"phase": defect.phase} if defect.phase else plain


def _at_faces(given, polygons, values):
    """(p,) means in faces of the values of the mesh's triangles, also after faces were split."""
    is_split = polygons is not given.polygons
    faces = meshes.faces_of_triangles(polygons, given.mesh.triangles) if is_split else polygons.triangle_faces
    count = len(polygons.starts)
    return polygons.at_faces(np.bincount(faces, values, count) / np.maximum(np.bincount(faces, minlength=count), 1))


def has_one_material(obj):
    """Whether showing the pattern on all faces loses no assignment of the user's."""
    slots = attributes.read_values(obj, "material_index", "FACE")
    return slots is None or (slots == slots[:1]).all()
