# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers that are printed: a machine's program, what lies on air, half a layer of offset, groups that a file names."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.printing.machine import MACHINES, read_machine
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.operators import layer_files
from synch_fields.synch_addon.solids import memory
from synch_fields.synch_addon.solids.report import headline, program_line

from ...core.layered_solids import block as solid_block
from ..scenes import make_active
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
    assert report["covered"] > 0.95 and report["machine"]["scale"] == 100
    assert report["heights"]["high"] == pytest.approx(SPACING, rel=1e-3)
    assert report["tilts"]["high"] == pytest.approx(np.degrees(np.arccos(np.cos(0.3) * np.cos(0.2))), abs=0.1)


@pytest.mark.parametrize(("wide", "is_narrow"), [(0.115, True), (0.2, False)])
def test_beads_narrower_than_the_nozzle_are_told(tmp_path, wide, is_narrow):
    """A long wall has one bead of its width; a nozzle of 0.22 lays down to three fifths of that."""
    (tmp_path / "printer.toml").write_text("bore = 0.22\nlargest_height = 1\n")
    obj = block((wide, 3, 1))
    api.layers(obj, spacing=0.2, size=0.06)
    report = api.layer_toolpaths(obj, machine=tmp_path / "printer.toml")
    assert 0.7 < report["too_narrow"] <= 1 if is_narrow else report["too_narrow"] < 0.01
    told = [line for line in report["warnings"] if "narrower than 0.13 mm" in line]
    assert len(told) == is_narrow and not any("take contours" in line for line in report["warnings"])


@pytest.mark.parametrize(("scale", "is_small"), [(1, True), (1000, False)])
def test_a_part_of_metres_is_told_to_be_small_in_millimetres(layered, tmp_path, scale, is_small):
    (tmp_path / "printer.toml").write_text(f"scale = {scale}\nbore = 0.4\n")
    report = api.layer_toolpaths(layered, 0.2, machine=tmp_path / "printer.toml")
    assert any("set scale" in line for line in report["warnings"]) == is_small


@pytest.mark.parametrize(("machine", "filament"), [("clay", False), ("marlin", True)])
def test_the_volume_that_is_extruded_is_told(machine, filament):
    """2 m of filament of 1.75 mm are 4.81 cubic centimetres; of clay 2000 mm are 2 of these."""
    facts = {"seconds": 60.0, "filament": 2000.0}
    line = program_line({"program": facts, "machine": vars(read_machine(machine))})
    assert ("2.00 m of filament, 4.81 cm³" in line) == filament and line.endswith("4.81 cm³" if filament else ", 2 cm³")


def path_table(obj, folder):
    api.layer_toolpaths(obj, 0.2, path=folder / "paths.csv")
    return folder / "paths.csv"


def test_beads_that_no_nozzle_lays_are_told_with_a_step_that_it_does(layered, tmp_path):
    """Beads of 1.6 mm once came from a nozzle of 0.4 mm without a word."""
    (tmp_path / "printer.toml").write_text("scale = 8\nbore = 0.4\nlargest_height = 9\n")
    report = api.layer_toolpaths(layered, 0.2, machine=tmp_path / "printer.toml")
    (line,) = [line for line in report["warnings"] if "do not come from a nozzle" in line]
    assert line.startswith("beads of 1.6 mm do not come from a nozzle of 0.4 mm: give a step of 0.05")
    step = float(line.split("give a step of ")[1].split(",")[0])
    told = api.layer_toolpaths(layered, step, machine=tmp_path / "printer.toml")["warnings"]
    assert not any("do not come from a nozzle" in line for line in told)


@pytest.mark.parametrize(
    ("limits", "remedy"),
    [
        (
            "smallest_height = 0.01\nlargest_height = 0.1",
            "take a smaller spacing, or give the layers a largest height where they have none",
        ),
        (
            "smallest_height = 8\nlargest_height = 9",
            "take a larger spacing, or give the layers a smallest height where they have none",
        ),
    ],
)
def test_beads_outside_the_heights_of_a_machine_are_told_with_a_remedy(layered, tmp_path, limits, remedy):
    """The machine has a limit wherever this is said: to give one is no advice where the layers have it, too."""
    (tmp_path / "printer.toml").write_text(limits)
    told = api.layer_toolpaths(layered, 0.2, machine=tmp_path / "printer.toml")["warnings"]
    (line,) = [line for line in told if "than the nozzle's" in line]
    assert line.endswith(remedy)


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


def test_layers_keep_to_the_heights_of_the_machine(tmp_path, capfd):
    """In a block of one unit between two groups three layers fit best; the nozzle lays at most 30 of 100 mm."""
    make_active(block())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "block.blend"))
    (tmp_path / "printer.toml").write_text("scale = 100\nsmallest_height = 10\nlargest_height = 30\n")
    report = tmp_path / "report.json"
    run = ["layers", str(tmp_path / "block.blend"), "--quiet", "--size", "0.15", "--groups", "Bottom=layer,Top=layer"]
    run += ["--machine", str(tmp_path / "printer.toml"), "--report", str(report), "--spacing"]
    assert main.main([*run, "0.3"]) == 0
    found = json.loads(report.read_text())
    assert found["settings"]["largest_height"] == pytest.approx(0.3) and found["outside_limits"] == 0
    assert found["spacings"]["mean"] == pytest.approx(0.25, rel=1e-3)
    # Flags go before the machine.
    assert main.main([*run, "0.33", "--largest-height", "0.5"]) == 0
    found = json.loads(report.read_text())
    assert found["spacings"]["mean"] == pytest.approx(1 / 3, rel=1e-3)
    capfd.readouterr()
    assert main.main([*run, "0.4"]) == 1
    assert "the spacing 0.4 is not between the heights 0.1 and 0.3" in capfd.readouterr().err


