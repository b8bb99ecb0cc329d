# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface nearest to a mesh that cannot carry a field: what comes apart, what is left out, what is turned over."""

import re
from pathlib import Path

import numpy as np
import pytest

from synch_fields.core.errors import MeshError
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import check_mesh
from synch_fields.core.geometry.manifold_repair import KINDS, find_seam_ends, repair_mesh
from synch_fields.core.interpolate import evaluate, face_phases

from ...corpus.makers import (
    boxes,
    checkerboard,
    doubled_and_turned,
    fans,
    hourglass,
    klein_bottle,
    moebius_strip,
    torus_on_a_sheet,
    turned_about,
)
from ..meshes import honeycomb_sphere, icosphere, mixed_torus, polygon_mesh, quad_torus, square


def carried(points, faces):
    """The repaired copy of a mesh that is refused, which is a surface and holds what it was made of."""
    mesh, polygons = polygon_mesh(np.asarray(points, float), faces)
    with pytest.raises(MeshError):
        check_mesh(mesh, polygons.triangle_faces)
    found = repair_mesh(mesh, polygons)
    check_mesh(found.mesh, found.polygons.triangle_faces)
    np.testing.assert_array_equal(found.polygons.triangles, found.mesh.triangles)
    np.testing.assert_array_equal(found.source[: len(points)], np.arange(len(points)))
    given = {tuple(sorted(t)) for t in found.own[mesh.triangles].tolist()}
    assert {tuple(sorted(t)) for t in found.source[found.mesh.triangles].tolist()} <= given
    np.testing.assert_array_equal(found.source[found.polygons.corner_vertices], found.own[polygons.corner_vertices])
    return found


def findings(found):
    """Elements by the names of findings."""
    return {finding.name: finding.elements.tolist() for finding in found.findings}


def characteristics(mesh):
    """Euler characteristic of each piece with faces, in the order of their first vertices."""
    used = np.unique(mesh.triangles)
    pieces = mesh.pieces
    counts = np.zeros(pieces.max() + 1, int)
    for labels, sign in ((pieces[used], 1), (pieces[mesh.edges[:, 0]], -1), (pieces[mesh.triangles[:, 0]], 1)):
        counts += sign * np.bincount(labels, minlength=len(counts))
    return counts[np.unique(pieces[used])].tolist()


def total_indices(mesh, symmetry):
    """Sum of the indices of a direction field in each piece with faces."""
    found = direction_field(mesh, symmetry).disclinations
    pieces = [mesh.pieces[mesh.triangles[d.triangle, 0]] for d in found]
    sums = np.bincount(pieces, [d.index for d in found], mesh.pieces.max() + 1)
    return sums[np.unique(mesh.pieces[np.unique(mesh.triangles)])]


