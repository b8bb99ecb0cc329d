# SPDX-License-Identifier: GPL-3.0-or-later
"""Constraints on fields along lines and on groups of nodes."""
