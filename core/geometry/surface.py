# SPDX-License-Identifier: GPL-3.0-or-later
"""A triangle surface with the attributes of a two-dimensional grid, for flows on either."""

import numpy as np

from .triangle_mesh import TriangleMesh


class Surface:
    """Nodes, edges and faces of a TriangleMesh; see :class:`Grid` for their meaning.

    Parameters
    ----------
    mesh : manifold, see :func:`check_mesh`
    seam : (k, 2) vertices at the same places that count as one
    """

    dimension = 2

    def __init__(self, mesh: TriangleMesh, seam: np.ndarray | None = None) -> None:
        self.mesh, self.seam = mesh, seam

    @property
    def node_count(self) -> int:
        return self.mesh.vertex_count

    @property
    def shape(self) -> tuple[int]:
        """The number of nodes, as one row."""
        return (self.node_count,)

    @property
    def places(self) -> np.ndarray:
        """(n, 3) coordinates of the nodes."""
        return self.mesh.vertices

    @property
    def edges(self) -> np.ndarray:
        """(e, 2) nodes, the lower one first."""
        return self.mesh.edges

    @property
    def weights(self) -> np.ndarray:
        """(e,) cotangent weights."""
        return self.mesh.weights

    @property
    def masses(self) -> np.ndarray:
        """(n,) a third of the area around each node."""
        return self.mesh.vertex_masses

    @property
    def faces(self) -> np.ndarray:
        """(f, 3) nodes around each face, counterclockwise seen from outside."""
        return self.mesh.triangles

    @property
    def face_edges(self) -> np.ndarray:
        """(f, 3) edges around each face."""
        return self.mesh.triangle_edges

    @property
    def face_signs(self) -> np.ndarray:
        """(f, 3) +1 where an edge runs forwards, else -1."""
        return self.mesh.triangle_edge_signs
