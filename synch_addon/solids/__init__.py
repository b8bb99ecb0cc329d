# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in solids, and what is made of them."""
