# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading tetrahedra of MEDIT and VTK: round trips through text written here, a real file, and one-line refusals."""

import re
import tracemalloc
import zlib
from base64 import b64encode

import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SettingError
from synch_fields.core.files.tets import read_marked_tets, read_tets
from synch_fields.core.geometry.tet_mesh import TetMesh

from ..meshes import SHARED
from ..solids import bent_bar, block, jittered

POINTS = "Vertices\n5\n0 0 0 1\n1 0 0 1\n0 1e0 0 2\n0 0 1.0E+0 0\n1 1 1 7\n"
TETS = "Tetrahedra\n2\n1 2 3 4 5\n2 4 3 5 6\n"


def medit(points=POINTS, tets=TETS, head="MeshVersionFormatted 1\nDimension 3\n", between="", end="End\n"):
    return head + points + between + tets + end


def rows(name, numbers):
    lines = [" ".join(map(repr, row)) + " 0" for row in numbers.tolist()]
    return "\n".join([name, str(len(lines)), *lines, ""])


def written(folder, text, name="solid.mesh"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_medit_text_is_read(tmp_path):
    mesh = read_tets(written(tmp_path, medit()))
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    np.testing.assert_array_equal(np.sort(mesh.tets), [[0, 1, 2, 3], [1, 2, 3, 4]])
    np.testing.assert_allclose(mesh.volumes, [1 / 6, 1 / 3])


@pytest.mark.parametrize(
    "text",
    [
        medit(between="# a comment of 3 Tetrahedra\nTriangles\n1\n1 2 3 9\nRidges 1 4\nEdges\n0\n"),
        medit(head="  MeshVersionFormatted\n2\n\nDimension\n3\n"),
        medit(end="\nEnd").replace("\n", "\r\n"),
        medit(tets=TETS.replace("1 2 3 4 5", "2 1 3 4 5")),
        medit(points=POINTS.replace("1 0 0 1", "0.1e01 0 0 1")),
        medit(points=POINTS.replace("1 0 0 1", "1.e000 0 0 1")),
        "\ufeff" + medit(between="# caf\xe9\n"),
    ],
    ids=["other-sections", "keywords-on-lines", "windows", "inverted", "exponents", "points", "not-ascii"],
)
def test_medit_comes_in_many_forms(tmp_path, text):
    plain, other = (read_tets(written(tmp_path, t, f"{k}.MESH")) for k, t in enumerate((medit(), text)))
    np.testing.assert_array_equal(other.vertices, plain.vertices)
    np.testing.assert_array_equal(np.sort(other.tets), np.sort(plain.tets))


def test_medit_keeps_every_digit(tmp_path):
    mesh = jittered(block())
    read = read_tets(written(tmp_path, medit(rows("Vertices", mesh.vertices), rows("Tetrahedra", mesh.tets + 1))))
    np.testing.assert_array_equal(read.vertices, mesh.vertices)
    np.testing.assert_array_equal(read.tets, mesh.tets)


def test_the_bunny_is_read():
    path = SHARED / "bunny.mesh"
    if not path.exists():
        pytest.skip("bunny.mesh is not here")
    mesh = read_tets(path)
    promised = [int(line) for line in path.read_text().split("Edges")[0].splitlines() if line.strip().isdigit()]
    # Its tetrahedra fill the convex hull, and its triangles are the bunny's skin.
    assert [mesh.vertex_count, len(mesh.boundary_faces)] == promised[:2]
    assert 20_000 < mesh.tet_count < promised[2]
    assert len(mesh.loose_vertices) == 0
    assert mesh.boundary_surface[0].euler_characteristic == 2
    last = path.read_text().splitlines()[mesh.vertex_count + 3].split()[:3]
    np.testing.assert_array_equal(mesh.vertices[-1], np.array(last, float))


@pytest.mark.parametrize("skin", ["middle", "middle and hull", "torn", "hull", "loose"])
def test_only_what_triangles_enclose_is_the_solid(tmp_path, skin):
    mesh = block((3, 3, 3))
    middle = np.flatnonzero((np.abs(mesh.vertices[mesh.tets].mean(axis=1) - 0.5) < 1 / 6).all(axis=1))
    core = TetMesh(mesh.vertices, mesh.tets[middle])
    triangles = {
        "middle": core.boundary_triangles[:, ::-1],
        "middle and hull": np.concatenate([core.boundary_triangles, mesh.boundary_triangles]),
        "torn": core.boundary_triangles[1:],
        "hull": mesh.boundary_triangles,
        "loose": np.array([[0, 5, 60], [7, 9, 21]]),
    }[skin]
    sections = [rows("Tetrahedra", mesh.tets + 1), rows("Triangles", triangles + 1)]
    read = read_tets(written(tmp_path, medit(rows("Vertices", mesh.vertices), "".join(sections))))
    np.testing.assert_array_equal(read.tets, core.tets if skin == "middle" else mesh.tets)
    np.testing.assert_array_equal(read.vertices, mesh.vertices)


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        (medit(tets=""), SettingError, "has no tetrahedra: export the solid, not its surface"),
        (medit(tets="Tetrahedra\n0\n"), SettingError, "has no tetrahedra"),
        (medit(tets=TETS.replace("\n2\n", "\n3\n", 1)), SettingError, "promises 3 Tetrahedra of 5 numbers and has 10"),
        (medit(points=POINTS.replace("1 0 0 1", "1 0 0")), SettingError, "promises 5 Vertices of 4 numbers"),
        (medit(points=POINTS.replace("1 0 0 1", "1 0 a 1")), SettingError, "cannot be read .*float: 'a'"),
        (medit(tets=TETS.replace("5 6", "9 6")), SettingError, "tetrahedron 1 names a vertex that is not among the 5"),
        (medit(tets=TETS.replace("5 6", "0 6")), SettingError, "tetrahedron 1 names a vertex"),
        (medit(tets=TETS.replace("5 6", "99999999999999999999999 6")), SettingError, "1e\\+23 is not a whole number"),
        (medit(tets=TETS.replace("5 6", "4.5 6")), SettingError, "4.5 is not a whole number"),
        (medit(between="Triangles\n1\n1 2 1e400 9\n"), SettingError, "inf is not a whole number"),
        (medit(tets=TETS.replace("5 6", "4 6")), MeshError, "tetrahedron 1 has no volume"),
        (medit(head="MeshVersionFormatted 1\nDimension 2\n"), SettingError, "is flat: export a solid of dimension 3"),
        (medit(between="Hexahedra\n1\n1 2 3 4 5 1 2 3 0\n"), SettingError, "has Hexahedra: split all cells"),
        ("solid cube\nfacet normal 0 0 1\n", SettingError, "is not a MEDIT file"),
        ("", SettingError, "is not a MEDIT file"),
        (b"MeshVersionFormatted\x00\xff\xfe", SettingError, "is not a text file: export it as ASCII"),
    ],
)
def test_broken_medit_files_are_refused_in_one_line(tmp_path, text, error, words):
    path = written(tmp_path, text)
    with pytest.raises(error, match=words) as caught:
        read_tets(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(SettingError, match=r"use the suffix \.mesh \(MEDIT, text\) or \.vtu"):
        read_tets(tmp_path / "solid.stl")
    with pytest.raises(SettingError, match=r"cannot be read .*: check the path"):
        read_tets(tmp_path / "missing.mesh")


class Vtu:
    """Writes the arrays of a solid with a triangle among its cells, in one of VTK's ways."""

    def __init__(self, way, order="<", header="u4"):
        self.way, self.order, self.header = way, order, np.dtype(order + header)
        self.appended = b""

    def packed(self, values):
        raw = values.astype(values.dtype.newbyteorder(self.order)).tobytes()
        if "zlib" not in self.way:
            return np.array(len(raw), self.header).tobytes(), raw
        blocks = [raw[k : k + 1000] for k in range(0, len(raw), 1000)]
        small = [zlib.compress(b) for b in blocks]
        sizes = [len(blocks), 1000, len(blocks[-1]) % 1000, *map(len, small)]
        return np.array(sizes, self.header).tobytes(), b"".join(small)

    def array(self, name, values, components=1):
        kind = {"f": "Float", "i": "Int", "u": "UInt"}[values.dtype.kind] + str(8 * values.dtype.itemsize)
        tag = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format='
        if self.way == "ascii":
            return f'{tag}"ascii">{" ".join(map(repr, values.ravel().tolist()))}</DataArray>'
        head, body = self.packed(values)
        text = b64encode(head + body) if self.way in ("binary", "appended") else b64encode(head) + b64encode(body)
        if "raw" in self.way or "appended" in self.way:
            offset = len(self.appended)
            self.appended += head + body if "raw" in self.way else text
            return f'{tag}"appended" offset="{offset}"/>'
        return f'{tag}"binary">\n  {text.decode()}\n</DataArray>'

    def text(self, mesh, kinds=(10, 5)):
        more = len(kinds) - 1
        cells = np.append(mesh.tets.ravel(), more * mesh.tets[0, :3].tolist()).astype(np.int64)
        ends = np.append(4 * np.arange(1, mesh.tet_count + 1), more * [len(cells)]).astype(np.int64)
        types = np.append(np.full(mesh.tet_count, kinds[0]), kinds[1:]).astype(np.uint8)
        piece = (
            f'<Piece NumberOfPoints="{mesh.vertex_count}" NumberOfCells="{len(types)}">'
            f"<PointData>{self.array('heat', np.arange(mesh.vertex_count, dtype=np.int32))}</PointData>"
            f"<Points>{self.array('Points', mesh.vertices, 3)}</Points><Cells>"
            f"{self.array('connectivity', cells)}{self.array('offsets', ends)}{self.array('types', types)}"
            "</Cells></Piece>"
        )
        compressor = ' compressor="vtkZLibDataCompressor"' if "zlib" in self.way else ""
        order = "BigEndian" if self.order == ">" else "LittleEndian"
        head = (
            f'<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="{order}" '
            f'header_type="UInt{8 * self.header.itemsize}"{compressor}><UnstructuredGrid>{piece}</UnstructuredGrid>'
        )
        encoding = "raw" if "raw" in self.way else "base64"
        tail = b""
        if self.appended:
            tail = f'<AppendedData encoding="{encoding}">\n _'.encode() + self.appended + b"\n</AppendedData>"
        return head.encode() + tail + b"</VTKFile>"


WAYS = ["ascii", "binary", "binary-apart", "zlib", "appended", "raw", "raw-zlib"]


@pytest.mark.parametrize("header", ["u4", "u8"])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("way", WAYS)
def test_vtu_is_read_however_it_is_stored(tmp_path, way, order, header):
    mesh = bent_bar()
    read = read_tets(written(tmp_path, Vtu(way, order, header).text(mesh), "solid.vtu"))
    np.testing.assert_array_equal(read.vertices, mesh.vertices)
    np.testing.assert_array_equal(read.tets, mesh.tets)


@pytest.mark.parametrize("header", ["u4", "u8"])
@pytest.mark.parametrize("way", WAYS)
def test_a_single_cell_of_vtu_is_read_however_it_is_stored(tmp_path, way, header):
    """Its kind is one byte, which leaves a stream of base64 as long as that of its header alone."""
    mesh = TetMesh(np.eye(4, 3), [[3, 0, 1, 2]])
    read = read_tets(written(tmp_path, Vtu(way, "<", header).text(mesh, (10,)), "solid.vtu"))
    np.testing.assert_array_equal(read.tets, mesh.tets)


def test_pieces_of_vtu_are_put_together(tmp_path):
    one = Vtu("ascii").text(block((1, 1, 1))).decode()
    piece = one[one.index("<Piece") : one.index("</Piece>") + 8]
    read = read_tets(written(tmp_path, one.replace(piece, piece + piece), "solid.vtu"))
    assert (read.vertex_count, read.tet_count, len(np.unique(read.pieces))) == (16, 12, 2)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[: len(text) // 2], "cannot be read"),
        (lambda text: text.replace(b"UnstructuredGrid", b"PolyData"), "is not an unstructured grid"),
        (lambda text: text.replace(b'Name="types"', b'Name="kinds"'), "cannot be read"),
        (lambda text: text.replace(b"vtkZLib", b"vtkLZ4"), "compressed by vtkLZ4DataCompressor, use zlib"),
        (lambda text: text.replace(b'type="Float64"', b'type="String"'), "cannot be read"),
    ],
)
def test_broken_vtu_files_are_refused_in_one_line(tmp_path, change, words):
    path = written(tmp_path, change(Vtu("zlib").text(block())), "solid.vtu")
    with pytest.raises(SettingError, match=words) as caught:
        read_tets(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_blocks_that_are_longer_than_promised_are_not_unpacked(tmp_path):
    """A hundred megabytes of zeros in a block of 1440 bytes: no more than that is made of it."""
    vtu, bomb = Vtu("zlib"), zlib.compress(bytes(100_000_000))
    whole = vtu.text(block())
    vtu.packed = lambda values: (np.array([1, 1440, 0, len(bomb)], vtu.header).tobytes(), bomb)
    points = vtu.array("Points", np.zeros(3)).encode()
    text = re.sub(rb'<DataArray[^<]*Name="Points".*?</DataArray>', lambda _: points, whole, flags=re.DOTALL)
    path = written(tmp_path, text, "solid.vtu")
    tracemalloc.start()
    with pytest.raises(SettingError, match="a block of other than the 1440 bytes that are promised"):
        read_tets(path)
    assert tracemalloc.get_traced_memory()[1] < 20_000_000
    tracemalloc.stop()


def test_indices_that_no_number_holds_are_refused_in_one_line(tmp_path):
    text = re.sub(rb'(Name="connectivity"[^>]*>)\d+', rb"\g<1>" + b"9" * 23, Vtu("ascii").text(block()))
    with pytest.raises(SettingError, match="cannot be read") as caught:
        read_tets(written(tmp_path, text, "solid.vtu"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: re.sub(rb' offset="\d+"', b"", text), "cannot be read"),
        (lambda text: text.replace(b"AppendedData", b"Data"), "cannot be read"),
    ],
)
def test_appended_arrays_that_are_nowhere_are_refused_in_one_line(tmp_path, change, words):
    path = written(tmp_path, change(Vtu("appended").text(block())), "solid.vtu")
    with pytest.raises(SettingError, match=words) as caught:
        read_tets(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("kinds", "offset"), [((10, 5), 3), ((10, 5), 0), ((5, 9), 2)])
