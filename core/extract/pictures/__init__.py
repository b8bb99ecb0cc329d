# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns as pictures: triangles for graphics cards, and thumbnails."""
