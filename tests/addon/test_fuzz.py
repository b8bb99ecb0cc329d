# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, settings, files and faults that nobody has thought of: a result or one line, and a scene as it was.

A short run belongs to the tests; `make fuzz` goes on for minutes, and keeps the smallest case of what it finds.
"""

import tempfile
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path

import bpy
import numpy as np

from synch_fields.core.files.flows import flow_file
from synch_fields.core.files.tets import read_tets
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.blender.openvdb import module_file
from synch_fields.synch_addon.blender.schema import ATTRIBUTES, DIRECTION, PHASES
from synch_fields.synch_addon.patterns.job import FieldJob

from ..core.files import flow_writers
from ..corpus import bad_meshes
from .faults import differences, fault_at, state
from .fuzz_cases import CASES, COUNTS, KEPT, empty_scene, mostly, read_or_refused, solved_or_refused, st, tried
from .scenes import LAYOUTS, add_attribute, add_group, add_object, furnished, grid, sphere
from .vortex_scenes import write_npz, write_vdb

LARGE = ("thirty boxes", "twenty triangles", "boxes that touch", "every face apart", "needles of a million")
NUMBERS = st.floats(width=32) | st.floats(-2, 2, width=32) | st.sampled_from([0.0, 1.0, 1e-7, 1e30])
NAMES = sorted(name for name in bad_meshes.MESHES if "inf" not in name and name not in LARGE)


@st.composite
def soups(draw):
    """A few vertices, some of them in one place, and faces over any of them."""
    places = draw(st.lists(st.tuples(*3 * [st.integers(-3, 3)]), min_size=3, max_size=12))
    corners = st.lists(st.integers(0, len(places) - 1), min_size=3, max_size=6, unique=True)
    return np.array(places, float) * draw(st.sampled_from([1.0, 1e-6, 1e6])), draw(
        st.lists(corners, min_size=1, max_size=20)
    )


@st.composite
def spoilt(draw):
    """A bad mesh with one vertex moved, one face turned and one face more."""
    vertices, faces = bad_meshes.MESHES[draw(st.sampled_from(NAMES))]()
    vertices, faces = vertices.copy(), [list(face) for face in faces]
    if len(vertices):
        finite = st.floats(-1e6, 1e6, width=32)
        vertices[draw(st.integers(0, len(vertices) - 1))] = draw(st.tuples(finite, finite, finite))
    if faces:
        faces[draw(st.integers(0, len(faces) - 1))].reverse()
        faces.append(list(faces[draw(st.integers(0, len(faces) - 1))]))
    return vertices, faces


@tried(soups() | spoilt(), st.sampled_from(["directions", "stripes", "quads"]))
def test_any_soup_is_solved_or_refused(mesh, command):
    empty_scene()
    obj = add_object(*mesh)
    report = solved_or_refused("meshes", lambda: getattr(api, command)(obj, time_limit=5.0))
    assert report is None or report["energy"] is None or report["lower_bound"] <= report["energy"]


def one_of(values, odd):
    return mostly(st.sampled_from(values), st.sampled_from(odd))


SHARES = mostly(st.floats(0, 1), NUMBERS | st.none())
SETTINGS = {
    "symmetry": one_of(["vector", "line", "cross"], ["other", ""]),
    "guidance": one_of(
        ["smooth", "axis:X", "axis:Z=2,curvature-max", "offset:some"], ["distance:boundary", "a:b", ":"]
    ),
    "angle": mostly(st.floats(-9, 9), NUMBERS),
    "spacing": mostly(st.floats(0.2, 3), NUMBERS | st.none()),
    "boundary": one_of(["free", "along", "across", "phase"], ["other"]),
    "mirror": one_of(["", "X", "XYZ"], ["W"]),
    "singularities": SHARES,
    "branching": SHARES,
    "aspect": mostly(st.floats(0.5, 2), NUMBERS),
    "method": st.sampled_from(["spectral", "diffusion", "sdp"]),
    "rounding": st.sampled_from(["continuation", "polish", "random", "svd", "none"]),
    "seed": mostly(st.integers(0, 9), st.integers(-1, 2**70)),
    "target_gap": mostly(st.floats(1e-3, 0.5), NUMBERS),
}
OBJECTS = {"sphere": lambda: sphere(2), "grid": lambda: grid(6), "furnished": furnished}


@tried(
    st.fixed_dictionaries({}, optional=SETTINGS),
    st.sampled_from(["stripes", "quads", "quad_mesh", "directions"]),
    st.sampled_from(sorted(OBJECTS)),
)
def test_any_settings_are_taken_or_refused(settings, command, name):
    empty_scene()
    obj = OBJECTS[name]()
    if "some" not in obj.vertex_groups:
        add_group(obj, "some", range(9))
    solved_or_refused("settings", lambda: getattr(api, command)(obj, time_limit=5.0, **settings))


@tried(
    st.lists(
        st.tuples(
            st.sampled_from([known.name for known in ATTRIBUTES]),
            st.sampled_from(sorted(LAYOUTS)),
            st.sampled_from(["POINT", "EDGE", "FACE", "CORNER"]),
        ),
        min_size=1,
        max_size=6,
        unique_by=lambda given: given[0],
    ),
    st.sampled_from(["stripes", "quads", "directions"]),
    st.integers(1, 300),
)
def test_any_attributes_with_our_names_come_back_after_a_fault_and_stop_nothing(given, command, number):
    empty_scene()
    obj = sphere(2)
    for seed, (name, data_type, domain) in enumerate(given):
        add_attribute(obj.data, name, data_type, domain, seed)
    spacing = None if command == "directions" else 0.7
    job = FieldJob(command, obj, SurfaceSettings(spacing=spacing, method="spectral"))
    result, before = job.request.solve(), state()
    with fault_at(number):
        try:
            job.write(result)
        except MemoryError as error:
            found = differences(before, state())
            assert not found, f"{error}: {found}"
            COUNTS["faults beside strange attributes"] += 1
            job.write(result)
    for own in (DIRECTION, *(phase.phase for phase in PHASES.get(command, ()))):
        assert (obj.data.attributes[own.name].domain, obj.data.attributes[own.name].data_type) == own.layout


@tried(soups() | spoilt(), st.integers(1, 12), st.sampled_from([0.0, 1.0]))
def test_any_soup_becomes_a_few_quads_or_is_refused(mesh, faces, branching):
    empty_scene()
    obj = add_object(*mesh)
    report = solved_or_refused(
        "few faces", lambda: api.quad_mesh(obj, faces=faces, branching=branching, time_limit=5.0)
    )
    if report is not None:
        made = bpy.data.objects[report["quad_mesh"]["object"]].data
        assert made.polygons and all(len(set(p.vertices)) == p.loop_total > 2 for p in made.polygons)


@st.composite
def rows(draw):
    """A field for the 20 faces of an icosahedron, or nearly."""
    symmetry = draw(st.sampled_from([1, 2, 4, 4, 4, 3]))
    width = draw(st.sampled_from([1, symmetry]))
    numbers = draw(st.lists(mostly(st.floats(-2, 2), NUMBERS), min_size=3 * width, max_size=3 * width))
    head = draw(st.sampled_from([f"20\n{symmetry}\n", f"{symmetry} 20\n"]))
    return (head + 20 * (" ".join(map(str, numbers)) + "\n")).encode()


@tried(
    st.binary(max_size=200) | st.text(alphabet="0123456789 .-+einfa\n", max_size=200).map(str.encode) | rows(),
    st.sampled_from([".rosy", ".rawfield"]),
    often=True,
)
def test_any_field_file_is_read_or_refused(content, suffix):
    empty_scene()
    obj = sphere(1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"field{suffix}"
        path.write_bytes(content)
        solved_or_refused("field files", lambda: api.import_field(obj, path))


def _exported(suffix):
    def write(path):
        empty_scene()
        files.export_mesh(sphere(1), path)

    return suffix, write, files.open_input


def _flow(path):
    return flow_file(path, module=module_file()).read()


def _write_medit(path):
    places = "".join(f"{x} {y} {z} 0\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    path.write_text(
        f"MeshVersionFormatted 1\nDimension 3\nVertices\n8\n{places}Tetrahedra\n2\n1 5 3 2 0\n8 4 6 7 0\nEnd\n"
    )


def _write_vtu(path):
    arrays = {"connectivity": "0 1 2 3 1 2 3 4", "offsets": "4 8", "types": "10 10"}
    cells = "".join(f'<DataArray type="Int64" Name="{k}" format="ascii">{v}</DataArray>' for k, v in arrays.items())
    points = '<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1 1 1 1</DataArray>'
    piece = f'<Piece NumberOfPoints="5" NumberOfCells="2"><Points>{points}</Points><Cells>{cells}</Cells></Piece>'
    path.write_text(f'<VTKFile type="UnstructuredGrid"><UnstructuredGrid>{piece}</UnstructuredGrid></VTKFile>')


def _write_vti(kind, path):
    flow_writers.vti(path, {"velocity": flow_writers.VELOCITY}, kind)


def _write_netcdf(path):
    flow_writers.netcdf(path, flow_writers.UVW, flow_writers.AXES)


# Suffix, what writes a sound file, and what reads it; optional libraries read some.
FORMATS = [
    (".npz", write_npz, _flow),
    (".vdb", write_vdb, _flow),
    *((".vti", partial(_write_vti, kind), _flow) for kind in ("ascii", "zlib", "raw")),
    (".nc", _write_netcdf, _flow),
    *([(".h5", flow_writers.hdf5, _flow)] if find_spec("h5py") else []),
    *((suffix, flow_writers.vtk_mesh, _flow) for suffix in (".vts", ".vtr", ".vtk", ".vtu") if find_spec("pyvista")),
    (".mesh", _write_medit, read_tets),
    (".vtu", _write_vtu, read_tets),
    *map(_exported, files.MESH_SUFFIXES),
]


@cache
def sound(number):
    """The bytes of a sound file."""
    suffix, write, _ = FORMATS[number]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"sound{suffix}"
        write(path)
        return path.read_bytes()


@st.composite
def damages(draw):
    """The number of a format, a few places, as shares of a file, with how many bytes go and those that come there, and
    the share that is left."""
    places = st.tuples(st.floats(0, 1), st.integers(0, 8), st.binary(max_size=8) | st.sampled_from([b"-1", b"9" * 30]))
    share = draw(mostly(st.just(1.0), st.floats(0, 1)))
    return draw(st.integers(0, len(FORMATS) - 1)), draw(st.lists(places, max_size=2)), share


@tried(damages(), often=True)
def test_any_damaged_file_is_read_or_refused(damage):
    number, places, share = damage
    suffix, _, read = FORMATS[number]
    content = sound(number)
    for place, lost, new in places:
        here = round(place * len(content))
        content = content[:here] + new + content[here + lost :]
    content = content[: round(len(content) * share)]
    with tempfile.TemporaryDirectory(dir=KEPT) as folder:  # what ends the process is found there
        path = Path(folder) / f"damaged{suffix}"
        path.write_bytes(content)
        read_or_refused(f"{suffix} files", lambda: read(path) or "read")


def test_a_fault_anywhere_leaves_the_scene_as_it_was():
    @tried(st.integers(1, 600), st.sampled_from(["stripes", "quads", "directions", "quad_mesh"]))
    def check(number, command):
        empty_scene()
        spacing = None if command == "directions" else 0.7
        job = FieldJob(command, furnished(), SurfaceSettings(spacing=spacing, method="spectral"))
        result = job.request.solve()
        before = state()
        with fault_at(number):
            try:
                job.write(result)
                COUNTS["writes without a fault"] += 1
            except MemoryError as error:
                COUNTS["faults injected"] += 1
                found = differences(before, state())
                assert not found, f"{error}: {found}"

    check()
    assert COUNTS["faults injected"] >= CASES / 2
