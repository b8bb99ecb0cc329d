# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of a number of faces, by what they are."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.quads import finishing as quad_smoothing
from synch_fields.core.extract.quads.measure.faults import REMEDY
from synch_fields.core.extract.quads.measure.quality import quality
from synch_fields.core.fields import direction_field, given_directions
from synch_fields.core.fields.constraints.features import feature_edges, feature_row
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.refinement.spacing import faces_of_factor, smallest_sides, spacing_factor
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.tasks import quad_drafts, quad_meshes, surfaces
from synch_fields.core.tasks.closed_tunnels import NARROWEST, WIDEST, without_tunnels
from synch_fields.core.tasks.surface_source import SurfaceSource
from synch_fields.core.tasks.surfaces import SurfaceRequest

from ..flat_crosses import plane_crosses
from ..meshes import bumpy_torus, cube, icosphere, square, torus
from ..sharp_shapes import ANGLE, chamfered_cube, distances_from_edges, plate_with_holes, samples, wedge


def asked(mesh, rows=(), directions=None, factors=1.0, **settings):
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    plain = {"spacing": 0.4, "singularities": 1.0, "smoothing": 0, "features": 0}
    source = SurfaceSource(given, rows, directions=directions, factors=factors)
    return SurfaceRequest.of("quad_mesh", source, SurfaceSettings(**plain | settings).for_command("quad_mesh"))


@pytest.mark.parametrize(
    ("build", "faces"), [(lambda: icosphere(4), 700), (lambda: bumpy_torus(16), 150), (lambda: square(30), 150)]
)
def test_a_number_of_faces_is_met(build, faces):
    mesh = build()
    result = asked(mesh, faces=faces).solve()
    count = len(result.quads.sizes)
    told = any(f"has {count} faces, not {faces}" in line for line in result.warnings)
    assert told == (abs(count / faces - 1) > 0.05)
    # Of so few faces a loop more or less is a tenth.
    assert count == pytest.approx(faces, rel=0.05 if faces == 700 else 0.08)
    assert result.settled["spacing"] != 0.4


@pytest.mark.parametrize("faces", [196, 235])
def test_between_sharp_edges_a_number_of_faces_is_met_by_strips(faces):
    """Grids of squares on a cube have 6 n^2 quads, 216 of 6 along an edge; a loop around it has 24 more or fewer."""
    mesh = cube(12)
    result = asked(mesh, faces=faces, features=ANGLE / 2, smoothing=20).solve()
    quads = result.quads
    assert len(quads.sizes) == (192 if faces < 216 else 240) and not result.warnings
    assert (quads.sizes == 4).all() and quads.euler_characteristic == 2 and (quads.edges[1] == 2).all()
    # Three right angles at each corner, and four everywhere else.
    assert sorted(np.bincount(quads.edges[0].ravel()).tolist())[:9] == [3] * 8 + [4]
    assert quality(quads)["angle_deviation"] < 2 and quads.edge_lengths.min() > 0.3 * quads.edge_lengths.mean()


def test_the_directions_are_solved_once(monkeypatch):
    calls = []

    def counted(*arguments, **settings):
        calls.append(1)
        return direction_field(*arguments, **settings)

    monkeypatch.setattr(surfaces, "direction_field", counted)
    asked(torus(around=48, across=24), faces=300).solve()
    assert len(calls) == 1


def test_a_map_of_spacings_keeps_its_proportions():
    mesh = icosphere(4)
    factors = 1 + 0.5 * mesh.vertices[:, 2]
    result = asked(mesh, faces=400, factors=factors).solve()
    assert len(result.quads.sizes) == pytest.approx(400, rel=0.05)
    above = result.quads.vertices[:, 2] > 0
    assert (~above).sum() > 1.5 * above.sum()


def test_the_estimate_of_the_number_is_the_area_over_that_of_a_quad():
    mesh = square(20)
    field, _ = plane_crosses(mesh, 30)
    assert TargetOneForm.of(mesh, field, 0.1).quad_count == pytest.approx(1 / 0.05**2, rel=1e-6)


def test_a_number_that_cannot_be_met_is_said():
    """Quads around a torus come in whole loops, a few of which are all that there are."""
    result = asked(torus(around=48, across=24), faces=13, smoothing=0).solve()
    assert abs(len(result.quads.sizes) / 13 - 1) > 0.05
    assert any("faces, not 13" in line for line in result.warnings)


