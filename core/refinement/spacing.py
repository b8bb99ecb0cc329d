# SPDX-License-Identifier: GPL-3.0-or-later
"""The spacing of lines on a surface that settings ask for, automatic ones included, and the edges that it needs."""

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingError, round_up
from ..geometry.check import refuse_far_vertices
from ..geometry.mesh_input import MeshInput, ObjectMesh
from ..geometry.mirror import are_divided_by_edges, is_mirrored, mirror_planes
from ..geometry.triangle_mesh import TriangleMesh
from ..geometry.welding import boundary_splits, welded_vertices
from ..settings.surface import QUADS as QUAD_COMMANDS
from ..settings.surface import SurfaceSettings
from .bound_surface import BoundSurface, TooFineError, refine

# The largest share of edges along which a phase may turn by more than half a period.
COARSE_SHARE = 0.05
# Spacings below this share of the object are too fine for phases in double precision.
_FINEST = 1e-9
# Automatic spacing: number of stripes or quads across the object, and least number of edges per period.
LINES_ACROSS = 40
EDGES_PER_PERIOD = 4
FEWEST_LINES = 2
# Faces that carry fewer lines than this across are replaced by a finer copy; edges may be longer than asked by SLACK.
FEW_LINES = LINES_ACROSS // 3
SLACK = 1.1
# A mesh whose edges carry fewer quads than the first is solved on a finer copy, with about as many quads as the second;
# stripes are as wide as quads.
FEWEST_QUADS, QUADS = 50, 1500
# An edge is short enough if it is at most this share of a period: the side of a quad.
EDGE_SHARE = 0.5
# Edges of a finer copy are at most this share of that, as quads become a little smaller than asked.
_MARGIN = 0.9
# Triangles with an edge this many times as long as that may cover COARSE_SHARE of the surface.
_TOO_LONG = 2.0


def automatic_spacing(mesh: TriangleMesh, per_period: int, across: float = LINES_ACROSS) -> float:
    """Choose a spacing for a surface: about ``across`` lines across its longest side, or as many as its edges carry, of
    which ``per_period`` make a period: 1 for stripes, 2 for quads.

    If its edges carry very few lines, a finer copy will be made, and the spacing follows from the area.
    """
    return spacing_across(_size(mesh), mesh.areas.sum(), carried_spacing(mesh.edge_lengths), per_period, across)


def spacing_across(size: float, area: float, finest: float, per_period: int, across: float = LINES_ACROSS) -> float:
    """Choose as :func:`automatic_spacing` from a surface's longest side, area, and finest spacing that it carries."""
    if finest <= 2 * np.sqrt(area / FEWEST_QUADS):
        return spacing_carried(size, finest, per_period, across)
    return wished_spacing(area, per_period) * LINES_ACROSS / across


def spacing_on_faces(mesh: TriangleMesh, per_period: int) -> float:
    """Choose as :func:`automatic_spacing` without a finer copy: as many lines as the edges carry, at least two."""
    return spacing_carried(_size(mesh), carried_spacing(mesh.edge_lengths), per_period)


def spacing_carried(size: float, finest: float, per_period: int, across: float = LINES_ACROSS) -> float:
    """Choose as :func:`spacing_on_faces` from a surface's longest side and finest spacing that it carries."""
    return float(min(max(per_period * size / across, finest), per_period * size / FEWEST_LINES))


def _size(mesh: TriangleMesh) -> float:
    """Compute the longest side of the box around a mesh's triangles."""
    return np.ptp(mesh.vertices[mesh.used_vertices], axis=0).max()


def wished_spacing(area: float, per_period: int) -> float:
    """Compute the automatic spacing of a surface that is refined as needed."""
    return float(per_period * np.sqrt(area / QUADS))


def carried_spacing(lengths: np.ndarray) -> float:
    """Compute the finest spacing for (e,) edge lengths: four median edges, and at least two of the longest."""
    median, long = np.quantile(lengths, [0.5, 1 - COARSE_SHARE])
    return float(max(EDGES_PER_PERIOD * median, long / EDGE_SHARE))


