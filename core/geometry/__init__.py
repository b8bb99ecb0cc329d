# SPDX-License-Identifier: GPL-3.0-or-later
"""Domains on which fields live: connectivity, lengths, angles, areas and weights."""

from .check import check_mesh
from .triangle_mesh import TriangleMesh

__all__ = ["TriangleMesh", "check_mesh"]
