# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a finer surface cannot carry is refused, with what helps."""

import re

import bpy
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.refinement import bound_surface
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.patterns.job import FieldJob

from ..scenes import grid, sphere

pytestmark = pytest.mark.any_surface


@pytest.mark.parametrize("stretch", [1, 200])
def test_more_faces_than_a_finer_surface_can_have_are_refused_with_a_number_that_is_not(stretch, monkeypatch):
    monkeypatch.setattr(bound_surface, "MOST_TRIANGLES", 4000)
    obj = grid(2)
    obj.scale.x = stretch
    bpy.context.view_layer.update()
    with pytest.raises(
        SynchError, match=r"100000 faces are too many for this mesh: ask for [1-9]\d* at most"
    ) as caught:
        FieldJob("quad_mesh", obj, SurfaceSettings(faces=100_000))
    fitting = int(re.search(r"ask for (\d+)", str(caught.value))[1])
    assert FieldJob("quad_mesh", obj, SurfaceSettings(faces=fitting)).request.settings.faces == fitting


def test_a_mesh_of_parts_too_thin_for_any_number_of_faces_is_refused_with_what_helps(monkeypatch):
    monkeypatch.setattr(bound_surface, "MOST_TRIANGLES", 100)  # fewer than it has
    obj = sphere()
    obj.data.vertices[0].co *= 1000
    with pytest.raises(SynchError, match="too long and thin for quads: delete vertices that lie far out, or remesh it"):
        FieldJob("quad_mesh", obj, SurfaceSettings(faces=10_000))
