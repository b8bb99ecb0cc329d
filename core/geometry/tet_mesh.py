# SPDX-License-Identifier: GPL-3.0-or-later
"""A solid of tetrahedra as arrays: any number of pieces, cavities and handles.

Corner ``k`` of a tetrahedron is opposite to its face ``k``. An edge ``e = (i, j)`` is stored once with ``i < j``, and
every quantity on edges (transport, phase change) is given in that direction.
"""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, name_elements
from ..graphs import components, pair_keys
from .triangle_mesh import TriangleMesh, rows_of
from .vertex_splitting import split_pinched_vertices

# Corners of the six edges of a tetrahedron, and of its four faces: face k is opposite to corner k and counterclockwise
# from outside where the tetrahedron is positive.
TET_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
TET_FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
# A tetrahedron whose volume is below this share of its longest edge cubed has no usable gradients.
FLAT_TET = 1e-12
# Eq. (2) needs positive weights. Dihedral angles are clipped to at least this far from 0 and 180 degrees, less than any
# that stuffing makes: once their negative weights are clipped, slivers would outweigh the rest of the mesh.
SHARPEST_ANGLE = np.radians(10)
# Least mean cotangent around an edge. The long edges of a body-centred lattice have weight 0.
SMALLEST_COTANGENT = 1e-4


