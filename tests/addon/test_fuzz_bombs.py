# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that promise more than they hold, and texts that are nested or numbered without end: refused before memory is
allocated for them."""

import io
import json
import struct
import tempfile
import tracemalloc
import zlib
from base64 import b64encode
from contextlib import chdir
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from synch_fields.core.files.directions import read_field
from synch_fields.core.files.flows import flow_file
from synch_fields.core.files.meshes import check_glb, check_ply
from synch_fields.core.files.solid_vectors import read_vectors
from synch_fields.core.files.tets import read_tets
from synch_fields.core.printing.machine import read_machine
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.blender.openvdb import module_file

from .fuzz_cases import command_line, read_or_refused, st, tried
from .test_fuzz_outputs import write_inputs
from .vortex_scenes import write_vdb

# What reading a small file may take, in bytes of Python and NumPy.
MOST_BYTES = 50_000_000
COUNTS = st.sampled_from([-1, 0, 1, 8, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 1, 10**12, 2**63 - 1, 10**30])
DEPTHS = st.sampled_from([1, 900, 5000, 200_000])


def npy(shape, dtype, body):
    """The bytes of an array of NumPy whose header promises a shape."""
    header = repr({"descr": dtype, "fortran_order": False, "shape": tuple(shape)}).encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + body


@st.composite
def archives(draw):
    """A .npz file whose arrays have any shapes, and bodies of other lengths."""
    file = io.BytesIO()
    with ZipFile(file, "w", ZIP_DEFLATED) as archive:
        for name in draw(st.lists(st.sampled_from(["velocity", "spacing", "origin", "solid"]), unique=True)):
            shape = draw(st.lists(COUNTS, max_size=4)) + draw(st.sampled_from([[], [2], [3]]))
            body = bytes(draw(st.sampled_from([0, 24, 3 * 8 * 512, 10**6])))
            archive.writestr(f"{name}.npy", npy(shape, draw(st.sampled_from(["<f8", "|b1", "<U9", "|O"])), body))
    return file.getvalue()


@st.composite
def vtu_files(draw):
    """A .vtu file with any numbers of points and cells, and blocks of zeros."""
    blocks, size, last = draw(COUNTS), draw(COUNTS), draw(COUNTS)
    packed = zlib.compress(bytes(10**5))
    head = struct.pack("<4I", *(number % 2**32 for number in (blocks, size, last, len(packed))))
    text = (b64encode(head) + b64encode(packed)).decode()
    kind = draw(st.sampled_from(["ascii", "binary", "appended"]))
    compressor = draw(st.sampled_from(["", ' compressor="vtkZLibDataCompressor"']))
    array = f'<DataArray type="Float64" format="{kind}" offset="{draw(COUNTS)}">{text}</DataArray>'
    return (
        f'<VTKFile type="UnstructuredGrid"{compressor}><UnstructuredGrid><Piece NumberOfPoints="{draw(COUNTS)}" '
        f'NumberOfCells="{draw(COUNTS)}"><Points>{array}</Points></Piece></UnstructuredGrid></VTKFile>'
    ).encode()


@st.composite
def vti_files(draw):
    """A .vti file with any extent and offset, and blocks of zeros."""
    extent = " ".join(f"{draw(st.sampled_from([0, 1, -(2**31)]))} {draw(COUNTS)}" for _ in range(3))
    packed = zlib.compress(bytes(10**5))
    head = struct.pack("<4I", *(draw(COUNTS) % 2**32 for _ in range(3)), len(packed))
    kind = draw(st.sampled_from(["ascii", "binary", "appended"]))
    where = draw(st.sampled_from(["PointData", "CellData"]))
    compressor = draw(st.sampled_from(["", ' compressor="vtkZLibDataCompressor"']))
    return (
        f'<VTKFile type="ImageData"{compressor}><ImageData WholeExtent="{extent}"><Piece><{where}><DataArray '
        f'type="Float64" Name="velocity" NumberOfComponents="3" format="{kind}" offset="{draw(COUNTS)}">'
        f"{(b64encode(head) + b64encode(packed)).decode()}</DataArray></{where}></Piece></ImageData></VTKFile>"
    ).encode()


@st.composite
def netcdf_files(draw):
    """A .nc file of NetCDF 3 whose dimensions, and the sizes and places of whose variables, are any numbers."""

    def number():
        return struct.pack(">I", draw(COUNTS) % 2**32)

    def name(text):
        return struct.pack(">I", len(text)) + text.encode().ljust(4, b"\0")

    dimensions = b"".join(name(axis) + number() for axis in "zyx")
    shape = struct.pack(">4I", 3, 0, 1, 2)
    variables = b"".join(name(v) + shape + bytes(8) + struct.pack(">I", 6) + number() + number() for v in "uvw")
    return (
        b"CDF\1" + number() + struct.pack(">2I", 10, 3) + dimensions + bytes(8) + struct.pack(">2I", 11, 3) + variables
    ) + bytes(draw(st.sampled_from([0, 64, 10**5])))


@st.composite
def medit_files(draw):
    """A .mesh or .sol file with any counts."""
    values = draw(st.sampled_from(["SolAtVertices\n4\n1 2\n1 2 3\n", f"SolAtVertices\n{draw(COUNTS)}\n1 2\n1 2 3\n"]))
    return (
        f"MeshVersionFormatted 1\nDimension {draw(COUNTS)}\nVertices\n{draw(COUNTS)}\n0 0 0 0\n"
        f"Tetrahedra\n{draw(COUNTS)}\n1 2 3 4 0\n{values}End\n"
    ).encode()


def nested(depth, opening, closing):
    return (opening * depth + closing * depth).encode()


@st.composite
def json_files(draw):
    """JSON that is nested, or has numbers of thousands of digits."""
    depth, digits = draw(DEPTHS), draw(st.sampled_from([1, 300, 5000, 10**5]))
    kinds = [nested(depth, "[", "]"), nested(depth, '{"a":', "}"), b"[" + b"9" * digits + b"]"]
    return draw(
        st.sampled_from([*kinds, b'[{"kind": "pin", "vertex": ' + b"9" * digits + b"}]", b"[1e" + b"9" * 400 + b"]"])
    )


@st.composite
def glb_files(draw):
    """A .glb file whose accessors, views and chunks have any sizes."""
    accessor = {"count": draw(COUNTS), "type": draw(st.sampled_from(["VEC3", "MAT4", "SCALAR", "VEC9"]))}
    accessor |= {"bufferView": draw(COUNTS), "componentType": 5126, "byteOffset": draw(COUNTS)}
    found = {"asset": {"version": "2.0"}, "accessors": [accessor], "buffers": [{"byteLength": draw(COUNTS)}]}
    found["bufferViews"] = [{"buffer": 0, "byteLength": draw(COUNTS), "byteOffset": draw(COUNTS)}]
    found["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": draw(COUNTS)}]}]
    found |= {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}
    text = draw(st.sampled_from([json.dumps(found).encode(), nested(draw(DEPTHS), "[", "]")]))
    length = draw(st.sampled_from([len(text), 2**32 - 1, 0]))
    return struct.pack("<4sIII4s", b"glTF", 2, (20 + len(text)) % 2**32, length, b"JSON") + text


@st.composite
def mesh_headers(draw):
    """A .ply or .stl file that promises any numbers of elements."""
    if draw(st.booleans()):
        return ".stl", bytes(80) + struct.pack("<I", draw(COUNTS) % 2**32) + bytes(50)
    kind = draw(st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]))
    return ".ply", (
        f"ply\nformat {kind} 1.0\nelement vertex {draw(COUNTS)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {draw(COUNTS)}\nproperty list uint8 int vertex_indices\nend_header\n0 0 0\n"
    ).encode()


@st.composite
def field_files(draw):
    head = draw(st.sampled_from([f"{draw(COUNTS)} {draw(COUNTS)}\n", f"{draw(COUNTS)}\n{draw(COUNTS)}\n"]))
    return (head + "1 0 0\n" * 20 + "9" * draw(st.sampled_from([1, 5000]))).encode()


@st.composite
def toml_files(draw):
    depth, digits = draw(DEPTHS), draw(st.sampled_from([300, 5000]))
    texts = [b"feed = " + nested(depth, "[", "]"), b"feed = " + b"9" * digits, b"[" + b"a." * min(depth, 5000) + b"a]"]
    return draw(st.sampled_from(texts))


def of_suffix(suffix, contents):
    return contents.map(lambda content: (suffix, content))


BOMBS = [
    of_suffix(".npz", archives()),
    of_suffix(".vtu", vtu_files()),
    of_suffix(".vti", vti_files()),
    of_suffix(".nc", netcdf_files()),
    of_suffix(".mesh", medit_files()),
    of_suffix(".sol", medit_files()),
    of_suffix(".glb", glb_files()),
    of_suffix(".rosy", field_files()),
    of_suffix(".rawfield", field_files()),
    of_suffix(".toml", toml_files()),
    mesh_headers(),
]
READERS = {
    ".npz": lambda path: flow_file(path).read(),
    ".vtu": read_tets,
    ".vti": lambda path: flow_file(path).read(),
    ".nc": lambda path: flow_file(path).read(),
    ".mesh": read_tets,
    ".sol": read_vectors,
    ".glb": check_glb,
    ".ply": check_ply,
    ".rosy": read_field,
    ".rawfield": read_field,
    ".toml": read_machine,
}


@tried(st.one_of(BOMBS), often=True)
def test_any_promise_is_kept_or_refused_without_its_memory(case):
    suffix, content = case
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"bomb{suffix}"
        path.write_bytes(content)
        if suffix in READERS:
            tracemalloc.start()
            read_or_refused(f"bombs {suffix}", lambda: READERS[suffix](path) or "read")
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            assert peak < MOST_BYTES + 100 * len(content)
        if suffix in (".glb", ".ply", ".stl"):
            read_or_refused(f"bombs {suffix} for Blender", lambda: files.open_input(path) or "read")


@tried(st.floats(0, 1), st.binary(min_size=8, max_size=8) | st.just(b"\xff" * 8), often=True)
def test_any_size_in_a_volume_is_kept_or_refused(share, size):
    with tempfile.TemporaryDirectory() as folder:
        path = write_vdb(Path(folder) / "bomb.vdb")
        content = path.read_bytes()
        place = round(share * (min(len(content), 3000) - 8))
        path.write_bytes(content[:place] + size + content[place + 8 :])
        read_or_refused("bombs .vdb", lambda: flow_file(path, module=module_file()).read() and "read")


@tried(json_files(), st.sampled_from(["--constraints", "rows"]))
def test_any_nested_json_is_read_or_refused(content, flag):
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        Path("bomb.json").write_bytes(content)
        if flag == "rows":
            command_line("bombs as rows", "batch", "bomb.json")
        else:
            command_line("bombs as constraints", "stripes", "ball.obj", "--spacing", "0.7", flag, "bomb.json")


FRAMES = st.sampled_from([-(2**70), -1, 0, 1, 2, 10**6, 10**9, 2**31, 2**63, 10**30]).map(str) | st.just("9" * 5000)


@tried(FRAMES, FRAMES, st.sampled_from(["clebsch ring_####.npz", "clebsch ring.npz", "animate ball.obj", "rows"]))
def test_any_range_of_frames_is_refused_or_ends_where_the_files_do(first, last, line):
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        write_inputs()
        Path("ring_0001.npz").write_bytes(Path("ring.npz").read_bytes())
        tracemalloc.start()
        if line == "rows":
            row = f'{{"command": "info", "input": "absent.obj", "frames": [{first}, {last}], "chunk": {10**9}}}\n'
            Path("rows.jsonl").write_text(row)
            command_line("frames", "batch", "rows.jsonl", "--jobs", "1")
        else:
            command_line("frames", *line.split(), "--frames", first, last)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < MOST_BYTES