def test_a_spike_makes_no_more_faces_than_the_search_can_use(monkeypatch):
    """The area of a needle says little of how many quads lie along it."""
    counts, traced = [], quad_meshes.draw

    def count_faces(*arguments):
        found = traced(*arguments)
        counts.append(found.face_count)
        return found

    monkeypatch.setattr(quad_meshes, "draw", count_faces)
    ball = icosphere(2)
    ball.vertices[0] *= 1e6
    asked(TriangleMesh(ball.vertices, ball.triangles), faces=8, branching=1.0).solve()
    assert max(counts) <= 400


def test_too_few_faces_give_the_coarsest_mesh_there_is_and_a_warning():
    result = asked(icosphere(3), faces=1).solve()
    assert 2 <= len(result.quads.sizes) <= 60 and result.quads.euler_characteristic == 2
    assert any("faces, not 1" in line for line in result.warnings)


def test_faces_that_no_spacing_gives_are_refused_with_their_number(monkeypatch):
    def refuse(*_):
        raise SettingError("the quads are too large")

    monkeypatch.setattr(quad_meshes, "draw", refuse)
    with pytest.raises(SettingError, match="7 faces are too few for a quad mesh of this surface"):
        asked(icosphere(2), faces=7).solve()


@pytest.mark.parametrize("degrees", [20, 45])
def test_a_narrow_corner_gets_one_quad(degrees):
    """Lines along both sides, one after the other, would leave no line between the sides."""
    mesh = wedge(degrees)
    result = asked(mesh, rows=(feature_row(mesh, mesh.boundary_edges),), faces=300).solve()
    figures = quality(result.quads)
    assert figures["angle_deviation"] < 7 and figures["folds"] <= 0.03 * len(result.quads.sizes)
    at_corner = np.linalg.norm(result.quads.vertices, axis=1) < 1e-6
    assert np.isin(result.quads.corner_vertices, np.flatnonzero(at_corner)).sum() == 1


@pytest.mark.parametrize(("share", "lost"), [(0.03, True), (0.03, False), (0.5, False)])
def test_lines_that_are_lost_are_told_with_their_length(share, lost, monkeypatch):
    """Chamfers of a share of a quad's side, which are lost where no room is made for a quad across them."""
    if lost:
        monkeypatch.setattr("synch_fields.core.fields.patterns.strip_stretch", lambda *_: 1.0)
    side = 0.1
    mesh = chamfered_cube(16, share * side / np.sqrt(2))
    edges = feature_edges(mesh, ANGLE, side)
    result = asked(mesh, rows=(feature_row(mesh, edges),), spacing=2 * side).solve()
    lines = [line for line in result.warnings if "sharp edges are lost" in line]
    assert len(lines) == lost
    apart = distances_from_edges(result.quads, samples(mesh, edges)).max()
    assert (apart > 0.02 * share * side) == lost
    if lost:
        count, of = int(lines[0].split()[0]), int(lines[0].split()[2])
        assert 0 < count <= of == 24
        assert f"of {mesh.edge_lengths[edges].sum():.3g} in length" in lines[0] and lines[0].endswith(REMEDY)


def test_faces_that_are_no_quads_are_told_where_none_were_asked_for(monkeypatch):
    told = "faces are not quads, although no branches are wanted"
    mesh = square(30)
    assert not any(told in line for line in asked(mesh).solve().warnings)

    def with_triangles(quads, *_):
        faces = np.split(quads.corner_vertices, quads.starts[1:])
        number = next(number for number, face in enumerate(faces) if len(face) == 4)
        a, b, c, d = faces.pop(number)
        faces += [[a, b, c], [a, c, d]]
        sizes = np.array([len(face) for face in faces])
        return replace(quads, corner_vertices=np.concatenate(faces), sizes=sizes), np.empty((0, 2), int)

    monkeypatch.setattr(quad_smoothing, "all_quads", with_triangles)
    result = asked(mesh).solve()
    others = np.count_nonzero(result.quads.sizes != 4)
    assert others >= 2
    assert any(f"{others} of {len(result.quads.sizes)} {told}" in line for line in result.warnings)


@pytest.mark.parametrize("spacings", [0.1, np.array([[0.1, 0.2]])])
def test_the_factor_of_spacings_leads_to_a_number_of_quads(spacings):
    mesh = square(20)
    field = given_directions(mesh, 4, np.tile([1.0, 0, 0], (mesh.vertex_count, 1)))
    factor = spacing_factor(mesh, spacings, 321)
    assert TargetOneForm.of(mesh, field, factor * spacings).quad_count == pytest.approx(321)


