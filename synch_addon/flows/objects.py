# SPDX-License-Identifier: GPL-3.0-or-later
"""What is shown of a solved flow: filaments as a curve object, tubes as a mesh coloured by the sphere.

First plain arrays (:func:`showing`), which may be computed in another thread, then the objects, made or filled anew.
"""

import math
from dataclasses import dataclass

import bpy
import numpy as np

from ...core.extract.filaments import Filament, filaments
from ...core.extract.isosurface import evened, isosurface
from ...core.fields.clebsch import ClebschMap, SphericalMap
from ..nodes.globe import SPHERE
from ..nodes.materials import pattern_material
from ..nodes.vortices import COLOR, STRENGTH, add_filaments_modifier

# Radius of a filament's tube in cells of the grid.
_THICKNESS = 0.25
# How far a tube's vertices are moved from the nodes of the grid before they are evened, as a share of its edges.
_MARGIN = 0.25
NORTH = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Tubes:
    """A surface around vortices.

    Attributes
    ----------
    vertices, triangles : (n, 3) and (m, 3)
    sphere : (n, 3) point of the sphere at each vertex
    strength : circulation around one that the map covers once
    pieces : connected parts
    """

    vertices: np.ndarray
    triangles: np.ndarray
    sphere: np.ndarray
    strength: float
    pieces: int


@dataclass(frozen=True)
class Shown:
    """What is shown of a map.

    Attributes
    ----------
    lines : list of Filament, or None where they are not asked for
    tubes : Tubes, or None
    quantum : circulation of one filament
    thickness : radius of one, in scene units
    """

    lines: list[Filament] | None
    tubes: Tubes | None
    quantum: float
    thickness: float


def seen(found: ClebschMap, sphere: SphericalMap | None, point) -> ClebschMap:
    """The map that a point of the sphere gives, the best one for None."""
    return found if point is None else sphere.seen_from(point)


def showing(found: ClebschMap, sphere: SphericalMap | None, settings) -> Shown:
    """What settings ask to see of a map and the sphere; that may be missing where there are only filaments."""
    lines = filaments(found, settings.smoothing) if settings.show != "tubes" else None
    tubes = _tubes(sphere, settings) if settings.show != "filaments" else None
    return Shown(lines, tubes, found.quantum, _THICKNESS * float(found.grid.spacing.min()))


def _tubes(sphere, settings):
    axis = -np.array(settings.point or NORTH, float)
    axis /= np.linalg.norm(axis)
    angle = math.radians(settings.opening)
    margin = _MARGIN if settings.smoothing else 0
    surface = isosurface(sphere.found.grid, sphere.sphere @ axis, math.cos(angle), margin)
    between = evened(surface.mesh, surface.interpolated(sphere.sphere), settings.smoothing)
    # The map is on the circle there: only how far around it is taken from between the nodes.
    around = between - (between @ axis)[:, None] * axis
    around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), 1e-12)
    shown = math.cos(angle) * axis + math.sin(angle) * around
    places = evened(surface.mesh, surface.mesh.vertices, settings.smoothing)
    strength = sphere.found.quantum * 0.5 * (1 - math.cos(angle))
    pieces = int(surface.mesh.pieces.max(initial=-1)) + 1
    return Tubes(places, surface.mesh.triangles, shown, strength, pieces)


def make_filaments(name, shown):
    """A curve object with a spline for every filament."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    made = bpy.data.objects.new(name, data)
    fill_filaments(made, shown)
    add_filaments_modifier(made, shown.thickness, shown.quantum)
    return made


def fill_filaments(obj, shown):
    """Put filaments into a curve object in place of what it has."""
    data = obj.data
    obj[STRENGTH] = shown.quantum
    data.splines.clear()
    for line in shown.lines:
        spline = data.splines.new("POLY")
        spline.points.add(len(line.points) - 1)
        points = np.column_stack([line.points, np.ones(len(line.points))]).astype(np.float32)
        spline.points.foreach_set("co", points.ravel())
        spline.use_cyclic_u = line.is_closed
        # Thicker where several lie on each other.
        thickness = math.sqrt(line.strength / shown.quantum)
        spline.points.foreach_set("radius", np.full(len(points), thickness, np.float32))


def make_tubes(name, shown):
    """A mesh object with the tubes."""
    made = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    fill_tubes(made, shown)
    pattern_material(made, "tubes")
    return made


def fill_tubes(obj, shown):
    """Put tubes into a mesh object in place of what it has; its materials stay."""
    data, tubes = obj.data, shown.tubes
    obj[STRENGTH] = tubes.strength
    data.clear_geometry()
    corners = len(tubes.triangles) * 3
    data.vertices.add(len(tubes.vertices))
    data.loops.add(corners)
    data.polygons.add(len(tubes.triangles))
    data.vertices.foreach_set("co", tubes.vertices.astype(np.float32).ravel())
    data.loops.foreach_set("vertex_index", tubes.triangles.astype(np.int32).ravel())
    data.polygons.foreach_set("loop_start", np.arange(0, corners, 3, dtype=np.int32))
    data.update(calc_edges=True)
    data.shade_smooth()
    colors = np.column_stack([0.5 + 0.5 * tubes.sphere, np.ones(len(tubes.sphere))])
    for attribute, kind, field, values in (
        (SPHERE, "FLOAT_VECTOR", "vector", tubes.sphere),
        (COLOR, "FLOAT_COLOR", "color", colors),
    ):
        data.attributes.new(attribute, kind, "POINT").data.foreach_set(field, values.astype(np.float32).ravel())


def present(objects):
    """Put new objects into the scene, selected, the last one active."""
    layer = bpy.context.view_layer
    for other in layer.objects:
        other.select_set(False)
    for made in objects:
        bpy.context.scene.collection.objects.link(made)
        made.select_set(True)
    layer.objects.active = objects[-1]


def fill(solved, found, objects):
    """Show a map of a solved flow in the objects that were made for it; returns the facts."""
    shown = showing(found, solved.sphere, solved.settings)
    for obj in objects:
        if obj.type == "CURVE" and shown.lines is not None:
            fill_filaments(obj, shown)
        elif obj.type == "MESH" and shown.tubes is not None:
            fill_tubes(obj, shown)
    return facts(shown)


def missing(shown):
    """Lines that say what a map shows nothing of, and the remedy."""
    remedy = "ask for more filaments, or a smaller circulation of each"
    if shown.lines == []:
        yield f"the map has no filaments: {remedy}"
    if shown.tubes is not None and not len(shown.tubes.triangles):
        yield f"the map does not come so near to the point's antipode: make the tubes wider, or {remedy}"


def facts(shown):
    """What a report says about the filaments and the tubes."""
    result = {}
    if shown.lines is not None:
        result["filaments"] = [
            {
                "strength": line.strength,
                "closed": line.is_closed,
                "points": len(line.points),
                "length": line.length,
            }
            for line in shown.lines
        ]
    if shown.tubes is not None:
        result["tubes"] = {"faces": len(shown.tubes.triangles), "pieces": shown.tubes.pieces}
    return result
