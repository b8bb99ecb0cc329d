# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods for a connected problem: semidefinite, spectral, diffusion, descent; rounding and certificates."""
