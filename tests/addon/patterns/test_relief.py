# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Relief by geometry nodes: the height at every vertex, from the attributes alone, and that it prints."""

from itertools import product

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.interpolate import evaluate, face_phases
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, meshes
from synch_fields.synch_addon.patterns import relief

from ..nodes.test_quads_look import random_phases, write_phases
from ..rebuilt_pattern import phases_of, polygons_of
from ..run_commands import undo_and_redo
from ..scenes import attribute, grid, hexagon_sphere, quad_sphere, save_and_reopen, snapshot, sphere, torus

HEIGHT, SPACING = 0.2, 0.5


class Evaluated:
    """What an object's modifiers make of it, with its mesh where the readers of attributes look for it."""

    def __init__(self, obj):
        self.data = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data

    @property
    def places(self):
        return attribute(self, "position").astype(float)


def random_stripes(obj):
    """Faces and phases of random stripes along the smoothest lines: full of defects of both kinds."""
    given = meshes.read_mesh(obj)
    growth = TargetOneForm.of(given.mesh, direction_field(given.mesh, 2), SPACING)
    phases = np.exp(1j * np.random.default_rng(2).uniform(-np.pi, np.pi, given.mesh.vertex_count))
    return given.polygons, face_phases(growth.edge_phases(phases), given.polygons)


def write_stripes(obj, phases):
    (phase,) = phases
    attributes.write_attribute(obj, "synch_phase", "CORNER", "FLOAT", phase.corner_phase)
    attributes.write_attribute(obj, "synch_barycentric", "CORNER", "FLOAT_VECTOR", phase.corner_place)
    attributes.write_attribute(obj, "synch_index", "FACE", "INT", phase.index)
    if phase.index_2.any():
        attributes.write_attribute(obj, "synch_index_2", "FACE", "INT", phase.index_2)
    attributes.write_attribute(obj, "synch_disclination", "FACE", "FLOAT_COLOR", phase.disclination)


def randomly_patterned(obj, kind):
    """Write random phases of a kind; returns the faces and phases."""
    obj["synch_spacing"] = SPACING
    polygons, phases = random_stripes(obj) if kind == "stripes" else random_phases(obj)
    if kind == "stripes":
        write_stripes(obj, phases)
    else:
        write_phases(obj, phases, polygons)
    attributes.write_attribute(obj, "face", "FACE", "INT", np.arange(len(polygons.starts)))
    return polygons, phases


def sine(theta):
    """Height of stripes that take half a period."""
    away = np.abs(theta[0] / (2 * np.pi) - np.rint(theta[0] / (2 * np.pi)))
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(1 - 4 * away, 0, 1))


def grid_lines(theta, width=0.5):
    """Height of grid lines that take half the area."""
    half = (1 - np.sqrt(1 - width)) / 2
    away = np.min([np.abs(t / np.pi - np.rint(t / np.pi)) for t in theta], axis=0)
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(1 - away / half, 0, 1))


KINDS = {"stripes": ("sine", sine, ("",)), "quads": ("grid lines", grid_lines, ("_x", "_y"))}


def flat_and_raised(obj, kind, smooth=False):
    """The subdivided mesh without and with its relief."""
    profile = KINDS[kind][0]
    api.relief(obj, 0.0, 0.5, profile, 2, smooth)
    flat = Evaluated(obj).places
    api.relief(obj, HEIGHT / SPACING, 0.5, profile, 2, smooth)
    return flat, Evaluated(obj)


