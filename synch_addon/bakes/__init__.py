# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns as images over a UV map."""
