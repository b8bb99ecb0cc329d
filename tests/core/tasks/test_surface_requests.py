# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests of a mesh and settings, without Blender: what is derived from both."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.errors import AsymmetryError, SettingError
from synch_fields.core.geometry.mesh_input import MeshInput, ObjectMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.refinement.spacing import QUADS
from synch_fields.core.settings.constraints import Constraint
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.tasks.surface_source import SurfaceSource
from synch_fields.core.tasks.surfaces import SurfaceRequest

from ..meshes import bumpy_torus, icosphere, square


def source_of(mesh, **read):
    return SurfaceSource(
        MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(len(mesh.vertices))), **read
    )


def asked(command, source, **settings):
    return SurfaceRequest.of(command, source, SurfaceSettings(**settings).for_command(command))


@pytest.mark.parametrize(("command", "lines"), [("stripes", 1), ("quads", 2)])
def test_an_automatic_spacing_follows_from_the_mesh(command, lines):
    mesh = icosphere(5)
    request = asked(command, source_of(mesh))
    lengths = np.linalg.norm(np.subtract(*mesh.vertices[mesh.edges.T]), axis=1)
    median, long = np.quantile(lengths, [0.5, 0.95])
    assert request.spacing == request.spacings == pytest.approx(max(lines * 2 / 40, 4 * median, 2 * long))
    fitted = asked(command, source_of(mesh, is_fitted=True))
    assert fitted.spacing == pytest.approx(lines * np.sqrt(mesh.areas.sum() / QUADS))


def test_maps_and_the_aspect_multiply_the_spacing():
    mesh = square(12)
    factors = 1 + mesh.vertices[:, 0]
    assert np.allclose(asked("stripes", source_of(mesh, factors=factors), spacing=0.4).spacings, 0.4 * factors)
    both = asked("quads", source_of(mesh, factors=factors), spacing=0.4, aspect=2.0).spacings
    assert np.allclose(both, 0.4 * factors[:, None] * [1, 2])


def test_pins_are_triangles_of_faces_that_exist():
    source = source_of(icosphere(2))
    assert asked("directions", source, symmetry="line", pins="7=1,3=-1").pins == ((7, 0.5), (3, -0.5))
    with pytest.raises(SettingError, match="there is no face 5000 to pin"):
        asked("directions", source, pins="5000=1")


def test_mirrors_and_features_are_found_on_the_mesh():
    request = asked("quad_mesh", source_of(square(8)), spacing=0.5, mirror="")
    assert [row.kind for row in request.rows] == ["grid"]
    assert asked("quad_mesh", source_of(square(8)), spacing=0.5, features=0.0).rows == ()
    assert len(asked("quads", source_of(icosphere(3)), spacing=0.5, mirror="XY").mirrors) == 2
    with pytest.raises(AsymmetryError):
        asked("stripes", source_of(bumpy_torus(8)), spacing=0.5, mirror="X")


def test_settings_that_have_no_effect_are_told():
    rows = (Constraint("seams", "along"),)
    (line,) = SurfaceSettings(guidance="attribute:flow", constraints=rows, singularities=1.0).unheeded("stripes", False)
    assert "without the constraint seams along" in line
    plain = SurfaceSettings(constraints=(Constraint("seams", "phase"),))
    assert list(plain.unheeded("stripes", is_turned=False)) == []
    (line,) = plain.unheeded("stripes", is_turned=True)
    assert "the angle turns directions away from lines with a stripe (the constraint seams phase)" in line


def test_stripes_of_crosses_and_phases_of_quads_are_refused():
    with pytest.raises(SettingError, match="vector or line"):
        SurfaceSettings(symmetry="cross").for_command("stripes")
    rows = (Constraint("attribute", "phase", "phi"),)
    with pytest.raises(SettingError, match="quads have two"):
        SurfaceSettings(constraints=rows).for_command("quads")
    assert SurfaceSettings(constraints=rows).for_command("stripes").branching == 1.0


def test_the_faces_of_an_object_become_a_surface_and_follow_it():
    mesh = icosphere(2)
    read = ObjectMesh("ball", mesh.vertices, Polygons.of_triangles(mesh), np.diag([2.0, 1, 1]))
    given = read.surface()
    assert np.array_equal(given.mesh.vertices, mesh.vertices * [2, 1, 1]) and given.findings == ()
    moved = replace(read, vertices=mesh.vertices + [0, 0, 1]).moved(given)
    assert np.array_equal(moved.mesh.triangles, given.mesh.triangles)
    assert np.allclose(moved.mesh.vertices - given.mesh.vertices, [0, 0, 1])
