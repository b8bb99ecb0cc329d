# SPDX-License-Identifier: GPL-3.0-or-later
"""Principal curvature directions at vertices, from the dihedral angles around them."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import cg

from ...algebra.factorization import solve_definite
from ...connection import levi_civita
from ...geometry.triangle_mesh import TriangleMesh

# Relative residual of the smoothed tensor, and steps in which conjugate gradients reach it, but for long thin triangles
# and lengths of more than a hundred edges.
_RESIDUAL, _STEPS = 1e-3, 500


def principal_directions(
    mesh: TriangleMesh, symmetry: int, largest: bool = True, detail: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Powers of a principal direction and weights with which the vertices should follow it.

    The traceless part of the curvature tensor is the sum of dihedral angle times edge length over the edges around a
    vertex (Knöppel et al. 2013, Section 5; Cohen-Steiner and Morvan 2003). Curvature is positive where the surface
    bends away from its normal, and "largest" means largest with its sign.

    Parameters
    ----------
    detail : length over which the tensor is smoothed; 0 for a mean over the neighbours of each vertex

    Returns
    -------
    values : (n,) complex, the direction's ``symmetry``-th power, unit modulus
    weights : (n,) mass * (k1 - k2)^2: free of units, zero on flat and umbilic parts
    """
    edge_angles = mesh.dihedral_angles * mesh.edge_lengths
    i, j = mesh.edges.T
    turn = np.exp(2j * mesh.edge_directions)
    # A bent edge has no curvature along itself: its tensor's traceless part points across it.
    at_vertices = np.zeros(mesh.vertex_count, complex)
    np.add.at(at_vertices, i, -0.5 * edge_angles * turn[:, 0])
    np.add.at(at_vertices, j, -0.5 * edge_angles * turn[:, 1])
    transport = np.exp(1j * levi_civita(mesh, 2))
    # (k1 - k2) exp(2 i angle of k1)
    difference = (
        _smoothed(mesh, transport, at_vertices, detail) if detail > 0 else _averaged(mesh, transport, at_vertices)
    )
    angles = np.angle(difference) / 2 + (0 if largest else np.pi / 2)
    weights = mesh.vertex_masses * np.abs(difference) ** 2
    # Bends that are only rounding of the coordinates are not curvature.
    weights[np.abs(difference) < 1e-5 / np.sqrt(mesh.areas.sum())] = 0
    return np.exp(1j * symmetry * angles), weights


def _averaged(mesh: TriangleMesh, transport: np.ndarray, integrals: np.ndarray) -> np.ndarray:
    """(n,) complex means over each vertex and its neighbours of a quantity whose integrals are at the vertices."""
    i, j = mesh.edges.T
    totals, masses = integrals.copy(), mesh.vertex_masses.copy()
    np.add.at(totals, j, transport * integrals[i])
    np.add.at(totals, i, transport.conj() * integrals[j])
    np.add.at(masses, j, mesh.vertex_masses[i])
    np.add.at(masses, i, mesh.vertex_masses[j])
    return totals / masses


def _smoothed(mesh: TriangleMesh, transport: np.ndarray, integrals: np.ndarray, length: float) -> np.ndarray:
    """(n,) complex values after one implicit step of diffusion over a length, from their integrals at the vertices."""
    (i, j), count = mesh.edges.T, mesh.vertex_count
    stiff = length**2 * np.maximum(mesh.weights, 0)
    diagonal = mesh.vertex_masses + np.bincount(mesh.edges.ravel(), np.repeat(stiff, 2), count)
    scale = 1 / np.sqrt(np.maximum(diagonal, np.finfo(float).tiny))
    links = -stiff * transport * scale[i] * scale[j]
    values = np.concatenate([np.ones(count), links, links.conj()])
    nodes = np.arange(count)
    matrix = csr_matrix((values, (np.concatenate([nodes, j, i]), np.concatenate([nodes, i, j]))), (count, count))
    found, failed = cg(matrix, scale * integrals, rtol=_RESIDUAL, maxiter=_STEPS)
    return scale * (solve_definite(matrix, scale * integrals) if failed else found)