def longest_edge(mesh: TriangleMesh, spacings: ArrayLike) -> float | None:
    """Compute the longest edge of a finer copy for one spacing, or one at each vertex (and axis); None without need.

    A mesh is fine enough if few edges are longer than the side of a quad, and few of its triangles have much longer
    edges.
    """
    at_vertices = np.asarray(spacings, float)
    at_vertices = at_vertices.min(axis=1) if at_vertices.ndim == 2 else at_vertices
    limits = EDGE_SHARE * (at_vertices[mesh.edges.T].min(axis=0) if at_vertices.ndim else at_vertices)
    much_longer = (mesh.edge_lengths > _TOO_LONG * limits)[mesh.triangle_edges].any(axis=1)
    few = (mesh.edge_lengths > limits).mean() <= COARSE_SHARE
    is_fine = few and mesh.areas[much_longer].sum() <= COARSE_SHARE * mesh.areas.sum()
    return None if is_fine else _MARGIN * EDGE_SHARE * float(np.quantile(at_vertices, COARSE_SHARE))


def lines_in_period(command: str) -> int:
    """A period has one stripe, and two quads."""
    return 2 if command in QUAD_COMMANDS else 1


def carries_few_lines(command: str, size: float, spacing: float) -> bool:
    """Whether an automatic spacing gives so few lines across a size that a finer surface is worth it."""
    return spacing > SLACK * lines_in_period(command) * size / FEW_LINES


def is_fine(command: str, given: MeshInput, settings: SurfaceSettings, factors: float | np.ndarray = 1.0) -> bool:
    """Whether faces carry the pattern asked for: their edges are short enough, joined where they meet, mirror images of
    others, and for quad meshes along a mirror plane.

    ``factors`` are one, or (n,) on the spacing. SettingError as of :func:`asked_spacings`.
    """
    uncut, mesh, spacing = given.uncut, given.mesh, settings.spacing
    if spacing is None:
        spacing = automatic_spacing(mesh, lines_in_period(command))
        has_count = command == "quad_mesh" and settings.faces
        if not has_count and carries_few_lines(command, _size(mesh), spacing):
            return False
    if _asked_edges(command, mesh, settings, spacing, factors)[2] is not None:
        return False
    units = mirror_planes(given.stretch, settings.mirror)
    # Cut at two planes, a face that lies across both is not always mirrored.
    if command == "quad_mesh" and len(units) == 1 and not are_divided_by_edges(mesh, units):
        return False
    if not is_mirrored(uncut, given.polygons, settings.mirror):
        return False
    if len(uncut.boundary_edges) == 0:
        return True
    if len(boundary_splits(uncut.vertices, uncut.triangles)[0]):
        return False
    return bool((welded_vertices(uncut.vertices, uncut.triangles) == np.arange(uncut.vertex_count)).all())


def finer_copy(
    command: str,
    read: ObjectMesh,
    edges: np.ndarray,
    given: MeshInput,
    settings: SurfaceSettings,
    factors: float | np.ndarray = 1.0,
    may_replace: bool = False,
) -> BoundSurface:
    """The finer copy of an object's mesh, with (e, 2) edges, that carries the pattern asked for; SettingError where it
    would have too many faces.

    ``given`` is the same mesh, repaired; the factors on the spacing are one or (n,). ``may_replace`` is of
    :func:`refine`.
    """
    mesh, longest = given.mesh, None
    spacing = settings.spacing or wished_spacing(mesh.areas.sum(), lines_in_period(command))
    spacings: float | np.ndarray = spacing
    if command != "directions":
        spacing, spacings, longest = _asked_edges(command, mesh, settings, spacing, factors)
    refuse_far_vertices(mesh)
    axes = ["XYZ".index(axis) for axis in settings.mirror]
    try:
        return refine(read, edges, np.inf if longest is None else longest, axes, may_replace)
    except TooFineError as error:
        factor = error.factor
    if command != "quad_mesh" or not settings.faces:
        raise SettingError(
            f"the spacing {spacing:g} is too fine for this mesh: use one from {round_up(factor * spacing)} on"
        )
    fitting = faces_of_factor(mesh, spacings, factor)
    if fitting < 1:
        raise SettingError(
            "parts of this mesh are too long and thin for quads: delete vertices that lie far out, or remesh it"
        )
    raise SettingError(f"{settings.faces} faces are too many for this mesh: ask for {fitting} at most")


def _asked_edges(
    command: str, mesh: TriangleMesh, settings: SurfaceSettings, spacing: float, factors: float | np.ndarray
) -> tuple[float, float | np.ndarray, float | None]:
    """Call :func:`asked_spacings`, then :func:`longest_edge`; returns the spacing, its map, and the longest edge.

    Far vertices are refused rather than a spacing that suits their distance.
    """
    try:
        spacing, spacings = asked_spacings(command, mesh, settings, spacing, factors)
        return spacing, spacings, longest_edge(mesh, spacings)
    except SettingError:
        refuse_far_vertices(mesh)
        raise


