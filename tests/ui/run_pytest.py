# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender in the background: pytest in this Python, with the arguments after "--".

A Blender as a module has no languages, a real one has. SYNCH_TEST_PATHS names the folders, split like PATH, in which
Python finds what Blender does not bring: pytest and this package.
"""

import os
import sys

sys.path.extend(os.environ["SYNCH_TEST_PATHS"].split(os.pathsep))

import pytest

sys.exit(pytest.main(sys.argv[sys.argv.index("--") + 1 :]))
