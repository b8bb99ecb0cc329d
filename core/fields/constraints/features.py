# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundaries and sharp edges of a surface, and grid lines that lie on them.

On a grid line of quads a phase is a multiple of pi, 1 or -1 as a complex number in every sheet. So the phases along a
line merge into one node, with an edge to itself that asks for one of these two values.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import minimum_spanning_tree

from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import components, sum_by
from ...unit_vectors import unit_vectors
from .groups import Links, OneForm, join_links
from .lines import line_of_edges, meeting_ends
from .rows import GRID, Row
from .strips import STRAIGHT, find_strips

# Radians by which a line turns at a corner.
CORNER = np.radians(30)
# The least angle between a grid line and the direction in which its phase grows: at half a right angle the line would
# be as near to the other phase's lines.
LEAST_ALONG = np.radians(50)
# Two lines that meet at a smaller angle at the boundary could both run along the same direction of a cross, without a
# quad between. Inside, where a sharp edge fades out beside another, such a corner needs none.
NARROW = np.radians(50)
# Lines between corners, and connected pieces of lines, that are shorter than this many sides of a quad are left out;
# boundaries are not. A piece with free ends, as bends on scans and low-poly animals have, needs a longer line.
SHORTEST_LINE, SHORTEST_PIECE, SHORTEST_FREE = 1.0, 4.0, 6.0
# Where edges divide most of the surface into parts with room for fewer quads than this, the parts are facets.
FEWEST_QUADS = 20.0
# Faces that bend by less than FLAT are one facet. A body whose facets mostly bend by more than COARSE, but by less than
# counts as sharp, is a round one in few polygons: an edge is sharp there if it bends by more than SHARPEST.
FLAT, COARSE, SHARPEST = np.radians([1, 15, 80])


def feature_edges(
    mesh: TriangleMesh, angle: float, side: float | np.ndarray, marked: ArrayLike = (), faces: np.ndarray | None = None
) -> np.ndarray:
    """Indices of the edges of boundaries and of sharp edges that quads can follow.

    Parameters
    ----------
    angle : radians between the normals of two faces beyond which their edge is sharp
    side : length of a quad's side, one or (n,) at the vertices
    marked : indices of further sharp edges
    faces : (m,) the input polygon of each triangle, within which nothing is sharp

    Where ``marked`` edges divide most of the surface into facets, they are ignored: the surface is shaded flat. On a
    round body of few polygons the angle is at least :data:`SHARPEST`.
    """
    marked = np.asarray(marked, int)
    bends = np.abs(mesh.angles_between(_normals(mesh, faces)))
    between = np.flatnonzero(bends > FLAT)
    is_coarse = len(between) > 0 and COARSE < np.median(bends[between]) < angle and _makes_facets(mesh, between, side)
    sharp = bends > (max(angle, SHARPEST) if is_coarse else angle)
    if not _makes_facets(mesh, marked, side):
        sharp[marked] = True
    sharp[mesh.boundary_edges] = True
    edges = np.flatnonzero(sharp)
    sides = np.broadcast_to(side, mesh.vertex_count)
    lengths = mesh.edge_lengths / sides[mesh.edges].mean(axis=1)
    on_boundary = mesh.edge_face_counts == 1
    labels = pieces_between_corners(mesh, edges)
    lines = np.bincount(labels, lengths[edges])[labels]
    long = (lines >= SHORTEST_LINE) | on_boundary[edges]
    edges = edges[long | _are_rungs(mesh, edges, labels, long, lines >= SHORTEST_PIECE, sides)]
    return edges[_is_long_piece(mesh, edges, lengths[edges]) | on_boundary[edges]]