@pytest.mark.parametrize("stretch", [1.0, 1e4])
def test_as_many_faces_as_a_spacing_leaves_room_for(stretch):
    mesh = square(5)
    mesh = TriangleMesh(mesh.vertices * [stretch, 1, 1], mesh.triangles)
    for faces in (1, 7, 100, 10_000):
        assert faces_of_factor(mesh, 0.2, (1 - 1e-9) * spacing_factor(mesh, 0.2, faces)) == faces


def test_the_smallest_sides_keep_a_map_and_take_the_shorter_axis():
    mesh = square(4)
    factors = 1 + mesh.vertices[:, 0]
    np.testing.assert_allclose(smallest_sides(mesh, 0.2 * factors), 0.1 * factors)
    both = 0.2 * factors[:, None] * [1.0, 0.5]
    np.testing.assert_allclose(smallest_sides(mesh, both), 0.05 * factors)
    np.testing.assert_allclose(smallest_sides(mesh, 0.2), np.full(mesh.vertex_count, 0.1))


@pytest.mark.parametrize("faces", [0, 700])
def test_a_draft_is_shown_before_the_mesh_and_leaves_it_as_it_is(faces):
    request, shown = asked(bumpy_torus(24), faces=faces), []
    found = request.solve_showing(shown.append)
    (draft,) = shown
    assert not draft.quads.is_unsound.any() and (draft.quads.sizes == 4).mean() > 0.9
    assert request.picture(draft).of_quads
    if faces:
        assert len(draft.quads.sizes) == pytest.approx(faces, rel=0.15)
    assert np.array_equal(found.quads.vertices, request.solve().quads.vertices)


def test_a_draft_that_is_no_mesh_is_not_shown(monkeypatch):
    draw, calls = quad_meshes.draw, []

    def refuse_the_draft(*arguments):
        calls.append(arguments)
        if len(calls) == 1:
            raise SettingError("the quads are too large")
        return draw(*arguments)

    monkeypatch.setattr(quad_meshes, "draw", refuse_the_draft)
    shown = []
    assert asked(icosphere(3)).solve_showing(shown.append).quads is not None and shown == []


def test_corrections_end_where_they_leave_as_many_dislocations(monkeypatch):
    pattern = asked(icosphere(3)).solve().pattern
    monkeypatch.setattr(type(pattern), "dislocations", [1, 2])
    tried = []
    monkeypatch.setattr(quad_drafts, "untangle", lambda pattern, _: tried.append(pattern) or pattern)
    assert asked(icosphere(3)).solve().quads is not None
    assert len(tried) == 1


@pytest.mark.parametrize(("length", "solves"), [(0.3, 1), (1.5, 2)])
def test_only_lines_of_several_quads_that_are_lost_are_solved_for_again(monkeypatch, length, solves):
    details = []
    directed = SurfaceRequest.directed
    monkeypatch.setattr(
        SurfaceRequest, "directed", lambda self, *rest: details.append(self.detail) or directed(self, *rest)
    )
    monkeypatch.setattr(quad_meshes, "lost_lines", lambda *_: (np.full(5, length), np.full(10, length)))
    found = asked(square(12), spacing=0.5, singularities=None).solve()
    assert [detail > 0 for detail in details] == [True, False][:solves]
    assert any("5 of 10 lines" in line for line in found.warnings)


@pytest.mark.full_search
def test_crowded_sharp_edges_are_left_out_where_a_bad_mesh_gets_better(monkeypatch):
    """Of each narrow chamfer of a cube one edge; a mesh that is not bad is not solved again."""
    request = asked(chamfered_cube(cut=0.04, cells=8), faces=260, features=ANGLE / 2, smoothing=20)
    first = request.solve()
    assert not any("run beside others" in line for line in first.warnings)
    monkeypatch.setattr(quad_meshes, "BAD_ANGLE", -1.0)
    clearer = request.uncrowded(first.settled["spacing"]).solve()
    result = request.solve()
    before, without, after = (quality(each.quads)["angle_deviation"] for each in (first, clearer, result))
    assert after == min(before, without)
    told = [line for line in result.warnings if "run beside others without room for quads, 11 of 22.1 in" in line]
    assert len(told) == 1 and without < before
    with pytest.raises(SettingError, match="run beside others"):
        replace(request, settings=replace(request.settings, strict=True)).solve()


