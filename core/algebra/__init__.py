# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse matrices and columns of fields: products, factorizations, multigrid, and the cores that share the work."""