class TetMesh:
    """Vertices and positively oriented tetrahedra, and quantities derived from them, computed on first use.

    Raises MeshError for arrays of another shape, a vertex index out of range, and no, flat or inverted tetrahedra.

    Parameters
    ----------
    vertices : (n, 3) float array, in scene units
    tets : (m, 4) int array: seen from the first corner, the other three run clockwise; see :func:`positive`
    """

    def __init__(self, vertices: ArrayLike, tets: ArrayLike) -> None:
        self.vertices = rows_of(3, vertices, np.float64, "vertices are points in space")
        self.tets = rows_of(4, tets, np.int64, "split other cells into tetrahedra")
        _refuse_indices(self.vertices, self.tets)
        _refuse_flat(self.vertices, self.tets, self.volumes)

    @property
    def vertex_count(self) -> int:
        return len(self.vertices)

    @property
    def tet_count(self) -> int:
        return len(self.tets)

    # Connectivity

    @cached_property
    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        """(e, 2) vertices of the edges, and (m, 6) edge of each pair of corners of a tetrahedron."""
        keys = pair_keys(self.tets[:, TET_EDGES], self.vertex_count)
        keys, inverse = np.unique(keys.ravel(), return_inverse=True)
        return np.column_stack(np.divmod(keys, max(self.vertex_count, 1))), inverse.reshape(-1, 6)

    @property
    def edges(self) -> np.ndarray:
        """(e, 2) vertex indices, the lower one first, sorted."""
        return self._edges[0]

    @property
    def tet_edges(self) -> np.ndarray:
        """(m, 6) edges between the pairs of corners in the order of ``TET_EDGES``."""
        return self._edges[1]

    def edges_between(self, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
        """Find the edges that join pairs of vertices in either direction; the pairs must be edges."""
        keys = self.edges[:, 0] * self.vertex_count + self.edges[:, 1]
        return np.searchsorted(keys, np.minimum(tails, heads) * self.vertex_count + np.maximum(tails, heads))

    @cached_property
    def _faces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(f, 3) vertices of the faces, (m, 4) face opposite to each corner, and (f, 2) indices of each face in that
        table, flattened: one for each tetrahedron, -1 outside."""
        corners = self.tets[:, TET_FACES].reshape(-1, 3)
        even = (corners[:, 0] < corners[:, 1]) ^ (corners[:, 1] < corners[:, 2]) ^ (corners[:, 0] < corners[:, 2])
        corners.sort(axis=1)
        # Three vertices in one integer: the index of the edge between the lower two, and the highest.
        keys = self.edges_between(corners[:, 0], corners[:, 1]) * self.vertex_count + corners[:, 2]
        _, first, inverse, counts = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
        faces, inverse = corners[first], inverse.reshape(-1)
        halves = np.full((len(faces), 2), -1)
        halves[:, 0] = first
        later = np.flatnonzero(first[inverse] != np.arange(len(inverse)))
        halves[inverse[later], 1] = later
        _refuse_overlaps(faces, halves, counts, even)
        return faces, inverse.reshape(-1, 4), halves

    @property
    def faces(self) -> np.ndarray:
        """(f, 3) vertex indices of each triangle, once, in increasing order, sorted."""
        return self._faces[0]

    @property
    def tet_faces(self) -> np.ndarray:
        """(m, 4) face opposite to corner k."""
        return self._faces[1]

    @cached_property
    def face_tets(self) -> np.ndarray:
        """(f, 2) tetrahedra on the two sides, the lower index first; -1 outside."""
        halves = self._faces[2]
        return np.where(halves < 0, -1, halves // 4)

    @cached_property
    def boundary_faces(self) -> np.ndarray:
        """Indices of the faces that have one tetrahedron only."""
        return np.flatnonzero(self._faces[2][:, 1] < 0)

    @cached_property
    def boundary_triangles(self) -> np.ndarray:
        """(b, 3) vertices of the boundary faces, in their order, counterclockwise from outside."""
        tets, corners = np.divmod(self._faces[2][self.boundary_faces, 0], 4)
        return self.tets[tets[:, None], np.array(TET_FACES)[corners]]

    @cached_property
    def boundary_vertices(self) -> np.ndarray:
        """(n,) bool."""
        mask = np.zeros(self.vertex_count, bool)
        mask[self.boundary_triangles] = True
        return mask

    @cached_property
    def boundary_surface(self) -> tuple[TriangleMesh, np.ndarray]:
        """The boundary as a :class:`TriangleMesh` with the triangles ``boundary_faces``, and (b,) the vertex here of
        each of its vertices, in increasing order.

        A vertex where the surface touches itself is repeated, once for each of its fans of triangles.
        """
        source, triangles = split_pinched_vertices(self.boundary_triangles)
        return TriangleMesh(self.vertices[source], triangles), source

    @cached_property
    def pieces(self) -> np.ndarray:
        """(n,) label of the connected piece of each vertex."""
        return components(self.vertex_count, self.edges)

    @cached_property
    def loose_vertices(self) -> np.ndarray:
        """Indices of the vertices without a tetrahedron; they carry no field."""
        return np.flatnonzero(np.bincount(self.tets.ravel(), minlength=self.vertex_count) == 0)

    # Lengths, volumes and gradients

    @cached_property
    def edge_vectors(self) -> np.ndarray:
        """(e, 3) from the lower to the higher vertex."""
        return self.vertices[self.edges[:, 1]] - self.vertices[self.edges[:, 0]]

    @cached_property
    def edge_lengths(self) -> np.ndarray:
        """(e,) length of each edge."""
        return np.linalg.norm(self.edge_vectors, axis=1)

    @cached_property
    def volumes(self) -> np.ndarray:
        """(m,) all positive."""
        return signed_volumes(self.vertices, self.tets)

    @cached_property
    def hat_gradients(self) -> np.ndarray:
        """(m, 4, 3) gradient of the linear function that is 1 at a corner and 0 at the others, one over length."""
        # Each is normal to the opposite face, as long as one over the height above it: twice the face's area over six
        # times the volume. All four add up to zero, as the functions add up to one.
        a, b, c, d = np.moveaxis(self.vertices[self.tets], 1, 0)
        gradients = np.empty((self.tet_count, 4, 3))
        gradients[:, 1] = np.cross(c - a, d - a)
        gradients[:, 2] = np.cross(d - a, b - a)
        gradients[:, 3] = np.cross(b - a, c - a)
        gradients[:, 1:] /= 6 * self.volumes[:, None, None]
        gradients[:, 0] = -gradients[:, 1:].sum(axis=1)
        return gradients

    @cached_property
    def vertex_masses(self) -> np.ndarray:
        """(n,) a quarter of the volume of each vertex's tetrahedra; never 0, so that it can be divided by."""
        shares = np.repeat(self.volumes / 4, 4)
        masses = np.bincount(self.tets.ravel(), weights=shares, minlength=self.vertex_count)
        return np.maximum(masses, 1e-9 * masses.mean())

    def gradients(self, values: np.ndarray) -> np.ndarray:
        """Compute (m, 3) gradients of the linear functions with (m, 4) values at the corners."""
        return np.einsum("tk,tkx->tx", values, self.hat_gradients)

    def at_vertices(self, values: np.ndarray) -> np.ndarray:
        """Average (m, ...) values of tetrahedra around each vertex, weighted by volume: (n, ...)."""
        shares = values * (self.volumes / 4).reshape(-1, *[1] * (values.ndim - 1))
        sums = np.zeros((self.vertex_count, *values.shape[1:]))
        np.add.at(sums, self.tets, shares[:, None])
        return sums / self.vertex_masses.reshape(-1, *[1] * (values.ndim - 1))

    @cached_property
    def _cotangents(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 6) cotangents of the dihedral angles at the opposite edges, and (m, 6) a sixth of their lengths."""
        g = self.hat_gradients
        products = np.stack([np.einsum("tx,tx->t", g[:, i], g[:, j]) for i, j in TET_EDGES], axis=1)
        opposite = self.edge_lengths[self.tet_edges[:, ::-1]] / 6
        # The gradients of two corners are normal to the faces that meet in the opposite edge.
        return -products * self.volumes[:, None] / opposite, opposite

    @cached_property
    def cotangent_weights(self) -> np.ndarray:
        """(e,) a sixth of the sum, over the tetrahedra at an edge, of the opposite edge's length times the cotangent of
        its dihedral angle: minus the stiffness matrix of linear elements. Either sign."""
        cotangents, sixths = self._cotangents
        return self._sum_at_edges(cotangents * sixths)

    @cached_property
    def weights(self) -> np.ndarray:
        """(e,) ``cotangent_weights`` with angles clipped to ``SHARPEST_ANGLE`` from flat, and positive sums.

        An edge of negative weight gets almost none instead of asking its ends to disagree. A perfect fit remains one:
        its energy vanishes edge by edge, whatever the weights.
        """
        cotangents, sixths = self._cotangents
        limit = 1 / np.tan(SHARPEST_ANGLE)
        sums = self._sum_at_edges(np.clip(cotangents, -limit, limit) * sixths)
        return np.maximum(sums, SMALLEST_COTANGENT * self._sum_at_edges(sixths))

    def _sum_at_edges(self, values: np.ndarray) -> np.ndarray:
        return np.bincount(self.tet_edges.ravel(), weights=values.ravel(), minlength=len(self.edges))


def signed_volumes(vertices: ArrayLike, tets: ArrayLike) -> np.ndarray:
    """Compute (m,) volumes, negative for inverted tetrahedra."""
    a, b, c, d = np.moveaxis(np.asarray(vertices)[np.asarray(tets)], 1, 0)
    return np.einsum("tx,tx->t", np.cross(b - a, c - a), d - a) / 6


def positive(vertices: ArrayLike, tets: ArrayLike) -> np.ndarray:
    """Swap the last two corners of inverted tetrahedra, which some files contain: (m, 4)."""
    tets = np.array(tets, np.int64)
    inverted = signed_volumes(vertices, tets) < 0
    tets[inverted] = tets[inverted][:, [0, 1, 3, 2]]
    return tets


def _refuse_indices(vertices: np.ndarray, tets: np.ndarray) -> None:
    if not len(tets):
        raise MeshError("the solid has no tetrahedra: a field in a solid needs one at least")
    outside = np.flatnonzero(((tets < 0) | (tets >= len(vertices))).any(axis=1))
    if len(outside):
        raise MeshError(
            f"tetrahedron {outside[0]} has the vertices {tets[outside[0]].tolist()} and there are {len(vertices)}: "
            "count them from 0"
        )
    lost = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(lost):
        verb = "has" if len(lost) == 1 else "have"
        raise MeshError(f"{name_elements('vertex', lost)} {verb} no finite position: set the coordinates", lost)


def _refuse_flat(vertices: np.ndarray, tets: np.ndarray, volumes: np.ndarray) -> None:
    corners = vertices[tets]
    reach = np.max([((corners[:, i] - corners[:, j]) ** 2).sum(axis=1) for i, j in TET_EDGES], axis=0, initial=0)
    limit = FLAT_TET * reach**1.5
    for is_bad, what, remedy in (
        (np.abs(volumes) <= limit, "no volume", "collapse its shortest edge, or mesh the solid again"),
        (volumes < 0, "its corners in the wrong order", "swap two of them"),
    ):
        bad = np.flatnonzero(is_bad)
        if len(bad):
            name = name_elements("tetrahedron", bad).replace("tetrahedrons", "tetrahedra")
            verb = "has" if len(bad) == 1 else "have"
            raise MeshError(f"{name} {verb} {what}: {remedy}", tets[bad])


def _refuse_overlaps(faces: np.ndarray, halves: np.ndarray, counts: np.ndarray, even: np.ndarray) -> None:
    """Refuse a face with more than two tetrahedra, or two on the same side."""
    crowded = np.flatnonzero(counts > 2)
    inside = np.flatnonzero((counts == 2) & (halves[:, 1] >= 0))
    same_side = inside[even[halves[inside, 0]] == even[halves[inside, 1]]]
    for bad, what in ((crowded, "more than two"), (same_side, "two on the same side")):
        if len(bad):
            more = f" and {len(bad) - 1} more" if len(bad) > 1 else ""
            raise MeshError(
                f"the triangle of vertices {', '.join(map(str, faces[bad[0]]))}{more} has {what} tetrahedra "
                f"(one is {halves[bad[0], 0] // 4}): remove those that overlap",
                faces[bad],
            )
