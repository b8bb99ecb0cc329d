# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The public meshes, for machines that have them."""

from pathlib import Path

import pytest

from synch_fields.synch_addon.blender import files

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "meshes"
MESHES = sorted(path.stem for path in FOLDER.glob("*.obj"))
MARKS = [pytest.mark.slow, pytest.mark.skipif(not MESHES, reason="the shared meshes are not here")]


def opened(name):
    """The object of a mesh."""
    return files.open_object(FOLDER / f"{name}.obj")
