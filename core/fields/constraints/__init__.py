# SPDX-License-Identifier: GPL-3.0-or-later
"""What is asked of fields along lines and on groups of nodes."""