@pytest.mark.parametrize("kind", KINDS)
def test_on_triangles_every_vertex_is_raised_by_the_phase_at_its_place(kind):
    """Where it is in its triangle is found from its position, and the phase there by the core."""
    obj = sphere(2)
    polygons, phases = randomly_patterned(obj, kind)
    flat, raised = flat_and_raised(obj, kind)
    fine = polygons_of(raised)
    faces = np.repeat(attribute(raised, "face"), fine.sizes)
    vertices = polygons.corner_vertices[polygons.triangle_corners[faces]]
    corners, normals = (attribute(obj, "position").astype(float)[vertices], vertex_normals(obj)[vertices])
    weights = np.linalg.solve(np.swapaxes(corners, 1, 2), flat[fine.corner_vertices][:, :, None])[:, :, 0]
    np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-5)
    heights = KINDS[kind][1]([evaluate(phase, polygons, faces, weights) for phase in phases])
    along = np.einsum("ck,ckx->cx", weights, normals)
    along /= np.linalg.norm(along, axis=1)[:, None]
    expected = flat[fine.corner_vertices] + HEIGHT * heights[:, None] * along
    off = np.linalg.norm(raised.places[fine.corner_vertices] - expected, axis=1)
    singular = np.any([phase.index[faces] != 0 for phase in phases], axis=0)
    at_centre = np.abs(weights - 1 / 3).max(axis=1) < 1e-4  # where a dislocation has no phase
    assert off[~(singular & at_centre)].max() < 2e-5 * HEIGHT
    assert singular.sum() > 100 and np.ptp(heights) > 0.99


def vertex_normals(obj):
    normals = np.empty((len(obj.data.vertices), 3), np.float32)
    obj.data.vertex_normals.foreach_get("vector", normals.ravel())
    return normals.astype(float)


@pytest.mark.parametrize(
    ("build", "kind", "smooth"),
    [
        (sphere, "stripes", False),
        (quad_sphere, "stripes", True),
        (sphere, "quads", True),
        (quad_sphere, "quads", False),
    ],
)
def test_heights_at_the_corners_of_a_vertex_agree(build, kind, smooth):
    """From the attributes as they come out of the subdivision: their mean is no compromise."""
    obj = build()
    randomly_patterned(obj, kind)
    flat, raised = flat_and_raised(obj, kind, smooth)
    suffixes, polygons = KINDS[kind][2], polygons_of(raised)
    phases, triangles = [phases_of(raised, suffix) for suffix in suffixes], np.arange(len(polygons.triangle_corners))
    heights = np.empty(len(polygons.corner_vertices))
    for k in range(3):
        weights = np.tile(np.eye(3)[k], (len(triangles), 1))
        heights[polygons.triangle_corners[:, k]] = KINDS[kind][1](
            [evaluate(phase, polygons, triangles, weights) for phase in phases]
        )
    low, high = np.full(len(flat), np.inf), np.full(len(flat), -np.inf)
    np.minimum.at(low, polygons.corner_vertices, heights)
    np.maximum.at(high, polygons.corner_vertices, heights)
    found = np.linalg.norm(raised.places - flat, axis=1) / HEIGHT
    centres = np.zeros(len(flat), bool)
    place = attribute(raised, "synch_barycentric")
    centres[polygons.corner_vertices[np.abs(place - 1 / 3).max(axis=1) < 1e-4]] = True
    assert (high - low)[~centres].max() < 1e-4
    np.testing.assert_allclose(found[~centres], 0.5 * (low + high)[~centres], atol=1e-4)
    assert centres.sum() < 0.1 * len(flat) and np.ptp(found) > 0.95


# Closed forms on a plane


def striped_plane():
    """A square, 2 by 2, of quads with stripes along X."""
    obj = grid(16)
    api.stripes(obj, spacing=0.25, guidance="axis:X")
    return obj


def periods_to_middle(obj):
    """At heights y of the plane; from the curve object of the middles, which knows nothing of geometry nodes."""
    made = bpy.data.objects[api.isolines(obj)["object"]]
    height = made.data.splines[0].points[0].co[1]

    def distance(y):
        periods = (y - height) / 0.25
        return np.abs(periods - np.rint(periods))

    return distance


SHAPES = {
    "sine": lambda s: 0.5 - 0.5 * np.cos(np.pi * s),
    "square": lambda s: np.clip(4 * s, 0, 1) ** 2 * (3 - 2 * np.clip(4 * s, 0, 1)),
    "triangle": lambda s: s,
    "rounded": lambda s: np.sqrt(s * (2 - s)),
    "thread": lambda s: np.sqrt(s * (2 - s)),  # as long as stripes have no numbers
}


