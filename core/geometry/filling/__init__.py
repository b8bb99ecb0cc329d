# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids that fill closed surfaces: tetrahedra from a lattice, fitted to the surface and its sharp edges."""
