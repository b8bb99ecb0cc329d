# SPDX-License-Identifier: GPL-3.0-or-later
"""What every job shares: how it runs, how far it is, and its report."""
