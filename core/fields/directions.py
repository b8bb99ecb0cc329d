# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction fields: unit tangent vectors up to a turn by 2 pi / symmetry (paper, Sections 3.1 and 3.2).

A field of symmetry n (1 vectors, 2 lines, 4 crosses) is solved as its n-th power: the unit
phase exp(i n a) for a direction at angle a in the vertex's tangent plane.
"""

from dataclasses import dataclass

import numpy as np

from ..connection import Connection, circle_transports, levi_civita
from ..defects import disclination_numbers, list_defects
from ..errors import SettingError
from ..geometry import TriangleMesh
from ..problem import SynchronizationProblem, Targets
from ..solve import Solution, solve
from .boundary import boundary_tangents, chosen_boundary_edges
from .curvature import principal_directions

SYMMETRIES = {"vector": 1, "line": 2, "cross": 4}
BOUNDARIES = ("free", "along", "across", "phase")
GUIDANCES = ("smooth", "curvature-max", "curvature-min")


@dataclass(frozen=True)
class DirectionWishes:
    """What a direction field should follow.

    Attributes
    ----------
    guidance : "smooth", "curvature-max" or "curvature-min": the direction of largest or smallest
        principal curvature, weighted so that it counts where the two differ
    boundary : "free", "along" or "across" the boundary edges ("phase", stripes that lie on the boundary,
        asks for "along")
    boundary_vertices : (n,) bool, restricts the boundary edges to those with both ends in it
    """

    guidance: str = "smooth"
    boundary: str = "free"
    boundary_vertices: np.ndarray | None = None


@dataclass(frozen=True)
class DirectionField:
    """A direction at every vertex.

    Attributes
    ----------
    mesh : TriangleMesh
    symmetry : 1, 2 or 4
    angles : (n,) one representative, radians in the vertices' tangent planes
    solution : Solution, or None for directions that were given
    """

    mesh: TriangleMesh
    symmetry: int
    angles: np.ndarray
    solution: Solution | None = None

    @property
    def vectors(self):
        """(n, 3) unit representatives in space."""
        x, y = self.mesh.tangent_frames
        return np.cos(self.angles)[:, None] * x + np.sin(self.angles)[:, None] * y

    def turned(self, angle):
        """The field with every direction turned counterclockwise by an angle in radians."""
        return DirectionField(self.mesh, self.symmetry, self.angles + angle, self.solution)

    @property
    def disclinations(self):
        """List of :class:`Defect`, index k / symmetry."""
        numbers = disclination_numbers(self.mesh, np.exp(1j * self.symmetry * self.angles), self.symmetry)
        return list_defects(self.mesh, "disclination", numbers, self.symmetry)


def direction_problem(mesh, symmetry, wishes=None):
    """The synchronization problem of a direction field; arguments as :func:`direction_field`."""
    wishes = DirectionWishes() if wishes is None else wishes
    if symmetry not in SYMMETRIES.values():
        raise SettingError(f"symmetry {symmetry!r} is unknown: use 1 (vector), 2 (line) or 4 (cross)")
    if wishes.boundary not in BOUNDARIES:
        raise SettingError(f"boundary {wishes.boundary!r} is unknown: use one of {', '.join(BOUNDARIES)}")
    if wishes.guidance not in GUIDANCES:
        raise SettingError(f"guidance {wishes.guidance!r} is unknown: use one of {', '.join(GUIDANCES)}")
    connection = Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(levi_civita(mesh, symmetry)))
    fixed = None
    if wishes.boundary != "free":
        edges = chosen_boundary_edges(mesh, wishes.boundary_vertices)
        nodes, values = boundary_tangents(mesh, symmetry, edges, across=wishes.boundary == "across")
        fixed = Targets(nodes, values)
    drawn = None
    if wishes.guidance != "smooth":
        values, weights = principal_directions(mesh, symmetry, largest=wishes.guidance == "curvature-max")
        nodes = np.flatnonzero(weights > 0)
        nodes = nodes if fixed is None else np.setdiff1d(nodes, fixed.nodes)
        drawn = Targets(nodes, values[nodes], weights[nodes]) if len(nodes) else None
    return SynchronizationProblem(connection, mesh.vertex_masses, fixed=fixed, drawn=drawn)


def direction_field(mesh, symmetry, wishes=None, options=None, callback=None):
    """The smoothest direction field that follows the wishes.

    Parameters
    ----------
    mesh : TriangleMesh, checked
    symmetry : 1, 2 or 4
    wishes : DirectionWishes, optional
    options, callback : see :func:`core.solve.solve`
    """
    solution = solve(direction_problem(mesh, symmetry, wishes), options, callback)
    return DirectionField(mesh, symmetry, np.angle(solution.phases) / symmetry, solution)


def given_directions(mesh, symmetry, vectors):
    """A field from (n, 3) vectors, projected to the tangent planes.

    Raises
    ------
    SettingError
        naming the first vertex whose vector has no tangential part
    """
    x, y = mesh.tangent_frames
    vectors = np.asarray(vectors, float)
    tangent = np.einsum("ij,ij->i", vectors, x) + 1j * np.einsum("ij,ij->i", vectors, y)
    lengths = np.linalg.norm(vectors, axis=1)
    bad = ~(np.abs(tangent) > 1e-6 * lengths) | ~np.isfinite(lengths)
    bad[mesh.loose_vertices] = False
    if bad.any():
        raise SettingError(
            f"the guidance vector of vertex {np.flatnonzero(bad)[0]} ({bad.sum()} in all) is zero or "
            "points straight out of the surface: give it a tangential direction"
        )
    return DirectionField(mesh, symmetry, np.angle(tangent))
