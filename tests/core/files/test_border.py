# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The border for data from outside: one line for whatever they raise, and no allocation of what they only promise."""

import base64
import json
import struct
import tracemalloc
import zlib
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

from synch_fields.core import memory
from synch_fields.core.errors import ContradictionError, MeshError, SettingError, SynchError
from synch_fields.core.files.border import border, text_numbers
from synch_fields.core.files.directions import read_field
from synch_fields.core.files.flows import flow_file
from synch_fields.core.files.json_text import NUMBER, json_text, read_kept_dict
from synch_fields.core.files.meshes import check_glb
from synch_fields.core.files.solid_vectors import read_vectors
from synch_fields.core.files.tets import read_tets
from synch_fields.core.memory import Room
from synch_fields.core.printing.machine import read_machine


def raised(error):
    raise error


@pytest.mark.parametrize(
    "error",
    [
        *(ValueError("two\nlines"), TypeError("t"), KeyError("k"), IndexError("i"), OverflowError("o")),
        *(RecursionError("r"), struct.error("s"), zlib.error("z"), MemoryError(), np.linalg.LinAlgError("l")),
        *(OSError(2, "No such file"), EOFError(), UnicodeDecodeError("ascii", b"\xff", 0, 1, "ordinal")),
    ],
    ids=lambda error: type(error).__name__,
)
def test_what_damaged_data_raises_is_one_line_with_a_remedy(error):
    with pytest.raises(SettingError) as caught, border("some/file.txt", "write it anew"):
        raised(error)
    line = str(caught.value)
    assert line.startswith("some/file.txt") and "\n" not in line
    assert line.endswith(("write it anew", "check the path"))


def test_errors_of_ours_stay_what_they_are_and_get_the_source_once():
    with pytest.raises(MeshError, match=r"^outer\.txt: thin$") as caught, border("outer.txt"):
        raise MeshError("thin", [3])
    assert caught.value.vertices.tolist() == [3]
    with pytest.raises(SettingError, match=r"^inner\.txt: thin$"), border("outer.txt"), border("inner.txt"):
        raise SettingError("thin")
    with pytest.raises(ContradictionError, match=r"^vertex 1 twice$"), border("outer.txt"):
        raise ContradictionError("{vertices} twice", [1])


def test_faults_that_data_do_not_cause_are_not_swallowed():
    for error in (AssertionError("ours"), KeyboardInterrupt()):
        with pytest.raises(type(error)), border("some/file.txt"):
            raise error


def test_numbers_of_a_text_are_made_in_parts(monkeypatch):
    monkeypatch.setattr("synch_fields.core.files.border._AT_ONCE", 5)
    numbers = np.arange(1000.0) / 7
    np.testing.assert_array_equal(text_numbers("  ".join(map(repr, numbers.tolist())) + "\n"), numbers)
    assert text_numbers(" \n ").size == 0
    with pytest.raises(ValueError):
        text_numbers("1 2 three 4 5 6 7 8")


# Files that promise much: what writes one of each kind, and what reads it.


def npz(path, **arrays):
    """A compressed archive: zeros take a thousandth of their size."""
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w") as file:
                np.lib.format.write_array(file, np.asarray(array))
    return path


def large_velocity(folder):
    return npz(folder / "flow.npz", velocity=np.zeros((160, 160, 160, 3)))


def vtu_piece(folder, points, cells, array):
    path = folder / "solid.vtu"
    path.write_text(
        '<VTKFile type="UnstructuredGrid" compressor="vtkZLibDataCompressor" byte_order="LittleEndian">'
        "<UnstructuredGrid>"
        f'<Piece NumberOfPoints="{points}" NumberOfCells="{cells}"><Points>{array}</Points><Cells/></Piece>'
        "</UnstructuredGrid></VTKFile>"
    )
    return path


def many_points(folder):
    return vtu_piece(folder, 10**13, 1, '<DataArray type="Float64" format="ascii">0 0 0</DataArray>')


