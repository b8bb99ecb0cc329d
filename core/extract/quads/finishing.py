# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes as they are shown: on the lines of their surface, of quads alone where asked, mirrored and smoothed."""

from dataclasses import replace

import numpy as np

from ...errors import SettingError
from ...fields.constraints.rows import GRID
from .features.chains import on_features
from .features.feature_lines import FeatureLines
from .mirror import ON_PLANE, average_with_partners, mirror_half, partners
from .repair.all_quads import all_quads
from .repair.edge_flips import flip_edges
from .repair.quad_collapse import with_faces_closed
from .repair.tip_recovery import recover_tips
from .smooth.fitting import fit_quads
from .smooth.worst_corners import move_worst_corners

# Cosine of the angle between the normals of neighbours beyond which both move for bad corners alone: rims keep their
# shape.
_SHARP = 0.5
# A vertex of the quad mesh nearer to an edge than this, as a barycentric coordinate, lies on it.
_ON_EDGE = 1e-3


def finish_quads(quads, mesh, rows, planes, rounds, only_quads=False):
    """The quad mesh on its surface's features, its own mirror image, and with faces as near to squares as can be.

    Vertices on boundaries and sharp edges that are kept move along them, others on the boundary, on lines that were
    asked for stay where they are, and those at sharp edges do but for bad corners.

    Parameters
    ----------
    quads : QuadMesh
    mesh : TriangleMesh that it was traced on
    rows : Rows of the constraint list; those of phases hold the vertices on their lines
    planes : (3,) normals of mirror planes through the origin, of any length
    rounds : how often vertices move
    only_quads : whether other faces are to become quads

    Raises
    ------
    SettingError
        for a pattern without any face, one whose faces would meet themselves, and one that loses a handle
    """
    check_quads(quads, mesh)
    planes = [np.asarray(normal) / np.linalg.norm(normal) for normal in planes]
    links = _feature_links(rows)
    features, chains = None, None
    if len(links):
        features = FeatureLines.of(mesh, np.unique(mesh.edges_between(*links.T)))
        quads, chains = on_features(quads, features, _side(quads), cut=only_quads)
    if only_quads:
        quads = all_quads(quads, mesh, [] if chains is None else chains.edges(quads))
    for unit in planes:
        quads = mirror_half(quads, mesh, unit)
    if features is not None:
        quads, chains = on_features(quads, features, _side(quads))
    if only_quads and not planes and (quads.sizes == 4).all():  # halves would be closed in other ways
        quads, chains = _collapse_quads(quads, mesh, rows, chains)
    check_quads(quads, mesh)
    if rounds == 0:
        return quads
    mates = [partners(quads, unit) for unit in planes]
    heights = [np.abs(quads.vertices @ unit) for unit in planes]
    on_planes = [h <= ON_PLANE * np.ptp(quads.vertices, axis=0).max() for h in heights]
    free, loose = _free(quads, mesh, rows, chains)
    if chains is not None:
        crossing = (chains.lines >= 0) & np.any([np.zeros(len(free), bool), *on_planes], axis=0)
        free, loose = free & ~crossing, loose & ~crossing
    held = list(zip(planes, on_planes, strict=True))
    quads = fit_quads(quads, mesh, loose, held, rounds, chains)
    quads = move_worst_corners(recover_tips(quads, mesh, free, held, chains), mesh, free, held, chains)
    if not planes:  # halves that mirror each other would be turned in other ways
        turned = flip_edges(quads, mesh.face_normals[quads.triangles], _fixed_edges(quads, free, chains))
        quads = move_worst_corners(turned, mesh, free, held, chains) if turned is not quads else quads
    for unit, mate in zip(planes, mates, strict=True):
        # Vertices that stood near to each other may be told apart by now.
        partner = partners(quads, unit) if mate is None else mate
        if partner is not None:
            quads = replace(quads, vertices=average_with_partners(quads.vertices, partner, unit))
    return quads


def lost_lines(quads, mesh, rows):
    """The boundaries and sharp edges that no chain of the quad mesh's edges follows.

    Parameters
    ----------
    quads : QuadMesh
    mesh : TriangleMesh that it was traced on
    rows : Rows of the constraint list

    Returns
    -------
    (k,) lengths of these lines, (l,) of all lines, both between corners
    """
    links = _feature_links(rows)
    if len(links) == 0:
        return np.empty(0), np.empty(0)
    features = FeatureLines.of(mesh, np.unique(mesh.edges_between(*links.T)))
    lengths = np.array([ways[-1] for ways in features.lengths])
    return lengths[list(on_features(quads, features, _side(quads))[1].missed)], lengths


def _feature_links(rows):
    """(k, 2) vertices of the edges that chains are put on."""
    return np.concatenate([np.empty((0, 2), int), *(row.line.links for row in rows if row.kind == GRID)])


def check_quads(quads, mesh):
    """Refuse quads that are not a mesh of the surface."""
    if len(quads.sizes) == 0:
        raise SettingError("no grid lines cross on the mesh: reduce the spacing")
    if not quads.is_simple:
        raise SettingError("the quads are too large for the mesh, some would meet themselves: reduce the spacing")
    if not mesh.boundary_vertices.any() and quads.euler_characteristic > mesh.euler_characteristic:
        raise SettingError("the quads are too large for the mesh, a handle of it would be lost: reduce the spacing")


def _side(quads):
    """The mean length of an edge."""
    edges, _ = quads.edges
    return float(np.linalg.norm(quads.vertices[edges[:, 1]] - quads.vertices[edges[:, 0]], axis=1).mean())


def _collapse_quads(quads, mesh, rows, chains):
    """The quad mesh with faces closed where that makes it more regular, and the chains of its vertices."""
    held = _fixed_vertices(_free(quads, mesh, rows, chains)[0], chains)
    corners = np.zeros_like(held) if chains is None else chains.fixed
    quads, kept = with_faces_closed(quads, mesh, held, corners)
    return quads, None if chains is None else chains.of_vertices(kept)


def _free(quads, mesh, rows, chains):
    """(n,) bool: vertices that may move, and those of them that are not where the surface bends."""
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


def _fixed_edges(quads, free, chains):
    """(k, 2) vertices of the edges between two vertices that stay or slide along lines."""
    edges, _ = quads.edges
    return edges[_fixed_vertices(free, chains)[edges].all(axis=1)]


def _fixed_vertices(free, chains):
    """(n,) bool: vertices that stay or slide along lines."""
    return ~free if chains is None else ~free | (chains.lines >= 0)


def _on_rows(quads, mesh, rows):
    """(n,) bool: vertices on edges or at vertices of rows that ask for a grid line."""
    held = np.zeros(mesh.vertex_count, bool)
    for row in rows:
        if row.is_of_phases:
            held[row.line.nodes] = True
    return (held[mesh.triangles[quads.triangles]] | (quads.weights < _ON_EDGE)).all(axis=1)