def test_vectors_of_a_file_guide_layers(tmp_path, capfd):
    """A block's vectors lean by as much as its layers then do; of lines the signs do not count."""
    solid = solid_block((4, 4, 4))
    corners = " ".join(map(str, solid.tets.ravel().tolist()))
    lean = np.array([0.6, 0, 0.8])
    signs = np.random.default_rng(0).choice([-1.0, 1.0], solid.vertex_count)

    def array(name, kind, values, width=1):
        numbers = " ".join(map(str, np.ravel(values).tolist()))
        return (
            f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">{numbers}</DataArray>'
        )

    points = array("flow", "Float64", np.tile(lean, (solid.vertex_count, 1)), 3)
    points += array("stress", "Float64", signs[:, None] * lean, 3)
    cells = array("offsets", "Int64", 4 * np.arange(1, solid.tet_count + 1))
    cells += array("types", "UInt8", [10] * solid.tet_count) + array("connectivity", "Int64", corners.split())
    (tmp_path / "block.vtu").write_text(
        '<VTKFile type="UnstructuredGrid"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{solid.vertex_count}" NumberOfCells="{solid.tet_count}"><PointData>'
        f"{points}</PointData><Points>{array('Points', 'Float64', solid.vertices, 3)}</Points><Cells>{cells}</Cells>"
        "</Piece></UnstructuredGrid></VTKFile>"
    )
    for guidance in ("file:{}:flow", "lines:{}:stress"):
        guidance = guidance.format(f'"{tmp_path / "block.vtu"}"')
        report = tmp_path / "report.json"
        run = ["layers", str(tmp_path / "block.vtu"), "--guidance", guidance, "--spacing", "0.3", "--quiet"]
        assert main.main([*run, "--report", str(report)]) == 0, capfd.readouterr().err
        found = json.loads(report.read_text())
        assert found["energy"] < 1e-9 and found["continued_directions"] == 0
        places = np.array([v.co[:] for v in bpy.data.objects[found["layers_object"]].data.vertices]) @ lean
        off = (places - places[0]) / 0.3
        np.testing.assert_allclose(off, np.rint(off), atol=1e-4)
    assert main.main([*run[:3], f'file:"{tmp_path / "block.vtu"}":strain', "--quiet"]) == 1
    assert "it has flow on points, stress on points" in capfd.readouterr().err


def test_levels_of_two_towers_share_their_numbers(tmp_path):
    obj = block((1, 1, 1))
    other = block((1, 1, 0.5))
    other.location.x, other.location.z = 3, -0.25
    make_active(obj)
    with bpy.context.temp_override(active_object=obj, selected_editable_objects=[obj, other]):
        bpy.ops.object.join()
    reports = [
        api.layers(obj, spacing=0.2, size=0.09, groups="Bottom=layer:0.5", numbers=n) for n in ("pieces", "levels")
    ]
    assert [report["layers"] for report in reports] == [8, 5]
    assert [headline(report).split(",")[0] for report in reports] == ["5 layers in 8 pieces", "5 layers"]
    made = bpy.data.objects[reports[-1]["layers_object"]]
    files = api.layer_export(obj, tmp_path / "part.stl")["files"]
    assert len(files) == 5 and {v.value for v in made.data.attributes["synch_layer"].data} == set(range(5))
    with pytest.raises(SettingError, match="numbers 'rows' is unknown"):
        api.layers(obj, numbers="rows")


def test_a_machine_is_chosen_from_a_list(layered, tmp_path):
    """The shipped ones, files beside the .blend, and any other file; without a name the last is refused."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), copy=False)
    mine = tmp_path / "mine.toml"
    mine.write_text("bed_width = 300\nfeed = 777")
    listed = {item[0] for item in layer_files._list_machines(None, None)}
    assert listed == {*MACHINES, "AUTOMATIC", "FILE", "//mine.toml"}
    before = layer_files._list_machines(None, None)
    (tmp_path / "earlier.toml").write_text("bed_width = 200")
    assert set(before) < set(layer_files._list_machines(None, None))  # with the same numbers, which Blender keeps
    chosen = [{}, {"machine": "klipper"}, {"machine": "//mine.toml"}, {"machine": "FILE", "machine_file": str(mine)}]
    programs = []
    for number, machine in enumerate(chosen):
        path = tmp_path / f"part{number}.gcode"
        bpy.ops.synch.layer_path_export(filepath=str(path), step=0.4, **machine)
        programs.append(path.read_text())
    assert "F777" not in programs[0] and "F777" in programs[2] and programs[2] == programs[3]
    assert programs[0] != programs[1]
    with pytest.raises(RuntimeError, match="the machine's file has no name: choose the file"):
        bpy.ops.synch.layer_toolpaths(machine="FILE")