def _is_long_piece(mesh: TriangleMesh, edges: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """(k,) bool: edges of connected pieces that are long, and have a long line if they have free ends.

    ``lengths``: (k,) of the edges in sides of a quad. Marked edges are like others, since shading by angle marks
    bends, too.
    """
    ends, lines = mesh.edges[edges], pieces_between_corners(mesh, edges)
    labels = components(mesh.vertex_count, ends)[ends[:, 0]]
    is_free = (np.bincount(ends.ravel(), minlength=mesh.vertex_count) == 1)[ends].any(axis=1)
    longest = np.zeros(mesh.vertex_count)
    np.maximum.at(longest, labels, np.bincount(lines, lengths)[lines])
    fades = np.bincount(labels, is_free) > 0
    is_long = np.bincount(labels, lengths) >= SHORTEST_PIECE
    return (is_long & (~fades | (longest[: len(fades)] >= SHORTEST_FREE)))[labels]


def _are_rungs(
    mesh: TriangleMesh, edges: np.ndarray, labels: np.ndarray, long: np.ndarray, longer: np.ndarray, sides: np.ndarray
) -> np.ndarray:
    """(k,) bool: edges of short lines that lead straight across narrow strips between long ones on both sides.

    Such a strip is one quad wide, and without the short line its two sides could be shifted against each other. At each
    end two of the ``longer`` lines must meet, and no other short one, as on the rim of a plate: in slits and where
    chamfers meet there is no room for a quad.
    """
    ends, count = mesh.edges[edges], mesh.vertex_count
    met = np.bincount(ends[longer].ravel(), minlength=count) >= 2
    met &= np.bincount(ends[~long].ravel(), minlength=count) == 1
    rungs = np.bincount(labels, met[ends].sum(axis=1) * ~long)[labels] == 2
    if not rungs.any():
        return rungs
    across, _ = find_strips(mesh, edges[long], sides)
    rows = np.full(len(mesh.edges), -1)
    rows[edges] = np.arange(len(edges))
    beside = rows[mesh.triangle_edges]
    cosines = np.einsum("mkx,mx->mk", unit_vectors(mesh.edge_vectors[edges])[beside], across)
    is_straight = np.bincount(beside[(beside >= 0) & (np.abs(cosines) > STRAIGHT)], minlength=len(edges)) == 2
    return rungs & (np.bincount(labels, is_straight) >= np.bincount(labels) / 2)[labels]


def _makes_facets(mesh: TriangleMesh, edges: np.ndarray, side: float | np.ndarray) -> bool:
    """Whether edges leave more than half of a surface in parts with room for few quads."""
    parts = mesh.parts_between(edges)
    quads = mesh.areas / np.broadcast_to(side, mesh.vertex_count)[mesh.triangles].mean(axis=1) ** 2
    is_small = np.bincount(parts, quads)[parts] < FEWEST_QUADS
    return bool(mesh.areas[is_small].sum() > mesh.areas.sum() / 2)


def _normals(mesh: TriangleMesh, faces: np.ndarray | None) -> np.ndarray:
    """(m, 3) normals of the triangles' polygons: the mean by area of those with several triangles."""
    if faces is None:
        return mesh.face_normals
    vectors = mesh.areas[:, None] * mesh.face_normals
    alone = np.bincount(faces)[faces] == 1
    return np.where(alone[:, None], mesh.face_normals, unit_vectors(sum_by(faces, vectors)[faces]))


def pieces_between_corners(mesh: TriangleMesh, edges: np.ndarray) -> np.ndarray:
    """(k,) label of the line between corners that each edge is on."""
    corner = np.zeros(mesh.vertex_count, bool)
    corner[line_corners(mesh, edges)] = True
    ends = mesh.edges[edges]
    meeting = meeting_ends(ends)
    return components(len(edges), meeting[~corner[ends.ravel()[meeting[:, 0]]]] // 2)


def line_corners(mesh: TriangleMesh, edges: np.ndarray) -> np.ndarray:
    """Vertices at which lines of edges end, branch, or turn by more than :data:`CORNER`."""
    return mesh.line_corners(edges, np.cos(CORNER))


def quads_around(mesh: TriangleMesh, edges: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(c,) numbers of quads around corners of lines, (k,) edges: the nearest number of right angles between each two
    lines, at least one."""
    scales = mesh.angle_scales[corners]
    wedges = zip(_wedges(mesh, edges, corners), scales, strict=True)
    counts = [np.maximum(np.rint(gaps / scale / (np.pi / 2)), 1).sum() for (_, gaps), scale in wedges]
    return np.array(counts, int)


def _wedges(mesh: TriangleMesh, edges: np.ndarray, corners: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The rescaled angles at which lines leave each corner, ascending, and the angles from each one to the next."""
    ends = mesh.edges[edges].ravel()
    angles = mesh.edge_directions[edges].ravel()
    order = np.lexsort((angles, ends))
    first = np.searchsorted(ends[order], [corners, corners + 1])
    for corner, (begin, end) in zip(corners, first.T, strict=True):
        around = angles[order[begin:end]]
        # At the boundary they count from one of its sides to the other.
        rest = [] if mesh.boundary_vertices[corner] else [around[0] + 2 * np.pi]
        yield around, np.diff(around, append=rest)


def feature_row(mesh: TriangleMesh, edges: np.ndarray) -> Row:
    """The row that holds a grid line on edges where no other row applies.

    At corners of the boundary too narrow for a right angle, the crosses' diagonal runs between the lines, so that there
    is a quad.
    """
    line = line_of_edges(mesh, edges)
    corners = line_corners(mesh, edges)
    corners = corners[mesh.boundary_vertices[corners]]
    for corner, (around, gaps) in zip(corners, _wedges(mesh, edges, corners), strict=True):
        between = around[: len(gaps)] + gaps / 2
        narrow = gaps < NARROW * mesh.angle_scales[corner]
        if narrow.any():
            crosses = np.exp(4j * (between[narrow] + np.pi / 4)).sum()
            line.angles[line.vertices == corner] = np.angle(crosses) / 4
    return Row(line, GRID, name="a sharp edge or the boundary")


def add_grid_lines(one_form: OneForm, rows: Sequence[Row], links: Links) -> tuple[Links, np.ndarray]:
    """The links of mirrors with those along grid lines, and the (k,) phases on these, each of which is 1 or -1."""
    along, nodes = _grid_links(one_form, rows)
    if len(nodes) == 0:
        return links, nodes
    joined = join_links([links, along])
    return _spanning(one_form.phase_count * one_form.mesh.vertex_count, joined, nodes), nodes


def link_to_themselves(nodes: np.ndarray) -> Links:
    """Links of nodes to themselves, which only 1 and -1 satisfy."""
    names = np.full(len(nodes), "a grid line", object)
    return Links(nodes, nodes, np.zeros(len(nodes)), np.ones(len(nodes), bool), names)


def _grid_links(one_form: OneForm, rows: Sequence[Row]) -> tuple[Links, np.ndarray]:
    """Links between the phases along the edges of grid lines, and the phases, which are 1 or -1.

    Of the two phases of an edge it is the one that grows most across. Edges at the vertices of other rows are left out,
    and so are those along which the directions do not run.
    """
    mesh, count = one_form.mesh, one_form.phase_count
    taken = np.zeros(mesh.vertex_count, bool)
    links = np.empty((0, 2), int)
    for row in rows:
        if row.kind == GRID:
            links = np.concatenate([links, row.line.links])
        else:
            taken[row.line.nodes] = True
    links = links[~taken[links].any(axis=1)]
    edges = np.unique(mesh.edges_between(*links.T)) if len(links) else np.empty(0, int)
    i, j = mesh.edges[edges].T
    own = np.arange(count)
    matched = one_form.matchings[edges, None]
    at_tail = one_form.angles[i, None] + one_form.turn * own - mesh.edge_directions[edges, :1]
    at_head = one_form.angles[j, None] + one_form.turn * (own - matched) - mesh.edge_directions[edges, 1:]
    across = np.abs(np.sin(at_tail)) + np.abs(np.sin(at_head))
    along = across.max(axis=1, initial=0) > 2 * np.sin(LEAST_ALONG)
    edges, i, j, across, matched = edges[along], i[along], j[along], across[along], matched[along]
    phase = across.argmax(axis=1)
    direction = (phase - matched[:, 0]) % (2 * count)
    tails, heads = count * i + phase, count * j + direction % count
    flips = direction >= count
    if count == 2:
        # Three or five quads at a vertex: its phases are exchanged around it, so that they are equal.
        corners = line_corners(mesh, edges)
        odd = corners[(quads_around(mesh, edges, corners) % 2 == 1) & ~mesh.boundary_vertices[corners]]
        tails, heads = np.append(tails, 2 * odd), np.append(heads, 2 * odd + 1)
        flips = np.append(flips, np.zeros(len(odd), bool))
    names = np.full(len(tails), "a grid line", object)
    return Links(tails, heads, np.zeros(len(tails)), flips, names), np.unique([tails, heads])


def _spanning(count: int, links: Links, loops: np.ndarray) -> Links:
    """Drop links that close cycles among nodes linked to the (k,) ``loops``, whose phases are 1 or -1.

    Around a cycle a phase may come back conjugated, which would be a contradiction for others but not for 1 and -1. No
    link has an angle.
    """
    pairs = np.column_stack([links.i, links.j])
    labels = components(count, pairs)
    whole = np.zeros(labels.max(initial=-1) + 1, bool)
    whole[labels[loops]] = True
    needed = ~whole[labels[links.i]]
    # The sparse matrix sums several links between two nodes; of these the first one is kept.
    tree = minimum_spanning_tree(coo_matrix((np.ones(len(pairs)), np.sort(pairs, axis=1).T), shape=(count, count)))
    first = np.unique(np.sort(pairs, axis=1), axis=0, return_index=True)[1]
    kept = np.column_stack(tree.nonzero())
    in_tree = np.isin(np.sort(pairs, axis=1)[first] @ [count, 1], np.sort(kept, axis=1) @ [count, 1])
    needed[first[in_tree]] = True
    return links.chosen(needed)
