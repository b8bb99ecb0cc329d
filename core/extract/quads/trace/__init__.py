# SPDX-License-Identifier: GPL-3.0-or-later
"""The quad mesh whose edges are the grid lines of a pattern (paper, Section 3.5)."""
