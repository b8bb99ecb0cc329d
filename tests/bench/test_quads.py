# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of quad meshes: what it makes again and what it keeps, how it compares, and other programs' meshes."""

import json
import sys
from concurrent.futures.process import BrokenProcessPool
from types import SimpleNamespace

import pytest

from synch_fields.bench import quads
from synch_fields.bench.meshes import write_obj
from synch_fields.bench.quads import OURS, Table, print_comparison, read_setting
from synch_fields.core.geometry import TriangleMesh

FIGURES = {
    "quad_share": 1.0,
    "other_faces": 0,
    "irregular_on_rim": 2,
    "irregular_vertices": 8,
    "angle_deviation": 4.0,
    "worst_angle": 60.0,
    "reflex_corners": 0,
    "turned_faces": 0,
    "length_spread": 0.1,
    "distance": 0.01,
    "euler_characteristic": 2,
    "given_characteristic": 2,
    "closed": True,
    "given_closed": True,
    "manifold": "yes",
    "seconds": 1.0,
}


@pytest.fixture
def made(monkeypatch):
    """What was made, as (maker, asked), by makers that give 100 faces or as many as they are asked for."""
    calls = []
    state = SimpleNamespace(calls=calls, faces=100, dies=False)

    def in_child(_work, maker, _path, _limit, *rest):
        if state.dies:
            raise BrokenProcessPool
        faces = state.faces if maker == "our_row" else rest[0]
        calls.append((maker, faces))
        return FIGURES | {"faces": faces, "asked": faces}

    monkeypatch.setattr(quads, "in_child", in_child)
    return state


def table(rows, again=(), methods=(OURS, "QuadriFlow"), peer=()):
    return Table(SimpleNamespace(rows=rows, again=again, methods=methods, peer=peer, set=[], keep=None, limit=1))


def test_rows_are_kept_in_the_file_and_not_made_again(made, tmp_path):
    file = tmp_path / "rows.jsonl"
    table(file).add("cube", "cube.obj", None)
    assert made.calls == [("our_row", 100), ("quadriflow_row", 100)]
    again = table(file, peer=["other=run {input} {output}"])
    again.add("cube", "cube.obj", None)
    assert made.calls[2:] == [("command_row", 100)]
    assert [row["method"] for row in again.rows()] == [OURS, "QuadriFlow", "other"]
    assert [json.loads(line)["method"] for line in file.read_text().splitlines()] == [OURS, "QuadriFlow", "other"]


def test_the_others_follow_our_number_of_faces(made, tmp_path):
    file = tmp_path / "rows.jsonl"
    table(file, peer=["other=run"]).add("cube", "cube.obj", None)
    made.faces = 120
    later = table(file, again=[OURS])
    later.add("cube", "cube.obj", None)
    assert made.calls[3:] == [("our_row", 120), ("quadriflow_row", 120)]
    # The other program's row is of another number of faces, and there is no command to make it anew.
    assert [(row["method"], row["faces"]) for row in later.rows()] == [(OURS, 120), ("QuadriFlow", 120)]


def test_a_process_that_dies_leaves_a_row_that_says_so(made, tmp_path):
    made.dies = True
    found = table(tmp_path / "rows.jsonl")
    found.add("cube", "cube.obj", None)
    (row,) = found.rows()
    assert "crashed" in row["fails"] and "faces" not in row


def test_the_comparison_counts_meshes_that_both_have(capsys):
    own = {"method": OURS, "asked": 100, "faces": 104} | FIGURES
    other = {"method": "QuadriFlow", "asked": 104, "faces": 104} | FIGURES
    rows = [
        {"mesh": "a"} | own,
        {"mesh": "a"} | other | {"worst_angle": 50.0, "euler_characteristic": 0},
        {"mesh": "b"} | own | {"other_faces": 3, "quad_share": 0.9, "faces": 110},
        {"mesh": "b"} | other | {"irregular_vertices": 9},
        {"mesh": "c"} | own,
        {"mesh": "c", "method": "QuadriFlow", "fails": "why"},
    ]
    print_comparison(rows)
    shares = dict(line.strip("| ").split(" | ") for line in capsys.readouterr().out.splitlines() if " of " in line)
    assert shares["nothing but quads"] == "2 of 3 (67%)"
    assert shares["face count within 5% of what was asked"] == "2 of 3 (67%)"
    assert shares["irregular vertices"] == shares["Hausdorff distance"] == "2 of 2 (100%)"
    assert shares["worst corner"] == shares["share of other faces"] == "1 of 2 (50%)"
    assert shares["their mesh keeps what is given"] == "1 of 2 (50%)"


@pytest.mark.parametrize(
    ("text", "value"), [("a=0", 0), ("a=0.5", 0.5), ("a=true", True), ("a=X=Y", "X=Y"), ("a={faces}", "{faces}")]
)
def test_settings_are_numbers_where_they_can_be(text, value):
    assert read_setting(text) == ("a", value)


def test_another_program_is_asked_again_until_it_is_near(tmp_path):
    """One that makes a strip of four times as many squares as it is asked for."""
    program = tmp_path / "program.py"
    program.write_text(
        "import sys\n"
        "source, target, faces = sys.argv[1:]\n"
        "count = 4 * int(faces)\n"
        "assert 'f ' in open(source).read()\n"
        "with open(target, 'w') as file:\n"
        "    for k in range(count + 1):\n"
        "        file.write(f'v {k / count} 0 0\\nv {k / count} 1 0\\n')\n"
        "    for k in range(1, 2 * count, 2):\n"
        "        file.write(f'f {k}//1 {k + 2}//1 {k + 3}//1 {k + 1}//1\\n')\n"
    )
    path = tmp_path / "square.obj"
    write_obj(TriangleMesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]), path)
    command = f"{sys.executable} {program} {{input}} {{output}} {{faces}}"
    row = quads.made("command_row", str(path), 60, 40, command)
    assert (row["faces"], row["asked"], row["quad_share"]) == (40, 40, 1.0)
    assert row["distance"] == pytest.approx(0, abs=1e-7) and row["manifold"] == "yes"
    failed = quads.made("command_row", str(path), 60, 40, f"{sys.executable} -c 1/0")
    assert failed == {"fails": "exit status 1", "asked": 40}
