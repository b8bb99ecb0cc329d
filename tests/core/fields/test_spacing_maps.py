# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A spacing that differs from vertex to vertex, and what it forces."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import Row, given_directions, stripe_pattern
from synch_fields.core.fields.directions import DirectionField
from synch_fields.core.fields.target_one_form import TargetOneForm

from ..direction_wishes import along, chain, cosines
from ..meshes import annulus, square


def test_a_spacing_that_grows_across_the_stripes():
    mesh = square(40, 10)
    x = mesh.vertices[:, 0]
    spacing = 0.1 * (1 + x)
    field = along(mesh, (0, -1, 0), 1)
    line = chain(mesh, x == 0)
    pattern = stripe_pattern(mesh, field, spacing, [Row(line, "phase")])
    # The integral of 2 pi / spacing, by the trapezoidal rule on the columns: no stripe needs to end.
    assert pattern.solution.energy < 1e-12 and TargetOneForm.of(mesh, field, spacing).forced_dislocations < 1e-9
    np.testing.assert_allclose(cosines(pattern), np.cos(20 * np.pi * np.log1p(x)), atol=0.03)


def test_what_a_spacing_forces_is_the_circulation():
    mesh = annulus(1.0, 4.0, rings=24, segments=160)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    spokes = given_directions(mesh, 2, mesh.vertices / radius[:, None])
    assert TargetOneForm.of(mesh, spokes, 0.5).forced_dislocations == pytest.approx(2 * np.pi * 3 / 0.5, rel=1e-3)
    # As many spokes outside as inside, but for what each triangle's trapezoidal rule is off.
    assert TargetOneForm.of(mesh, spokes, 0.5 * radius).forced_dislocations < 0.05 * 2 * np.pi * 3 / 0.5


@pytest.mark.parametrize(
    ("value", "message"), [(0.0, "0 at vertex 3"), (np.nan, "nan at vertex 3"), (-1.0, "-1 at vertex 3")]
)
def test_a_spacing_map_that_is_no_length_is_refused_by_its_vertex(value, message):
    mesh = square(4)
    spacing = np.full(mesh.vertex_count, 0.3)
    spacing[3] = value
    with pytest.raises(SettingError, match=message):
        stripe_pattern(mesh, DirectionField(mesh, 2, np.zeros(mesh.vertex_count)), spacing)
