# SPDX-License-Identifier: GPL-3.0-or-later
"""What is typed: the command line, a file for each command."""
