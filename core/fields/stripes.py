# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripe patterns: evenly spaced stripes along a direction field (paper, Section 3.3)."""

from dataclasses import dataclass

import numpy as np

from ..connection import Connection, circle_transports, line_flips, stripe_rotations
from ..defects import list_defects
from ..errors import SettingError
from ..geometry import TriangleMesh
from ..interpolate import EdgePhases, dislocation_numbers, face_phases
from ..problem import SynchronizationProblem, Targets
from ..solve import Solution, solve
from .boundary import chosen_boundary_edges


@dataclass(frozen=True)
class StripePattern:
    """Phases of a stripe pattern on a mesh.

    Attributes
    ----------
    mesh : TriangleMesh
    solution : Solution
    edge_phases : EdgePhases, the phase change along every edge
    """

    mesh: TriangleMesh
    solution: Solution
    edge_phases: EdgePhases

    @property
    def dislocations(self):
        """List of :class:`Defect` with integer index."""
        numbers, _ = dislocation_numbers(self.edge_phases, self.mesh.triangles)
        return list_defects(self.mesh, "dislocation", numbers)

    def on_faces(self, polygons):
        """:class:`FacePhases` for the faces that the mesh's triangles draw."""
        return face_phases(self.edge_phases, polygons)


def check_spacing(mesh, spacing):
    """Refuse a spacing that no stripe fits in; lengths in the mesh's units."""
    if not np.isfinite(spacing) or spacing <= 0:
        raise SettingError(f"the spacing is {spacing:g}: give a positive length")
    extent = np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0))
    if spacing > extent:
        raise SettingError(
            f"the spacing {spacing:g} is larger than the object ({extent:g}): no stripe would fit, reduce it"
        )


def coarse_edge_share(mesh, field, spacing):
    """Share of the edges along which the phase should turn by more than half a period."""
    rotations, _ = stripe_transports(mesh, field, spacing)
    return float((np.abs(rotations) > np.pi).mean())


def stripe_transports(mesh, field, spacing):
    """Angles and flips of the stripe connection; stripes run along the field, the phase grows across."""
    if field.symmetry not in (1, 2):
        raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
    angles = field.angles + np.pi / 2
    flips = line_flips(mesh, angles) if field.symmetry == 2 else np.zeros(len(mesh.edges), bool)
    rates = np.full(mesh.vertex_count, 2 * np.pi / spacing)
    return stripe_rotations(mesh, angles, rates, flips), flips


def stripe_problem(mesh, field, spacing, on_boundary=False, boundary_vertices=None):
    """The synchronization problem of a stripe pattern.

    Parameters
    ----------
    mesh : TriangleMesh
    field : DirectionField of symmetry 1 or 2, along which stripes run
    spacing : distance between two stripes, in the mesh's units
    on_boundary : put a stripe (phase 0) on the boundary edges
    boundary_vertices : (n,) bool, restricts these edges to those with both ends in it
    """
    check_spacing(mesh, spacing)
    angles, flips = stripe_transports(mesh, field, spacing)
    connection = Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(angles, flips))
    fixed = None
    if on_boundary:
        nodes = np.unique(mesh.edges[chosen_boundary_edges(mesh, boundary_vertices)])
        fixed = Targets(nodes, np.ones(len(nodes), complex))
    return SynchronizationProblem(connection, mesh.vertex_masses, fixed=fixed)


def stripe_pattern(mesh, field, spacing, on_boundary=False, boundary_vertices=None, options=None, callback=None):
    """Solve a stripe pattern; arguments as :func:`stripe_problem` and :func:`core.solve.solve`."""
    solution = solve(stripe_problem(mesh, field, spacing, on_boundary, boundary_vertices), options, callback)
    angles, flips = stripe_transports(mesh, field, spacing)
    return StripePattern(mesh, solution, EdgePhases.of(mesh, solution.phases, angles, flips))
