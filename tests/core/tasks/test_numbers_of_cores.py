# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The number of cores changes the time of a result, not a bit of it."""

import numpy as np
import pytest

from synch_fields.core.algebra import products, workers
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.solve.methods import rounding
from synch_fields.core.tasks.surface_source import SurfaceSource
from synch_fields.core.tasks.surfaces import SurfaceRequest

from ..meshes import bumpy_torus, icosphere, together

CASES = [
    pytest.param("directions", lambda: bumpy_torus(14), {"symmetry": "cross"}, id="crosses"),
    pytest.param("stripes", lambda: icosphere(3), {"spacing": 0.15}, id="stripes"),
    pytest.param("quads", lambda: bumpy_torus(12), {"spacing": 0.2}, id="quads"),
    pytest.param("stripes", lambda: together(bumpy_torus(14), icosphere(3)), {"spacing": 0.2}, id="several pieces"),
    pytest.param("quad_mesh", lambda: bumpy_torus(14), {"faces": 200}, id="quad mesh"),
]


@pytest.mark.parametrize(("command", "build", "settings"), CASES)
def test_results_have_the_same_bits_on_one_two_four_and_eight_cores(monkeypatch, command, build, settings):
    # Meshes of tests are so small that nothing would be shared.
    monkeypatch.setattr(rounding, "WORTH_SHARING", 1)
    monkeypatch.setattr(rounding, "SHARED_COLUMNS", 2)
    monkeypatch.setattr(products, "WORTH_SHARING", 1)
    shared, share, mesh = [], workers.pool.map, build()
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    request = SurfaceRequest.of(command, SurfaceSource(given), SurfaceSettings(**settings).for_command(command))

    def counted(work, parts):
        parts = list(parts)
        shared.append(len(parts))
        return share(work, parts)

    monkeypatch.setattr(workers.pool, "map", counted)
    found = []
    for cores in (1, 2, 4, 8):
        monkeypatch.setattr(workers, "WORKERS", cores)
        shared.clear()
        found.append(_arrays(request.solve()))
        assert cores in shared or cores == 1
    for others in found[1:]:
        for array, other in zip(found[0], others, strict=True):
            np.testing.assert_array_equal(array, other)


def _arrays(result):
    """What a result consists of."""
    arrays = [result.field.angles, result.field.bending]
    if result.pattern is not None:
        solution = result.pattern.solution
        arrays += [result.pattern.phases, solution.energy, solution.lower_bound]
    if result.quads is not None:
        arrays += [result.quads.vertices, result.quads.corner_vertices]
    return arrays