@pytest.mark.full_search
@pytest.mark.parametrize(
    "asked_for", [{"faces": 500}, pytest.param({"faces": 650}, marks=pytest.mark.slow), {"spacing": 0.95}]
)
def test_holes_narrower_than_a_quad_are_closed_where_quads_would_meet_themselves(asked_for, monkeypatch):
    monkeypatch.setattr(quad_meshes, "without_tunnels", lambda *given: None)  # as without sharp edges around them
    mesh = plate_with_holes((2, 4, 6), side=0.15)
    assert mesh.euler_characteristic == 2 - 2 * 9
    result = asked(mesh, features=ANGLE, smoothing=20, **asked_for).solve()
    lost, faces = (result.quads.euler_characteristic - mesh.euler_characteristic) // 2, len(result.quads.sizes)
    assert 0 < lost <= 9
    assert faces == pytest.approx(
        asked_for.get("faces", mesh.areas.sum() / 0.475**2), rel=0.05 if "faces" in asked_for else 0.08
    )
    assert (result.quads.edges[1] == 2).all() and quality(result.quads)["folds"] < 0.03 * faces
    assert any(f"{lost} of 9 tunnels or handles of the surface" in line for line in result.warnings)
    # The plate is as large as before, and its flat sides are where they were.
    assert np.ptp(result.quads.vertices, axis=0) == pytest.approx([8, 8, 0.3])


def test_holes_narrower_than_a_quad_are_closed_before_the_solve():
    """The plate without holes is nearly a grid, with 8 corners (it had 69 irregular vertices)."""
    mesh = plate_with_holes((2, 4, 6), side=0.25, step=0.2)
    result = asked(mesh, faces=576, features=ANGLE, smoothing=20).solve()
    quads = result.quads
    assert quads.is_irregular.sum() <= 16 and (quads.edges[1] == 2).all() and quality(quads)["angle_deviation"] < 2
    assert np.ptp(quads.vertices, axis=0) == pytest.approx([8, 8, 0.3])
    assert [line for line in result.warnings if "9 of 9 tunnels or handles of the surface" in line]
    # Vertices refer to the given surface, of which they may be apart in the disks only.
    there = np.einsum("nk,nkx->nx", quads.weights, mesh.vertices[mesh.triangles[quads.triangles]])
    assert np.linalg.norm(there - quads.vertices, axis=1).max() < 0.25
    assert np.median(np.linalg.norm(there - quads.vertices, axis=1)) < 1e-9
    assert result.given.vertex_count == mesh.vertex_count < result.field.angles.size
    # A defect in a disk is reported in a face of the object.
    assert len(result.given.polygons.triangle_faces) == result.given.mesh.triangle_count
    assert result.given.polygons.triangle_faces.max() < mesh.triangle_count
    pinned, finer = asked(mesh, faces=576, features=ANGLE, pins="0=1"), asked(mesh, faces=9000, features=ANGLE)
    assert without_tunnels(pinned, NARROWEST) is None and without_tunnels(finer, NARROWEST) is None


@pytest.mark.parametrize("is_marked", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_wider_holes_and_marks_are_left_out_where_corners_are_bad(is_marked, monkeypatch):
    """Holes a little narrower than a quad, and a straight line across the flat top that is marked sharp."""
    monkeypatch.setattr(quad_meshes, "WORST_ANGLE", 0.8)
    mesh = plate_with_holes((2, 4, 6), side=0.4, step=0.3)
    given = asked(mesh, faces=576, features=ANGLE)
    assert NARROWEST < 0.4 / given.side < WIDEST and without_tunnels(given, NARROWEST) is None
    ends = mesh.vertices[mesh.edges]
    line = np.flatnonzero((ends[:, :, 2] > 0.29).all(axis=1) & np.isclose(ends[:, :, 0], 5).all(axis=1))
    source = replace(given.source, sharp=line if is_marked else ())
    result = SurfaceRequest.of("quad_mesh", source, given.settings).solve()
    assert quality(result.quads)["angle_deviation"] < 0.8 and result.quads.is_irregular.sum() <= 16
    text = "\n".join(result.warnings)
    assert "9 of 9 tunnels or handles of the surface" in text
    assert ("are left out that are around narrow tunnels or only marked" in text) == is_marked


def test_thin_plates_are_grids_on_both_sides_and_their_rim():
    thin = TriangleMesh(cube(20).vertices * [1, 1, 0.02], cube(20).triangles)
    quads = asked(thin, spacing=0.1, faces=420, features=ANGLE, smoothing=20).solve().quads
    assert quads.is_irregular.sum() == 8 and quality(quads)["angle_deviation"] < 0.5
