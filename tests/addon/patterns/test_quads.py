# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads on a mesh: attributes, cuts, defects and their empties, on triangles, quads and larger faces."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SettingError, SynchError
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api

from ..constraint_rows import add_row
from ..quad_meshes import corner_vertices, mixed_sphere, part
from ..rebuilt_pattern import largest_jump
from ..scenes import (
    add_group,
    attribute,
    empties,
    grid,
    hexagon_sphere,
    mark_edges,
    quad_sphere,
    snapshot,
    sphere,
    torus,
    tube,
    written,
)

TOLERANCE = 1e-4
QUAD_ATTRIBUTES = {
    "synch_direction": ("POINT", "FLOAT_VECTOR"),
    "synch_phase_x": ("CORNER", "FLOAT"),
    "synch_phase_y": ("CORNER", "FLOAT"),
    "synch_index_x": ("FACE", "INT"),
    "synch_index_y": ("FACE", "INT"),
    "synch_disclination_x": ("FACE", "FLOAT_COLOR"),
    "synch_disclination_y": ("FACE", "FLOAT_COLOR"),
    "synch_closing": ("FACE", "FLOAT2"),
    "synch_barycentric": ("CORNER", "FLOAT_VECTOR"),
    "synch_vertex_phase_x": ("POINT", "FLOAT"),
    "synch_vertex_phase_y": ("POINT", "FLOAT"),
    "synch_pattern": ("POINT", "FLOAT"),
    "synch_spacing_error": ("FACE", "FLOAT"),
    "synch_singularity": ("FACE", "FLOAT"),
}
OPTIONAL = {"synch_index_x_2": ("FACE", "INT"), "synch_index_y_2": ("FACE", "INT")}


def values(obj):
    """Every attribute of ours, as bytes."""
    return {name: attribute(obj, name).tobytes() for name in written(obj)}


def optional(obj, name):
    """A face attribute that may be absent where it is zero."""
    return attribute(obj, name) if name in obj.data.attributes else np.zeros(len(obj.data.polygons))


def singular_faces(obj):
    """Faces in which a phase is not simply interpolated."""
    found = attribute(obj, "synch_singularity") != 0
    for axis in "xy":
        for name in (f"synch_index_{axis}", f"synch_index_{axis}_2"):
            found |= optional(obj, name) != 0
    return found


@pytest.mark.parametrize("build", [sphere, hexagon_sphere, mixed_sphere, tube])
def test_vertices_carry_the_product_of_both_cosines_and_so_do_the_corners_of_regular_faces(build):
    obj = build()
    assert bpy.ops.synch.quads(spacing=0.4) == {"FINISHED"}
    found = written(obj)
    assert QUAD_ATTRIBUTES.items() <= found.items() <= (QUAD_ATTRIBUTES | OPTIONAL).items()
    for name in found:
        assert np.isfinite(attribute(obj, name)).all(), name
    (slot,) = obj.material_slots
    groups = [n.node_tree.name for n in slot.material.node_tree.nodes if n.bl_idname == "ShaderNodeGroup"]
    assert groups == ["Synch Quads"]
    pattern = attribute(obj, "synch_pattern")
    at_vertices = [attribute(obj, f"synch_vertex_phase_{axis}") for axis in "xy"]
    np.testing.assert_allclose(np.cos(at_vertices).prod(axis=0), pattern, atol=1e-6)
    assert all(np.ptp(phase) > 1 for phase in at_vertices)
    singular = singular_faces(obj)
    assert not singular.all()
    regular = ~np.repeat(singular, [p.loop_total for p in obj.data.polygons])
    phases = np.array([attribute(obj, f"synch_phase_{axis}") for axis in "xy"])
    product = np.cos(phases).prod(axis=0)
    np.testing.assert_allclose(product[regular], pattern[corner_vertices(obj)][regular], atol=2e-5)
    firsts = phases[:, [p.loop_start for p in obj.data.polygons]][:, ~singular]
    assert (np.abs(firsts) <= np.float32(np.pi)).all()
    # What only singular faces need is zero elsewhere, and says in them what the shader has to do.
    rim = np.column_stack([attribute(obj, f"synch_disclination_{axis}") for axis in "xy"])
    torn = attribute(obj, "synch_singularity") != 0
    assert not attribute(obj, "synch_barycentric")[regular].any()
    np.testing.assert_array_equal(rim.any(axis=1), torn)
    assert not attribute(obj, "synch_closing")[~torn].any()


