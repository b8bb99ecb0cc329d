# SPDX-License-Identifier: GPL-3.0-or-later
"""The last solves of flows, kept while Blender runs: another point of the sphere needs no other."""

from ..jobs.shelf import ObjectShelf

# Of the objects that show the vortices of a flow, the latest ones: a kilobyte a node each.
flows = ObjectShelf(4)
