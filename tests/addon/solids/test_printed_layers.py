# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that are printed: a machine's program, what lies on air, half a layer of offset, groups that a file names."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.solids import memory

from ...core.layered_solids import block as solid_block
from ..solid_objects import SPACING, block, in_world


def test_a_program_leads_to_the_paths_of_its_machine(layered, tmp_path):
    """The middle of the part stands where the machine says, its lowest place on the bed, in its millimetres."""
    (tmp_path / "printer.toml").write_text("scale = 100\nbed_x = 50\nbed_y = 60\nstart = ''\nretraction = 0\n")
    report = api.layer_toolpaths(layered, 0.2, path=tmp_path / "part.gcode", machine=tmp_path / "printer.toml")
    moves = [line for line in (tmp_path / "part.gcode").read_text().splitlines() if line.startswith("G1")]
    at = np.array([[float(word[1:]) for word in line.split()[1:4]] for line in moves])
    extruded = sum(float(line.split("E")[1].split()[0]) for line in moves)
    world = in_world(layered, memory.recall_layers(layered).solid.vertices)
    low, high = world.min(axis=0), world.max(axis=0)
    middle = np.append((low + high)[:2] / 2, low[2])
    assert (at >= 100 * (low - middle) + [50, 60, 0] - 1e-2).all()
    assert (at <= 100 * (high - middle) + [50, 60, 0] + 1e-2).all()
    # Beads as wide as the step and as high as the layers fill them.
    rows = np.loadtxt(path_table(layered, tmp_path), delimiter=",", skiprows=1)
    steps = np.linalg.norm(np.diff(rows[:, 2:5], axis=0), axis=1) * (np.diff(rows[:, 1]) == 0)
    sections = rows[:, 8] * rows[:, 9]
    volume = (steps * (sections[1:] + sections[:-1]) / 2).sum()
    assert extruded * np.pi * 1.75**2 / 4 == pytest.approx(100**3 * volume, rel=0.01)
    assert report["covered"] > 0.99 and report["machine"]["scale"] == 100
    assert report["heights"]["high"] == pytest.approx(SPACING, rel=1e-3)
    assert report["tilts"]["high"] == pytest.approx(np.degrees(np.arccos(np.cos(0.3) * np.cos(0.2))), abs=0.1)


def path_table(obj, folder):
    api.layer_toolpaths(obj, 0.2, path=folder / "paths.csv")
    return folder / "paths.csv"


def test_what_lies_on_air_is_listed_and_drawn(layered):
    """A tilted block stands on a corner: its lowest layer is on air but there."""
    report = api.layer_toolpaths(layered, 0.2)
    flaws = bpy.data.collections[report["collection"]].objects["Block Overhangs"]
    points = np.array([point.co[:3] for spline in flaws.data.splines for point in spline.points])
    low = in_world(layered, memory.recall_layers(layered).solid.vertices)[:, 2].min()
    assert report["overhangs"]["pieces"] == len(flaws.data.splines) > 0
    assert in_world(layered, points)[:, 2].max() > low + SPACING / 2
    assert any("lie on air" in line for line in report["warnings"])
    first = report["overhangs"]["places"][0]
    assert first["layer"] == 0 and first["share"] <= report["overhangs"]["share"] < 0.6


def test_a_group_may_lie_half_a_layer_above_the_last_bead():
    obj = block()
    for text, gap in (("Top=layer", 0.0), ("Top=layer:0.5", SPACING / 2), ("Top=layer:0.25", SPACING / 4)):
        api.layers(obj, guidance="axis:Z", groups=text, spacing=SPACING, size=0.15)
        surfaces = memory.recall_layers(obj).surfaces
        assert 0.5 - surfaces.vertices[:, 2].max() == pytest.approx(gap, abs=1e-6)
    for text in ("Top=layer:1", "Top=layer:-0.5", "Top=layer:half", "Top=constant:0.5", "Top=layer:nan"):
        with pytest.raises(SettingError, match=r"offset .* of the group 'Top'"):
            api.layers(obj, groups=text)


def test_references_of_a_file_are_groups_of_the_command(tmp_path, capfd):
    """A bar of tetrahedra whose ends have the references 1 and 2: layers from one to the other, flush with both."""
    mesh = solid_block((4, 4, 8), (0.5, 0.5, 1.0))
    triangles = mesh.boundary_triangles
    heights = mesh.vertices[triangles][:, :, 2]
    marks = np.where((heights == 0).all(axis=1), 1, np.where((heights == 1).all(axis=1), 2, 0))
    lines = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(mesh.vertex_count)]
    lines += [" ".join(map(repr, place)) + " 0" for place in mesh.vertices.tolist()]
    lines += ["Triangles", str(len(triangles))]
    lines += [f"{a} {b} {c} {mark}" for (a, b, c), mark in zip((triangles + 1).tolist(), marks, strict=True)]
    lines += ["Tetrahedra", str(mesh.tet_count)]
    lines += [" ".join(map(str, tet)) + " 0" for tet in (mesh.tets + 1).tolist()]
    (tmp_path / "bar.mesh").write_text("\n".join([*lines, "End", ""]))
    run = ["layers", str(tmp_path / "bar.mesh"), "--guidance", "harmonic:ref_1:ref_2", "--spacing", "0.25", "--quiet"]
    assert main.main([*run, "--groups", "ref_1=layer,ref_2=layer"]) == 0, capfd.readouterr().err
    assert "5 layers, 0.25 apart on average" in capfd.readouterr().out
    assert main.main([*run, "--groups", "ref_7=layer"]) == 1 and "no vertex group 'ref_7'" in capfd.readouterr().err
