# SPDX-License-Identifier: GPL-3.0-or-later
"""Principal curvature directions at vertices, from the dihedral angles around them."""

import numpy as np

from ...geometry.triangle_mesh import TriangleMesh


def principal_directions(mesh: TriangleMesh, symmetry: int, largest: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Powers of a principal direction and weights with which the vertices should follow it.

    The traceless part of the curvature tensor, the sum of dihedral angle times edge length over the edges around a
    vertex (Knöppel et al. 2013, Section 5; Cohen-Steiner and Morvan 2003), is averaged once over the neighbours.
    Curvature is positive where the surface bends away from its normal, and "largest" means largest with its sign.

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
    transport = np.exp(2j * (mesh.edge_directions[:, 1] + np.pi - mesh.edge_directions[:, 0]))
    totals, masses = at_vertices.copy(), mesh.vertex_masses.copy()
    np.add.at(totals, j, transport * at_vertices[i])
    np.add.at(totals, i, transport.conj() * at_vertices[j])
    np.add.at(masses, j, mesh.vertex_masses[i])
    np.add.at(masses, i, mesh.vertex_masses[j])
    difference = totals / masses  # (k1 - k2) exp(2 i angle of k1)
    angles = np.angle(difference) / 2 + (0 if largest else np.pi / 2)
    weights = mesh.vertex_masses * np.abs(difference) ** 2
    # Bends that are only rounding of the coordinates are not curvature.
    weights[np.abs(difference) < 1e-5 / np.sqrt(mesh.areas.sum())] = 0
    return np.exp(1j * symmetry * angles), weights
