# SPDX-License-Identifier: GPL-3.0-or-later
"""Where layers cross the edges of a solid, and the polygons that join the crossings in regular tetrahedra.

Counting decides: a vertex is above or below a level, never on it. One that is nearer to a level than ``ASIDE`` periods
is moved off it, and the crossings beside it are put back onto it, so that polygons there shrink to edges and points, or
become whole faces where a layer lies on faces.

Faces of the boundary on which a layer lies become part of it, and their vertices move to the side of the solid, so that
nothing else is found beside them.
"""

from dataclasses import dataclass

import numpy as np

from ...geometry.tet_mesh import TetMesh
from ...graphs import components, ragged_arange
from ...interpolate import TURN, EdgePhases
from ...interpolate_solid import EDGE_CORNERS, FACE_CORNERS
from ...memory import check_memory
from ..lines.edge_crossings import refuse_more

# Vertices this near to a level are moved off it, in periods.
ASIDE = 1e-7
# 630 were measured for a million crossings.
BYTES_PER_CROSSING = 650


@dataclass(frozen=True)
class LayerCrossings:
    """Phases in periods, moved so that none is on a level, and the places where levels cross the edges.

    Attributes
    ----------
    phases : (n,) at the vertices
    changes : (e,) along the edges from the lower to the higher vertex
    starts, counts : (e,) the crossings of each edge follow one another from its lower vertex
    edges, shares : (c,) edge of each crossing and how far along it
    nodes : (c,) the number of the crossing, or c + v where it is put back onto vertex v
    faces : (f, 3) vertices of the boundary's faces on which a layer lies, with normals to larger phases
    """

    mesh: TetMesh
    phases: np.ndarray
    changes: np.ndarray
    starts: np.ndarray
    counts: np.ndarray
    edges: np.ndarray
    shares: np.ndarray
    nodes: np.ndarray
    faces: np.ndarray


def refuse_too_many_layers(changes: np.ndarray) -> None:
    """Refuse changes of the phase along edges, in radians, with more crossings than allowed or than memory holds."""
    count = np.abs(changes).sum() / TURN
    refuse_more(count, "the layers cross the solid's edges", 1)
    check_memory(BYTES_PER_CROSSING * count, f"layers that cross the solid's edges {count:.2g} times")


def crossings_of(edge_phases: EdgePhases[TetMesh]) -> LayerCrossings:
    """Find where the levels 2 pi k cross the edges of a solid; errors as :func:`refuse_too_many_layers`."""
    mesh = edge_phases.mesh
    refuse_too_many_layers(edge_phases.changes)
    given, changes = edge_phases.arguments[:, 0] / TURN, edge_phases.changes[:, 0] / TURN
    # Phases on a level, up to rounding, are moved to one side of it by ASIDE, so that every crossing is inside an edge.
    near = np.abs(given - np.rint(given)) < ASIDE
    faces, sides = _layers_on_boundary(mesh, near, changes)
    phases = np.where(near, np.rint(given) + ASIDE * sides, given)
    i, j = mesh.edges.T
    changes = changes + (phases - given)[j] - (phases - given)[i]
    begins, ends = phases[i], phases[i] + changes
    rising = changes > 0
    first = np.where(rising, np.floor(begins) + 1, np.ceil(begins) - 1)
    counts = np.where(rising, np.ceil(ends) - first, first - np.floor(ends)).astype(int)
    edges, place = ragged_arange(counts)
    levels = first[edges] + np.where(rising, 1, -1)[edges] * place
    shares = np.clip((levels - begins[edges]) / changes[edges], 0, 1)
    # Crossings beside a vertex that was on the level become the vertex itself.
    at_begin = near[i][edges] & (levels == np.rint(begins[edges]))
    at_end = near[j][edges] & (levels == np.rint(ends[edges]))
    nodes = np.arange(len(edges))
    nodes[at_begin] = len(edges) + i[edges[at_begin]]
    nodes[at_end] = len(edges) + j[edges[at_end]]
    return LayerCrossings(mesh, phases, changes, np.cumsum(counts) - counts, counts, edges, shares, nodes, faces)


