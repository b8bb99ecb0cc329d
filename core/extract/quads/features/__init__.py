# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundaries and sharp edges that a quad mesh keeps."""
