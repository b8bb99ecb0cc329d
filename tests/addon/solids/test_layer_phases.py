# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The phase of layers on the surface: on the given mesh where it is fine enough, else on the solid's own boundary."""

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from synch_fields.core.geometry.tet_mesh import TetMesh
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.defect_empties import defect_empties
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.solids.memory import recall_layers

from ...core.solids import block as tetrahedra
from ..rebuilt_pattern import largest_jump
from ..scenes import add_object, attribute, empties, make_active, quad_sphere, snapshot, sphere
from ..solid_objects import bent_bar, block, layers_of, made


@pytest.mark.parametrize("build", [lambda: sphere(4), lambda: quad_sphere(15)])
def test_a_fine_mesh_carries_the_phase_itself(build):
    obj = build()
    obj.scale = (1, 1, 1.5)
    report = api.layers(obj, spacing=0.5, size=0.2)
    assert report["surface_object"] == obj.name
    heights = 1.5 * attribute(obj, "position")[:, 2]
    phases = attribute(obj, "synch_vertex_phase") - 2 * np.pi * heights / 0.5
    np.testing.assert_allclose(np.exp(1j * (phases - phases[0])), 1, atol=1e-4)
    level = np.mean([places[:, 2].mean() / 0.5 % 1 for places in layers_of(made(report))])
    np.testing.assert_allclose(np.exp(1j * (phases + 2 * np.pi * level)), 1, atol=1e-3)
    jump, compared = largest_jump(obj)
    assert compared > 1000 and jump < 1e-4
    assert [slot.material.name for slot in obj.material_slots] == ["Synch Stripes"]


def test_a_coarse_mesh_is_left_alone_and_the_solids_boundary_carries_the_phase():
    obj = block(faces=(1, 1, 1))
    report = api.layers(obj, guidance="axis:X", spacing=0.2, size=0.09)
    shown = made(report, "surface")
    assert shown != obj and shown.hide_get() and not [a for a in obj.data.attributes if a.name.startswith("synch_")]
    layering = recall_layers(obj)
    assert len(shown.data.polygons) == len(layering.solid.boundary_faces)
    phases = attribute(shown, "synch_vertex_phase") - 2 * np.pi * attribute(shown, "position")[:, 0] / 0.2
    np.testing.assert_allclose(np.exp(1j * (phases - phases[0])), 1, atol=1e-4)


@pytest.mark.parametrize("faces", [(1, 1, 1), (24, 6, 12)])
def test_dislocations_of_the_surface_are_the_ends_of_the_curves(faces):
    """Inside, around a curve's end, and on the surface the phase turns as often."""
    obj = bent_bar(faces=(16, 4, 8) if faces == (1, 1, 1) else faces)
    report = api.layers(obj, guidance="harmonic:Begin:End", spacing=0.22, size=0.1, seed=1)
    shown = made(report, "surface")
    jump, _ = largest_jump(shown)
    assert jump < 1e-3
    ends = [empty["synch_index"] for empty in empties(made(report), "dislocation")]
    found = attribute(shown, "synch_index").sum()
    assert found == sum(ends) == 0
    if shown != obj:
        assert np.abs(attribute(shown, "synch_index")).sum() == len(ends) > 0


def test_an_earlier_field_of_the_surface_goes():
    obj = sphere(4)
    api.stripes(obj, spacing=0.3)
    assert defect_empties(obj) and "synch_direction" in obj.data.attributes and obj.synch.result
    api.layers(obj, spacing=0.5, size=0.2)
    assert not defect_empties(obj) and "synch_direction" not in obj.data.attributes
    assert not obj.synch.result and not memory.holds(obj)


def test_undo_and_redo_are_exact():
    obj = make_active(sphere(4))
    bpy.ops.ed.undo_push(message="before")
    before = snapshot()
    assert bpy.ops.synch.layers(spacing=0.5, size=0.2) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="layers")
    after = snapshot()
    bpy.ops.ed.undo()
    assert snapshot() == before
    bpy.ops.ed.redo()
    assert snapshot() == after and obj is not None


def test_layers_in_edit_mode():
    block()
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.synch.layers(spacing=0.3, size=0.14) == {"FINISHED"}
    assert bpy.context.active_object.name == "Block Layers" and bpy.context.mode == "OBJECT"


def test_tetrahedra_of_a_file_are_taken_as_they_are(tmp_path):
    solid = tetrahedra((5, 5, 5))
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(solid.vertex_count)]
    lines += [f"{x} {y} {z} 0" for x, y, z in solid.vertices.tolist()]
    lines += ["Tetrahedra", str(solid.tet_count), *(f"{a} {b} {c} {d} 0" for a, b, c, d in (solid.tets + 1).tolist())]
    (tmp_path / "block.mesh").write_text("\n".join([*lines, "End"]))
    report, blend = tmp_path / "report.json", tmp_path / "out.blend"
    arguments = ["layers", str(tmp_path / "block.mesh"), "--guidance=axis:Y", "--spacing=0.5", "--quiet"]
    assert (
        main.main([*arguments, f"--report={report}", f"--output={blend}", f"--export-mesh={tmp_path / 'l.stl'}"]) == 0
    )
    assert bpy.data.objects["block Layers"] and blend.is_file() and (tmp_path / "l.stl").stat().st_size > 1000
    layering = recall_layers(bpy.data.objects["block"])
    assert layering.solid.tet_count == solid.tet_count and layering.pattern.solution.energy < 1e-12
    assert main.main(["layers", str(tmp_path / "none.mesh"), "--quiet"]) == 1
    assert main.main(["layers", str(tmp_path / "block.mesh"), "--guidance=axis:Q", "--quiet"]) == 1


def test_tetrahedra_far_from_the_origin_have_their_groups():
    """Blender rounds the coordinates of their boundary."""
    solid = tetrahedra((5, 5, 5))
    turn = Rotation.from_rotvec([0.3, 0.5, 0.2]).as_matrix()
    far = TetMesh(solid.vertices @ turn.T + [100.1, 60.7, 30.3], solid.tets)
    boundary = far.boundary_surface[0]
    obj = make_active(add_object(boundary.vertices, boundary.triangles))
    api.layers(obj, solid=far, guidance="distance:boundary", groups="boundary=layer", spacing=0.4)
    phases = recall_layers(obj).pattern.vertex_phases
    np.testing.assert_allclose(phases[far.boundary_vertices], 0, atol=1e-12)
