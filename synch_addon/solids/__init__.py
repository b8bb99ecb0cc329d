# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in solids, and their outputs: files, tool paths and volumes."""
