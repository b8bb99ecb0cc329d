# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of a quad mesh: corner angles, irregular vertices, edge lengths, loops."""