def test_cells_of_too_few_corners_are_refused(tmp_path, kinds, offset):
    """Corners are counted back from each cell's end, and there are none before the first."""
    text = Vtu("ascii").text(block((1, 1, 1)), kinds).decode()
    text = text.replace('format="ascii">4 8', f'format="ascii">{offset} 8')
    with pytest.raises(SettingError, match="tetrahedra without 4 corners, or triangles without 3: export it again"):
        read_tets(written(tmp_path, text, "solid.vtu"))


def test_vtu_of_other_cells_is_refused(tmp_path):
    with pytest.raises(SettingError, match="has hexahedra: split all cells into straight tetrahedra"):
        read_tets(written(tmp_path, Vtu("ascii").text(block(), kinds=(10, 12)), "solid.vtu"))
    with pytest.raises(SettingError, match="has no tetrahedra"):
        read_tets(written(tmp_path, Vtu("ascii").text(block(), kinds=(9, 5)), "solid.vtu"))


@pytest.mark.parametrize("suffix", [".mesh", ".vtu"])
def test_what_meshio_writes_is_read(tmp_path, suffix):
    meshio = pytest.importorskip("meshio")
    mesh = bent_bar()
    path = tmp_path / f"solid{suffix}"
    meshio.Mesh(mesh.vertices, [("triangle", mesh.tets[:5, :3]), ("tetra", mesh.tets)]).write(path)
    read = read_tets(path)
    np.testing.assert_allclose(read.vertices, mesh.vertices, rtol=1e-14)
    np.testing.assert_array_equal(read.tets, mesh.tets)


