# SPDX-License-Identifier: GPL-3.0-or-later
"""A finer copy of a mesh, bound to it point by point, for meshes that are too coarse for a spacing."""

from .bound_surface import BoundSurface, TooFineError, refine

__all__ = ["BoundSurface", "TooFineError", "refine"]
