# SPDX-License-Identifier: GPL-3.0-or-later
"""The mathematics of Synch Fields: NumPy and SciPy alone, usable without Blender.

Data flows one way: geometry -> connection -> problem -> solve -> fields, defects and interpolate.
"""