@pytest.mark.parametrize("build", [quad_sphere, mixed_sphere, grid])
def test_directions_of_quads_are_those_of_a_cross_field(build):
    obj = build()
    api.directions(obj, symmetry="cross")
    alone = {name: attribute(obj, name) for name in ("synch_direction", "synch_singularity")}
    api.quads(obj, spacing=0.5)
    np.testing.assert_array_equal(attribute(obj, "synch_direction"), alone["synch_direction"])
    # Larger faces with a defect have been split since.
    assert sorted(attribute(obj, "synch_singularity"))[-8:] == sorted(alone["synch_singularity"])[-8:]


def test_a_cut_tears_the_pattern_there_and_nowhere_else():
    obj = tube()
    mark_edges(obj, "seams", np.arange(24 * 9) // 24 == 4)
    api.quads(obj, spacing=0.45)
    assert largest_jump(obj)[0] < TOLERANCE
    api.quads(obj, spacing=0.45, constraints=[{"where": "seams", "what": "cut"}])
    assert largest_jump(obj)[0] > 0.1
    above = np.array([p.center.z > 1 for p in obj.data.polygons])
    for half in (part(obj, above), part(obj, ~above)):
        assert len(half.data.polygons) == 24 * 4 and largest_jump(half)[0] < TOLERANCE


# What an earlier run left


@pytest.mark.parametrize(
    "build, first, last", [(quad_sphere, "quads", "stripes"), (torus, "stripes", "quads"), (sphere, "quads", "quads")]
)
def test_the_last_of_stripes_and_quads_is_all_that_is_left(first, last, build):
    obj = build()
    api.run(last, obj, SurfaceSettings(spacing=0.3))
    expected = values(obj), sorted(e.name for e in empties(obj)), [s.material.name for s in obj.material_slots]
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = build()
    api.run(first, obj, SurfaceSettings(spacing=0.22))
    api.run(last, obj, SurfaceSettings(spacing=0.3))
    found = values(obj), sorted(e.name for e in empties(obj)), [s.material.name for s in obj.material_slots]
    assert found == expected


# Defects


@pytest.mark.parametrize("build", [sphere, torus])
def test_empties_mark_the_defects_of_both_phases(build):
    obj = build()
    obj.location, obj.scale, obj.rotation_euler = (3, 2, 1), (1, 2, 1), (0.3, 0.2, 0.1)
    report = api.quads(obj, spacing=0.3)
    bpy.context.view_layer.update()
    marks = {kind: empties(obj, kind) for kind in ("disclination", "dislocation")}
    for kind, found in marks.items():
        assert len(found) == len(report[f"{kind}s"]) > 0
        shown = [(e["synch_face"], e["synch_index"], e.get("synch_phase", "")) for e in found]
        asked = [(d["face"], d["index"], d.get("phase", "")) for d in report[f"{kind}s"]]
        assert sorted(shown) == sorted(asked)
        places_shown = sorted(tuple(e.matrix_world.translation) for e in found)
        places_asked = sorted(tuple(d["position"]) for d in report[f"{kind}s"])
        np.testing.assert_allclose(places_shown, places_asked, atol=1e-5)
    singularity = attribute(obj, "synch_singularity")
    assert len(marks["disclination"]) == np.count_nonzero(singularity)
    for empty in marks["disclination"]:
        assert singularity[empty["synch_face"]] == empty["synch_index"]
        assert "synch_phase" not in empty and "1/4" in empty.name
    assert {e["synch_phase"] for e in marks["dislocation"]} == {"x", "y"} or build is sphere
    for axis in "xy":
        numbers = attribute(obj, f"synch_index_{axis}"), optional(obj, f"synch_index_{axis}_2")
        # Where a quad holds both, the rim values of the disclination carry the dislocation too.
        mine = [e for e in marks["dislocation"] if e["synch_phase"] == axis and not singularity[e["synch_face"]]]
        assert len(mine) == sum(np.count_nonzero(n) for n in numbers)
        for empty in mine:
            assert empty["synch_index"] in [n[empty["synch_face"]] for n in numbers]
            assert empty.name.startswith(f"dislocation {axis} ")


# Settings


@pytest.mark.parametrize("symmetry", ["vector", "line", "cross"])
def test_quads_have_the_symmetry_of_a_cross_whatever_is_set(symmetry):
    obj = sphere()
    report = api.quads(obj, spacing=0.5, symmetry=symmetry)
    assert report["settings"]["symmetry"] == "cross" and len(report["disclinations"]) == 8
    found = values(obj)
    api.quads(obj, spacing=0.5)
    assert values(obj) == found


@pytest.mark.parametrize("command", ["stripes", "directions"])
def test_aspect_and_smoothing_are_of_quads_alone(command):
    obj = sphere()
    run = getattr(api, command)
    run(obj, spacing=0.5)
    found = values(obj)
    run(obj, spacing=0.5, aspect=3.0, smoothing=9)
    assert values(obj) == found


REFUSALS = {
    "aspect on a sphere": ({"aspect": 2.0}, "never change places"),
    "aspect of zero": ({"aspect": 0.0}, "the aspect is 0"),
    "spacing beyond the object": ({"spacing": 99.0}, "larger than the object"),
    "phases of an attribute": (
        {"constraints": [{"where": "attribute", "what": "phase", "name": "phases"}]},
        "one phase a vertex, and quads have two",
    ),
    "no boundary": ({"boundary": "phase"}, "has no boundary"),
    "missing map": ({"spacing_map": "absent"}, "no attribute 'absent'"),
    "missing guide": ({"guidance": "attribute:absent"}, "no attribute 'absent'"),
}


@pytest.mark.parametrize("command", ["quads", "quad_mesh"])
@pytest.mark.parametrize("name", REFUSALS)
def test_what_cannot_be_is_refused_in_one_line_and_nothing_is_written(name, command):
    settings, reason = REFUSALS[name]
    obj = sphere()
    obj.data.attributes.new("phases", "FLOAT", "POINT")
    before = snapshot()
    with pytest.raises(SynchError) as refusal:
        getattr(api, command)(obj, **({"spacing": 0.5} | settings))
    assert reason in str(refusal.value)
    assert "\n" not in str(refusal.value) and ":" in str(refusal.value), "one line: what is wrong, what to do"
    assert snapshot() == before and not obj.hide_render and not obj.hide_get()


def test_phases_of_an_attribute_do_not_hinder_directions():
    obj = grid()
    obj.data.attributes.new("phases", "FLOAT", "POINT")
    report = api.directions(
        obj, symmetry="cross", constraints=[{"where": "attribute", "what": "phase", "name": "phases"}]
    )
    assert report["status"] == "certified"


def test_stripes_of_a_cross_are_refused():
    with pytest.raises(SettingError, match="stripes need a vector or line field"):
        api.stripes(sphere(), symmetry="cross")


@pytest.mark.parametrize("command", ["quads", "quad_mesh"])
def test_vertices_of_a_contradiction_are_selected(command):
    obj = grid()
    add_group(obj, "left", [5, 6])
    add_group(obj, "right", [6, 7])
    for name, phase in (("left", 0.0), ("right", 1.0)):
        add_row(obj, where="GROUP", what="PHASE", vertex_group=name, phase=phase)
    with pytest.raises(RuntimeError, match="fix vertex 6 to different phases"):
        getattr(bpy.ops.synch, command)(spacing=0.5)
    assert [v.index for v in obj.data.vertices if v.select] == [6]
    assert not written(obj) and len(bpy.data.objects) == 1


@pytest.mark.parametrize("command", ["quads", "quad_mesh"])
def test_a_mesh_that_is_no_surface_is_refused_when_strict(command):
    obj = sphere()
    obj.data.polygons[0].flip()
    before = snapshot()
    with pytest.raises(MeshError):
        getattr(api, command)(obj, spacing=0.5, strict=True)
    assert snapshot() == before
