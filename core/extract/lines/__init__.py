# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines on a surface: streamlines of a direction field, isolines and numbers of a pattern."""
