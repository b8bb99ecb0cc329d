# SPDX-License-Identifier: GPL-3.0-or-later
"""Finishes a traced quad mesh: puts it onto sharp edges, makes all faces quads if asked, and smooths it."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ...errors import SettingError
from ...fields.constraints.rows import GRID, Row
from ...geometry import TriangleMesh
from .features.chains import Chains, follow_features
from .features.feature_lines import FeatureLines
from .repair.all_quads import all_quads
from .repair.bad_corners import mend_bad_corners
from .repair.narrow_tunnels import close_narrow_tunnels, find_flat_faces
from .repair.quad_collapse import collapse_quads
from .repair.strips import Rules, meet_count
from .repair.tip_recovery import recover_tips
from .smooth.fitting import fit_quads, keep_better, part_vertices
from .smooth.mean_angles import BAD_MEAN, lower_mean_angle, mean_angle
from .smooth.worst_corners import move_worst_corners
from .trace.quad_mesh import QuadMesh

# Neighbours move only to mend bad corners if the cosine between their normals is smaller: rims keep their shape.
_SHARP = 0.5
# Rounds of smoothing after a strip of quads was added or removed.
_AFTER_STRIP = 5
# Rings of vertices around a face that are smoothed with it.
_AROUND = 3
# A vertex of the quad mesh with a barycentric coordinate below this lies on the edge.
_ON_EDGE = 1e-3


def finish_quads(
    quads: QuadMesh,
    mesh: TriangleMesh,
    rows: Sequence[Row],
    rounds: int,
    only_quads: bool = False,
    closes_tunnels: bool = False,
    apart: Callable[[QuadMesh], np.ndarray] | None = None,
    wanted: float = 0,
    later: list[Callable[[], QuadMesh]] | None = None,
) -> QuadMesh:
    """The quad mesh put onto its surface's features, and with faces as near to squares as possible.

    Vertices on boundaries and sharp edges that are kept slide along them. Other vertices on the boundary or on lines of
    rows stay in place, and those at other sharp edges move only to mend bad corners.

    Parameters
    ----------
    mesh : on which the quad mesh was traced
    rows : of the constraint list; rows of phases hold the vertices on their lines
    rounds : number of smoothing steps
    only_quads : whether all faces become quads
    closes_tunnels : whether handles of a closed surface may be lost
    apart : tells the (n,) bool vertices of a quad mesh that no new edge may join to one another
    wanted : number of faces for which strips of quads are added or removed, as far as these exist; 0 for any number
    later : list, optional; where corners are bad, the last step of smoothing takes long: it is then left to the caller,
        as a function that is added here and returns the mesh

    Errors as :func:`check_quads`.
    """
    check_quads(quads, mesh, closes_tunnels)
    apart_vertices = () if apart is None else np.flatnonzero(apart(quads))
    features, chains = _feature_lines(mesh, rows), None
    if features is not None:
        quads, chains = follow_features(quads, features, cut=only_quads)
    if only_quads:
        keep = np.empty((0, 2), int) if chains is None else chains.edges(quads)
        followed, (quads, origins) = quads, all_quads(quads, mesh, keep, apart_vertices)
        if features is not None and chains is not None and quads is not followed:
            carried = _carry(chains, followed, origins, is_final=rounds > 0)
            quads, chains = follow_features(quads, features) if carried is None else (quads, carried)
    if only_quads and (quads.sizes == 4).all():
        fixed = _fixed_vertices(_free(quads, mesh, rows, chains)[0], chains)
        quads, kept = collapse_quads(quads, mesh, fixed, np.zeros_like(fixed) if chains is None else chains.fixed)
        chains = chains and chains.of_vertices(kept)
        if wanted and not closes_tunnels:
            rules = _strip_rules(mesh, rows, features, apart, min(rounds, _AFTER_STRIP))
            quads, chains = meet_count(quads, mesh, chains, wanted, rules)
    if closes_tunnels:  # collapses may leave two faces that enclose no volume
        thick = ~find_flat_faces(quads)
        kept, quads = np.unique(quads.corner_vertices[thick[quads.corner_faces]]), quads.only(thick)
        chains = chains and chains.of_vertices(kept)
    check_quads(quads, mesh, closes_tunnels)
    if rounds == 0:
        return quads
    free, loose = _free(quads, mesh, rows, chains)
    quads = keep_better(fit_quads(quads, mesh, loose, rounds, chains), quads)
    quads = move_worst_corners(recover_tips(quads, mesh, free, chains), mesh, free, chains)
    apart_vertices = () if apart is None else np.flatnonzero(apart(quads))
    quads, kept = mend_bad_corners(quads, mesh, free, chains, apart_vertices)
    free, chains = free[kept], chains and chains.of_vertices(kept)

    def lowered() -> QuadMesh:
        return part_vertices(lower_mean_angle(quads, mesh, free, chains), mesh, ~free)

    if later is None or mean_angle(quads) <= BAD_MEAN:
        return lowered()
    later.append(lowered)
    return part_vertices(quads, mesh, ~free)


def _carry(chains: Chains, quads: QuadMesh, origins: np.ndarray, is_final: bool) -> Chains | None:
    """The chains of a quad mesh on one whose vertices were its own or halve its edges.

    None for a final mesh where a line is lost, which it may follow now, or an edge between two corners may be halved.
    ``origins`` : as of :func:`all_quads`
    """
    count, halves = len(quads.vertices), origins[:, 0] != origins[:, 1]
    if (origins >= count).any():
        return None
    if is_final and (len(chains.lost) or chains.fixed[origins[halves]].all(axis=1).any()):
        return None
    lines, ends = chains.lines[origins].max(axis=1), np.sort(origins[halves], axis=1)
    lines[halves] = np.where(np.isin(ends @ [count, 1], chains.edges(quads) @ [count, 1]), lines[halves], -1)
    gaps = chains.features.lengths / (1 + np.bincount(lines[lines >= 0], minlength=len(chains.gaps)))
    return replace(chains, lines=lines, fixed=chains.fixed[origins[:, 0]] & ~halves, gaps=gaps)


def _strip_rules(
    mesh: TriangleMesh,
    rows: Sequence[Row],
    features: FeatureLines | None,
    apart: Callable[[QuadMesh], np.ndarray] | None,
    rounds: int,
) -> Rules:
    """How strips of a quad mesh may change; arguments as of :func:`finish_quads`."""

    def follow(quads: QuadMesh) -> tuple[QuadMesh, Chains | None]:
        return (quads, None) if features is None else follow_features(quads, features)

    def smooth(quads: QuadMesh, chains: Chains | None) -> QuadMesh:
        return keep_better(fit_quads(quads, mesh, _free(quads, mesh, rows, chains)[1], rounds, chains), quads)

    def held(quads: QuadMesh) -> np.ndarray:
        return _on_rows(quads, mesh, [row for row in rows if row.kind != GRID])

    return Rules(
        follow, smooth, held, lambda quads: np.zeros(len(quads.vertices), bool) if apart is None else apart(quads)
    )


def smooth_faces(
    quads: QuadMesh, mesh: TriangleMesh, rows: Sequence[Row], rounds: int, which: np.ndarray, without: ArrayLike
) -> tuple[QuadMesh, np.ndarray]:
    """The finished quad mesh smoothed around (f,) bool faces, and (n,) bool the vertices around them.

    Vertices on the boundary and on lines of rows stay, except those on edges in ``without``. After some rounds tips are
    recovered; bad corners are always moved. Other arguments as of :func:`finish_quads`.
    """
    near = np.zeros(len(quads.vertices), bool)
    for _ in range(_AROUND):
        near[quads.corner_vertices[which[quads.corner_faces]]] = True
        which = np.bincount(quads.corner_faces, near[quads.corner_vertices]) > 0
    on_lines = np.zeros(mesh.vertex_count, bool)
    on_lines[mesh.edges[np.setdiff1d(_grid_edges(mesh, rows), without)]] = True
    free = near & ~quads.on_rim & ~_is_at(quads, mesh, on_lines)
    free &= ~_on_rows(quads, mesh, [row for row in rows if row.kind != GRID])
    if rounds > 0:
        quads = recover_tips(fit_quads(quads, mesh, free, rounds), mesh, free)
    return move_worst_corners(quads, mesh, free), near


def lost_lines(
    quads: QuadMesh, mesh: TriangleMesh, rows: Sequence[Row], followed: ArrayLike = ()
) -> tuple[np.ndarray, np.ndarray]:
    """(k,) the length that the quad mesh's edges do not follow, of each boundary and sharp edge that they do not follow
    from end to end, and (l,) lengths of all of them.

    Lines are counted from corner to corner, without edges that are ``followed``; arguments as of :func:`finish_quads`.
    """
    features = _feature_lines(mesh, rows, followed)
    if features is None:
        return np.empty(0), np.empty(0)
    return follow_features(quads, features)[1].lost, features.lengths


def _feature_lines(mesh: TriangleMesh, rows: Sequence[Row], without: ArrayLike = ()) -> FeatureLines | None:
    """The lines that edges of the quad mesh should follow, except edges in ``without``; None if no line is left."""
    edges = np.setdiff1d(_grid_edges(mesh, rows), without)
    return FeatureLines.of(mesh, edges) if len(edges) else None


def _grid_edges(mesh: TriangleMesh, rows: Sequence[Row]) -> np.ndarray:
    """(k,) edges of the surface that grid lines follow."""
    links = np.concatenate([np.empty((0, 2), int), *(row.line.links for row in rows if row.kind == GRID)])
    return mesh.edges_between(*links.T)


class TooLargeQuads(SettingError):
    """Quads that are too large for their surface.

    Attributes
    ----------
    share : of the faces that are unsound
    """

    def __init__(self, message: str, share: float = 0.0) -> None:
        super().__init__(f"the quads are too large for the mesh, {message}: reduce the spacing")
        self.share = share


def sound_quads(quads: QuadMesh, mesh: TriangleMesh, closes_tunnels: bool) -> QuadMesh:
    """The traced quads, checked; with ``closes_tunnels``, where they are too large for a handle, it is closed."""
    quads = close_narrow_tunnels(quads) if closes_tunnels else quads
    check_quads(quads, mesh, closes_tunnels)
    return quads


def check_quads(quads: QuadMesh, mesh: TriangleMesh, closes_tunnels: bool = False) -> None:
    """Raise SettingError for quads that are not a mesh of the surface: without faces, with faces that meet themselves,
    or, unless ``closes_tunnels``, without a handle of a closed surface.
    """
    if len(quads.sizes) == 0:
        raise SettingError("no grid lines cross on the mesh: reduce the spacing")
    unsound = quads.is_unsound
    if unsound.any():
        raise TooLargeQuads("some would meet themselves", unsound.mean())
    if (
        not closes_tunnels
        and not mesh.boundary_vertices.any()
        and quads.euler_characteristic > mesh.euler_characteristic
    ):
        raise TooLargeQuads("a handle of it would be lost")


def _free(
    quads: QuadMesh, mesh: TriangleMesh, rows: Sequence[Row], chains: Chains | None
) -> tuple[np.ndarray, np.ndarray]:
    """Which vertices may move, (n,) bool, freely or along a line; and which of these do not lie on a sharp edge without
    a line, (n,) bool."""
    edges, counts = quads.edges
    on_lines = np.zeros(len(quads.vertices), bool) if chains is None else chains.fixed | (chains.lines >= 0)
    asked = _on_rows(quads, mesh, [row for row in rows if row.kind != GRID])
    held = _on_rows(quads, mesh, rows)
    held[edges[counts == 1]] = True
    free = ~held if chains is None else ~chains.fixed & ~asked & (~held | (chains.lines >= 0))
    normals = mesh.face_normals[quads.triangles]
    bent = np.einsum("ij,ij->i", normals[edges[:, 0]], normals[edges[:, 1]]) < _SHARP
    loose = free.copy()
    loose[edges[bent & ~on_lines[edges].any(axis=1)]] = False
    return free, loose


def _fixed_vertices(free: np.ndarray, chains: Chains | None) -> np.ndarray:
    """(n,) bool: vertices that stay in place or slide along lines."""
    return ~free if chains is None else ~free | (chains.lines >= 0)


def _on_rows(quads: QuadMesh, mesh: TriangleMesh, rows: Sequence[Row]) -> np.ndarray:
    """(n,) bool: vertices of the quad mesh on lines of rows of phases."""
    held = np.zeros(mesh.vertex_count, bool)
    for row in rows:
        if row.is_of_phases:
            held[row.line.nodes] = True
    return _is_at(quads, mesh, held)


def _is_at(quads: QuadMesh, mesh: TriangleMesh, nodes: np.ndarray) -> np.ndarray:
    """(n,) bool: vertices of the quad mesh at some vertices of the surface, (m,) bool, or on edges between them."""
    return (nodes[mesh.triangles[quads.triangles]] | (quads.weights < _ON_EDGE)).all(axis=1)
