# SPDX-License-Identifier: GPL-3.0-or-later
"""An object with layers."""

import pytest

from synch_fields.core.settings.layers import LayerSettings
from synch_fields.synch_addon import api

from ..scenes import make_active
from ..solid_objects import SPACING, block


@pytest.fixture(scope="session")
def found():
    """The result of the solve that all tests share, once there is one."""
    return []


@pytest.fixture
def layered(found):
    """A turned, scaled and moved block with layers across a slanted guide: the object."""
    obj = block()
    obj.scale, obj.location, obj.rotation_euler = (1.2, 1, 0.9), (3, -1, 2), (0.3, 0.2, -0.5)
    job = api.layer_job(obj, LayerSettings(guidance="axis:Z", spacing=SPACING, size=0.15))
    if not found:
        found.append(job.request.solve())
    job.write(found[0])
    return make_active(obj)
