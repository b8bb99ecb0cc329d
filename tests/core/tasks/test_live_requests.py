# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of Live: what they send to the window's process."""

import io
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.process.ipc import Unpacker, pack_parts
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.solve.warm_start import Follower
from synch_fields.core.tasks.live import LiveRequest
from synch_fields.core.tasks.surface_source import SurfaceSource
from synch_fields.core.tasks.surfaces import SurfaceRequest

from ..meshes import bumpy_torus


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_a_result_goes_to_another_process_without_matrices_and_is_the_same_there(command):
    mesh = bumpy_torus(24)
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    settings = SurfaceSettings(spacing=0.4).for_command(command)
    asked = SurfaceRequest.of(command, SurfaceSource(given), settings)
    shown, followers = asked.solve(), (Follower(), Follower())
    for spacing in (0.404, 0.408, 0.412):
        asked = replace(asked, spacing=spacing, spacings=spacing)
        request = LiveRequest(asked, shown.field.without_solution, shown.pattern.phases, True, followers)
        shown = request.solve()
    stream = io.BytesIO()
    for part in pack_parts(shown, request.shared):
        stream.write(part)
    assert len(stream.getvalue()) < 1000 * mesh.vertex_count
    (there,) = Unpacker(request.shared).feed(stream.getvalue())
    assert there.pattern.mesh is mesh and "evenness" in vars(there.pattern)
    for name in ("arguments", "changes", "matchings"):
        found, expected = (getattr(result.pattern.edge_phases, name) for result in (there, shown))
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(there.pattern.one_form.changes, shown.pattern.one_form.changes)
    assert there.pattern.energy == shown.pattern.energy
    assert there.pattern.problem.energy(there.pattern.phases) == shown.pattern.problem.energy(shown.pattern.phases)
    assert [d.triangle for d in there.pattern.dislocations] == [d.triangle for d in shown.pattern.dislocations]
    problem, own = there.pattern.problem, shown.pattern.problem
    assert abs(problem.pieces[0].matrix - own.pieces[0].matrix).max() == 0
    np.testing.assert_array_equal(problem.calmer(), own.calmer())
