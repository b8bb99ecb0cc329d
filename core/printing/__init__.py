# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as a printer lays them: beads that cover them, their heights, their order and reach, G-code; how flush they are."""
