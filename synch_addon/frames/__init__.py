# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns on a moving mesh, frame by frame."""
