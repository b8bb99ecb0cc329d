# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows of an object, as points, segments and triangles: directions, defects, constrained edges,
how far apart lines are, a loop of quads, layers.

Every function here takes an object and returns [(points, colour)] in its space: (k, 2, 3) ends of segments
or (k, 3) points, and four numbers red, green, blue, alpha; or (k, 3, 3) corners of triangles with (k, 4) colours, or
(k, 3, 4) at the corners.
"""

from dataclasses import dataclass

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.extract import direction_glyphs, evenly_traced
from ...core.settings.pins import parse_pins
from ...core.settings.surface import SYMMETRY_ORDERS
from ..blender import attributes, groups, meshes
from ..blender.defect_empties import COLORS as DEFECT_COLORS
from ..blender.pattern_surface import shows_vertices_first, surface_of
from ..blender.schema import COLOR, DIRECTION, LAYER, PHASES, SINGULARITY, SPACING_ERROR
from ..nodes.layers import layer_colors
from ..patterns.loops import faces_of_loop, shown_edge

# No more marks or streamlines than this, however dense the mesh.
GLYPHS, STREAMLINES = 6_000, 250
DIRECTION_COLOR = (0.05, 0.35, 0.95, 1.0)
# Of constrained edges, by what is asked there.
WISH_COLORS = {
    "ALONG": (0.30, 0.85, 0.15, 1.0),
    "ACROSS": (0.0, 0.75, 0.85, 1.0),
    "ANGLE": (0.45, 0.40, 1.0, 1.0),
    "PHASE": (1.0, 0.25, 0.75, 1.0),
    "CONSTANT": (1.0, 0.65, 0.05, 1.0),
    "CUT": (0.90, 0.12, 0.05, 1.0),
}
# Of lines that are farther apart than asked, nearer, and just right; and from how many times on they are full.
WIDE_COLOR, NARROW_COLOR, EVEN_COLOR = (0.85, 0.05, 0.03, 0.8), (0.03, 0.12, 0.85, 0.8), (1.0, 1.0, 1.0, 0.8)
FULL_COLOR_AT = 1.5
# Of pinned faces around which directions are not to turn.
UNTURNED_COLOR = (0.45, 0.45, 0.45, 1.0)
# Opacity of colours through which the shading of Solid view is seen.
SHEER = 0.75
LOOP_COLOR, SPIRAL_COLOR = (1.0, 0.45, 0.0, 0.8), (0.85, 0.0, 0.5, 0.8)


def direction_marks(obj):
    """A short line, cross or arrow for the attribute ``synch_direction`` at the vertices."""
    return _directions(obj, lambda *field: direction_glyphs(*field, GLYPHS))


def direction_lines(obj):
    """Streamlines of the attribute ``synch_direction``."""
    return _directions(obj, lambda mesh, *field: evenly_traced(mesh, *field, STREAMLINES).segments(mesh))


def _directions(obj, draw):
    settings, obj = obj.synch, surface_of(obj)
    if DIRECTION.name not in obj.data.attributes:
        return []
    try:
        given = meshes.read_mesh(obj)
        vectors = attributes.read_vectors(obj, DIRECTION.name, given)
    except SynchError:  # the mesh was edited, and cannot carry a field any more
        return []
    segments = draw(given.mesh, vectors, SYMMETRY_ORDERS[settings.symmetry.lower()])
    return [(segments @ np.linalg.inv(given.stretch).T, DIRECTION_COLOR)]


@dataclass(frozen=True)
class Dots:
    """Defects of an object, as they are drawn: of which kinds, with their (n,) indices and faces and (n, 3) places.

    Faces are those of the mesh that carries the pattern.
    """

    kinds: np.ndarray
    indices: np.ndarray
    faces: np.ndarray
    places: np.ndarray

    @property
    def colours(self):
        """The colour of each."""
        return [DEFECT_COLORS[kind][int(index < 0)] for kind, index in zip(self.kinds, self.indices, strict=True)]


def defect_dots(obj):
    """The :class:`Dots` of an object, from the attributes that its defects were written to.

    A quad with a disclination has no index: what dislocation its other triangle has is a part of how its values close.
    """
    owner, obj = obj, surface_of(obj)
    kinds, indices, faces, places = [], [], [], []
    if len(obj.data.polygons):
        polygons = meshes.read_polygons(obj)
        corners = _shown_places(owner, len(obj.data.vertices))
        corners = attributes.read_values(obj, "position", "POINT") if corners is None else corners
        sums = np.add.reduceat(corners[polygons.corner_vertices], polygons.starts)
        centres, first = corners[polygons.triangles].mean(axis=1), polygons.first_triangles
        second = np.minimum(first + 1, len(centres) - 1)
        found = [(SINGULARITY, "disclination", sums / polygons.sizes[:, None])]
        for phase in (phase for of_kind in PHASES.values() for phase in of_kind):
            found += [(phase.index, "dislocation", centres[first]), (phase.index_2, "dislocation", centres[second])]
        for attribute, kind, at in found:
            index = attributes.read(obj, attribute)
            chosen = np.flatnonzero(index) if index is not None else []
            if len(chosen):
                kinds += [kind] * len(chosen)
                indices, faces, places = [*indices, *index[chosen]], [*faces, *chosen], [*places, *at[chosen]]
    return Dots(np.array(kinds), np.array(indices, float), np.array(faces, int), np.reshape(places, (-1, 3)))


def _shown_places(obj, count):
    """(count, 3) places at which an object shows the vertices of the mesh that carries its pattern; None where they
    are not known, or are those of that mesh."""
    if obj.is_evaluated or obj.mode == "EDIT" or not (obj.data.shape_keys or len(obj.modifiers)):
        return None
    if not shows_vertices_first(obj):
        return None
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    places = attributes.read_values(shown, "position", "POINT") if len(shown.data.vertices) >= count else None
    return None if places is None else places[:count]


def defect_points(obj):
    """The places of an object's :func:`defect_dots` by their colours."""
    dots = defect_dots(obj)
    return [
        (dots.places[[other == colour for other in dots.colours]], colour) for colour in dict.fromkeys(dots.colours)
    ]


