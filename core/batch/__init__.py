# SPDX-License-Identifier: GPL-3.0-or-later
"""Many commands at once: rows, their records, the processes or the cluster that run them, and the table of results."""
