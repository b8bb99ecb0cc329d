# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects whose meshes are no surface: solved all the same, told in the report, and left as they are."""

import json
import pickle
from unittest.mock import MagicMock

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.geometry.manifold_repair import KINDS
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.panels.overlay import direction_marks
from synch_fields.synch_addon.panels.result import FINDINGS, draw_findings
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.job import FieldJob

from ...corpus.makers import (
    checkerboard,
    doubled_and_turned,
    fans,
    hourglass,
    klein_bottle,
    moebius_strip,
    torus_on_a_sheet,
)
from ..moving_meshes import swaying
from ..rebuilt_pattern import largest_jump
from ..scenes import add_group, add_object, attribute, hexagon_sphere, places, quad_sphere, sphere


def rebuilt(obj, doubled=(), turned=()):
    """An object with some faces of another one once more, and others turned over; and the other one."""
    faces = [list(face.vertices) for face in obj.data.polygons]
    return add_object(places(obj), doubled_and_turned(faces, doubled, turned), "Rebuilt")


def patched(build=sphere):
    """A sphere with a turned patch of faces and two doubled ones."""
    obj = build()
    turned = [face.index for face in obj.data.polygons if face.center.x > 0.5]
    return rebuilt(obj, doubled=[3, 40], turned=turned)


def lost():
    """A sphere with one vertex that is nowhere."""
    obj = sphere()
    obj.data.vertices[40].co.x = float("nan")
    return obj


def with_flat_faces():
    """A sphere with two faces without area along edges, one with a vertex of its own."""
    obj = sphere()
    faces = [list(face.vertices) for face in obj.data.polygons]
    points = places(obj)
    a, b, _ = faces[7]
    middle = (points[a] + points[b]) / 2
    return add_object([*points, middle], [*faces, [a, len(points), b]], "Flat")


BAD = {
    "fans": (lambda: add_object(*fans(8)), {"non_manifold_edges": 8}),
    "hourglass": (lambda: add_object(*hourglass()[:2]), {"pinched_vertices": 1}),
    "patched": (patched, {"doubled_faces": 2, "turned_faces": 82}),
    "moebius strip": (lambda: add_object(*moebius_strip(40, 6)), {}),
    "klein bottle": (lambda: add_object(*klein_bottle()), {}),
    "torus on a sheet": (lambda: add_object(*torus_on_a_sheet()), {"non_manifold_edges": 24}),
    "boxes": (lambda: add_object(*checkerboard(2)), {"non_manifold_edges": 6}),
    "lost vertex": (lost, {"lost_vertices": 1}),
    "flat face": (with_flat_faces, {"flat_faces": 1}),
}
COMMANDS = {"directions": api.directions, "stripes": api.stripes, "quads": api.quads}


@pytest.fixture(params=BAD)
def bad(request):
    build, counts = BAD[request.param]
    return build(), counts


def geometry(obj):
    """What a run must not change, as bytes."""
    own = [name for name in obj.data.attributes.keys() if not name.startswith("synch_") and name != "material_index"]
    return {name: attribute(obj, name).tobytes() for name in own if name != "sharp_face"}


@pytest.mark.parametrize(
    "name, command",
    [
        *((name, "stripes") for name in BAD),
        ("flat face", "directions"),
        ("patched", "quads"),
        ("klein bottle", "quads"),
    ],
)
def test_it_is_solved_reported_and_left_as_it_is(name, command):
    build, counts = BAD[name]
    obj = build()
    before = geometry(obj)
    spacing = {} if command == "directions" else {"spacing": 0.5}
    report = COMMANDS[command](obj, **spacing)
    assert counts.items() <= report["carrier"].items() and report["carrier"]
    told = [line for line in report["warnings"] if any(what in line for _, what, _ in KINDS.values())]
    assert len(told) == len(report["carrier"])
    assert report["certificate"] == "proved"
    if not any("were split into triangles" in line for line in report["warnings"]):  # which is told, as ever
        assert geometry(obj) == before
    before = geometry(obj)
    faces = len(obj.data.polygons)
    assert all(0 <= d["face"] < faces for d in report["disclinations"] + report["dislocations"])
    assert len(attribute(obj, "synch_direction")) == len(obj.data.vertices)
    assert direction_marks(obj)
    if command == "stripes":
        assert np.isfinite(attribute(obj, "synch_phase")).all()
        assert api.vary(obj, 1)["energy"] > 0 or report["energy"] < 1e-9
        assert geometry(obj) == before


@pytest.mark.parametrize("name", ["hourglass", "patched", "torus on a sheet"])
def test_closed_pieces_have_the_index_sum_of_their_characteristic(name):
    obj = BAD[name][0]()
    report = api.directions(obj, symmetry="cross")
    total = sum(d["index"] for d in report["disclinations"])
    assert report["closed"] == (name != "torus on a sheet")
    if report["closed"]:
        assert total == report["euler_characteristic"] == {"hourglass": 4, "patched": 2}[name]


