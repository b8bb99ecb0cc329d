# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads whose pattern is known in closed form: flat sheets, rings and cubes."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api

from ..constrained_sheet import pattern, wave
from ..quad_meshes import cube, ends, mark_sharp, poked
from ..run_commands import WAYS, add_weights, solve
from ..scenes import add_group, attribute, bent, directions, grid, panel, places, ring, set_numbers, set_vectors, torus

SPACING = 0.5


def crossed(x, y, spacing=(SPACING, SPACING)):
    """The pattern where grid lines lie at x = 0 and y = 0."""
    return wave(x, spacing[0]) * wave(y, spacing[1])


def point(obj, place):
    """A constraint that lets lines of both families meet at the vertex nearest to a place, and that vertex."""
    vertex = int(np.linalg.norm(places(obj) - (*place, 0.0), axis=1).argmin())
    add_group(obj, "point", [vertex])
    return [{"where": "group", "what": "phase", "name": "point"}], places(obj)[vertex]


@pytest.mark.parametrize(
    "guidance, spacing", [("smooth", 0.25), ("smooth", 0.5), ("smooth", 1.0), ("axis:X", 0.25), ("axis:Y", 0.5)]
)
def test_lines_on_the_boundary_lie_on_all_four_sides(guidance, spacing):
    obj = grid(16)
    report = api.quads(obj, spacing=spacing, guidance=guidance, boundary="phase")
    x, y, _ = places(obj).T
    np.testing.assert_allclose(pattern(obj), crossed(x + 1, y + 1, (spacing, spacing)), atol=1e-5)
    phases = np.column_stack([attribute(obj, f"synch_vertex_phase_{axis}") for axis in "xy"])
    on_sides = np.column_stack([np.abs(x), np.abs(y)]) > 1 - 1e-6
    multiples = np.abs(phases / np.pi - np.round(phases / np.pi)) < 1e-5
    assert (multiples.sum(axis=1) >= on_sides.sum(axis=1)).all()
    assert report["energy"] < 1e-9 and report["disclinations"] == report["dislocations"] == []


def test_a_free_boundary_leaves_the_lines_where_they_fall():
    obj = grid()
    report = api.quads(obj, spacing=0.45, guidance="axis:X")
    at = 2 * np.pi * places(obj)[:, :2] / 0.45
    terms = [f(at[:, 0]) * g(at[:, 1]) for f in (np.cos, np.sin) for g in (np.cos, np.sin)]
    found, *_ = np.linalg.lstsq(np.column_stack(terms), pattern(obj), rcond=None)
    np.testing.assert_allclose(np.column_stack(terms) @ found, pattern(obj), atol=1e-5)
    # The product of two waves of height 1.
    np.testing.assert_allclose(np.linalg.svd(found.reshape(2, 2))[1], [1, 0], atol=1e-5)
    assert report["energy"] < 1e-9


@pytest.mark.parametrize("way", WAYS)
def test_the_angle_turns_the_lines(way):
    obj = grid(16)
    rows, here = point(obj, (0.3, -0.2))
    if way == "api":
        api.quads(obj, spacing=SPACING, guidance="axis:X", angle=np.radians(30), constraints=rows)
        x, y, _ = (places(obj) - here).T
        turned = np.cos(np.radians(30)) * x + np.sin(np.radians(30)) * y
        across = np.cos(np.radians(30)) * y - np.sin(np.radians(30)) * x
        np.testing.assert_allclose(pattern(obj), crossed(turned, across), atol=1e-4)
    solve(way, obj, "quads", spacing=SPACING, guidance="axis:X", angle=np.radians(30))
    cosines = np.abs(directions(obj) @ [np.cos(np.radians(30)), np.sin(np.radians(30)), 0])
    assert (np.minimum(cosines, np.abs(cosines - 1)) < 1e-5).all()


# Spacing


@pytest.mark.parametrize(("aspect", "boundary"), [(2.0, "free"), (0.5, "phase")])
def test_aspect_is_the_spacing_along_the_second_axis_over_that_along_the_first(aspect, boundary):
    obj = grid(20)
    if boundary == "phase":
        rows, here = None, np.array([-1.0, -1.0, 0.0])
    else:
        rows, here = point(obj, (0.2, 0.1))
    report = api.quads(obj, spacing=SPACING, guidance="axis:X", aspect=aspect, boundary=boundary, constraints=rows)
    x, y, _ = (places(obj) - here).T
    np.testing.assert_allclose(pattern(obj), crossed(x, y, (SPACING, aspect * SPACING)), atol=1e-5)
    assert report["energy"] < 1e-9 and report["settings"]["aspect"] == aspect


@pytest.mark.parametrize("guidance", ["axis:X", "axis:Y"])
def test_the_first_axis_is_the_one_nearer_to_x_however_the_cross_is_guided(guidance):
    obj = grid(20)
    obj.rotation_euler.z = np.radians(60)  # it is the object's own X
    api.quads(obj, spacing=SPACING, guidance=guidance, aspect=2.0, boundary="phase")
    x, y, _ = (places(obj) + 1).T
    np.testing.assert_allclose(pattern(obj), crossed(x, y, (SPACING, 2 * SPACING)), atol=1e-5)


@pytest.mark.parametrize("kind", ["attribute", "group"])
def test_a_map_multiplies_the_spacing(kind):
    obj = grid(20)
    if kind == "attribute":
        set_numbers(obj, "factor", np.full(len(obj.data.vertices), 2.0))
    else:
        add_weights(obj, "factor", np.ones(len(obj.data.vertices)))
    api.quads(obj, spacing=SPACING, boundary="phase", spacing_map="factor", aspect=0.5)
    x, y, _ = (places(obj) + 1).T
    np.testing.assert_allclose(pattern(obj), crossed(x, y, (2 * SPACING, SPACING)), atol=1e-5)


