# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines on a surface to which constraints apply: boundaries, seams, groups and strokes.

A line is a list of *stations*: a vertex on or beside it, the direction of the line there, and the part of its length
that the vertex stands for. At a corner a vertex has stations of several directions; inside an area, or at a single
point, a station has no direction.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...errors import SettingError
from ...gauge import balance
from ...geometry.polylines import piece_lengths, values_along
from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import components, sum_by
from ..guidance.face_directions import corner_turns, face_frames


@dataclass(frozen=True)
class Line:
    """Stations of one or several lines.

    Attributes
    ----------
    vertices : (s,) vertex of each station
    angles : (s,) direction of the line, radians in the vertex's tangent plane; NaN where there is none
    offsets : (s,) distance of the vertex from the line, positive to its left
    lengths : (s,) length of line that the station stands for; for areas, area by its square root
    links : (l, 2) pairs of consecutive vertices on the same line
    """

    vertices: np.ndarray
    angles: np.ndarray
    offsets: np.ndarray
    lengths: np.ndarray
    links: np.ndarray

    @property
    def nodes(self) -> np.ndarray:
        """(k,) the vertices, each once."""
        return np.unique(self.vertices)

    @property
    def directed(self) -> "Line":
        """The stations that have a direction; links as they are."""
        keep = np.isfinite(self.angles)
        vertices, angles, offsets, lengths = (array[keep] for array in _columns(self)[:4])
        return Line(vertices, angles, offsets, lengths, self.links)

    def means(self, values: np.ndarray) -> np.ndarray:
        """(k,) means of real or complex station values at :attr:`nodes`."""
        _, place = np.unique(self.vertices, return_inverse=True)
        return sum_by(place, values) / np.bincount(place)

    @property
    def node_lengths(self) -> np.ndarray:
        """(k,) length of line that each of the :attr:`nodes` stands for, summed over its stations."""
        _, place = np.unique(self.vertices, return_inverse=True)
        return np.bincount(place, self.lengths)

    @property
    def pieces(self) -> np.ndarray:
        """(k,) label of the connected piece of the line that contains each node."""
        nodes = self.nodes
        return components(len(nodes), np.searchsorted(nodes, self.links))


def line_of_edges(mesh: TriangleMesh, edges: np.ndarray) -> Line:
    """The line that runs over mesh edges, (k,) indices.

    Boundaries run with the face on their left. Every other chain of edges runs one way from end to end or junction to
    junction, as its lowest edge does.
    """
    edges = np.unique(edges)
    reversed_ = _reversed_edges(mesh, edges)
    towards = np.where(reversed_, np.pi, 0)
    directions = mesh.edge_directions[edges]
    # At its higher end the direction of an edge points back to the lower one.
    angles = np.column_stack([directions[:, 0] + towards, directions[:, 1] + np.pi + towards])
    ends = mesh.edges[edges]
    return Line(
        vertices=ends.ravel(),
        angles=angles.ravel(),
        offsets=np.zeros(2 * len(edges)),
        lengths=np.repeat(mesh.edge_lengths[edges] / 2, 2),
        links=ends,
    )


