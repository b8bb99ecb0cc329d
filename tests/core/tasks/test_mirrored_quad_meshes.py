# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirrored quad meshes are exactly mirrored, whatever the number of faces."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.core.extract.quads.measure.quality import worst_deviations
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.refinement.spacing import is_fine
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.tasks import face_counts, quad_drafts

from ..meshes import cube, torus
from .test_surface_requests import asked, source_of


def ball(cuts=8):
    """A sphere of quads in four triangles each, symmetric in all axes."""
    given = cube(2 * cuts)
    places = given.vertices - given.vertices.mean(axis=0)
    places = np.tan(places / np.abs(places).max() * np.pi / 4)
    faces = given.triangles.reshape(-1, 2, 3)
    corners = np.array([_around(*pair) for pair in faces])
    middles = places[corners].mean(axis=1)
    numbers = len(places) + np.arange(len(corners))
    triangles = np.concatenate([np.column_stack([corners[:, k - 1], corners[:, k], numbers]) for k in range(4)])
    places = np.concatenate([places, middles])
    return TriangleMesh(places / np.linalg.norm(places, axis=1, keepdims=True), triangles)


def _around(first, second):
    """The corners of two triangles that are a quad, in order."""
    (alone,) = set(second.tolist()) - set(first.tolist())
    place = next(k for k in range(3) if first[k] not in second)
    return [first[place], first[(place + 1) % 3], alone, first[(place + 2) % 3]]


def tailed():
    """A ball with a bent tail, thinner than a quad, along the plane across X."""
    mesh = ball()
    places = mesh.vertices.copy()
    length = np.clip(-0.2 - places[:, 2], 0, None)
    width = np.maximum(0.08, 1 - 1.2 * length)
    places[:, 0] *= width
    places[:, 1] = places[:, 1] * width + 1.2 * length**2
    places[:, 2] -= 2 * length
    return TriangleMesh(places, mesh.triangles)


@pytest.mark.parametrize(
    ("shape", "axes", "faces"),
    [("ball", "XYZ", 100), ("ball", "XYZ", 400), ("ball", "Y", 400)]
    + [("tailed", "X", faces) for faces in (200, 300, 400)],
)
def test_a_mirrored_quad_mesh_is_its_own_image_at_every_count(shape, axes, faces, counts):
    mesh = {"ball": ball, "tailed": tailed}[shape]()
    quads = asked("quad_mesh", source_of(mesh), faces=faces, mirror=axes).solve().quads
    assert (quads.sizes == 4).all() and not quads.is_unsound.any()
    assert (quads.euler_characteristic, (quads.edges[1] == 2).all()) == (2, True)
    assert abs(len(quads.sizes) / faces - 1) < 0.15
    assert np.bincount(quads.edges[0].ravel()).min() > 2 and worst_deviations(quads).max() < 55
    away = np.linalg.norm(mesh.finder.nearest(quads.vertices)[0] - quads.vertices, axis=1)
    assert away.max() < 2e-3 * quads.edge_lengths.mean()
    for axis in axes:
        image = quads.vertices * np.where(np.array(list("XYZ")) == axis, -1, 1)
        apart, partner = cKDTree(quads.vertices).query(image)
        assert apart.max() < 1e-9
        theirs = np.sort(partner[quads.corner_vertices].reshape(-1, 4), axis=1)
        own = np.sort(quads.corner_vertices.reshape(-1, 4), axis=1)
        assert {*map(tuple, theirs)} == {*map(tuple, own)}
    if (shape, faces) == ("ball", 400):
        check_counts(counts, faces)


@pytest.mark.parametrize(("axes", "branching"), [("", 0.0), ("", 1.0), ("Y", 1.0)])
def test_the_faces_of_the_whole_mesh_are_counted_before_it_is_finished(axes, branching, counts):
    asked("quad_mesh", source_of(ball()), faces=400, mirror=axes, branching=branching).solve()
    check_counts(counts, 400)


@pytest.fixture
def counts(monkeypatch):
    """Numbers of faces that were expected and drafted, and of the finished mesh, for each mesh that was finished."""
    found = []

    def finished(draft, *progress):
        result = quad_drafts.complete(draft, *progress)
        found.append((draft.finished_count, draft.face_count, len(result.quads.sizes)))
        return result

    monkeypatch.setattr(face_counts, "complete", finished)
    return found


def check_counts(counts, faces):
    for expected, drafted, finished in counts:
        assert abs(expected / finished - 1) < 0.03 and abs(drafted / finished - 1) < 0.05
    assert counts and abs(counts[-1][-1] / faces - 1) < 0.05


def test_a_mirror_plane_across_faces_asks_for_a_surface_of_its_own():
    given = source_of(torus(1.0, 0.4, 63, 30)).given
    settings = SurfaceSettings(faces=200).for_command("quad_mesh")
    assert is_fine("quad_mesh", given, settings)
    assert is_fine("quad_mesh", given, SurfaceSettings(faces=200, mirror="Z").for_command("quad_mesh"))
    assert not is_fine("quad_mesh", given, SurfaceSettings(faces=200, mirror="X").for_command("quad_mesh"))
