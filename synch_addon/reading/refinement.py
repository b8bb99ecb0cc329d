# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object's own faces are fine enough for a pattern, and the finer surface that it is solved on where not."""

import hashlib
from contextlib import contextmanager
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.refinement import BoundSurface
from ...core.refinement.spacing import finer_copy, is_fine
from ..blender import attributes, meshes
from ..blender.modifiers import changing_modifiers, foreign_modifiers, hidden, is_ours, last_bending
from ..blender.refined_mesh import refined_object
from .surface import read_spacing_map


@dataclass(frozen=True)
class Refinement:
    """A surface of its own for the pattern of an object.

    Attributes
    ----------
    bound : BoundSurface of the object's mesh, or of what its modifiers make of it
    is_seen : whether it is of the result of modifiers
    state : hash of the object's own mesh, see :func:`state_of`
    topology : hash of the mesh that it is bound to, without places, see :func:`_topology_of`
    mirror : axes of the pattern's mirror: those asked for, or where a quad mesh has none, those of modifiers
    unbent : names of modifiers that bend the object and that the surface is without, for a quad mesh to have them
    """

    bound: BoundSurface
    is_seen: bool
    state: str
    topology: str
    mirror: str
    unbent: tuple[str, ...] = ()

    @property
    def figures(self):
        """Entries of a report about the surface."""
        bound = self.bound
        of = "modifiers" if self.is_seen else "mesh"
        return {"of": of, "vertices": len(bound.vertices), "faces": len(bound.starts), "joined": bound.welded}


def refinement_of(command, obj, settings, follows_mirror):
    """Choose the surface that a command on an object in object mode is solved on.

    Returns a :class:`Refinement` and None, or for the object's own faces None and their MeshInput; this is None, too,
    unless it was read for the choice. Raises SynchError as :func:`gather`, and where the surface would have too many
    faces.

    ``follows_mirror``: mirror a quad mesh that asks for no mirror as the Mirror modifiers mirror the object.
    """
    if settings.surface == "faces" or (settings.surface == "automatic" and command == "directions"):
        return None, None
    if settings.surface == "seen":
        applies_modifiers = True
    else:
        applies_modifiers = bool(changing_modifiers(obj))
        given = meshes.read_mesh(obj, strict=settings.strict)
        factors = read_spacing_map(obj, given, settings)
        is_mirrored = command == "quad_mesh" and _mirrored_by_modifiers(obj)
        if is_fine(command, given, settings, factors) and not is_mirrored:
            return None, given
    return _refine(command, obj, settings, applies_modifiers, follows_mirror), None


def _refine(command, obj, settings, applies_modifiers, follows_mirror):
    """The :class:`Refinement` of the object's mesh, or of what its modifiers make of it."""
    unbent = ()
    if command == "quad_mesh" and applies_modifiers and settings.surface != "seen":
        unbent = tuple(modifier.name for modifier in last_bending(obj))
    with source_of(obj, applies_modifiers, unbent) as source:
        read = meshes.read_faces(source)
        edges = attributes.read_all(source.data.edges, "vertices", 2)
        state, topology = state_of(obj), _topology_of(source, edges)
        given = read.surface(settings.strict)
        factors = read_spacing_map(source, given, settings)
        mirror = settings.mirror
        if follows_mirror and not mirror and command == "quad_mesh" and applies_modifiers:
            mirror = _mirrored_by_modifiers(obj)
        mirrored, may_replace = replace(settings, mirror=mirror), bool(settings.mirror)
        bound = finer_copy(command, read, edges, given, mirrored, factors, may_replace)
        return Refinement(bound, applies_modifiers, state, topology, mirror, unbent)


def _mirrored_by_modifiers(obj):
    """The axes, such as "XY", in which modifiers mirror an object; later ones may spoil that."""
    found = [one for one in foreign_modifiers(obj) if one.type == "MIRROR" and one.mirror_object is None]
    return "".join(axis for number, axis in enumerate("XYZ") if any(one.use_axis[number] for one in found))


@contextmanager
def source_of(obj, is_seen, unbent=()):
    """The object whose mesh is refined: the given one, or for a while a copy of what its modifiers make of it, without
    the ``unbent`` ones."""
    if not is_seen:
        yield obj
        return
    left_out = [modifier for modifier in obj.modifiers if is_ours(modifier) or modifier.name in unbent]
    with hidden(left_out), _levels_of_renders(obj):
        graph = bpy.context.evaluated_depsgraph_get()
        data = bpy.data.meshes.new_from_object(obj.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph)
    seen = bpy.data.objects.new(obj.name, data)
    try:
        seen.matrix_world = obj.matrix_world
        yield seen
    finally:
        bpy.data.batch_remove([seen, data])


@contextmanager
def _levels_of_renders(obj):
    """Evaluate for a while with the finer of the levels of viewport and renders."""
    before = [(modifier, modifier.levels) for modifier in unequal_levels(obj)]
    try:
        for modifier, _ in before:
            modifier.levels = max(modifier.levels, modifier.render_levels)
        yield
    finally:
        for modifier, level in before:
            modifier.levels = level


def unequal_levels(obj):
    """Modifiers that are seen and subdivide more often in renders than in the viewport, or less often."""
    return [
        modifier
        for modifier in foreign_modifiers(obj)
        if modifier.type in ("SUBSURF", "MULTIRES") and modifier.levels != modifier.render_levels
    ]


@contextmanager
def solved_object(obj, refinement):
    """The object whose mesh is solved on: the given one, or for a while one with the mesh of a refinement."""
    if refinement is None:
        yield obj
        return
    with source_of(obj, refinement.is_seen, refinement.unbent) as source:
        made = made_of(obj, source, refinement)
    try:
        yield made
    finally:
        bpy.data.batch_remove([made, made.data])


def made_of(obj, source, refinement):
    """The object with the mesh of a refinement of ``source``, for a pattern of ``obj``.

    Raises SynchError where the source has other faces by now.
    """
    edges = attributes.read_all(source.data.edges, "vertices", 2)
    if _topology_of(source, edges) != refinement.topology or state_of(obj) != refinement.state:
        raise SynchError(f"the mesh or the modifiers of {obj.name} changed while it was solved: run again")
    return refined_object(source, refinement.bound, obj, refinement.state)


def state_of(obj):
    """Hash of the faces of an object's own mesh and of the places of its vertices."""
    polygons = meshes.read_polygons(obj, with_triangles=False)
    return digest_of(polygons.corner_vertices, polygons.starts, meshes.measured_places(obj))


def _topology_of(obj, edges):
    """Hash of the edges and faces of an object's mesh and of the number of its vertices; places do not count."""
    polygons = meshes.read_polygons(obj, with_triangles=False)
    return digest_of(np.array(len(obj.data.vertices)), edges, polygons.corner_vertices, polygons.starts)


def digest_of(*arrays):
    """Hash of the bytes of arrays."""
    digest = hashlib.sha1(usedforsecurity=False)
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