def _reversed_edges(mesh: TriangleMesh, edges: np.ndarray) -> np.ndarray:
    """(k,) bool: edges on which the line runs from the higher to the lower vertex."""
    ends = mesh.edges[edges]
    # Where exactly two edges meet, one arrives and the other leaves.
    meeting = meeting_ends(ends)
    same_end = meeting[:, 0] % 2 == meeting[:, 1] % 2
    turned, _ = balance(len(edges), meeting // 2, same_end) if len(meeting) else (np.zeros(len(edges), bool), None)
    on_boundary = mesh.edge_face_counts[edges] == 1
    forward = np.zeros(len(mesh.edges), int)
    forward[mesh.triangle_edges.ravel()] = mesh.triangle_edge_signs.ravel()
    return np.where(on_boundary, forward[edges] < 0, turned)


def meeting_ends(ends: np.ndarray) -> np.ndarray:
    """(m, 2) pairs of ends at vertices where exactly two edges meet, as indices into the flattened (k, 2) ends."""
    order = np.argsort(ends.ravel(), kind="stable")
    met = ends.ravel()[order]
    first = np.flatnonzero(met[:-1] == met[1:])
    first = first[np.bincount(met)[met[first]] == 2]
    return np.column_stack([order[first], order[first + 1]])


def boundary_line(mesh: TriangleMesh, vertices: ArrayLike | None = None, edges: np.ndarray | None = None) -> Line:
    """The boundary, or its edges with both ends among (n,) bool ``vertices``.

    Where ``edges`` are given, (k,) indices, these are the boundary. Raises :class:`SettingError` where it is empty.
    """
    edges = mesh.boundary_edges if edges is None else edges
    if len(edges) == 0:
        raise SettingError("the mesh has no boundary: set the boundary to free")
    if vertices is not None:
        edges = edges[np.asarray(vertices, bool)[mesh.edges[edges]].all(axis=1)]
        if len(edges) == 0:
            raise SettingError("the vertex group holds no boundary edge: add both ends of at least one to it")
    return line_of_edges(mesh, edges)


def group_edges(mesh: TriangleMesh, vertices: np.ndarray) -> np.ndarray:
    """Indices of the edges that are chains of a group of (n,) bool vertices, or outlines of its areas."""
    inside = vertices[mesh.triangles].all(axis=1)
    sides = np.bincount(mesh.triangle_edges[inside].ravel(), minlength=len(mesh.edges))
    return np.flatnonzero(vertices[mesh.edges].all(axis=1) & (sides < 2))


def line_of_group(mesh: TriangleMesh, vertices: np.ndarray) -> Line:
    """The line of a group of (n,) bool vertices: its chains of edges and the outlines of its areas.

    Vertices inside areas are stations too, which stand for their share of the area, and so are single vertices.
    """
    inside = vertices[mesh.triangles].all(axis=1)
    among = vertices[mesh.edges].all(axis=1)
    lines = line_of_edges(mesh, group_edges(mesh, vertices))
    areas = np.bincount(mesh.triangles[inside].ravel(), np.repeat(mesh.areas[inside] / 3, 3), mesh.vertex_count)
    off_lines = np.setdiff1d(np.flatnonzero(vertices), lines.nodes)
    nodes = np.concatenate([np.flatnonzero(areas), off_lines[areas[off_lines] == 0]])
    points = line_of_points(mesh, nodes, areas=areas[nodes])
    return replace(join_stations([lines, points]), links=mesh.edges[among])


def line_of_points(
    mesh: TriangleMesh, vertices: np.ndarray, angles: np.ndarray | None = None, areas: np.ndarray | None = None
) -> Line:
    """A station at each of (k,) vertices, without links, optionally with (k,) angles, as of a given field.

    Each stands for its vertex's share of the surface's area, or for one of (k,) given areas.
    """
    angles = np.full(len(vertices), np.nan) if angles is None else angles
    lengths = (mesh.vertex_masses[vertices] if areas is None else areas) / np.sqrt(mesh.areas.sum())
    return Line(vertices, angles, np.zeros(len(vertices)), lengths, np.empty((0, 2), int))


def line_of_vectors(mesh: TriangleMesh, vectors: np.ndarray) -> Line:
    """The vertices at which (n, 3) vectors have a tangential part, each with its direction."""
    tangent = mesh.tangent_numbers(vectors)
    nodes = np.flatnonzero(np.abs(tangent) > 1e-6 * np.linalg.norm(vectors, axis=1))
    return line_of_points(mesh, nodes, np.angle(tangent[nodes]))


def line_of_strokes(mesh: TriangleMesh, strokes: Iterable[tuple[ArrayLike, ArrayLike]]) -> Line:
    """Curves drawn on the surface, which pass between the vertices.

    Stations are the corners of the faces that a stroke passes, each with the direction and offset of the nearest
    sample. A stroke is (p,) triangles and (p, 3) points in them, sampled more densely than the mesh.
    """
    frames, turns = face_frames(mesh), corner_turns(mesh)
    samples = [(np.asarray(faces), np.asarray(points, float)) for faces, points in strokes]
    return join_stations([_line_of_stroke(mesh, faces, points, frames, turns[faces]) for faces, points in samples])


def _line_of_stroke(
    mesh: TriangleMesh, faces: np.ndarray, points: np.ndarray, frames: tuple[np.ndarray, np.ndarray], turns: np.ndarray
) -> Line:
    """The line of one stroke, see :func:`line_of_strokes`; ``turns`` are :func:`corner_turns` of its (p,) faces."""
    if len(points) < 2:
        raise SettingError("a stroke has a single point: give it two at least")
    steps = piece_lengths(points)
    tangents = _tangents(points, steps, np.median(mesh.edge_lengths[mesh.triangle_edges[faces]]))
    lengths = 0.5 * (np.append(steps, 0) + np.insert(steps, 0, 0))
    x, y = (axis[faces] for axis in frames)
    heading = np.einsum("ij,ij->i", tangents, x) + 1j * np.einsum("ij,ij->i", tangents, y)
    corners = mesh.triangles[faces]
    away = mesh.vertices[corners] - points[:, None]
    places = np.einsum("pkj,pj->pk", away, x) + 1j * np.einsum("pkj,pj->pk", away, y)
    heading = heading / np.where(heading == 0, 1, np.abs(heading))
    offsets = (places * heading.conj()[:, None]).imag
    angles = np.angle(heading)[:, None] + turns
    vertices = corners.ravel()
    order = np.lexsort((np.abs(places).ravel(), vertices))
    nodes, first = np.unique(vertices[order], return_index=True)
    nearest = order[first]
    shares = np.bincount(np.searchsorted(nodes, vertices), np.repeat(lengths / 3, 3))
    links = mesh.edges[np.unique(mesh.triangle_edges[faces])]
    return Line(nodes, angles.ravel()[nearest], offsets.ravel()[nearest], shares, links)


def _tangents(points: np.ndarray, steps: np.ndarray, reach: float) -> np.ndarray:
    """(p, 3) vectors from about ``reach`` before each point of a polyline to as far behind it: differences of
    consecutive points, which may be close, would jump where faces meet."""
    reach = min(reach, steps.sum() / 4)
    before, behind = values_along(points, points, (-reach, reach))
    return behind - before


def join_stations(lines: Iterable[Line]) -> Line:
    """All stations of several lines as one."""
    return Line(*(np.concatenate(parts) for parts in zip(*map(_columns, lines), strict=True)))


def _columns(line: Line) -> tuple[np.ndarray, ...]:
    return line.vertices, line.angles, line.offsets, line.lengths, line.links
