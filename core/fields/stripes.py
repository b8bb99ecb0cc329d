# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripe patterns: evenly spaced stripes along a direction field (paper, Section 3.3)."""

from dataclasses import dataclass

import numpy as np

from ..connection import Connection, circle_transports, line_flips, stripe_rotations
from ..defects import list_defects
from ..errors import SettingError
from ..geometry import TriangleMesh
from ..interpolate import EdgePhases, dislocation_numbers, face_phases
from ..problem import SynchronizationProblem, joined_targets
from ..solve import Solution, solve
from .groups import TOLERANCE
from .mirror import LEAN, on_mirror, snapped, split_links, with_loops
from .phase_rows import phase_constraints


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
    """Refuse a spacing that no stripe fits in: a length in the mesh's units, or (n,) one at each vertex."""
    spacing = np.asarray(spacing, float)
    bad = np.flatnonzero(~(np.isfinite(spacing) & (spacing > 0)))
    if len(bad):
        where = f" at vertex {bad[0]} ({len(bad)} in all)" if spacing.ndim else ""
        raise SettingError(f"the spacing is {spacing.flat[bad[0]]:g}{where}: give a positive length")
    extent = np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0))
    if spacing.min() > extent:
        raise SettingError(
            f"the spacing {spacing.min():g} is larger than the object ({extent:g}): no stripe would fit, reduce it"
        )


def coarse_edge_share(mesh, field, spacing):
    """Share of the edges along which the phase should turn by more than half a period."""
    rotations, _ = stripe_transports(mesh, field, spacing)
    return float((np.abs(rotations) > np.pi).mean())


def forced_dislocations(mesh, field, spacing):
    """How many dislocations the field and the spacing force: the circulation of v / hbar, in turns.

    The asked phase changes around a triangle add up to turns that no phase can make; their sizes are summed over all
    triangles around which a line field keeps its sheet. A pattern that stretches and bends needs fewer, and what the
    trapezoidal rule is off by in each triangle counts too.
    """
    angles, flips = stripe_transports(mesh, field, spacing)
    asked = EdgePhases(mesh, np.zeros(mesh.vertex_count), np.where(flips, -angles, angles), np.where(flips, -1, 1))
    values, sheet = asked.around(mesh.triangles)
    return float(np.abs(values[sheet > 0, 3]).sum() / (2 * np.pi))


def stripe_rates(mesh, spacing):
    """(n,) phase per unit length for one spacing, or one at each vertex."""
    return np.broadcast_to(2 * np.pi / np.asarray(spacing, float), mesh.vertex_count)


def stripe_transports(mesh, field, spacing):
    """Angles and flips of the stripe connection; stripes run along the field, the phase grows across."""
    if field.symmetry not in (1, 2):
        raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
    angles = field.angles + np.pi / 2
    flips = line_flips(mesh, angles) if field.symmetry == 2 else np.zeros(len(mesh.edges), bool)
    return stripe_rotations(mesh, angles, stripe_rates(mesh, spacing), flips), flips


def stripe_problem(mesh, field, spacing, rows=(), mirrors=()):
    """The synchronization problem of a stripe pattern.

    Parameters
    ----------
    mesh : TriangleMesh
    field : DirectionField of symmetry 1 or 2, along which stripes run
    spacing : distance between two stripes in the mesh's units, or (n,) one at each vertex
    rows : Rows of the constraint list; those of the kinds "phase" and "constant" count
    mirrors : Mirrors that leave the pattern as it is
    """
    check_spacing(mesh, spacing)
    angles, flips = stripe_transports(mesh, field, spacing)
    connection = Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(angles, flips))
    rows = [row for row in rows if row.is_of_phases]
    links, loops = _mirror_links(field, mirrors)
    slack = LEAN if mirrors else TOLERANCE
    fixed, merged, drawn = phase_constraints(mesh, field, stripe_rates(mesh, spacing), rows, [links], slack)
    fixed = on_mirror(fixed, loops, slack)
    connection = with_loops(connection, loops)
    return SynchronizationProblem(connection, mesh.vertex_masses, merged, fixed, joined_targets(drawn))


def stripe_pattern(mesh, field, spacing, rows=(), mirrors=(), options=None, callback=None):
    """Solve a stripe pattern; arguments as :func:`stripe_problem` and :func:`core.solve.solve`."""
    problem = stripe_problem(mesh, field, spacing, rows, mirrors)
    solution = snapped(problem, solve(problem, options, callback), _mirror_links(field, mirrors)[1])
    angles, flips = stripe_transports(mesh, field, spacing)
    return StripePattern(mesh, solution, EdgePhases.of(mesh, solution.phases, angles, flips))


def _mirror_links(field, mirrors):
    return split_links(field.mesh.vertex_count, [mirror.phase_links(field.angles + np.pi / 2) for mirror in mirrors])