def pin_points(obj):
    """The middles of the pinned faces, in the colours of the disclinations that are asked for there, or grey for none;
    nothing where pins cannot be read."""
    try:
        pins = parse_pins(obj.synch.pins)
    except SynchError:
        return []
    obj = surface_of(obj)
    faces = {face: turns for face, turns in pins.items() if 0 <= face < len(obj.data.polygons)}
    positive, negative = DEFECT_COLORS["disclination"]
    colours = [positive if turns > 0 else negative if turns < 0 else UNTURNED_COLOR for turns in faces.values()]
    middles = np.array([obj.data.polygons[face].center for face in faces]).reshape(-1, 3)
    return [(middles[[other == colour for other in colours]], colour) for colour in dict.fromkeys(colours)]


def spacing_errors(obj):
    """The faces in colours by the attribute ``synch_spacing_error``: red where lines are too far apart, blue where they
    are too near."""
    obj = surface_of(obj)
    errors = attributes.read(obj, SPACING_ERROR)
    if errors is None or not len(errors):
        return []
    polygons = meshes.read_polygons(obj)
    corners = attributes.read_values(obj, "position", "POINT")[polygons.triangles]
    return [(corners, error_colors(errors)[polygons.triangle_faces])]


def layer_faces(obj):
    """The faces of layers, as modifiers leave them, in the colours of their material."""
    obj = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    layers = attributes.read(obj, LAYER)
    if layers is None or not len(layers):
        return []
    polygons = meshes.read_polygons(obj)
    corners = attributes.read_values(obj, "position", "POINT")[polygons.triangles]
    return [(corners, layer_colors(layers)[polygons.triangle_faces])]


