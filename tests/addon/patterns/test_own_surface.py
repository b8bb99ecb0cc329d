# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns where an object's faces are too coarse, or modifiers make others: the pattern has a surface of its own, the
mesh is what it was, and all that reads patterns reads that surface."""

import importlib
import re

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError, SynchError
from synch_fields.core.refinement import bound_surface
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.pattern_surface import surface_modifier, surface_of
from synch_fields.synch_addon.blender.phases import pattern_kind
from synch_fields.synch_addon.patterns import favourites, memory
from synch_fields.synch_addon.patterns.job import FieldJob
from synch_fields.synch_addon.patterns.picking import PickedSurface
from synch_fields.synch_addon.patterns.read_back import read_back

from ..rebuilt_pattern import largest_jump
from ..run_commands import undo_and_redo
from ..scenes import add_group, add_object, attribute, make_active, snapshot, sphere, torus, tube
from .coarse_shapes import BUILD, bytes_of, cube, half_body, rigged_tube, seen

bmesh = importlib.import_module("bmesh")  # on the path once bpy is loaded, as isort cannot know
pytestmark = pytest.mark.any_surface


def solved_cube(**settings):
    obj = cube()
    return obj, api.stripes(obj, **{"spacing": 0.4} | settings)


@BUILD
def test_the_pattern_is_seen_without_jumps_where_the_object_is_and_the_mesh_is_what_it_was(build, settings, of):
    obj = build()
    shown = _shown_by(obj)
    make_active(obj)
    before, modifiers = bytes_of(obj.data), [modifier.name for modifier in obj.modifiers]
    report = api.stripes(obj, **settings)
    assert bytes_of(obj.data) == before
    assert [modifier.name for modifier in obj.modifiers] == [*modifiers, "Synch Surface"]
    assert report["surface"]["of"] == of and report["surface"]["faces"] == len(surface_of(obj).data.polygons)
    mesh = seen(obj).data
    assert len(mesh.polygons) == report["surface"]["faces"]
    assert {"synch_phase", "synch_index"} <= set(mesh.attributes.keys())
    assert [material.name for material in mesh.materials][-1] == "Synch Stripes"
    jump, compared = largest_jump(surface_of(obj))
    assert compared > 1000 and jump < 1e-3
    assert not [line for line in report["warnings"] if "finer than" in line]
    places = attribute(seen(obj), "position")
    bpy.context.view_layer.update()
    apart = [np.linalg.norm(np.array(shown.closest_point_on_mesh(place)[1]) - place) for place in places[::7]]
    assert max(apart) < 1e-5


def _shown_by(obj):
    """An object of the faces that modifiers show in renders."""
    levels = [(modifier, modifier.levels) for modifier in obj.modifiers if modifier.type == "SUBSURF"]
    for modifier, _ in levels:
        modifier.levels = modifier.render_levels
    mesh = bpy.data.meshes.new_from_object(seen(obj))
    for modifier, level in levels:
        modifier.levels = level
    return add_object([v.co[:] for v in mesh.vertices], [p.vertices[:] for p in mesh.polygons])


def test_the_surface_follows_an_armature_frame_by_frame():
    obj = rigged_tube()
    api.stripes(obj, spacing=0.4)
    surface = surface_of(obj)
    parents = np.column_stack([attribute(surface, f"synch_parent_{k}") for k in (1, 2, 3)])
    weights = attribute(surface, "synch_weights")
    moved = []
    for frame in (1, 20):
        bpy.context.scene.frame_set(frame)
        with_pattern = attribute(seen(obj), "position").copy()
        obj.modifiers["Synch Surface"].show_viewport = False
        bare = attribute(seen(obj), "position").copy()
        obj.modifiers["Synch Surface"].show_viewport = True
        assert np.abs(with_pattern - np.einsum("vk,vkx->vx", weights, bare[parents])).max() < 1e-5
        assert "synch_phase" in seen(obj).data.attributes
        moved.append(with_pattern)
    assert np.abs(moved[1] - moved[0]).max() > 1


def test_a_choice_of_own_faces_is_kept_to():
    obj, report = solved_cube(surface="faces", spacing=1.5)
    assert "surface" not in report and surface_of(obj) == obj
    assert any("set the surface to automatic" in line for line in report["warnings"])


def test_what_is_seen_is_solved_on_where_it_is_chosen():
    obj = sphere(4)
    obj.modifiers.new("Array", "ARRAY").relative_offset_displace = (1.5, 0, 0)
    report = api.stripes(obj, spacing=0.4, surface="seen")
    assert report["surface"]["of"] == "modifiers"
    assert report["surface"]["faces"] == 2 * len(obj.data.polygons) == len(seen(obj).data.polygons)


def test_triangles_that_are_apart_are_joined_and_counted():
    source = torus()
    places, faces = attribute(source, "position"), [p.vertices[:] for p in source.data.polygons]
    corners = np.concatenate(faces)
    obj = add_object(places[corners], np.arange(len(corners)).reshape(-1, 4))
    report = api.stripes(obj, spacing=0.5)
    assert report["closed"] and report["euler_characteristic"] == 0
    assert report["surface"]["joined"] == len(corners) - len(places)
    assert any("Mesh > Merge > By Distance" in line for line in report["warnings"])


def test_a_fine_grid_beside_a_finer_one_is_closed_where_vertices_lie_on_its_edges():
    coarse, fine = (np.arange(n + 1) / n for n in (10, 20))
    places, faces = [], []
    for left, steps in ((0.0, coarse), (1.0, fine)):
        count = len(steps)
        x, y = np.meshgrid(left + steps, steps, indexing="ij")
        numbers = np.arange(count**2).reshape(count, count) + sum(map(len, places))
        places.append(np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]))
        faces.append(
            np.stack([numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]], -1).reshape(-1, 4)
        )
    obj = add_object(np.concatenate(places), np.concatenate(faces))
    report = api.stripes(obj, spacing=0.3)
    assert report["surface"]["joined"] == 11 + 10
    assert report["euler_characteristic"] == 1


def test_quads_that_become_smaller_than_their_surface_was_made_for_are_no_fault_of_it():
    obj = add_object([(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0), (2, 1, 0)], [(0, 1, 2), (3, 4, 5)])
    assert not any("finer than the mesh" in line for line in api.quad_mesh(obj, faces=700)["warnings"])


def test_edges_of_a_low_step_are_followed():
    """Curvature that varies over less than half a quad does not turn the crosses at first, though a step needs it."""
    profile = [(0, 0), (1, 0), (1, 0.3), (0.5, 0.3), (0.5, 0.32), (0, 0.32)]
    sides = [(k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k) for k in range(6)]
    ends = [tuple(range(5, -1, -1)), tuple(range(6, 12))]
    obj = add_object([(*place, height) for height in (0, 0.8) for place in profile], ends + sides)
    report = api.quad_mesh(obj, faces=400)
    assert report["quad_mesh"]["closed"] and not any("lost" in line for line in report["warnings"])


def test_a_spacing_that_would_take_too_many_faces_is_refused_with_one_that_works(monkeypatch):
    monkeypatch.setattr(bound_surface, "MOST_TRIANGLES", 10_000)
    obj = cube()
    with pytest.raises(SettingError, match=r"too fine for this mesh: use one from [0-9.]+ on") as caught:
        api.stripes(obj, spacing=0.04)
    assert surface_of(obj) == obj and not obj.modifiers
    api.stripes(obj, spacing=float(re.search("from ([0-9.]+) on", str(caught.value))[1]), method="spectral")
    assert surface_of(obj) != obj


def texts_of(obj, name):
    return [element.value for element in obj.data.attributes[name].data]


def test_groups_marks_maps_and_attributes_go_over():
    obj = cube()
    mesh = obj.data
    mesh.uv_layers.new(name="Second")
    mesh.materials.append(bpy.data.materials.new("Red"))
    mesh.materials.append(bpy.data.materials.new("Green"))
    mesh.polygons.foreach_set("material_index", [0, 1, 0, 1, 0, 1])
    mesh.attributes.new("height", "FLOAT", "POINT").data.foreach_set("value", attribute(obj, "position")[:, 2])
    mesh.attributes.new("number", "INT", "FACE").data.foreach_set("value", np.arange(6, dtype=np.int32))
    mesh.attributes.new("uv_seam", "BOOLEAN", "EDGE").data.foreach_set("value", [True] + [False] * 11)
    for domain, texts in (("FACE", "abcdef"), ("EDGE", "a" * 12), ("POINT", "abcdefgh")):
        for element, text in zip(mesh.attributes.new(domain.lower(), "STRING", domain).data, texts, strict=True):
            element.value = text.encode()
    for axis, name in enumerate(("right", "back", "top")):
        add_group(obj, name, np.flatnonzero(attribute(obj, "position")[:, axis] > 0))
    api.stripes(obj, spacing=0.4)
    surface = surface_of(obj)
    places = attribute(surface, "position")
    assert np.abs(attribute(surface, "height") - places[:, 2]).max() < 1e-6
    for axis, name in enumerate(("right", "back", "top")):
        number = surface.vertex_groups[name].index
        weights = [sum(g.weight for g in vertex.groups if g.group == number) for vertex in surface.data.vertices]
        assert np.abs(np.array(weights) - (places[:, axis] + 1) / 2).max() < 1e-6
    centres = np.array([polygon.center[:] for polygon in surface.data.polygons])
    numbers, slots = attribute(surface, "number"), attribute(surface, "material_index")
    for number, polygon in enumerate(mesh.polygons):
        off = np.abs((centres[numbers == number] - np.array(polygon.center)) @ np.array(polygon.normal))
        assert off.max() < 1e-6 and (slots[numbers == number] == polygon.material_index).all()
    assert texts_of(surface, "face") == [b"abcdef"[number : number + 1] for number in numbers]
    assert texts_of(surface, "point")[:8] == texts_of(obj, "point")
    assert set(texts_of(surface, "edge")) == {b"", b"a"}
    seam = attribute(surface, "uv_seam")
    ends = np.array([edge.vertices[:] for edge in surface.data.edges])[seam]
    assert np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1).sum() == pytest.approx(2)
    corners = attribute(obj, "Second"), attribute(surface, "Second")
    assert np.allclose(corners[0].min(axis=0), corners[1].min(axis=0)) and len(surface.data.uv_layers) == 2


def test_a_smooth_object_stays_smooth():
    obj = tube(segments=8, rings=3)
    obj.data.shade_smooth()
    api.stripes(obj, spacing=0.4)
    mesh = seen(obj).data
    normals = np.array([corner.vector[:] for corner in mesh.corner_normals])
    places = attribute(seen(obj), "position")[[loop.vertex_index for loop in mesh.loops]]
    outward = places * [1, 1, 0] / np.linalg.norm(places[:, :2], axis=1)[:, None]
    assert np.einsum("ij,ij->i", normals, outward).min() > 0.995  # the flat parts are up to 22 degrees off


def test_removing_the_modifier_leaves_the_object_as_it_was():
    obj, _ = solved_cube()
    obj.modifiers.remove(obj.modifiers["Synch Surface"])
    assert surface_of(obj) == obj and pattern_kind(obj) is None
    assert len(seen(obj).data.vertices) == 8
    with pytest.raises(SynchError, match="solve it again"):
        memory.recall(obj)


def test_other_faces_show_themselves_in_place_of_a_wrong_pattern():
    obj, _ = solved_cube()
    assert not memory.is_outdated(obj)
    grown = bmesh.new()
    grown.from_mesh(obj.data)
    bmesh.ops.subdivide_edges(grown, edges=grown.edges[:], cuts=1, use_grid_fill=True)
    grown.to_mesh(obj.data)
    obj.data.update()
    bpy.context.view_layer.update()
    assert len(seen(obj).data.vertices) == len(obj.data.vertices) == 26
    assert memory.is_outdated(obj)
    with pytest.raises(SynchError, match="has changed since it was solved"):
        api.vary(obj, 1)


def test_own_faces_come_back_with_a_spacing_that_they_carry():
    obj = sphere(3)
    api.stripes(obj, spacing=0.3)
    assert surface_of(obj) != obj
    assert "surface" not in api.stripes(obj, spacing=0.8)
    assert surface_of(obj) == obj and not obj.modifiers and "Icosphere Surface" not in bpy.data.objects
    assert "synch_phase" in obj.data.attributes


def test_a_second_solve_leaves_one_surface_with_the_look_numbers_and_favourites():
    obj, _ = solved_cube(guidance="axis:Z")
    count = api.number_stripes(obj)
    material = surface_of(obj).material_slots[0].material.copy()
    surface_of(obj).material_slots[0].material = material
    name = favourites.keep(obj)
    api.stripes(obj, spacing=0.4, guidance="axis:Z", seed=1)
    assert [m.name for m in obj.modifiers] == ["Synch Surface"]
    assert len([o for o in bpy.data.objects if o.name.startswith("Cube Surface")]) == 1
    assert surface_of(obj).material_slots[0].material == material
    assert count > 3 and "synch_number" in surface_of(obj).data.attributes
    favourites.show(obj, name)
    api.stripes(obj, spacing=0.3, guidance="axis:Z")
    assert surface_of(obj).material_slots[0].material == material
    assert "synch_number" in surface_of(obj).data.attributes and not obj.synch.favourites


@pytest.mark.parametrize("build", [cube, half_body])
def test_undo_and_redo_are_exact(build):
    build()
    undo_and_redo(lambda: bpy.ops.synch.stripes(spacing=0.4))


def test_a_cancelled_solve_changes_nothing():
    obj = half_body()
    before = snapshot()
    with pytest.raises(Cancelled):
        api.stripes(obj, spacing=0.4, callback=lambda *_: False)
    assert snapshot() == before


@pytest.mark.parametrize("command", ["stripes", "quad_mesh"])
def test_a_modifier_that_divides_faces_meanwhile_ends_in_one_line(command):
    """It leaves as many vertices as there were. The triangles are not symmetric, though those of the Mirror are."""
    obj = cube()
    obj.modifiers.new("Mirror", "MIRROR")
    triangulate = obj.modifiers.new("Triangulate", "TRIANGULATE")
    job = FieldJob(command, obj, SurfaceSettings(spacing=0.8))
    obj.modifiers.remove(triangulate)
    before = bytes_of(obj.data)
    with pytest.raises(SynchError, match="changed while it was solved: run again"):
        job.write(job.request.solve())
    assert bytes_of(obj.data) == before and surface_of(obj) == obj


def test_variations_lines_reliefs_and_quads_read_the_surface():
    obj, report = solved_cube(guidance="axis:Z")
    assert api.vary(obj, 2)["energy"] > 0
    lines = api.isolines(obj)
    points = [p.co[:3] for s in bpy.data.objects[lines["object"]].data.splines for p in s.points]
    assert np.abs(np.abs(points).max(axis=1) - 1).max() < 0.05  # on the cube
    assert api.relief(obj, level=1)["level"] == 1
    assert [m.name for m in obj.modifiers] == ["Synch Surface", "Synch Relief"]
    assert len(seen(obj).data.polygons) > report["surface"]["faces"]
    made = api.quad_mesh(obj, faces=600)["quad_mesh"]
    assert len(bpy.data.objects[made["object"]].data.polygons) == pytest.approx(600, rel=0.3)
    assert surface_of(obj) != obj and pattern_kind(obj) == "stripes"


def test_a_saved_pattern_is_read_back(tmp_path):
    obj, report = solved_cube(guidance="axis:Z")
    lines = api.isolines(obj)["lines"]
    path = str(tmp_path / "cube.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Cube"]
    assert len(seen(obj).data.polygons) == report["surface"]["faces"]
    memory.forget(obj)
    _, request, _, _ = read_back(obj, obj.synch.result)
    assert request.given.mesh.triangle_count == report["surface"]["faces"]
    assert api.isolines(obj)["lines"] == lines > 3


def test_clicks_meet_the_surface_where_it_is_seen():
    obj = rigged_tube()
    api.stripes(obj, spacing=0.4)
    bpy.context.scene.frame_set(20)
    picked = PickedSurface.of(obj)
    assert np.abs(picked.places - attribute(seen(obj), "position")).max() < 1e-6
    assert len(picked.polygons.starts) == len(surface_of(obj).data.polygons)


def test_a_copy_keeps_its_pattern_when_the_object_gets_another():
    obj, _ = solved_cube()
    twin = obj.copy()
    bpy.context.scene.collection.objects.link(twin)
    faces = len(seen(twin).data.polygons)
    api.stripes(obj, spacing=0.3)
    assert surface_of(twin) != surface_of(obj) and len(seen(twin).data.polygons) == faces
    assert surface_modifier(twin) is not None and "synch_phase" in seen(twin).data.attributes


def test_renders_and_viewport_are_subdivided_alike():
    obj = half_body()
    report = api.stripes(obj, spacing=0.3)
    subdivision = obj.modifiers["Subsurf"]
    assert subdivision.levels == subdivision.render_levels == 2
    assert any("Subsurf has level 2 in viewport and renders now" in line for line in report["warnings"])


def test_animations_and_their_removal_go_back_to_own_faces():
    obj, _ = solved_cube()
    api.animate(obj, frames=(1, 2), spacing=1.2)
    assert surface_modifier(obj) is None and "synch_phase.1" in obj.data.attributes


def test_pins_stay_in_their_places_when_the_surface_is_another_one():
    obj = cube()
    side = next(f for f in obj.data.polygons if f.normal.x > 0.9)
    obj.synch.pins = f"{side.index}=1"
    report = api.stripes(obj, spacing=0.5)
    middles = []
    for spacing in (0.4, 1.9):
        assert [d for d in report["disclinations"] if d["index"] == 0.5 and np.abs(d["position"][0] - 1) < 1e-5]
        (face,) = (int(pin.split("=")[0]) for pin in obj.synch.pins.split(","))
        middles.append(surface_of(obj).data.polygons[face].center[:])
        report = api.stripes(obj, spacing=spacing)
    assert np.abs(np.array(middles) - [1, 0, 0]).max() < 0.35


def test_faces_of_defects_are_those_of_the_mesh_that_is_edited():
    obj, report = solved_cube()
    assert bpy.ops.synch.select_defects() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    chosen = {polygon.index for polygon in obj.data.polygons if polygon.select}
    at = np.array([d["position"] for d in report["disclinations"] + report["dislocations"]])
    for number, polygon in enumerate(obj.data.polygons):
        off = np.abs((at - np.array(polygon.center)) @ np.array(polygon.normal))
        inside = (off < 1e-6) & (np.abs(at) < 1 - 1e-6).sum(axis=1).__ge__(2)
        assert not inside.any() or number in chosen


@pytest.mark.parametrize("build", [cube, half_body])
def test_bakes_read_the_surface(build, tmp_path):
    obj = build()
    if not obj.data.uv_layers:
        obj.data.uv_layers.new(name="UVMap")
    api.stripes(obj, spacing=0.4, guidance="axis:Z")
    before = bytes_of(obj.data)
    report = api.bake(obj, maps="mask", size=64, margin=0, folder=str(tmp_path), unwrap=build is cube)
    assert bytes_of(obj.data) == before
    image = bpy.data.images.load(report["maps"]["mask"]["file"])
    values = np.array(image.pixels[:]).reshape(-1, 4)[:, 0]
    assert 0.05 < (values > 0.5).mean() < 0.95
