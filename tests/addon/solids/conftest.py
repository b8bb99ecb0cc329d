# SPDX-License-Identifier: GPL-3.0-or-later
"""An object with layers."""

import pytest

from synch_fields.synch_addon import api

from ..scenes import make_active
from ..solid_objects import SPACING, block


@pytest.fixture
def layered():
    """A turned, scaled and moved block with layers across a slanted guide: the object."""
    obj = block()
    obj.scale, obj.location, obj.rotation_euler = (1.2, 1, 0.9), (3, -1, 2), (0.3, 0.2, -0.5)
    api.layers(obj, guidance="axis:Z", spacing=SPACING, size=0.15)
    make_active(obj)
    return obj
