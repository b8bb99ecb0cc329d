# SPDX-License-Identifier: GPL-3.0-or-later
"""What directions follow: curvature, distances, potentials and given vectors, on surfaces and in solids."""