@pytest.mark.parametrize(
    ("angles", "joined"), [((0, 120, 250), {1, 2}), ((0, 90, 180), {0, 2}), ((10, 20, 185), {0, 2})]
)
def test_of_three_fans_those_that_bend_least_stay_joined(angles, joined):
    # Angles between neighbours of 120, 130 and 110: the second and the third bend least.
    found = carried(*fans(6, angles))
    assert findings(found) == {"non_manifold_edges": [[k, k + 1] for k in range(6)]} | (
        {"turned_faces": findings(found)["turned_faces"]}
    )
    assert characteristics(found.mesh) == [1, 1]
    along = found.source[found.mesh.edges] <= 6
    inside = np.flatnonzero(along.all(axis=1) & (found.mesh.edge_face_counts == 2))
    assert len(inside) == 6
    at = found.mesh.edges[inside, 0]
    rims = found.mesh.triangles[(np.isin(found.mesh.triangles, at)).any(axis=1)]
    rims = np.unique(found.source[rims][found.source[rims] > 6] // 7 - 1)
    assert set(rims.tolist()) == joined


def test_sheets_are_joined_the_same_way_all_along_whatever_noise_says():
    points, faces = fans(40)
    noise = 1e-7 * np.random.default_rng(3).standard_normal(points.shape)
    found = carried(points + noise, faces)
    assert characteristics(found.mesh) == [1, 1]
    assert len(found.mesh.boundary_edges) == 4 * 40 + 6


@pytest.mark.parametrize("count", [4, 5, 8])
def test_many_fans_are_joined_in_pairs(count):
    found = carried(*fans(3, np.arange(count) * 360 / count))
    assert characteristics(found.mesh) == [1] * ((count + 1) // 2)


def test_faces_come_apart_at_an_edge_of_very_many():
    found = carried(*fans(1, np.arange(3000) * 360 / 3000))
    assert characteristics(found.mesh) == [1] * 3000


def test_an_hourglass_is_two_spheres():
    points, faces, waist = hourglass()
    found = carried(points, faces)
    assert findings(found) == {"pinched_vertices": [waist]}
    assert characteristics(found.mesh) == [2, 2]
    assert found.source[len(points) :].tolist() == [waist]
    np.testing.assert_allclose(total_indices(found.mesh, 4), [2, 2], atol=1e-12)


@pytest.mark.parametrize("build", [quad_torus, mixed_torus, honeycomb_sphere])
def test_turned_and_doubled_faces_give_the_clean_surface(build):
    mesh, polygons = build()
    count = len(polygons.starts)
    some = np.arange(count) < count // 3
    found = carried(mesh.vertices, turned_about(polygons, some, doubled=[2, 30]))
    assert findings(found) == {"doubled_faces": [count, count + 1], "turned_faces": np.flatnonzero(some).tolist()}
    assert found.mesh.vertex_count == mesh.vertex_count
    assert found.mesh.euler_characteristic == mesh.euler_characteristic
    np.testing.assert_allclose(found.mesh.vertex_normals, mesh.vertex_normals, atol=1e-9)


def test_the_larger_share_of_the_area_keeps_its_winding():
    ball = icosphere(2)
    most = np.arange(ball.triangle_count) >= 60
    faces = doubled_and_turned(ball.triangles.tolist(), turned=np.flatnonzero(most))
    found = carried(ball.vertices, faces)
    assert findings(found) == {"turned_faces": list(range(60))}
    np.testing.assert_array_equal(found.mesh.triangles, ball.triangles[:, ::-1])


def test_the_field_of_a_sphere_with_a_doubled_face_and_a_turned_patch_is_that_of_the_clean_sphere():
    ball = icosphere(3)
    patch = np.flatnonzero(ball.vertices[ball.triangles][:, :, 0].min(axis=1) > 0.5)
    found = carried(ball.vertices, doubled_and_turned(ball.triangles.tolist(), doubled=[7], turned=patch))
    np.testing.assert_array_equal(found.mesh.triangles, ball.triangles)
    np.testing.assert_array_equal(found.mesh.vertices, ball.vertices)
    clean, field = (direction_field(mesh, 2) for mesh in (ball, found.mesh))
    np.testing.assert_array_equal(field.vectors, clean.vectors)
    assert field.energy == clean.energy and field.solution.lower_bound == clean.solution.lower_bound


def triangle_sphere():
    return polygon_mesh(icosphere(2).vertices, icosphere(2).triangles.tolist())


@pytest.mark.parametrize(
    ("build", "symmetry"), [(quad_torus, 2), (mixed_torus, 4), (honeycomb_sphere, 4), (triangle_sphere, 2)]
)
def test_turned_and_doubled_faces_show_what_clean_ones_do(build, symmetry):
    mesh, polygons = build()
    count = len(polygons.starts)
    doubled = np.arange(count)[1::2]
    turned, drawn = polygon_mesh(mesh.vertices, turned_about(polygons, np.arange(count) % 5 < 2, doubled))
    found = repair_mesh(turned, drawn)
    triangles = [np.unique(np.sort(each.triangles), axis=0) for each in (found.mesh, mesh)]
    np.testing.assert_array_equal(*triangles)
    growth = TargetOneForm.of(mesh, direction_field(mesh, symmetry), 0.3)
    phases = np.exp(1j * np.random.default_rng(6).uniform(-np.pi, np.pi, len(growth.masses)))
    edge_phases = growth.edge_phases(phases)
    clean, shown = face_phases(edge_phases, polygons), face_phases(edge_phases, found.polygons)
    faces = np.append(np.arange(count), doubled)
    np.testing.assert_array_equal(shown[0].unfit, np.flatnonzero(np.isin(faces, clean[0].unfit)))
    # The same places of each face that is drawn and of the clean one.
    rows = np.flatnonzero(~np.isin(faces[drawn.triangle_faces], clean[0].unfit))
    weights = np.random.default_rng(1).dirichlet(np.ones(3), len(rows))
    first = polygons.first_triangles[faces[drawn.triangle_faces[rows]]]
    there = first + rows - drawn.first_triangles[drawn.triangle_faces[rows]]
    sizes = polygons.sizes[faces[drawn.triangle_faces[rows]]]
    # Turned over, the last triangle of a fan comes first.
    is_turned = (polygons.triangles[there] != drawn.triangles[rows]).any(axis=1)
    there = np.where(is_turned, 2 * first + sizes - 3 - there, there)
    match = polygons.triangles[there][:, :, None] == drawn.triangles[rows][:, None]
    assert match.sum() == 3 * len(rows)
    same = np.einsum("nk,njk->nj", weights, match)
    ours = np.cos([evaluate(phase, drawn, rows, weights) for phase in shown])
    theirs = np.cos([evaluate(phase, polygons, there, same) for phase in clean])
    if symmetry == 4:  # only the pair goes on from face to face
        ours, theirs = ([np.sum(v, axis=0), np.prod(v, axis=0)] for v in (ours, theirs))
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
    assert is_turned.any()
    assert shown[0].corner_place.any() or polygons.sizes.min() > 4


def test_faces_without_area_are_left_out():
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0, 0], [0.25, 0, 0]]
    found = carried(points, [[0, 1, 2, 3], [0, 5, 4, 1], [2, 3, 2]])
    assert findings(found) == {"flat_faces": [1, 2]}
    assert found.mesh.areas.sum() == 1 and found.polygons.drawn.tolist() == [True, False, False]