def test_profiles_of_straight_stripes():
    obj = striped_plane()
    distance = periods_to_middle(obj)
    for profile, width in product(SHAPES, (0.3, 0.5, 1.0)):
        report = api.relief(obj, height=0.4, width=width, profile=profile, level=3)
        assert report["height"] == pytest.approx(0.1) and report["profile"] == profile
        points = Evaluated(obj).places
        share = np.clip(1 - distance(points[:, 1]) / (0.5 * width), 0, 1)
        expected = 0.1 * SHAPES[profile](share)
        slope = {"rounded": 0.02, "thread": 0.02}.get(profile, 2e-3)  # these begin upright
        np.testing.assert_allclose(points[:, 2], expected, atol=slope * 0.1, err_msg=f"{profile}, {width}")
        assert len(points) == (16 * 8 + 1) ** 2


def test_profiles_of_quads_are_those_of_the_shader():
    obj = grid(16)
    api.quads(obj, spacing=0.5, guidance="axis:X")
    for number, name in enumerate(relief.QUAD_PROFILES):
        report = api.relief(obj, height=0.2, profile=number, level=3)
        assert report["profile"] == name and report["modifier"] == "Synch Quad Relief"
        heights = Evaluated(obj).places[:, 2] / 0.1
        assert heights.min() > -1e-6 and heights.max() < 1 + 1e-6
        assert heights.max() > 0.9 and (heights < 0.05).mean() > 0.1
        if name in ("grid lines", "checker", "dots"):
            assert (heights > 1e-3).mean() == pytest.approx(0.5, abs=0.08)


def test_height_below_zero_cuts_in():
    obj = striped_plane()
    api.relief(obj, height=-0.4, level=5)
    heights = Evaluated(obj).places[:, 2]
    assert heights.min() == pytest.approx(-0.1, abs=2e-3) and heights.max() < 1e-6


def test_height_is_in_scene_units_whatever_the_scale():
    obj = grid(16)
    obj.scale = (3, 3, 3)
    bpy.context.view_layer.update()
    api.stripes(obj, spacing=0.75, guidance="axis:X")
    api.relief(obj, height=0.2, width=1.0, profile="sine", level=5)
    assert 3 * np.ptp(Evaluated(obj).places[:, 2]) == pytest.approx(0.15, rel=1e-2)


# What it does to an object


@pytest.mark.parametrize(
    ("build", "command"), [(sphere, "stripes"), (hexagon_sphere, "stripes"), (torus, "quads"), (quad_sphere, "quads")]
)
def test_a_closed_surface_stays_a_solid_that_prints(build, command):
    import bmesh  # on the path once bpy is loaded

    obj = build()
    getattr(api, command)(obj, spacing=0.4)
    solid = bmesh.new()
    solid.from_mesh(obj.data)
    before = solid.calc_volume()
    api.relief(obj, level=2)
    solid.clear()
    solid.from_mesh(Evaluated(obj).data)
    assert all(edge.is_manifold and edge.is_contiguous for edge in solid.edges)
    assert all(vertex.is_manifold for vertex in solid.verts)
    assert min(face.calc_area() for face in solid.faces) > 0
    area = sum(face.calc_area() for face in solid.faces)
    assert before < solid.calc_volume() < before + 0.15 * 0.4 * area
    solid.free()


def test_smooth_rounds_the_surface():
    obj = sphere(2)
    api.stripes(obj, spacing=1.0)

    def flatness(smooth):
        api.relief(obj, height=0.0, level=4, smooth=smooth)
        radii = np.linalg.norm(Evaluated(obj).places, axis=1)
        return np.ptp(radii) / radii.mean()

    assert flatness(True) < 0.5 * flatness(False)


def test_the_automatic_level_gives_a_period_twelve_edges():
    obj = sphere(4)
    for spacing in (0.3, 0.6, 1.2):
        api.stripes(obj, spacing=spacing)
        report = api.relief(obj)
        data = Evaluated(obj).data
        ends = attribute(Evaluated(obj), "position")[np.array([edge.vertices[:] for edge in data.edges])]
        edge = np.median(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1))
        assert spacing / edge > 11 and (report["level"] == 0 or spacing / (2 * edge) < 13)