def asked_spacings(
    command: str, mesh: TriangleMesh, settings: SurfaceSettings, spacing: float, factors: float | np.ndarray = 1.0
) -> tuple[float, float | np.ndarray]:
    """The spacing, and that times its map: for quads with an aspect (n, 2); both as the face count asks, if there is
    one. SettingError for a spacing that does not fit the mesh."""
    spacings = spacing * factors
    if settings.symmetry == "cross" and settings.aspect != 1:
        spacings = np.reshape(spacings, (-1, 1)) * [1.0, settings.aspect]
    if command == "quad_mesh" and settings.faces:
        check_lengths(spacings)
        factor = spacing_factor(mesh, spacings, settings.faces)
        return factor * spacing, factor * spacings
    check_spacing(mesh.vertices[mesh.used_vertices], spacings)
    return spacing, spacings


def check_spacing(places: np.ndarray, spacing: ArrayLike, what: str = "stripe") -> None:
    """Refuse a spacing, one length or one at each vertex (and axis), larger than what the (n, 3) places of vertices
    span, or too fine for double precision; messages call the spaced thing ``what``."""
    spacing = check_lengths(spacing)
    extent = np.linalg.norm(np.ptp(places, axis=0))
    if spacing.min() > extent:
        raise SettingError(
            f"the spacing {spacing.min():g} is larger than the object ({extent:g}): no {what} would fit, reduce it"
        )
    if spacing.min() < _FINEST * extent:
        raise SettingError(
            f"the spacing {spacing.min():g} is finer than the precision of coordinates on an object of {extent:g}: "
            f"give one from {1.1 * _FINEST * extent:.2g} on"
        )


def check_lengths(spacing: ArrayLike) -> np.ndarray:
    """Spacings, one or one at each vertex (and axis), as an array; refuses those that are not positive lengths."""
    spacing = np.asarray(spacing, float)
    bad = np.argwhere(~(np.isfinite(spacing) & (spacing > 0)))
    if len(bad):
        where = f" at vertex {bad[0][0]} ({len(bad)} in all)" if spacing.ndim else ""
        raise SettingError(f"the spacing is {spacing[tuple(bad[0])]:g}{where}: give a positive length")
    return spacing


def spacing_factor(mesh: TriangleMesh, spacings: ArrayLike, faces: int) -> float:
    """The factor of spacings that gives about a number of quads on a flat surface.

    It is large enough for the quads to reach from one end of each component to the other. Spacings are one number,
    (n,), or (n, 2) or (1, 2) along two axes.
    """
    return float(max(_area_factor(mesh, spacings) / np.sqrt(faces), least_factor(mesh, spacings, faces)))


def faces_of_factor(mesh: TriangleMesh, spacings: ArrayLike, factor: float) -> int:
    """The number of quads for which :func:`spacing_factor` returns the given factor, rounded down."""
    return int(max((_area_factor(mesh, spacings) / factor) ** 2, least_factor(mesh, spacings, 1) / factor))


def _area_factor(mesh: TriangleMesh, spacings: ArrayLike) -> float:
    """The factor with which one quad is as large as the surface."""
    sides = np.broadcast_to(_along_axes(spacings), (mesh.vertex_count, 2)) / 2
    return float(np.sqrt((mesh.vertex_masses / sides.prod(axis=1)).sum()))


def least_factor(mesh: TriangleMesh, spacings: ArrayLike, faces: int) -> float:
    """Find the factor on spacings with which ``faces`` quads, corner to corner, are as long as the longest component.

    The area of a needle is too small to determine a spacing.
    """
    low, high = np.full((2, mesh.vertex_count, 3), np.inf)
    np.minimum.at(low, mesh.pieces, mesh.vertices)
    np.minimum.at(high, mesh.pieces, -mesh.vertices)
    present = np.unique(mesh.pieces[mesh.triangles])
    reach = (-high[present] - low[present]).max()
    return float(reach / (np.sqrt(0.5) * np.asarray(spacings).max() * faces))


def smallest_sides(mesh: TriangleMesh, spacings: ArrayLike) -> np.ndarray:
    """(n,) the shorter side of a quad at each vertex; spacings as of :func:`spacing_factor`."""
    return np.broadcast_to(_along_axes(spacings).min(axis=1) / 2, mesh.vertex_count)


def _along_axes(spacings: ArrayLike) -> np.ndarray:
    spacings = np.asarray(spacings, float)
    return spacings if spacings.ndim == 2 else np.repeat(spacings.reshape(-1, 1), 2, axis=1)