@pytest.mark.parametrize("apart", [0.0, 1e-13])
def test_the_surface_closes_over_needles(apart):
    """A row of vertices of a sphere doubled, with needles between the two: each counts as one."""
    ball = icosphere(2)
    low = ball.vertices[ball.triangles].mean(axis=1)[:, 2] < 0
    ring = np.intersect1d(ball.triangles[low], ball.triangles[~low])
    copies = np.arange(ball.vertex_count)
    copies[ring] = ball.vertex_count + np.arange(len(ring))
    points = np.vstack([ball.vertices, ball.vertices[ring] + [0, 0, apart]])
    both = np.bincount(ball.triangle_edges[low].ravel(), minlength=len(ball.edges)) == 1
    around = ball.edges[both]
    needles = [[i, j, copies[j], copies[i]] for i, j in around.tolist()]
    faces = np.vstack([ball.triangles[low], copies[ball.triangles[~low]]]).tolist()
    found = carried(points, faces + needles)
    assert findings(found) == {"flat_faces": list(range(len(faces), len(faces) + len(needles)))}
    np.testing.assert_array_equal(found.mesh.triangles, np.vstack([ball.triangles[low], ball.triangles[~low]]))
    np.testing.assert_array_equal(found.own[copies[ring]], ring)


def test_vertices_at_one_place_stay_two_where_another_face_has_both():
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0], [0, -1, 0]]
    found = carried(points, [[0, 1, 2, 3, 4], [0, 4, 5]])
    assert findings(found) == {"flat_faces": [1]}
    np.testing.assert_array_equal(found.own, np.arange(6))


def test_a_face_that_passes_a_vertex_twice_is_left_out():
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 1, 0], [-1, 0, 0]]
    found = carried(points, [[0, 1, 2, 0, 3, 4], [0, 1, 2]])
    assert findings(found) == {"flat_faces": [0]}


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_vertices_without_a_position_take_their_faces_along(value):
    mesh = square(4)
    points = mesh.vertices.copy()
    points[12, 1] = value
    found = carried(points, mesh.triangles.tolist())
    assert findings(found) == {"lost_vertices": [12]}
    assert np.isfinite(found.mesh.vertices).all()
    gone = (mesh.triangles == 12).any(axis=1)
    np.testing.assert_array_equal(found.mesh.triangles, mesh.triangles[~gone])
    assert found.mesh.euler_characteristic == 0


@pytest.mark.parametrize(("count", "across"), [(3, 1), (12, 1), (13, 4), (24, 3)])
def test_a_moebius_strip_is_open_across(count, across):
    found = carried(*moebius_strip(count, across))
    assert characteristics(found.mesh) == [1]
    seam = findings(found)["one_sided_edges"]
    assert len(seam) == across
    assert len(found.mesh.boundary_edges) == 2 * count + 2 * len(seam)