def test_a_second_run_sets_the_modifier_that_is_there_and_other_modifiers_stay():
    obj = sphere()
    obj.modifiers.new("Mine", "WAVE")
    api.stripes(obj)
    first = api.relief(obj, height=0.1, level=1)
    second = api.relief(obj, height=0.2, level=2, profile="square")
    assert [m.name for m in obj.modifiers] == ["Mine", "Synch Relief"]
    assert second["height"] == pytest.approx(2 * first["height"]) and second["modifier"] == first["modifier"]
    groups = sorted(group.name for group in bpy.data.node_groups if group.bl_idname == "GeometryNodeTree")
    assert groups == ["Synch Relief", "Synch Relief Phase"]
    api.quads(obj)
    assert api.relief(obj, level=1)["modifier"] == "Synch Relief" and len(obj.modifiers) == 2
    assert obj.modifiers[1].node_group.name == "Synch Quad Relief"


def test_solving_again_does_not_warn_of_the_relief():
    obj = sphere()
    api.stripes(obj)
    api.relief(obj, level=1)
    assert not [line for line in api.stripes(obj, seed=2)["warnings"] if "modifiers" in line]
    obj.modifiers.new("Thick", "SOLIDIFY")
    assert [line for line in api.stripes(obj)["warnings"] if "(Thick)" in line]


@pytest.mark.parametrize("kind", KINDS)
def test_groups_are_whole_and_have_the_inputs_that_are_promised(kind):
    tree = relief.relief_group(kind)
    assert tree == relief.relief_group(kind) and tree.is_modifier
    assert all(link.is_valid for link in tree.links) and not any(
        node.bl_idname == "NodeUndefined" for node in tree.nodes
    )
    names = [item.name for item in tree.interface.items_tree if item.in_out == "INPUT"]
    promised = ["Geometry", "Height", "Width", "Profile", "Level", "Smooth"]
    assert names == promised + (["Strands"] if kind == "stripes" else [])


def test_it_is_there_after_saving_and_loading(tmp_path):
    obj = sphere()
    api.stripes(obj)
    api.relief(obj, level=2)
    name, before = obj.name, Evaluated(obj).places
    obj = save_and_reopen(tmp_path / "relief.blend", name)
    np.testing.assert_array_equal(Evaluated(obj).places, before)
    api.relief(obj, height=0.3, level=2)  # needs the attributes alone, not the solve
    assert np.abs(Evaluated(obj).places - before).max() > 1e-3


# Errors, undo


REFUSED = [
    ({"height": float("nan")}, "height"),
    ({"height": "high"}, "height"),
    ({"width": 2}, "width"),
    ({"level": 7}, "level"),
    ({"level": 1.5}, "level"),
    ({"profile": "weave"}, "rounded"),
    ({"profile": 9}, "rounded"),
]


def test_refused_settings_change_nothing():
    obj = sphere()
    api.stripes(obj)
    bpy.context.view_layer.update()
    before = snapshot()
    for settings, says in REFUSED:
        with pytest.raises(SynchError, match=says) as refusal:
            api.relief(obj, **settings)
        assert "\n" not in str(refusal.value) and ":" in str(refusal.value)
        assert snapshot() == before


@pytest.mark.parametrize("command", [None, "directions"])
def test_an_object_without_a_pattern_is_refused(command):
    obj = sphere()
    if command:
        getattr(api, command)(obj)
    bpy.context.view_layer.update()
    before = snapshot()
    with pytest.raises(SynchError, match="no stripes or quads"):
        api.relief(obj)
    with pytest.raises(RuntimeError, match="has no pattern: solve stripes or quads on it first"):
        bpy.ops.synch.relief()
    assert snapshot() == before


def test_undo_removes_the_relief_and_redo_brings_it_back():
    sphere()
    bpy.ops.synch.stripes()
    undo_and_redo(lambda: bpy.ops.synch.relief(height=0.1, level=2))


def test_in_edit_mode_it_works_and_stays_there():
    obj = sphere()
    api.stripes(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.synch.relief() == {"FINISHED"}
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(Evaluated(obj).data.vertices) > len(obj.data.vertices)