def _layers_on_boundary(mesh: TetMesh, near: np.ndarray, changes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces of the boundary that lie on a level, and (n,) +-1: the side to which vertices move."""
    sides = np.ones(mesh.vertex_count)
    triangles = mesh.boundary_triangles
    flat = near[triangles].all(axis=1)
    for k in range(3):
        flat[flat] &= np.abs(changes[mesh.edges_between(triangles[flat, k - 1], triangles[flat, k])]) < 2 * ASIDE
    triangles, face = triangles[flat], mesh.boundary_faces[flat]
    if len(face) == 0:
        return triangles, sides
    tet = mesh.face_tets[face, 0]
    behind = mesh.tets[tet, np.argmax(mesh.tet_faces[tet] == face[:, None], axis=1)]
    inward = changes[mesh.edges_between(triangles[:, 0], behind)]
    inward = np.where(triangles[:, 0] < behind, inward, -inward)
    votes = np.where(np.abs(inward) < 2 * ASIDE, 0, np.sign(inward))
    at_vertex = np.bincount(triangles.ravel(), np.repeat(votes, 3), mesh.vertex_count)
    patches = components(mesh.vertex_count, triangles[:, [0, 1, 1, 2]].reshape(-1, 2))
    at_patch = np.bincount(patches[triangles[:, 0]], votes, patches.max() + 1)
    vertices = np.unique(triangles)
    sides[vertices] = np.where(at_vertex == 0, at_patch[patches], at_vertex)[vertices] >= 0
    sides[vertices] = 2 * sides[vertices] - 1
    outward = at_patch[patches[triangles[:, 0]]] < 0
    return np.where(outward[:, None], triangles, triangles[:, ::-1]), sides


def polygons_in(crossings: LayerCrossings, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(p, 3) triangles and (q, 4) quads of crossings, the levels in (t,) tetrahedra without a punctured face; their
    normals point to larger phases."""
    mesh = crossings.mesh
    corners, edges = mesh.tets[tets], mesh.tet_edges[tets]
    values = np.repeat(crossings.phases[corners[:, :1]], 4, axis=1)
    values[:, 1:] += np.where(corners[:, :1] < corners[:, 1:], 1, -1) * crossings.changes[edges[:, :3]]
    first = np.floor(values.min(axis=1)) + 1
    counts = np.maximum(np.ceil(values.max(axis=1)) - first, 0).astype(int)
    row, place = ragged_arange(counts)
    levels = first[row] + place
    pattern = (values[row] > levels[:, None]) @ (1 << np.arange(4))
    parts = []
    for patterns, table in _POLYGONS:
        chosen = np.isin(pattern, patterns)
        local = table[pattern[chosen]]
        parts.append(_crossings_at(crossings, corners, edges, values, row[chosen, None], levels[chosen, None], local))
    return parts[0], parts[1]


def _crossings_at(
    crossings: LayerCrossings,
    corners: np.ndarray,
    edges: np.ndarray,
    values: np.ndarray,
    row: np.ndarray,
    levels: np.ndarray,
    local: np.ndarray,
) -> np.ndarray:
    """Numbers of the crossings of local edges with levels, which each tetrahedron counts from its first corner."""
    edge = edges[row, local]
    i, j = EDGE_CORNERS.T
    lower = np.where(corners[row, i[local]] < corners[row, j[local]], i[local], j[local])
    phases, rising = crossings.phases[corners[row, lower]], crossings.changes[edge] > 0
    own = levels - np.rint(values[row, lower] - phases)
    place = np.where(rising, own - np.floor(phases) - 1, np.ceil(phases) - 1 - own)
    return crossings.starts[edge] + place.astype(int)


def _polygon_tables() -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """For triangles and for quads: the patterns of corners above (bits), and (16, size) local edges of the polygon."""
    number = np.zeros((4, 4), int)
    for edge, (i, j) in enumerate(EDGE_CORNERS):
        number[i, j] = number[j, i] = edge
    triangles, quads = np.zeros((16, 3), int), np.zeros((16, 4), int)
    for corner, others in enumerate(FACE_CORNERS):
        triangles[15 - (1 << corner)] = number[corner, others]
        triangles[1 << corner] = number[corner, others[::-1]]
    for a, b, c, d in [(0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (2, 3, 0, 1), (1, 3, 2, 0), (1, 2, 0, 3)]:
        quads[(1 << a) + (1 << b)] = number[[a, b, b, a], [c, c, d, d]]
    sizes = np.array([bin(k).count("1") for k in range(16)])
    return (np.flatnonzero(sizes % 2), triangles), (np.flatnonzero(sizes == 2), quads)


_POLYGONS = _polygon_tables()
