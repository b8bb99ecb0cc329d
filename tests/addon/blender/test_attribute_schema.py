# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of attributes: everything that is written is in it, the manual says the same, and nothing else is taken."""

import re
from pathlib import Path

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, schema
from synch_fields.synch_addon.patterns import favourites

from ..moving_meshes import swaying
from ..scenes import attribute, hexagon_sphere, places, quad_sphere, set_vectors, snapshot, sphere, torus, tube, written
from ..solid_objects import block

PAGE = Path(__file__).parents[3] / "docs" / "attributes.md"
# What the manual calls domains and types.
DOMAINS = {"POINT": "point", "FACE": "face", "CORNER": "corner"}
TYPES = {"FLOAT": "float", "INT": "int", "FLOAT_VECTOR": "vector", "FLOAT2": "two floats", "FLOAT_COLOR": "colour"}
LAYOUTS = {a.name: (a.domain, a.data_type) for a in schema.ATTRIBUTES}


def numbered():
    obj = tube()
    api.stripes(obj, guidance="axis:Z", symmetry="vector", spacing=0.5)
    api.number_stripes(obj)
    return obj


def kept(solve, build):
    obj = build()
    solve(obj, spacing=0.5)
    favourites.keep(obj)
    return obj


def animated(pattern):
    obj = swaying(tube(segments=16, rings=9), 2)
    api.animate(obj, frames=(1, 2), pattern=pattern, spacing=0.7)
    return obj


def flowing():
    obj = sphere()
    set_vectors(obj, "velocity", np.cross([0, 0, 1], places(obj)))
    api.clebsch(obj, quantum=np.pi / 5, show="tubes", target_gap=0.1)
    return obj


def solved(solve, build=sphere, **settings):
    obj = build()
    solve(obj, **settings)
    return obj


def layered():
    obj = block()
    report = api.layers(obj, spacing=0.4, size=0.2)
    return bpy.data.objects[report["layers_object"]]


WRITERS = {
    "directions": (lambda: solved(api.directions), {"synch_direction", "synch_singularity"}),
    "stripes": (lambda: solved(api.stripes, hexagon_sphere, spacing=0.5), {"synch_phase", "synch_disclination"}),
    "quads": (lambda: solved(api.quads, quad_sphere, spacing=0.4), {"synch_phase_x", "synch_index_y", "synch_closing"}),
    "quad mesh": (lambda: solved(api.quad_mesh, torus, spacing=0.3), set()),
    "numbers": (numbered, {"synch_number", "synch_along"}),
    "favourite of stripes": (lambda: kept(api.stripes, sphere), {"synch_favourite_1_direction"}),
    "favourite of quads": (lambda: kept(api.quads, quad_sphere), {"synch_favourite_1_phase_y"}),
    "stripes in frames": (lambda: animated("stripes"), {"synch_phase.1", "synch_direction.2"}),
    "quads in frames": (lambda: animated("quads"), {"synch_phase_x.2", "synch_closing.1"}),
    "layers": (layered, {"synch_layer"}),
    "own surface": (lambda: solved(api.stripes, surface="seen", spacing=0.5), {"synch_parent_1", "synch_weights"}),
    "flow": (flowing, {"synch_sphere", "synch_color", "synch_strength", "synch_phase"}),
}


@pytest.mark.parametrize("name", WRITERS)
def test_all_that_is_written_is_in_the_table(name):
    make, expected = WRITERS[name]
    make()
    found = {}
    for mesh in bpy.data.meshes:
        for a in mesh.attributes:
            if a.name.startswith("synch_"):
                plain = re.sub(r"\.\d+$", "", a.name)
                plain = re.sub(r"^synch_favourite_1_(?=direction)", "synch_", plain)
                plain = re.sub(r"^synch_favourite_1_", "synch_vertex_", plain)
                assert LAYOUTS[plain] == (a.domain, a.data_type) == schema.layout_of(a.name), a.name
                found[a.name] = a
    assert expected <= found.keys()


