# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of flows, in space, on surfaces and in sequences."""
