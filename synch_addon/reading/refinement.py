# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object's own faces are fine enough for a pattern, and the finer surface that it is solved on where not."""

import hashlib
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.errors import SettingError, SynchError
from ...core.geometry.check import refuse_far_vertices
from ...core.geometry.welding import welded_vertices
from ...core.refinement import BoundSurface, TooFineError, refine
from ...core.refinement.spacing import LINES_ACROSS, longest_edge
from ...core.tasks.quad_meshes import faces_of_factor
from ..blender import attributes, meshes
from ..blender.modifiers import changing_modifiers, foreign_modifiers, hidden, is_ours
from ..blender.refined_mesh import refined_object
from . import constraints
from .surface import asked_spacings, automatic_spacing, lines_in_period, wished_spacing

# Fewer lines across than these, which is all that some faces carry, are reason for a surface of their own.
FEW_LINES = LINES_ACROSS // 3
# That much longer than they should be edges may be.
SLACK = 1.1


@dataclass(frozen=True)
class Refinement:
    """A surface of its own for the pattern of an object.

    Attributes
    ----------
    bound : BoundSurface of the object's mesh, or of what its modifiers make of it
    is_seen : whether it is of that
    state : what tells the mesh that it was made for from others, see :func:`state_of`
    source_vertices : how many vertices it is bound to
    """

    bound: BoundSurface
    is_seen: bool
    state: str
    source_vertices: int

    @property
    def figures(self):
        """What a report says of it."""
        bound = self.bound
        of = "modifiers" if self.is_seen else "mesh"
        return {"of": of, "vertices": len(bound.vertices), "faces": len(bound.starts), "joined": bound.welded}


def refinement_of(command, obj, settings):
    """The :class:`Refinement` on which a command on an object in object mode is solved, None for its own faces; and
    the MeshInput of these, with the edges apart that are cut, where it was read.

    Raises
    ------
    SynchError
        as :func:`gather`, and where the surface would have too many faces
    """
    if settings.surface == "faces" or (settings.surface == "automatic" and command == "directions"):
        return None, None
    is_seen = settings.surface == "seen"
    if not is_seen:
        given = meshes.read_mesh(obj, strict=settings.strict)
        try:
            if is_fine(command, obj, given, settings):
                return None, constraints.cut_mesh(obj, given, settings.constraints)
        except SettingError:
            refuse_far_vertices(given.mesh)  # rather than a spacing that suits their distance
            raise
        is_seen = bool(changing_modifiers(obj))
    with source_of(obj, is_seen) as source:
        given = meshes.read_mesh(source, strict=settings.strict)
        refuse_far_vertices(given.mesh)
        longest = None
        if command != "directions":
            spacing = wished_spacing(command, given.mesh) if settings.spacing is None else settings.spacing
            longest = _longest_edge(command, source, given, settings, spacing)
        try:
            bound = _refined(source, given, np.inf if longest is None else longest, settings.mirror)
        except TooFineError as error:
            raise SettingError(_finest(command, obj, given, settings, spacing, error.factor)) from None
        return Refinement(bound, is_seen, state_of(obj), len(source.data.vertices)), None


def carries_few_lines(command, size, spacing):
    """Whether an automatic spacing gives so few lines across a size that a finer surface is worth it."""
    return spacing > SLACK * lines_in_period(command) * size / FEW_LINES


def is_fine(command, obj, given, settings):
    """Whether faces carry what is asked of a pattern: edges that are short enough, and joined where they meet."""
    uncut = given.uncut
    spacing = automatic_spacing(command, given.mesh) if settings.spacing is None else settings.spacing
    if settings.spacing is None and not (command == "quad_mesh" and settings.faces):
        size = np.ptp(given.mesh.vertices[np.unique(given.mesh.triangles)], axis=0).max()
        if carries_few_lines(command, size, spacing):
            return False
    if _longest_edge(command, obj, given, settings, spacing) is not None:
        return False
    if len(given.uncut.boundary_edges) == 0:
        return True
    return bool((welded_vertices(uncut.vertices, uncut.triangles) == np.arange(uncut.vertex_count)).all())


def _longest_edge(command, obj, given, settings, spacing):
    """How long edges may be for a spacing, or for the number of faces that is asked for; None where they are fine."""
    _, spacings = asked_spacings(command, obj, given, settings, spacing)
    return longest_edge(given.mesh, spacings)


def _finest(command, obj, given, settings, spacing, factor):
    """The line that refuses faces or a spacing, and says which would do."""
    if command == "quad_mesh" and settings.faces:
        _, asked = asked_spacings(command, obj, given, settings, spacing)
        fitting = faces_of_factor(given.mesh, asked, factor)
        if fitting < 1:
            return "parts of this mesh are too long and thin for quads: delete vertices that lie far out, or remesh it"
        return f"{settings.faces} faces are too many for this mesh: ask for {fitting} at most"
    return f"the spacing {spacing:g} is too fine for this mesh: use one from {factor * spacing:.3g} on"


def _refined(source, given, longest, axes):
    polygons = meshes.read_polygons(source)
    edges = attributes.read_all(source.data.edges, "vertices", 2)
    mesh = meshes.measured_places(source), polygons.starts, polygons.corner_vertices, edges
    return refine(*mesh, longest, given.stretch, polygons.triangle_corners, tuple(map("XYZ".index, axes)))


@contextmanager
def source_of(obj, is_seen):
    """The object whose mesh is refined: the given one, or for a while a copy of what its modifiers make of it."""
    if not is_seen:
        yield obj
        return
    ours = [modifier for modifier in obj.modifiers if is_ours(modifier)]
    with hidden(ours), _levels_of_renders(obj):
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
    with source_of(obj, refinement.is_seen) as source:
        made = made_of(obj, source, refinement)
    try:
        yield made
    finally:
        bpy.data.batch_remove([made, made.data])


def made_of(obj, source, refinement):
    """The object with the mesh of a refinement of ``source``, for a pattern of ``obj``.

    Raises
    ------
    SynchError
        where the source has other faces by now
    """
    if len(source.data.vertices) != refinement.source_vertices or state_of(obj) != refinement.state:
        raise SynchError(f"the mesh or the modifiers of {obj.name} changed while it was solved: run again")
    return refined_object(source, refinement.bound, obj, refinement.state)


def state_of(obj):
    """What is equal as long as an object's own mesh has the same faces at the same places."""
    polygons = meshes.read_polygons(obj)
    digest = hashlib.sha1(usedforsecurity=False)
    for array in (polygons.corner_vertices, polygons.starts, meshes.measured_places(obj)):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
