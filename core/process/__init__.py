# SPDX-License-Identifier: GPL-3.0-or-later
"""A child process that solves requests, and the bytes of its messages."""
