# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines, meshes and surfaces made from solved fields."""

from .lines.even_lines import evenly_traced
from .lines.glyphs import direction_glyphs
from .lines.streamlines import trace

__all__ = ["direction_glyphs", "evenly_traced", "trace"]
