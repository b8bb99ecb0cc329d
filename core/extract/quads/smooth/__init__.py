# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of a quad mesh's vertices: rectangular faces on the surface."""
