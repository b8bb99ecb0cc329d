# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve synchronization problems with a proved bound."""

from ..solution import METHODS, ROUNDINGS, Certificate, Options, Solution, Status
from .solver import solve

__all__ = ["METHODS", "ROUNDINGS", "Certificate", "Options", "Solution", "Status", "solve"]
