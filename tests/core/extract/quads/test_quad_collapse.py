# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads that were opened in a grid close again, and what is regular or held stays."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.repair.quad_collapse import collapse_quads
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.barycentric import barycentric

from ...flat_crosses import plane_edge_phases
from ...meshes import square
from ...topology import euler, on_rim, valences

CELLS = 10


def grid():
    mesh = square(20)
    return mesh, quad_mesh(plane_edge_phases(mesh, 0, 2 / CELLS))


def vertex_at(quads, x, y):
    return np.linalg.norm(quads.vertices[:, :2] - [x, y], axis=1).argmin()


def opened(quads, *places):
    """Each vertex in two, with a quad between them and two neighbours across from each other; and these numbers."""
    faces, vertices = quads.corner_vertices.reshape(-1, 4).tolist(), quads.vertices
    pairs = []
    for x, y in places:
        old, new = vertex_at(quads, x, y), len(vertices)
        left, right = vertex_at(quads, x - 1 / CELLS, y), vertex_at(quads, x + 1 / CELLS, y)
        for number, corners in enumerate(faces):
            above = np.mean([vertices[corner][1] for corner in corners]) > y
            if old in corners and above:
                faces[number] = [new if corner == old else corner for corner in corners]
        faces.append([old, right, new, left])
        aside = [0, 0.2 / CELLS, 0]
        vertices = np.vstack([vertices, vertices[old] + aside])
        vertices[old] -= aside
        pairs.append((old, new))
    count = len(vertices) - len(quads.vertices)
    extra = {name: np.concatenate([getattr(quads, name)] + [getattr(quads, name)[-1:]] * count)
             for name in ("triangles", "weights")}  # fmt: skip
    return QuadMesh(vertices, **extra, corner_vertices=np.ravel(faces), sizes=np.full(len(faces), 4)), pairs


def closed(quads, mesh, held, corners=()):
    return collapse_quads(quads, mesh, held, np.isin(np.arange(len(held)), corners))


def irregular(quads):
    return int(((valences(quads) != 4) & ~on_rim(quads)).sum())


def test_a_regular_grid_stays():
    mesh, quads = grid()
    after, kept = closed(quads, mesh, on_rim(quads))
    np.testing.assert_array_equal(kept, np.arange(len(quads.vertices)))
    np.testing.assert_array_equal(after.corner_vertices, quads.corner_vertices)
    np.testing.assert_array_equal(after.vertices, quads.vertices)


def test_opened_quads_close_and_their_vertices_come_back():
    mesh, quads = grid()
    bad, _ = opened(quads, (0.3, 0.3), (0.6, 0.7))
    assert irregular(bad) == 8 and euler(bad) == 1
    after, kept = closed(bad, mesh, on_rim(bad))
    assert irregular(after) == 0 and euler(after) == 1 and len(after.sizes) == CELLS**2 and len(kept) == 121
    order, expected = (np.lexsort(np.round(m.vertices, 6).T) for m in (after, quads))
    np.testing.assert_allclose(after.vertices[order], quads.vertices[expected], atol=1e-9)
    at = np.einsum("nk,nkx->nx", after.weights, mesh.vertices[mesh.triangles[after.triangles]])
    np.testing.assert_allclose(after.vertices, at, atol=1e-9)


@pytest.mark.parametrize("which", [0, 1])
def test_a_held_vertex_keeps_its_place(which):
    mesh, quads = grid()
    bad, ((*pair,),) = opened(quads, (0.5, 0.5))
    held = on_rim(bad)
    held[pair[which]] = True
    after, kept = closed(bad, mesh, held)
    assert irregular(after) == 0 and pair[which] in kept and pair[1 - which] not in kept
    np.testing.assert_array_equal(after.vertices[np.searchsorted(kept, pair[which])], bad.vertices[pair[which]])