@pytest.mark.parametrize(
    ("build", "command"), [(sphere, api.stripes), (hexagon_sphere, api.stripes), (quad_sphere, api.quads)]
)
def test_a_patched_sphere_shows_a_pattern_without_jumps(build, command):
    obj = patched(build)
    report = command(obj, spacing=0.3)
    assert report["dislocations"] or report["disclinations"]
    jump, compared = largest_jump(obj)
    assert jump < 1e-4 and compared > len(obj.data.edges)


def test_doubles_of_split_faces_are_removed():
    # Their own triangles could be others than those that the pattern is written for.
    source = hexagon_sphere()
    faces = [list(face.vertices) for face in source.data.polygons]
    obj = add_object(places(source), [*faces, *(face[2:] + face[:2] for face in faces)], "Doubled")
    report = api.stripes(obj, spacing=0.3)
    split = len({d["face"] for d in report["disclinations"] + report["dislocations"]})
    line = next(line for line in report["warnings"] if "were split into triangles" in line)
    assert line.startswith(f"{split} faces") and f"and {split} that doubled them removed" in line
    sizes = np.array([len(face.vertices) for face in obj.data.polygons])
    assert (sizes > 3).sum() == 2 * (len(faces) - split)
    assert largest_jump(obj)[0] < 1e-4 and api.vary(obj, 1)["dislocations"]
    assert largest_jump(obj)[0] < 1e-4


def test_doubled_polygons_with_a_defect_are_split_once():
    """The triangles that draw one of them cannot be there twice: the other one stays."""
    clean = hexagon_sphere()
    count = len(clean.data.polygons)
    obj = rebuilt(clean, doubled=range(count))
    report = api.quads(obj, spacing=0.25)
    assert report["disclinations"] and any("split" in line for line in report["warnings"])
    sizes = np.array([len(polygon.vertices) for polygon in obj.data.polygons])
    assert np.count_nonzero(sizes == 3) and np.count_nonzero(sizes > 3) > count
    corners = [tuple(sorted(polygon.vertices)) for polygon in obj.data.polygons if len(polygon.vertices) == 3]
    assert len(set(corners)) == len(corners)


def test_a_moved_mesh_is_refused_where_a_vertex_of_its_surface_is_lost():
    obj = sphere()
    given = meshes.read_mesh(obj)
    obj.data.vertices[3].co.x = np.nan
    with pytest.raises(SynchError, match=r"vertex 3 has no finite position"):
        meshes.read_mesh(obj, given)


def test_a_quad_mesh_of_it_has_no_such_places():
    obj = patched()
    made = bpy.data.objects[api.quad_mesh(obj, spacing=0.4)["quad_mesh"]["object"]]
    assert json.loads(made.synch.result)["carrier"] == {}


def test_a_patched_sphere_has_the_field_of_the_clean_one():
    clean = sphere()
    obj = patched()
    expected, report = (api.stripes(each, spacing=0.3, seed=2) for each in (clean, obj))
    for name in ("energy", "lower_bound", "nodes", "edges", "euler_characteristic"):
        assert report[name] == expected[name]
    for name in ("synch_direction", "synch_vertex_phase", "synch_pattern"):
        np.testing.assert_array_equal(attribute(obj, name), attribute(clean, name))
    np.testing.assert_array_equal(
        attribute(obj, "synch_spacing_error")[: len(clean.data.polygons)], attribute(clean, "synch_spacing_error")
    )
    doubled = attribute(obj, "synch_spacing_error")[-2:]
    np.testing.assert_array_equal(doubled, attribute(clean, "synch_spacing_error")[[3, 40]])


@pytest.mark.parametrize("name", ["fans", "patched", "klein bottle", "lost vertex"])
def test_lines_quads_and_numbers_are_made_of_it(name):
    obj = BAD[name][0]()
    api.stripes(obj, spacing=0.5)
    lines = api.isolines(obj)
    assert lines["lines"] > 0
    api.number_stripes(obj)
    assert np.isfinite(attribute(obj, "synch_along")).all()
    report = api.quad_mesh(obj, spacing=0.4)
    made = bpy.data.objects[report["quad_mesh"]["object"]]
    assert len(made.data.polygons) == report["quad_mesh"]["faces"] > 0
    assert report["quad_mesh"]["hausdorff_distance"] < 0.5


def test_attributes_of_the_object_go_to_the_copies():
    obj = add_object(*hourglass()[:2])
    add_group(obj, "top", np.flatnonzero(places(obj)[:, 2] > places(obj)[:, 2].max() - 0.3))
    report = api.stripes(obj, spacing=0.3, guidance="axis:Z", spacing_map="top", spacing_range=0.5)
    assert report["energy"] > 0
    with_cut = api.stripes(obj, spacing=0.3, constraints=[{"where": "group", "what": "cut", "name": "top"}])
    assert with_cut["nodes"] > report["nodes"]


def test_marks_hold_on_every_sheet():
    obj = add_object(*fans(8))
    for edge in obj.data.edges:
        edge.use_seam = max(edge.vertices) <= 8
    report = api.stripes(obj, spacing=0.3, constraints=[{"where": "seams", "what": "phase"}])
    assert report["energy"] < 1e-9
    np.testing.assert_allclose(np.cos(attribute(obj, "synch_vertex_phase")[:9]), 1, atol=1e-6)