def glb(folder):
    text = json.dumps({"accessors": [{"count": 10**12, "type": "VEC3"}]}).encode()
    path = folder / "mesh.glb"
    path.write_bytes(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON") + text)
    return path


def wide_field(folder):
    path = folder / "field.rawfield"
    path.write_text("9999999999 1\n1 0 0\n")
    return path


def long_mesh(folder):
    path = folder / "solid.mesh"
    path.write_text("MeshVersionFormatted 1\nDimension 3\nVertices\n999999999999\n0 0 0 0\nTetrahedra\n1\n1 2 3 4 0\n")
    return path


def long_sol(folder):
    long_mesh(folder).write_text(
        "MeshVersionFormatted 1\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
        "Tetrahedra\n1\n1 2 3 4 0\n"
    )
    path = folder / "solid.sol"
    path.write_text("MeshVersionFormatted 1\nDimension 3\nSolAtVertices\n999999999999\n1 2\n1 2 3\n")
    return path


def read_flow(path):
    return flow_file(path).read()


BOMBS = {
    "velocity": (large_velocity, read_flow),
    "points": (many_points, read_tets),
    "accessors": (glb, check_glb),
    "vectors": (wide_field, read_field),
    "rows": (long_mesh, read_tets),
    "values": (long_sol, read_vectors),
}


@pytest.mark.parametrize("name", BOMBS)
def test_what_is_only_promised_is_refused_before_it_is_allocated(name, tmp_path, monkeypatch):
    """On a machine that has 50 MB left."""
    write, read = BOMBS[name]
    path = write(tmp_path)
    monkeypatch.setattr(memory, "room", lambda reserved=1.0: Room(5e7, 1.0, "memory", "use a machine with more"))
    tracemalloc.start()
    with pytest.raises(SynchError) as caught:
        read(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
    assert peak < 5_000_000


def test_arrays_that_a_flow_does_not_use_are_not_read(tmp_path):
    velocity = np.random.default_rng(0).standard_normal((4, 4, 4, 3))
    path = npz(tmp_path / "flow.npz", velocity=velocity, pressure=np.zeros(5_000_000), spacing=0.5)
    tracemalloc.start()
    flow = read_flow(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    np.testing.assert_array_equal(flow.velocity, velocity.reshape(-1, 3))
    assert peak < 2_000_000


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"spacing": np.zeros(3_000_000)}, "spacing is of the shape"),
        ({"solid": np.zeros((300, 300, 300), bool)}, "solid has bool values of the shape"),
    ],
)
def test_large_arrays_in_the_place_of_small_ones_are_not_read(tmp_path, arrays, words):
    path = npz(tmp_path / "flow.npz", velocity=np.ones((4, 4, 4, 3)), **arrays)
    tracemalloc.start()
    with pytest.raises(SettingError, match=words):
        read_flow(path)
    assert tracemalloc.get_traced_memory()[1] < 2_000_000
    tracemalloc.stop()


def test_blocks_of_zeros_beyond_the_points_are_not_unpacked(tmp_path):
    """A .vtu that promises one point, and has a hundred megabytes of zeros in its blocks."""
    bomb = zlib.compress(bytes(1_000_000))
    head = np.array([100, 1_000_000, 0, *[len(bomb)] * 100], "<u4").tobytes()
    text = (base64.b64encode(head) + base64.b64encode(100 * bomb)).decode()
    path = vtu_piece(tmp_path, 1, 1, f'<DataArray type="Float64" format="binary">{text}</DataArray>')
    tracemalloc.start()
    with pytest.raises(SettingError, match="100 blocks of 1000000 bytes where 24 bytes are promised"):
        read_tets(path)
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("feed = 1" + "0" * 5000, "digits"),
        ("feed = " + "[" * 100_000, "nested too deeply|cannot be read"),
        ("feed = 1e999", "the feed is inf"),
        ("feed = nan", "the feed is nan"),
        ("feed = '1200'", "give a number"),
        ("feed = 1979-05-27", "give a number"),
        ("start = '\x00'", "cannot be read"),
    ],
)
def test_spoilt_machines_are_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "machine.toml"
    path.write_text(text)
    with pytest.raises(SettingError, match=words) as caught:
        read_machine(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_json_has_null_where_a_number_is_not_finite():
    report = {"a": np.nan, "b": [np.float32(np.inf), 1.5], "c": np.array([1.0, -np.inf]), "d": (np.int64(3), True)}
    assert json.loads(json_text(report)) == {"a": None, "b": [None, 1.5], "c": [1.0, None], "d": [3, True]}


VALUES = {"command": ("", str), "energy": (None, NUMBER), "spread": (None, {"low": NUMBER, "ends": [NUMBER] * 2})}


def test_kept_values_come_back_with_defaults():
    found = read_kept_dict('{"command": "stripes", "spread": {"low": 1, "ends": [0, 2.5]}}', "what Body keeps", VALUES)
    assert found == {"command": "stripes", "energy": None, "spread": {"low": 1, "ends": [0, 2.5]}}
    assert read_kept_dict("", "what Body keeps", VALUES) == {}


@pytest.mark.parametrize(
    "text",
    [
        *("x", "[]", "null", "1" * 5000, "{" * 5000, "[" * 100_000, '{"command": 5}', '{"command": null}'),
        *('{"energy": NaN}', '{"energy": true}', '{"energy": "1"}', '{"spread": []}', '{"spread": {"low": 1}}'),
        '{"spread": {"low": 1, "ends": [1, 2, 3]}}',
    ],
)
def test_spoilt_kept_values_are_refused_in_one_line(text):
    with pytest.raises(SettingError, match=r"^what Body keeps cannot be read .*: solve it again$") as caught:
        read_kept_dict(text, "what Body keeps", VALUES)
    assert "\n" not in str(caught.value)
