# SPDX-License-Identifier: GPL-3.0-or-later
"""Many commands at once: rows, what is done of them, the processes or the cluster that run them, and their table."""