def test_two_held_vertices_stay_two():
    mesh, quads = grid()
    bad, (pair,) = opened(quads, (0.5, 0.5))
    held = on_rim(bad)
    held[list(pair)] = True
    after, kept = closed(bad, mesh, held)
    assert len(kept) == len(bad.vertices) and irregular(after) == 4


@pytest.mark.parametrize("corner", range(4))
def test_corners_keep_their_edges(corner):
    mesh, quads = grid()
    bad, _ = opened(quads, (0.5, 0.5))
    after, _ = closed(bad, mesh, on_rim(bad), [bad.corner_vertices[-4:][corner]])
    assert irregular(after) == 4


def test_a_cube_is_no_more_regular_with_a_face_less():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    mesh = TriangleMesh(corners, np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]))
    cube = QuadMesh(corners, np.zeros(8, int), np.eye(3)[[0] * 8], faces.ravel(), np.full(6, 4))
    after, kept = closed(cube, mesh, np.zeros(8, bool))
    assert len(kept) == 8 and (valences(after) == 3).all()


def around_a_halved_edge():
    """A disk of eight quads, two of which share both halves of the edge a to c, and its surface; a to d are numbers 0
    to 3, and the middle of the edge is 4."""
    a, c, b, d, middle = range(5)
    around = 2 * np.pi / 8 * np.arange(8)
    ring = np.column_stack([np.cos(around), np.sin(around), 0 * around]) / 2
    places = np.array([[-0.1, 0, 0], [0.1, 0, 0], [0, 0.25, 0], [0, -0.25, 0], [0, 0, 0]])
    east, north, west, south = 5, 7, 9, 11
    faces = [
        [a, middle, c, b], [c, middle, a, d],
        [c, east, 6, b], [b, 6, north, 8], [b, 8, west, a], [a, west, 10, d], [d, 10, south, 12], [d, 12, east, c],
    ]  # fmt: skip
    vertices = np.vstack([places, ring]) + [0.5, 0.5, 0]
    mesh = square(20)
    on, triangles = mesh.finder.nearest(vertices)
    bad = QuadMesh(vertices, triangles, barycentric(mesh, triangles, on), np.ravel(faces), np.full(8, 4))
    assert euler(bad) == 1 and valences(bad)[:5].tolist() == [4, 4, 4, 4, 2]
    return mesh, bad


@pytest.mark.parametrize("corners", [(), (0,), (1,)])
def test_the_ends_of_a_halved_edge_are_merged(corners):
    mesh, bad = around_a_halved_edge()
    held = np.isin(np.arange(13), [0, 1, 4]) | on_rim(bad)
    after, kept = closed(bad, mesh, held, corners)
    stays = corners[0] if corners else kept[0]
    assert len(after.sizes) == 6 and euler(after) == 1 and len(kept) == 11
    assert valences(after)[np.searchsorted(kept, [stays, 2, 3])].tolist() == [4, 3, 3]
    np.testing.assert_array_equal(after.vertices[np.searchsorted(kept, stays)], bad.vertices[stays])


def test_a_halved_edge_between_two_corners_stays():
    mesh, bad = around_a_halved_edge()
    after, _ = closed(bad, mesh, np.ones(13, bool), (0, 1))
    np.testing.assert_array_equal(after.corner_vertices, bad.corner_vertices)


@pytest.mark.parametrize("end", [0, 1])
def test_a_held_end_of_a_halved_edge_stays(end):
    mesh, bad = around_a_halved_edge()
    _, kept = closed(bad, mesh, (np.arange(13) == end) | on_rim(bad))
    assert end in kept and 1 - end not in kept


def test_a_halved_edge_beside_or_at_a_corner_stays():
    mesh, bad = around_a_halved_edge()
    for corner in (2, 3, 4):
        after, _ = closed(bad, mesh, np.ones(13, bool), [corner])
        np.testing.assert_array_equal(after.corner_vertices, bad.corner_vertices)
