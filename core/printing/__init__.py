# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as a printer lays them: how flush they are, beads that cover them, heights, order and reach, G-code."""
