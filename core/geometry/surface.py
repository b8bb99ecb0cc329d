# SPDX-License-Identifier: GPL-3.0-or-later
"""A triangle surface under the names of a two-dimensional grid, for flows that live on either."""


class Surface:
    """Nodes, edges and faces of a TriangleMesh; see :class:`Grid` for their meaning.

    Parameters
    ----------
    mesh : TriangleMesh, checked
    seam : (k, 2) vertices at the same places that count as one, None for none
    """

    dimension = 2

    def __init__(self, mesh, seam=None):
        self.mesh, self.seam = mesh, seam

    @property
    def node_count(self):
        return self.mesh.vertex_count

    @property
    def shape(self):
        """(1,) the nodes, in one row."""
        return (self.node_count,)

    @property
    def places(self):
        """(n, 3) coordinates of the nodes."""
        return self.mesh.vertices

    @property
    def edges(self):
        """(e, 2) nodes, the lower one first."""
        return self.mesh.edges

    @property
    def weights(self):
        """(e,) cotangent weights."""
        return self.mesh.weights

    @property
    def masses(self):
        """(n,) a third of the area around each node."""
        return self.mesh.vertex_masses

    @property
    def faces(self):
        """(f, 3) nodes around each face, counterclockwise seen from outside."""
        return self.mesh.triangles

    @property
    def face_edges(self):
        """(f, 3) edges around each face."""
        return self.mesh.triangle_edges

    @property
    def face_signs(self):
        """(f, 3) +1 where an edge is passed forwards, else -1."""
        return self.mesh.triangle_edge_signs
