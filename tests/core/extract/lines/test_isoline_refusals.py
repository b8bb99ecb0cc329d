# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines that are refused, and no lines at all."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.lines.isolines import isolines
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.interpolate import EdgePhases

from ...flat_crosses import plane_edge_phases
from ...meshes import icosphere, square
from ...plane_stripes import plane_stripes


@pytest.mark.parametrize("width", [-0.1, 1.1, np.nan, np.inf])
def test_a_width_outside_a_period_is_refused(width):
    with pytest.raises(SettingError, match="width"):
        isolines(plane_stripes(square(4), 0, 0.5), width)


def test_quads_have_no_width():
    with pytest.raises(SettingError, match="grid lines"):
        isolines(plane_edge_phases(square(4), 0, 0.5), 0.5)


def test_without_a_line_there_is_nothing():
    """A sphere smaller than a period."""
    mesh = icosphere(1)
    none = np.zeros(len(mesh.edges), int)
    lines = isolines(EdgePhases(mesh, np.ones((mesh.vertex_count, 1)), np.zeros((len(none), 1)), none))
    assert len(lines.sizes) == len(lines.triangles) == 0
    assert len(lines.resampled(0.1).triangles) == len(lines.without_repeats(0.1).triangles) == 0


@pytest.mark.parametrize(("build", "refusals"), [(isolines, 1), (quad_mesh, 2)])
def test_more_lines_than_memory_holds_are_refused_with_a_spacing_that_fits(build, refusals, monkeypatch):
    """Far more lines than a square of few triangles may have; lines of quads cross the edges and one another."""
    mesh, spacing = square(4), 0.001
    monkeypatch.setattr("synch_fields.core.extract.lines.edge_crossings.MOST", 1000)
    draw = plane_stripes if build is isolines else plane_edge_phases
    for _ in range(refusals):
        with pytest.raises(SettingError, match=r"more than 1e\+03 are not drawn: make the spacing") as caught:
            build(draw(mesh, 30, spacing))
        assert "\n" not in str(caught.value)
        factor = float(str(caught.value).split("make the spacing ")[1].split()[0])
        assert 1 < factor < 100
        spacing *= factor
    build(draw(mesh, 30, spacing))


def test_points_too_close_together_are_refused_with_a_distance_that_fits(monkeypatch):
    lines = isolines(plane_stripes(square(4), 0, 0.26))
    total = lines.lengths.sum()
    for factor in np.linspace(1, 1.1, 11):
        monkeypatch.setattr("synch_fields.core.extract.lines.isolines.MOST", 1000 * factor)
        with pytest.raises(SettingError, match=r"are more than .*: make it ") as caught:
            lines.resampled(0.5 * total / 1000)
        lines.resampled(float(str(caught.value).split("make it ")[1].split()[0]))
