# SPDX-License-Identifier: GPL-3.0-or-later
"""The phase of layers on a surface: on the mesh that the solid fills, or on the solid's own boundary."""

from dataclasses import dataclass

import numpy as np

from ..geometry import TriangleMesh
from ..geometry.nearest import NearestTriangles, nearest_in_triangles
from ..interpolate import EdgePhases
from ..interpolate_solid import evaluate_in_tets
from ..refinement.spacing import COARSE_SHARE
from .layers import LayerPattern, SolidTargetOneForm


@dataclass(frozen=True)
class SurfacePhases:
    """The phase of layers on a surface, in ``edge_phases``.

    ``is_own`` says whether that is the solid's boundary, because the given mesh is too coarse for the phase.
    """

    edge_phases: EdgePhases
    is_own: bool

    @property
    def mesh(self) -> TriangleMesh:
        return self.edge_phases.mesh


def surface_phases(mesh: TriangleMesh, pattern: LayerPattern, one_form: SolidTargetOneForm) -> SurfacePhases:
    """The phase of a pattern on the mesh that the solid fills, or on the solid's boundary where its edges are too long.

    ``one_form`` is the target that the pattern was solved for.
    """
    given = _on_surface(mesh, pattern, one_form)
    return SurfacePhases(given, False) if given is not None else SurfacePhases(_on_boundary(pattern), True)


def _on_surface(mesh: TriangleMesh, pattern: LayerPattern, one_form: SolidTargetOneForm) -> EdgePhases | None:
    """Phases at the surface's vertices: those at the solid's nearest point, continued from there by the one-form; None
    if edges are too long for that."""
    solid = pattern.mesh
    boundary, source = solid.boundary_surface
    _, found = NearestTriangles(boundary.vertices, boundary.triangles).nearest(mesh.vertices)
    corners = source[boundary.triangles[found]]
    shares = nearest_in_triangles(mesh.vertices, np.moveaxis(solid.vertices[corners], 1, 0))
    places = np.einsum("pc,pcx->px", shares, solid.vertices[corners])
    rates = np.einsum("pc,pcx->px", shares, one_form.rates[corners])
    i, j = mesh.edges.T
    asked = 0.5 * np.einsum("ex,ex->e", rates[i] + rates[j], mesh.edge_vectors)
    if (np.abs(asked) > np.pi).mean() > COARSE_SHARE:
        return None
    tets = solid.face_tets[solid.boundary_faces[found], 0]
    weights = np.einsum("pc,pck->pk", shares, corners[:, :, None] == solid.tets[tets][:, None])
    angles = evaluate_in_tets(pattern.tet_phases, tets, weights)
    angles += np.einsum("px,px->p", rates, mesh.vertices - places)
    return EdgePhases.of(mesh, np.exp(1j * angles)[:, None], asked[:, None], np.zeros(len(asked), int))


def _on_boundary(pattern: LayerPattern) -> EdgePhases:
    """Phases of the solid on its boundary."""
    solid, phases = pattern.mesh, pattern.edge_phases
    boundary, source = solid.boundary_surface
    # The boundary's vertices are in the solid's order, so that edges run the same way.
    edges = solid.edges_between(*source[boundary.edges].T)
    return EdgePhases(boundary, phases.arguments[source], phases.changes[edges], phases.matchings[edges])
