# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, settings, files and faults that nobody has thought of: a result or one line, and a scene as it was.

A short run belongs to the tests; `make fuzz` goes on for minutes, and keeps the smallest case of what it finds.
"""

import os
import warnings

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns.job import FieldJob
from synch_fields.synch_addon.settings.fields import Settings

from ..corpus import bad_meshes
from .faults import differences, fault_at, state
from .scenes import add_object, furnished, snapshot, sphere

hypothesis = pytest.importorskip("hypothesis")
st = hypothesis.strategies
# How many cases each test tries, and where what fails is kept.
CASES = int(os.environ.get("SYNCH_FUZZ_CASES", "10"))
KEPT = os.environ.get("SYNCH_FUZZ_KEPT")
fuzzed = hypothesis.settings(
    max_examples=CASES,
    deadline=None,
    derandomize=KEPT is None,
    database=KEPT and hypothesis.database.DirectoryBasedExampleDatabase(KEPT),
    suppress_health_check=list(hypothesis.HealthCheck),
)
LARGE = ("thirty boxes", "twenty triangles", "boxes that touch", "every face apart", "needles of a million")
NUMBERS = st.floats(width=32) | st.floats(-2, 2, width=32) | st.sampled_from([0.0, 1.0, 1e-7, 1e30])
NAMES = sorted(name for name in bad_meshes.MESHES if "inf" not in name and name not in LARGE)


@st.composite
def soups(draw):
    """A few vertices, some of them in one place, and faces over any of them."""
    places = draw(st.lists(st.tuples(*3 * [st.integers(-3, 3)]), min_size=3, max_size=12))
    corners = st.lists(st.integers(0, len(places) - 1), min_size=3, max_size=6, unique=True)
    return np.array(places, float) * draw(st.sampled_from([1.0, 1e-6, 1e6])), draw(st.lists(corners, max_size=20))


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


def solved_or_refused(work):
    """The report of some work, or None where it has said in one line why not, and left the scene as it was."""
    bpy.context.view_layer.update()
    before = snapshot()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return work()
        except SynchError as error:
            assert str(error) and "\n" not in str(error)
            assert snapshot() == before
            return None


def empty_scene():
    bpy.ops.wm.read_homefile(use_empty=True)


@fuzzed
@hypothesis.given(soups() | spoilt(), st.sampled_from(["directions", "stripes", "quads"]))
def test_any_soup_is_solved_or_refused(mesh, command):
    empty_scene()
    obj = add_object(*mesh)
    report = solved_or_refused(lambda: getattr(api, command)(obj, time_limit=5.0))
    assert report is None or report["energy"] is None or report["lower_bound"] <= report["energy"]


SETTINGS = {
    "symmetry": st.sampled_from(["vector", "line", "cross", "other"]),
    "guidance": st.sampled_from(["smooth", "axis:X", "axis:Z=2,curvature-max", "boundary", "distance:boundary", "a:b"]),
    "angle": NUMBERS,
    "spacing": NUMBERS | st.none(),
    "boundary": st.sampled_from(["free", "along", "across", "phase"]),
    "mirror": st.sampled_from(["", "X", "XYZ", "W"]),
    "singularities": NUMBERS,
    "branching": NUMBERS | st.none(),
    "aspect": NUMBERS,
    "method": st.sampled_from(["spectral", "diffusion", "sdp"]),
    "rounding": st.sampled_from(["continuation", "polish", "random", "svd", "none"]),
    "seed": st.integers(-1, 2**70),
    "target_gap": NUMBERS,
}


@fuzzed
@hypothesis.given(st.fixed_dictionaries({}, optional=SETTINGS), st.sampled_from(["stripes", "quads", "quad_mesh"]))
def test_any_settings_are_taken_or_refused(settings, command):
    empty_scene()
    obj = sphere(2)
    solved_or_refused(lambda: getattr(api, command)(obj, time_limit=5.0, **settings))


@fuzzed
@hypothesis.given(
    st.binary(max_size=200) | st.text(alphabet="0123456789 .-+einfa\n", max_size=200).map(str.encode),
    st.sampled_from([".rosy", ".rawfield"]),
)
def test_any_field_file_is_read_or_refused(content, suffix):
    import tempfile
    from pathlib import Path

    empty_scene()
    obj = sphere(1)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"field{suffix}"
        path.write_bytes(content)
        solved_or_refused(lambda: api.import_field(obj, path))


@fuzzed
@hypothesis.given(st.integers(1, 600), st.sampled_from(["stripes", "quads", "directions", "quad_mesh"]))
def test_a_fault_anywhere_leaves_the_scene_as_it_was(number, command):
    empty_scene()
    job = FieldJob(command, furnished(), Settings(spacing=None if command == "directions" else 0.7, method="spectral"))
    result = job.request.solve()
    before = state()
    with fault_at(number):
        try:
            job.write(result)
        except MemoryError as error:
            found = differences(before, state())
            assert not found, f"{error}: {found}"