def test_windings_of_a_one_sided_surface_agree_up_to_a_short_seam():
    points, faces = moebius_strip(40, 4)
    turned = np.random.default_rng(5).random(len(faces)) < 0.4
    found = carried(points, doubled_and_turned(faces, turned=np.flatnonzero(turned)))
    assert characteristics(found.mesh) == [1]
    assert len(findings(found)["one_sided_edges"]) <= 2 * 4


def test_the_two_sides_of_a_seam_are_told():
    found = carried(*klein_bottle(24, 12))
    seam = find_seam_ends(found.mesh, found.across)
    np.testing.assert_array_equal(*found.source[seam].T)
    assert len(seam) == len(np.unique(seam[:, 1])) == 12
    normals = found.mesh.vertex_normals[seam]
    assert np.einsum("kx,kx->k", normals[:, 0], normals[:, 1]).max() < 0


def test_a_klein_bottle_is_opened_to_a_tube():
    found = carried(*klein_bottle(24, 12))
    assert characteristics(found.mesh) == [0]
    seam = np.array(findings(found)["one_sided_edges"])
    assert len(seam) == 12
    assert len(found.mesh.boundary_edges) == 2 * len(seam)
    assert (np.bincount(seam.ravel()) % 2 == 0).all()


def test_a_torus_on_a_sheet_stays_a_torus():
    found = carried(*torus_on_a_sheet())
    assert set(findings(found)) <= {"non_manifold_edges", "turned_faces"}
    assert len(findings(found)["non_manifold_edges"]) == 24
    assert characteristics(found.mesh) == [0, 0]
    closed = found.mesh.pieces[found.mesh.edges[found.mesh.boundary_edges, 0]]
    assert len(np.unique(closed)) == 1
    torus_sum = total_indices(found.mesh, 4)[found.mesh.pieces[0]]
    assert abs(torus_sum) < 1e-12


@pytest.mark.parametrize("size", [2, 3, 4])
def test_boxes_that_touch_in_edges_and_vertices_are_boxes(size):
    points, faces = checkerboard(size)
    count = len(faces) // 6
    turn = np.linalg.qr(np.random.default_rng(4).standard_normal((3, 3)))[0]
    found = carried((points @ turn).astype(np.float32), faces)
    assert characteristics(found.mesh) == [2] * count
    assert "turned_faces" not in findings(found)


def test_boxes_that_share_faces_keep_their_outside():
    found = carried(*boxes([(0, 0, 0), (1, 0, 0)]))
    assert len(findings(found)["doubled_faces"]) == 1
    assert sorted(characteristics(found.mesh)) == [1, 2]
    whole = found.mesh.pieces == found.mesh.pieces[0]
    assert found.mesh.areas[whole[found.mesh.triangles[:, 0]]].sum() == 10


def test_overlapping_faces_come_off():
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]]
    carried(points, [[0, 1, 2, 3], ([0, 1, 2, 4], 0), [0, 1, 2]])


def test_nothing_is_left_of_faces_without_area():
    mesh, polygons = polygon_mesh(np.zeros((3, 3)), [[0, 1, 2]])
    with pytest.raises(MeshError, match="face 0 has no area"):
        repair_mesh(mesh, polygons)


@pytest.mark.parametrize("seed", range(8))
def test_any_soup_has_a_carrier(seed):
    for step in range(40):
        random = np.random.default_rng([seed, step])
        points = random.standard_normal((random.integers(4, 14), 3))
        points = points.round(random.integers(0, 4)) if step % 2 else points
        points[random.random(len(points)) < 0.05] = np.nan
        faces = [
            random.choice(len(points), random.integers(3, min(len(points), 6) + 1), replace=step % 5 == 0).tolist()
            for _ in range(random.integers(1, 30))
        ]
        mesh, polygons = polygon_mesh(points, faces)
        try:
            check_mesh(mesh, polygons.triangle_faces)
        except MeshError:
            try:
                carried(points, faces)
            except MeshError as error:  # nothing is left
                assert "area" in str(error) or "position" in str(error)


def test_the_lines_name_elements_and_what_is_done():
    found = carried(*fans(2))
    lines = {finding.name: finding.line for finding in found.findings}
    assert lines["non_manifold_edges"] == (
        "the edge between vertices 0 and 1 and 1 more have three or more faces: "
        "the two that bend least stay joined, others are separated"
    )


def test_the_manual_has_a_row_for_every_kind():
    table = (Path(__file__).parents[3] / "docs" / "meshes.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE) == list(KINDS)
