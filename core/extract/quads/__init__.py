# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes from a quad pattern: traced, laid onto features, repaired, smoothed and measured."""
