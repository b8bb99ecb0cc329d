# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs of a page each, on the core alone: what is solved, its equation, and what comes out."""