@pytest.mark.slow
def test_each_attribute_of_the_table_is_written_by_something():
    found = set()
    for make, _ in WRITERS.values():
        bpy.ops.wm.read_homefile(use_empty=True)
        make()
        found |= {a.name for mesh in bpy.data.meshes for a in mesh.attributes}
    rare = {"synch_index_2", "synch_index_x_2", "synch_index_y_2"}  # quads of two defects: test_attributes, test_quads
    assert LAYOUTS.keys() - rare <= found


def test_names_of_others_are_none_of_ours():
    for name in ("velocity", "position", "synch_phase.x", "synch_layer.1", "synch_favourite_x_phase", "synch_wish"):
        assert schema.layout_of(name) is None
    for name in ("synch_phase.12", "synch_index_2.-3", "synch_favourite_12_phase_x"):
        assert schema.layout_of(name) is not None


WRONG = {
    "too few": np.zeros(161),
    "too many": np.zeros(163),
    "of faces": np.zeros(320),
    "wide": np.zeros((162, 3)),
    "flat": np.zeros((162, 1)),
    "one": 0.5,
    "complex": np.zeros(162, complex),
    "text": np.full(162, "a"),
    "not a number": np.full(162, np.nan),
    "beyond single precision": np.full(162, 1e300),
}


@pytest.mark.parametrize("present", [None, ("FLOAT", "POINT"), ("INT", "FACE")])
def test_values_that_do_not_fit_change_nothing(present):
    obj = sphere()
    if present:
        obj.data.attributes.new("synch_pattern", *present)
    before = snapshot()
    for name, values in WRONG.items():
        with np.errstate(over="ignore"), pytest.raises(ValueError, match="synch_pattern as FLOAT on 162 x POINT"):
            attributes.write(obj, schema.PATTERN, values)
        assert snapshot() == before, name


@pytest.mark.parametrize(
    ("domain", "data_type", "values"),
    [
        ("FACE", "INT", np.zeros(320)),
        ("FACE", "INT", np.full(320, 2**31)),
        ("FACE", "FLOAT", np.zeros(320)),
        ("POINT", "INT", np.zeros(162, int)),
    ],
)
def test_an_index_is_whole_and_on_faces(domain, data_type, values):
    obj = sphere()
    with pytest.raises(ValueError, match="synch_index as"):
        attributes.write_attribute(obj, "synch_index", domain, data_type, values)
    assert not written(obj)


def test_a_name_that_is_not_in_the_table_is_refused():
    obj = sphere()
    with pytest.raises(ValueError, match="synch_wish as FLOAT"):
        attributes.write_attribute(obj, "synch_wish", "POINT", "FLOAT", np.zeros(162))
    assert not written(obj)


def test_what_users_have_is_carried_over_as_it_is():
    obj = sphere()
    values = np.array([np.nan, np.inf, -1] * 54, np.float32)
    attributes.write_attribute(obj, "heat", "POINT", "FLOAT", values)
    np.testing.assert_array_equal(attribute(obj, "heat"), values)


def test_what_is_written_is_read():
    obj = sphere()
    for a in schema.ATTRIBUTES:
        dtype, width, _ = schema.TYPES[a.data_type]
        count = {"POINT": 162, "FACE": 320, "CORNER": 960}[a.domain]
        values = np.arange(count * width).reshape((count, width) if width > 1 else count).astype(dtype)
        attributes.write(obj, a, values)
        np.testing.assert_array_equal(attributes.read(obj, a), values)
    assert written(obj) == LAYOUTS


def test_the_manual_has_the_table():
    text = PAGE.read_text(encoding="utf-8")
    rows = [
        f"| `{a.name}` | {DOMAINS[a.domain]}, {TYPES[a.data_type]} | {a.meaning} |"
        for a in schema.ATTRIBUTES
        if not re.search(r"_[xy](_2)?$", a.name)
    ]
    assert [line for line in text.splitlines() if line.startswith("| `synch_")] == rows
