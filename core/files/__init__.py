# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of other programs as arrays: directions, tetrahedra and flows."""