def test_quads_grow_with_the_distance_where_the_map_says_so():
    """In a ring with a spacing in proportion to the radius, lines are radial and circles at a fixed factor."""
    obj = ring(np.geomspace(0.5, 1.5, 25), 96)  # whose circles grow by the same factor each
    x, y, _ = places(obj).T
    radius = np.hypot(x, y)
    set_numbers(obj, "radius", radius)
    set_vectors(obj, "outwards", np.column_stack([x / radius, y / radius, 0 * x]))
    add_group(obj, "start", [0])
    report = api.quads(
        obj,
        spacing=2 * np.pi / 8,  # eight periods around
        spacing_map="radius",
        guidance="attribute:outwards",
        constraints=[{"where": "group", "what": "phase", "name": "start"}],
    )
    expected = np.cos(8 * np.log(radius / 0.5)) * np.cos(8 * np.arctan2(y, x))
    np.testing.assert_allclose(pattern(obj), expected, atol=0.02)
    assert report["dislocations"] == report["disclinations"] == []


# The object in the world


@pytest.mark.parametrize(
    "scale, by", [((2, 0.5, 3), "object"), ((3, 3, 3), "parent"), ((-1, 2, 1), "object"), ((-1, 2, 1), "parent")]
)
def test_lengths_are_those_of_the_world(scale, by):
    obj = panel((2, 1.2), (20, 12), (-1, -0.6))
    scaled = obj
    if by == "parent":
        scaled = bpy.data.objects.new("Parent", None)
        bpy.context.scene.collection.objects.link(scaled)
        obj.parent = scaled
    scaled.scale, scaled.rotation_euler, scaled.location = scale, (0.3, 0.4, 0.7), (5, 6, 7)
    rows, here = point(obj, (0.1, -0.1))
    api.quads(obj, spacing=0.7, guidance="axis:X", aspect=1.5, constraints=rows)
    x, y, _ = (places(obj) - here).T * np.abs(scale)[:, None]
    np.testing.assert_allclose(pattern(obj), crossed(x, y, (0.7, 1.05)), atol=1e-4)
    np.testing.assert_allclose(np.abs(directions(obj)).max(axis=1), 1, atol=1e-5)


@pytest.mark.parametrize("subdivisions, spacing", [(90, 2 * 2 / 40), (20, 4 * 2 / 20)])
def test_automatic_spacing_is_forty_quads_across_or_what_four_edges_carry(subdivisions, spacing):
    obj = grid(subdivisions)
    report = api.quads(obj, method="spectral", guidance="axis:X")
    assert report["settings"]["spacing"] == pytest.approx(spacing)
    assert obj["synch_spacing"] == pytest.approx(spacing)


# Mirror


@pytest.mark.parametrize(("build", "axes"), [(lambda: bent(poked(grid(12))), "Y"), (lambda: poked(torus()), "XY")])
def test_quads_are_their_own_mirror_image(build, axes):
    obj = build()
    report = api.quads(obj, spacing=0.4, mirror=axes)
    here = places(obj)
    for axis in ("XYZ".index(a) for a in axes):
        image = here * np.where(np.arange(3) == axis, -1, 1)
        apart = np.linalg.norm(image[:, None] - here[None], axis=2)
        partner = apart.argmin(axis=1)
        assert apart.min(axis=1).max() < 1e-5
        np.testing.assert_allclose(pattern(obj)[partner], pattern(obj), atol=1e-6)
        turned = directions(obj)[partner] * np.where(np.arange(3) == axis, -1, 1)
        cosines = np.abs(np.einsum("ij,ij->i", turned, directions(obj)))
        assert (np.minimum(cosines, 1 - cosines) < 1e-3).all(), "the same up to quarter turns"
    assert np.ptp(pattern(obj)) > 1.5 and report["lower_bound"] <= report["energy"]


# Edges


def test_sharp_edges_as_guides_make_a_cube_of_squares():
    obj, sides = cube()
    middles = places(obj)[ends(obj)].mean(axis=1)
    mark_sharp(obj, (np.abs(middles) > 1 - 1e-6).sum(axis=1) == 2)
    report = api.quads(obj, spacing=SPACING, constraints=[{"where": "sharp", "what": "phase"}])
    assert [d["index"] for d in report["disclinations"]] == [0.25] * 8 and report["dislocations"] == []
    at = np.array([d["position"] for d in report["disclinations"]])
    assert len(np.unique(np.sign(at), axis=0)) == 8, "one at each corner"
    np.testing.assert_allclose(np.abs(at), 1, atol=0.13)  # in a triangle there
    x = places(obj)
    np.testing.assert_allclose(np.abs(pattern(obj)[sides == 3]), 1, atol=1e-5)
    # Along an edge the pattern is that of the other family, away from the corners that the field turns around.
    for axis in range(3):
        inside = (sides == 2) & (np.abs(x[:, axis]) < 0.8)
        np.testing.assert_allclose(np.abs(pattern(obj)[inside]), np.abs(wave(x[inside, axis] + 1, SPACING)), atol=0.05)
    faces = np.abs(wave(x + 1, SPACING))
    inside = (sides == 1) & (np.sort(np.abs(x), axis=1)[:, :2] < 0.7).all(axis=1)
    across = np.where(np.abs(x) > 1 - 1e-6, 1, faces).prod(axis=1)
    np.testing.assert_allclose(np.abs(pattern(obj)[inside]), across[inside], atol=0.05)
