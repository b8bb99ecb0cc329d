# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The first picture on fine meshes: a wave of the asked spacing, continuous over the surface, before any result."""

from functools import partial

import numpy as np
import pytest

from synch_fields.core.fields import Row, boundary_line
from synch_fields.core.fields.guidance.guides import axis_guide
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.process.child import _PictureSender
from synch_fields.core.tasks.glimpse import FEWEST, glimpse
from synch_fields.core.tasks.surface_source import PendingGuide, SurfaceSource
from synch_fields.core.tasks.surfaces import Picture

from ..geometry.test_mirror import quads_of
from ..meshes import grid_quads, square, torus, torus_points
from .test_surface_requests import asked, source_of


class _Shown(Exception):
    """Ends a solve at the first picture."""


@pytest.mark.parametrize(("command", "symmetry"), [("stripes", "line"), ("stripes", "vector"), ("quads", "cross")])
def test_a_glimpse_is_a_continuous_wave_of_the_asked_spacing(command, symmetry):
    mesh = torus(around=240, across=100)
    assert mesh.vertex_count >= FEWEST
    spacing = 0.2
    request = asked(command, source_of(mesh), spacing=spacing, symmetry=symmetry)
    picture = glimpse(request)
    places, phases = picture.places.reshape(-1, 3, 3), picture.phases.reshape(-1, 3, 2)
    assert np.allclose(places, mesh.vertices[mesh.triangles], atol=1e-6)
    assert picture.of_quads == (command == "quads") and picture.phases[:, 1].any() == picture.of_quads
    # The drawn value at a vertex is the same in all its triangles.
    drawn = np.cos(phases).prod(axis=2)
    at_vertices = np.zeros(mesh.vertex_count)
    at_vertices[mesh.triangles] = drawn
    assert np.allclose(drawn, at_vertices[mesh.triangles], atol=1e-3)
    # Gradients of the phases: they solve two equations in the plane of each triangle.
    phases = phases if picture.of_quads else phases[..., :1]
    edges = places[:, 1:] - places[:, :1]
    gradients = np.linalg.pinv(edges) @ (phases[:, 1:] - phases[:, :1])
    lines = np.linalg.norm(gradients, axis=1) * spacing / (2 * np.pi)
    assert np.median(lines) == pytest.approx(1, abs=0.05)
    assert (abs(lines - 1) < 0.3).mean() > 0.8


def _gradients(picture):
    """(m, 3) gradients of the first phase: they solve two equations in the plane of each triangle."""
    places, phases = picture.places.reshape(-1, 3, 3), picture.phases.reshape(-1, 3, 2)[..., :1]
    return (np.linalg.pinv(places[:, 1:] - places[:, :1]) @ (phases[:, 1:] - phases[:, :1]))[..., 0]


def test_a_glimpse_follows_guides_and_constraints():
    mesh, axis = square(150), np.array([0.5, np.sqrt(0.75), 0])
    guide = PendingGuide("axis", partial(axis_guide, mesh, axis), 1e3)
    gradients = _gradients(glimpse(asked("stripes", source_of(mesh, guides=(guide,)), spacing=0.1, symmetry="line")))
    # Lines run along the field, and phases grow across.
    assert np.median(np.abs(gradients @ [-axis[1], axis[0], 0])) == pytest.approx(2 * np.pi / 0.1, rel=0.02)


def test_a_glimpse_has_given_phases_on_lines():
    mesh = square(150)
    line = boundary_line(mesh, mesh.vertices[:, 0] == 0)
    rows = Row(line, "along"), Row(line, "phase", 0.7)
    picture = glimpse(asked("stripes", source_of(mesh, rows=rows), spacing=0.1, symmetry="line"))
    on_line = picture.phases[picture.places[:, 0] == 0, 0]
    # Vertices of the copy are off the line; the phases of the waves around them are right on it, up to their sign.
    assert len(on_line) > 300 and np.median(np.abs(np.cos(on_line) - np.cos(0.7))) < 0.02
    assert np.quantile(np.abs(np.cos(on_line) - np.cos(0.7)), 0.9) < 0.1


@pytest.mark.parametrize("command", ["stripes", "quad_mesh"])
def test_a_glimpse_with_mirrors_is_its_own_image(command):
    mesh, polygons = quads_of(torus_points(1.0, 0.4, 240, 100), grid_quads(240, 100, True, True))
    source = SurfaceSource(MeshInput(mesh, polygons, np.eye(3), mesh, np.arange(mesh.vertex_count)))
    settings = {"spacing": 0.2, "symmetry": "line"} if command == "stripes" else {"faces": 600, "symmetry": "cross"}
    picture = glimpse(asked(command, source, mirror="XY", **settings))
    at = {}
    for place, phase in zip(picture.places.round(4) + 0.0, np.cos(picture.phases).prod(axis=1), strict=True):
        at.setdefault(tuple(place), []).append(phase)
    assert len(at) == mesh.vertex_count
    off = [np.ptp([*values, *at[-x, y, z], *at[x, -y, z]]) for (x, y, z), values in at.items() if x * y]
    assert np.median(off) < 1e-3 and np.quantile(off, 0.95) < 0.1


@pytest.mark.parametrize("wanted", [{"faces": 600}, {"spacing": 0.32}])
def test_a_glimpse_of_a_quad_mesh_has_quads_as_large_as_its_faces(wanted):
    mesh = torus(around=240, across=100)
    picture = glimpse(asked("quad_mesh", source_of(mesh), symmetry="cross", **wanted))
    assert picture.of_quads and not picture.is_result
    side = np.sqrt(mesh.areas.sum() / 600) if "faces" in wanted else 0.16
    assert np.median(np.linalg.norm(_gradients(picture), axis=1)) == pytest.approx(np.pi / side, rel=0.1)


def test_a_mesh_that_is_not_much_finer_than_its_pattern_and_a_constrained_one_have_none():
    mesh = torus(around=240, across=100)
    assert glimpse(asked("stripes", source_of(mesh), spacing=0.04)) is None
    small = source_of(torus(around=140, across=60))
    assert glimpse(asked("stripes", small, spacing=0.2)) is None
    assert glimpse(asked("quad_mesh", small, faces=400, symmetry="cross")) is not None  # whose drafts take longer
    assert glimpse(asked("stripes", source_of(mesh), spacing=0.2, pins="7=1")) is None


def test_a_solve_cannot_end_with_a_glimpse_that_is_shown_first():
    request = asked("stripes", source_of(torus(around=240, across=100)), spacing=0.2)
    shown = []

    def show(result):
        shown.append(result)
        raise _Shown

    with pytest.raises(_Shown):
        request.solve_showing(show)
    assert isinstance(shown[0], Picture) and not shown[0].is_result
    assert len(shown[0].places) == len(shown[0].phases) == 3 * len(request.given.mesh.triangles)
    sent = []
    sender = _PictureSender(request, sent.append)
    sender(shown[0])
    assert sender.last is None and sent == [("shown", shown[0])]
