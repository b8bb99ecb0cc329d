# SPDX-License-Identifier: GPL-3.0-or-later
"""Many components of a problem, solved together."""
