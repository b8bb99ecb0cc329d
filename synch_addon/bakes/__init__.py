# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pattern shows, as images over a UV map."""