def sphere_faces(obj):
    """The faces of tubes, or of a surface with a flow, in the colours of the points of the sphere at their vertices."""
    colors = attributes.read(obj, COLOR)
    if colors is None or not len(obj.data.polygons):
        return []
    triangles = meshes.read_polygons(obj).triangles
    corners = attributes.read_values(obj, "position", "POINT")[triangles]
    return [(corners, (colors * (1, 1, 1, SHEER))[triangles])]


def painted_weights(obj):
    """The faces of a mesh in the colours of the map that is being painted, where Blender cannot show it: it draws
    weights on what modifiers leave, and the pattern's own surface has none."""
    group = obj.vertex_groups.active
    if obj.mode != "WEIGHT_PAINT" or surface_of(obj) == obj or group is None or not len(obj.data.polygons):
        return []
    triangles = meshes.read_polygons(obj).triangles
    colors = weight_colors(groups.read_weights(obj, group.name))
    return [(attributes.read_values(obj, "position", "POINT")[triangles], colors[triangles])]


def weight_colors(weights):
    """(n, 4) colours of weights, as Blender has them: blue at 0, green at a half, red at 1."""
    stops = np.array([(0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 1, 0), (1, 0, 0)], float)
    channels = [np.interp(weights, np.linspace(0, 1, len(stops)), channel) for channel in stops.T]
    dim = np.interp(weights, [0, 1], [0.5, 1.0])
    return np.column_stack([*(dim * channel for channel in channels), np.ones(len(weights))])


def error_colors(errors):
    """(k, 4) colours of spacings over the asked ones less 1: as strong for twice as for half the spacing."""
    strength = np.log1p(errors) / np.log(FULL_COLOR_AT)
    full = np.where(strength[:, None] > 0, WIDE_COLOR, NARROW_COLOR)
    return EVEN_COLOR + np.minimum(np.abs(strength), 1)[:, None] * (full - EVEN_COLOR)


def loop_faces(obj):
    """The faces of the loop of quads that passes through the object's chosen edge; a spiral has another colour."""
    edge = shown_edge(obj)
    if edge < 0 or not len(obj.data.polygons):
        return []
    faces, is_spiral = faces_of_loop(obj, edge)
    polygons = meshes.read_polygons(obj)
    triangles = polygons.triangles[faces[polygons.triangle_faces]]
    corners = attributes.read_values(obj, "position", "POINT")[triangles]
    colour = SPIRAL_COLOR if is_spiral else LOOP_COLOR
    return _not_empty([(corners, np.tile(colour, (len(corners), 1)))])


def constraint_lines(obj):
    """The edges that the constraint list and the boundary setting speak of; curves are seen by themselves."""
    if not len(obj.data.edges):
        return []
    settings = obj.synch
    rows = [(row.where, row.what, row.vertex_group) for row in settings.constraints if row.enabled]
    if settings.boundary != "FREE":
        rows.append(("BOUNDARY", settings.boundary, settings.vertex_group))
    ends = attributes.read_values(obj, ".edge_verts", "EDGE")
    segments = attributes.read_values(obj, "position", "POINT")[ends]
    return _not_empty(
        [(segments[_edges_at(obj, where, group, ends)], WISH_COLORS[what]) for where, what, group in rows]
    )


def _edges_at(obj, where, group, ends):
    """(e,) bool: edges that a row holds, none where the solve would refuse it."""
    chosen = np.zeros(len(ends), bool)
    if where in ("SEAMS", "SHARP", "CREASES"):
        marked = attributes.read_values(obj, attributes.MARKS[where.lower()], "EDGE")
        return chosen if marked is None else marked > 0
    if where == "BOUNDARY" and len(obj.data.polygons):
        chosen = np.bincount(attributes.read_values(obj, ".corner_edge", "CORNER"), minlength=len(ends)) == 1
    if where == "GROUP":
        chosen[:] = bool(group)
    if group:
        try:
            chosen &= groups.read_group(obj, group)[ends].all(axis=1)
        except SynchError:  # no such group, or an empty one
            chosen[:] = False
    return chosen


def _not_empty(layers):
    return [(points, colour) for points, colour in layers if len(points)]
