# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: python -m synch_fields."""

import sys

from .synch_addon.cli import main

sys.exit(main(sys.argv[1:]))
