# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines drawn from solved fields."""

from .even_lines import evenly_traced
from .glyphs import direction_glyphs
from .streamlines import trace

__all__ = ["direction_glyphs", "evenly_traced", "trace"]
