# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortex filaments and tubes of a Clebsch map, and how filaments are linked."""
