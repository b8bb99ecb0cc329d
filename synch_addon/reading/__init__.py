# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene read into requests: the mesh, its guides and its constraints."""
