# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far guides are off."""

import numpy as np


def in_space(mesh, guide):
    """(n, 3) unit vectors."""
    x, y = mesh.tangent_frames
    return np.cos(guide.angles)[:, None] * x + np.sin(guide.angles)[:, None] * y


def misses(mesh, guide, expected):
    """Degrees between a guide and expected directions, projected to the tangent planes."""
    expected = (
        np.asarray(expected) - np.einsum("ij,ij->i", expected, mesh.vertex_normals)[:, None] * mesh.vertex_normals
    )
    given = in_space(mesh, guide)
    sine = np.linalg.norm(np.cross(given, expected), axis=1)
    return np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", given, expected)))
