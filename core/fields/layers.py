# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in a solid: evenly spaced sheets across given directions, flush with chosen surfaces (paper, Section 3.4)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..connection import Connection, circle_transports
from ..errors import ContradictionError, SettingError
from ..geometry.tet_mesh import TetMesh
from ..interpolate import TURN, EdgePhases
from ..interpolate_solid import face_numbers, tet_phases
from ..problem import SynchronizationProblem, Targets
from ..solve import Solution, solve
from .groups import TOLERANCE, Links, contracted, joined_links
from .poisson import potential


@dataclass(frozen=True)
class LayerGroup:
    """Surfaces that a layer follows.

    Attributes
    ----------
    vertices : (k,) indices of those that share a phase
    triangles : (f, 3) faces among them, over which the phase does not change
    phase : radians; None for a phase that is left to the solver, one for each connected piece of the triangles
    name : what messages call the group
    """

    vertices: np.ndarray
    triangles: np.ndarray
    phase: float | None = None
    name: str = "the group"

    @classmethod
    def of_vertices(cls, mesh, chosen, phase=None, name="the group"):
        """The boundary's triangles with three chosen corners, and the inner ones with a chosen corner inside.

        Parameters
        ----------
        mesh : TetMesh
        chosen : (n,) bool
        """
        chosen = np.asarray(chosen, bool)
        if chosen.shape != (mesh.vertex_count,):
            raise SettingError(
                f"{name} has {chosen.size} values and the solid {mesh.vertex_count} vertices: give each a truth value"
            )
        on_boundary = np.zeros(len(mesh.faces), bool)
        on_boundary[mesh.boundary_faces] = True
        on_boundary |= ~mesh.boundary_vertices[mesh.faces].all(axis=1)
        return cls(np.flatnonzero(chosen), mesh.faces[on_boundary & chosen[mesh.faces].all(axis=1)], phase, name)

    @classmethod
    def of_triangles(cls, triangles, phase=None, name="the group"):
        """The given faces of the solid, (f, 3) vertices."""
        triangles = np.asarray(triangles, int).reshape(-1, 3)
        return cls(np.unique(triangles), triangles, phase, name)

    @property
    def sides(self):
        """(3 f, 2) ends of the triangles' sides."""
        return self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)

    @property
    def links(self):
        """Each vertex follows the first one of its connected piece."""
        ends = np.searchsorted(self.vertices, self.sides).T
        count = len(self.vertices)
        graph = coo_matrix((np.ones(ends.shape[1]), ends), shape=(count, count))
        _, first, piece = np.unique(
            connected_components(graph, directed=False)[1], return_index=True, return_inverse=True
        )
        roots = self.vertices[first[piece]]
        return Links(roots, self.vertices, np.zeros(count), np.zeros(count, bool), np.full(count, self.name, object))


@dataclass(frozen=True)
class SolidGrowth:
    """Where the phase of layers should grow, and the connection that asks for it (Eq. 6).

    Attributes
    ----------
    mesh : TetMesh
    rates : (n, 3) phase per unit length as a vector: 2 pi / spacing in the direction in which layers follow one another
    """

    mesh: TetMesh
    rates: np.ndarray

    @classmethod
    def of(cls, mesh, directions, spacing):
        """From (n, 3) unit vectors, zero where the phase should not change, and a spacing or one at each vertex."""
        directions = np.asarray(directions, float)
        if directions.shape != mesh.vertices.shape:
            raise SettingError(
                f"the directions have the shape {directions.shape}: give one vector to each of the "
                f"{mesh.vertex_count} vertices"
            )
        spacing = _checked_spacing(mesh, spacing)
        return cls(mesh, directions * (TURN / spacing)[:, None])

    @cached_property
    def changes(self):
        """(e,) phase change asked for from the lower to the higher vertex: the trapezoidal rule over the two ends."""
        i, j = self.mesh.edges.T
        return 0.5 * np.einsum("ex,ex->e", self.rates[i] + self.rates[j], self.mesh.edge_vectors)

    @property
    def connection(self):
        """:class:`Connection` between the vertices."""
        mesh = self.mesh
        return Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(self.changes))

    @property
    def coarse_share(self):
        """Share of the edges along which the phase should turn by more than half a period."""
        return float((np.abs(self.changes) > np.pi).mean())

    @property
    def forced_dislocations(self):
        """How many dislocations of the faces the directions force: the circulation of the rates, in turns, all told."""
        asked = self.edge_phases(np.ones(self.mesh.vertex_count), wrapped=False)
        values, _ = asked.around(self.mesh.faces)
        return float(np.abs(values[:, 3] - values[:, 0]).sum() / TURN)