def test_references_of_triangles_are_marks(tmp_path):
    triangles = "Triangles\n4\n1 2 3 9\n2 3 4 9\n1 2 4 3\n1 2 99 3\n"
    solid, marks = read_marked_tets(written(tmp_path, medit(between=triangles)))
    assert solid.tet_count == 2 and sorted(marks) == ["ref_3", "ref_9"]
    np.testing.assert_array_equal(marks["ref_9"], [[0, 1, 2], [1, 2, 3]])
    np.testing.assert_array_equal(marks["ref_3"], [[0, 1, 3]])  # of vertices that there are


@pytest.mark.parametrize("way", ["ascii", "raw-zlib"])
def test_whole_numbers_on_cells_of_vtu_are_marks(tmp_path, way):
    mesh, writer = bent_bar(), Vtu(way)
    numbers = np.append(np.zeros(mesh.tet_count, np.int32), np.int32(4))
    heat = np.zeros(len(numbers))
    data = f"<CellData>{writer.array('side', numbers)}{writer.array('heat', heat)}</CellData>"
    text = writer.text(mesh).replace(b"<Points>", data.encode() + b"<Points>", 1)
    solid, marks = read_marked_tets(written(tmp_path, text, "solid.vtu"))
    assert list(marks) == ["side_4"]
    np.testing.assert_array_equal(marks["side_4"], [solid.tets[0, :3]])