def test_a_file_that_is_opened_again_tells_what_came_apart():
    obj = add_object(*hourglass()[:2])
    api.stripes(obj, spacing=0.3)
    memory.forget(obj)
    with pytest.raises(SynchError, match="has cuts, which its attributes cannot store: solve it again"):
        api.isolines(obj)
    whole = patched()
    api.stripes(whole, spacing=0.3)
    there = api.isolines(whole)["length"]
    memory.forget(whole)
    assert api.isolines(whole)["length"] == pytest.approx(there, rel=1e-4)


def test_a_mesh_that_moves_keeps_its_carrier():
    obj = swaying(patched())
    report = api.animate(obj, frames=(1, 3), spacing=0.4)
    assert report["carrier"]["turned_faces"] == 82 and len(report["frames"]) == 3
    jump, _ = largest_jump(obj)
    assert jump < 1e-4


PLACES = {
    "faces": (patched, "doubled_faces", [320, 321]),
    "edges": (lambda: add_object(*fans(8)), "non_manifold_edges", [(k, k + 1) for k in range(8)]),
    "vertices": (lambda: add_object(*hourglass()[:2]), "pinched_vertices", [hourglass()[2]]),
}


@pytest.mark.parametrize("kind", PLACES)
def test_a_button_selects_the_places(kind):
    build, name, expected = PLACES[kind]
    obj = build()
    report = api.directions(obj)
    layout = MagicMock()
    draw_findings(layout, json.loads(obj.synch.result)["carrier"])
    operators = [call for call in layout.mock_calls if call[0].endswith("operator")]
    assert len(operators) == len(report["carrier"])
    assert bpy.ops.synch.select_places(finding=name) == {"FINISHED"}
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    chosen = {
        "faces": [face.index for face in obj.data.polygons if face.select],
        "edges": sorted(tuple(sorted(edge.vertices)) for edge in obj.data.edges if edge.select),
        "vertices": [vertex.index for vertex in obj.data.vertices if vertex.select],
    }
    assert chosen[kind] == expected and (kind == "faces" or not chosen["faces"])
    assert kind != "vertices" or not chosen["edges"]
    with pytest.raises(RuntimeError, match="no such place"):
        bpy.ops.synch.select_places(finding="lost_vertices")


def test_every_kind_of_place_has_a_label():
    assert FINDINGS.keys() == KINDS.keys()


def test_a_process_of_its_own_solves_it_too(bad):
    request = FieldJob("stripes", bad[0], SurfaceSettings(spacing=0.5)).request
    sent = pickle.loads(pickle.dumps(request, protocol=5))
    np.testing.assert_array_equal(sent.solve().pattern.phases, request.solve().pattern.phases)


def test_the_window_says_what_was_done():
    obj = patched()
    bpy.ops.synch.stripes(spacing=0.3)
    assert json.loads(obj.synch.result)["carrier"] == {"doubled_faces": 2, "turned_faces": 82}


def test_a_changed_mesh_is_seen():
    obj = patched()
    given = meshes.read_mesh(obj)
    assert meshes.is_unchanged(obj, given)
    obj.data.polygons[5].flip()
    assert not meshes.is_unchanged(obj, given)
    obj = lost()
    given = meshes.read_mesh(obj)
    assert meshes.is_unchanged(obj, given)
    obj.data.vertices[3].co.x += 0.1
    assert not meshes.is_unchanged(obj, given)


def test_the_command_line_tells_and_is_strict_when_asked(tmp_path, capfd):
    patched()
    source, told = tmp_path / "bad.blend", tmp_path / "out.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(source))
    assert main.main(["directions", str(source), "--quiet", "--report", str(told)]) == 0
    report = json.loads(told.read_text())
    assert report["carrier"] == {"doubled_faces": 2, "turned_faces": 82}
    printed = capfd.readouterr()
    assert "have the same corners as another face: they count once" in printed.out + printed.err
    assert main.main(["directions", str(source), "--quiet", "--strict", "--report", str(told)]) == 1
    assert "the same corners as another face: delete" in capfd.readouterr().err
    assert main.main(["info", str(source), "--report", str(told)]) == 0
    assert json.loads(told.read_text())["carrier"] == {"doubled_faces": 2, "turned_faces": 82}


def test_a_field_file_has_a_direction_for_each_face_of_the_object(tmp_path):
    obj = patched()
    api.directions(obj)
    before = attribute(obj, "synch_direction")
    api.export_field(obj, str(tmp_path / "field.rosy"), "line")
    api.import_field(obj, str(tmp_path / "field.rosy"))
    after = attribute(obj, "synch_direction")
    assert np.abs(np.einsum("ij,ij->i", before, after)).mean() > 0.98


def test_a_flow_on_it_has_its_vortices():
    obj = patched()
    swirl = np.cross([0, 0, 1.0], places(obj))
    data = obj.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data
    data.foreach_set("vector", swirl.astype(np.float32).ravel())
    report = api.clebsch(obj, quantum=1.0)
    assert any("same corners" in line for line in report["warnings"])
    assert report["vortices"]
