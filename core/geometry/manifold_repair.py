# SPDX-License-Identifier: GPL-3.0-or-later
"""Repair of a mesh: a surface of its faces that is manifold, consistently oriented and without faces of no area.

Faces that cannot be part of a surface are left out. Where more than two meet at an edge, those that bend least stay
joined; solids that touch at an edge are separated. Then vertices are split, one copy for each fan of faces.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree

from ..errors import name_elements
from ..graphs import components, label_rows
from .check import FLAT_FACE, check_mesh, flat_faces
from .cut import cut_all_but
from .face_orientation import orient_faces
from .nonmanifold_pairing import pair_half_edges
from .polygons import Polygons, find_duplicates, match_corners
from .triangle_mesh import TriangleMesh
from .vertex_splitting import next_half_edges, split_pinched_vertices

# Kinds of findings: the element, what is wrong with it, and what is done about it.
KINDS = {
    "joined_vertices": ("vertex", "the same place as another on the other side of a gap", "they count as one"),
    "lost_vertices": ("vertex", "no finite position", "their faces are left out"),
    "flat_faces": ("face", "no area", "left out of the surface"),
    "doubled_faces": ("face", "the same corners as another face", "they count once, and show the same as it"),
    "non_manifold_edges": ("edge", "three or more faces", "the two that bend least stay joined, others are separated"),
    "pinched_vertices": ("vertex", "faces that touch only at this point", "they are separated"),
    "turned_faces": ("face", "the opposite orientation of their neighbours", "they count as turned over"),
    "one_sided_edges": ("edge", "both sides of a one-sided surface", "cut there, with the same pattern on both sides"),
}
# Findings whose vertices have copies, each with its own values.
APART = ("non_manifold_edges", "pinched_vertices", "one_sided_edges")


@dataclass(frozen=True)
class Finding:
    """Elements at which the repaired surface differs from the given mesh.

    Attributes
    ----------
    name : one of :data:`KINDS`
    elements : (k,) numbers of vertices or faces, or (k, 2) ends of edges
    """

    name: str
    elements: np.ndarray

    @property
    def kind(self) -> str:
        """Kind of its elements: "vertex", "edge" or "face"."""
        return KINDS[self.name][0]

    @property
    def line(self) -> str:
        """Description of the problem and of what is done about it."""
        kind, what, done = KINDS[self.name]
        count = len(self.elements)
        if kind == "edge":
            named = "the edge between vertices {} and {}".format(*self.elements[0])
            named += f" and {count - 1} more" if count > 1 else ""
        else:
            named = name_elements(kind, self.elements)
        return f"{named} {'has' if count == 1 else 'have'} {what}: {done}"


@dataclass(frozen=True)
class RepairedMesh:
    """The repaired surface, and the elements of the given mesh that its elements come from.

    Attributes
    ----------
    polygons : all given faces; only those in the surface have triangles, in the order of ``mesh``
    source : (n,) given vertex of each vertex: the given ones first, then their copies
    own : (k,) vertex that represents each given one: itself, or one at the same place
    across : (s, 2) half-edges on the two sides along which a one-sided surface is open, with the same first vertex
    """

    mesh: TriangleMesh
    polygons: Polygons
    source: np.ndarray
    own: np.ndarray
    across: np.ndarray
    findings: tuple[Finding, ...]


def repair_mesh(mesh: TriangleMesh, polygons: Polygons) -> RepairedMesh:
    """Repair a mesh that :func:`check_mesh` refuses; its triangles are those of the polygons.

    Raises MeshError if no face is left.
    """
    lost = ~np.isfinite(mesh.vertices).all(axis=1)
    vertices = finite_places(mesh.vertices)
    is_lost = np.logical_or.reduceat(lost[polygons.corner_vertices], polygons.starts)
    is_flat = flat_faces(TriangleMesh(vertices, mesh.triangles), polygons.triangle_faces) | _repeats_vertex(polygons)
    is_flat &= ~is_lost
    own = _represent_all(polygons, vertices, is_flat, is_lost)
    polygons = replace(polygons, corner_vertices=own[polygons.corner_vertices])
    first = _find_duplicates(polygons, ~is_lost & ~is_flat)
    is_double = first != np.arange(len(first))
    kept = ~(is_lost | is_flat | is_double)
    if not kept.any():
        check_mesh(mesh, polygons.triangle_faces)
    rows = kept[polygons.triangle_faces]
    faces, corners = polygons.triangle_faces[rows], polygons.triangle_corners[rows]
    whole = TriangleMesh(vertices, own[mesh.triangles[rows]])
    joins = pair_half_edges(whole, faces)
    turned, seam = orient_faces(whole, faces, joins)
    corners = np.where(turned[faces, None], corners[:, ::-1], corners)
    # The same half-edges in triangles that are turned over.
    halves = np.where(turned[faces[joins // 3]], joins - joins % 3 + np.array([1, 0, 2])[joins % 3], joins)
    surface, source = _split_into_fans(TriangleMesh(vertices, polygons.corner_vertices[corners]), faces, halves[~seam])
    alike = match_corners(polygons, first)
    corner_vertices = polygons.corner_vertices.copy()
    corner_vertices[corners] = surface.triangles
    fans, counts = np.unique(split_pinched_vertices(whole.triangles)[0], return_counts=True)
    one_sided = np.unique(whole.triangle_edges.ravel()[joins[seam, 0]])
    found = {
        "lost_vertices": np.flatnonzero(lost),
        "flat_faces": np.flatnonzero(is_flat),
        "doubled_faces": np.flatnonzero(is_double),
        "non_manifold_edges": whole.edges[whole.edge_face_counts > 2],
        "pinched_vertices": fans[counts > 1],
        "turned_faces": np.flatnonzero(turned),
        "one_sided_edges": whole.edges[one_sided],
    }
    return RepairedMesh(
        surface,
        Polygons(corner_vertices[alike], polygons.starts, polygons.sizes, corners, faces, alike),
        source,
        own,
        halves[seam],
        tuple(Finding(name, elements) for name, elements in found.items() if len(elements)),
    )


def find_seam_ends(mesh: TriangleMesh, across: np.ndarray) -> np.ndarray:
    """Find the (k, 2) pairs of vertices on the two sides of a seam, (s, 2) half-edges: a spanning forest of them."""
    pairs = mesh.triangles.ravel()[np.concatenate([across, next_half_edges(across)])]
    nodes, names = np.unique(pairs, return_inverse=True)
    names = names.reshape(pairs.shape)
    graph = coo_array((np.ones(len(pairs)), names.T), shape=(len(nodes),) * 2)
    return np.sort(nodes[np.column_stack(minimum_spanning_tree(graph).nonzero())], axis=1)


def finite_places(vertices: np.ndarray) -> np.ndarray:
    """Replace (n, 3) points that are not finite by the first finite one."""
    finite = np.isfinite(vertices).all(axis=1)
    return vertices if finite.all() else np.where(finite[:, None], vertices, vertices[np.argmax(finite)])


def _represent_all(polygons: Polygons, vertices: np.ndarray, is_flat: np.ndarray, is_lost: np.ndarray) -> np.ndarray:
    """Find the (n,) vertex that represents each: the first at the same place that edges of flat faces join, so that the
    surface closes where these faces were; itself if another face has two of them."""
    ahead = np.arange(len(polygons.corner_vertices)) + 1
    ahead[polygons.starts + polygons.sizes - 1] = polygons.starts
    ends = np.column_stack([polygons.corner_vertices, polygons.corner_vertices[ahead]])
    lengths = np.linalg.norm(np.diff(vertices[ends], axis=1)[:, 0], axis=1)
    reach = np.maximum.reduceat(lengths, polygons.starts)[polygons.corner_faces]
    joined = is_flat[polygons.corner_faces] & (lengths <= 2 * FLAT_FACE * reach)
    places = components(len(vertices), ends[joined])
    within = ~(is_flat | is_lost)[polygons.corner_faces]
    twice = _find_repeated(polygons.corner_faces[within], places[polygons.corner_vertices[within]])[1]
    first = np.unique(places, return_index=True)[1]
    return np.where(np.isin(places, twice), np.arange(len(places)), first[places])


def _find_repeated(faces: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """List the faces and labels for which two corners of a face have the same label."""
    order = np.lexsort((labels, faces))
    faces, labels = faces[order], labels[order]
    same = np.flatnonzero((faces[1:] == faces[:-1]) & (labels[1:] == labels[:-1]))
    return faces[same], labels[same]


def _repeats_vertex(polygons: Polygons) -> np.ndarray:
    """Find faces that repeat a vertex, (p,) bool."""
    faces = _find_repeated(polygons.corner_faces, polygons.corner_vertices)[0]
    return np.bincount(faces, minlength=len(polygons.starts)) > 0


def _find_duplicates(polygons: Polygons, usable: np.ndarray) -> np.ndarray:
    """Find the (p,) face that each usable face duplicates, itself for others: one with the same corners, or a larger
    one that covers all of its triangles."""
    first = np.where(usable, find_duplicates(polygons, usable), np.arange(len(usable)))
    rows = (usable & (first == np.arange(len(first))))[polygons.triangle_faces]
    faces, triangles = polygons.triangle_faces[rows], np.sort(polygons.triangles[rows], axis=1)
    labels = label_rows(triangles)
    order = np.lexsort((-faces, polygons.sizes[faces]))
    covers = np.empty(labels.max(initial=-1) + 1, int)
    covers[labels[order]] = faces[order]  # the last of several assignments counts
    low, high = np.full(len(first), len(first)), np.full(len(first), -1)
    np.minimum.at(low, faces, covers[labels])
    np.maximum.at(high, faces, covers[labels])
    first = np.where(low == high, low, first)
    return first[first]


def _split_into_fans(mesh: TriangleMesh, faces: np.ndarray, joins: np.ndarray) -> tuple[TriangleMesh, np.ndarray]:
    """Split the vertices where no join connects their triangles; also returns the vertex that each was.

    Where two edges join the same two vertices, or two triangles the same three, with one fan at each, faces are
    detached until no edge and no triangle has the vertices of another.
    """
    while True:
        surface, source = cut_all_but(mesh, *np.concatenate([joins, joins[:, ::-1]]).T)
        own = np.arange(3 * surface.triangle_count)
        own[joins[:, 1]] = joins[:, 0]
        edges = surface.triangle_edges.ravel()
        first = np.full(len(surface.edges), len(edges))
        np.minimum.at(first, edges, own)
        alone = np.zeros(faces.max() + 1, bool)
        alone[faces[np.flatnonzero(own != first[edges]) // 3]] = True
        _, where, labels = np.unique(np.sort(surface.triangles, axis=1), axis=0, return_index=True, return_inverse=True)
        alone[faces[where[labels.reshape(-1)] != np.arange(surface.triangle_count)]] = True
        ends = faces[joins // 3]
        loosened = (ends[:, 0] != ends[:, 1]) & alone[ends].any(axis=1)
        if not loosened.any():
            return surface, source
        joins = joins[~loosened]
