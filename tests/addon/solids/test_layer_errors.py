# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be filled with layers is refused in one line that names the remedy, and nothing changes."""

import re
from contextlib import contextmanager

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SettingError, SynchError
from synch_fields.core.settings.layers import Flush, LayerGuide, LayerSettings, groups_of_text, text_of_groups
from synch_fields.synch_addon import api
from synch_fields.synch_addon.solids.surface import read_surface

from ...core.meshes import cube
from ...corpus.makers import boxes, fans, klein_bottle
from ..scenes import add_group, add_object, attribute, grid, make_active, places, snapshot, tube
from ..solid_objects import block, layers_of, made


def refused(obj, match, **settings):
    """Run on an object by script; the error, after which the scene is as it was."""
    before = snapshot()
    with pytest.raises(SynchError, match=match) as caught:
        api.layers(obj, **settings)
    assert snapshot() == before and "\n" not in str(caught.value)
    return caught.value


@contextmanager
def editing(obj, faces=None):
    """Edit mode, with some faces selected or everything."""
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    bpy.ops.mesh.select_all(action="SELECT" if faces is None else "DESELECT")
    if faces is not None:
        bpy.ops.object.mode_set(mode="OBJECT")
        for face in faces:
            obj.data.polygons[face].select = True
        bpy.ops.object.mode_set(mode="EDIT")
    yield
    bpy.ops.object.mode_set(mode="OBJECT")


def test_faces_that_share_no_vertex_enclose_a_solid_and_are_told():
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.active_object.data
    corners = [cube.vertices[vertex].co[:] for face in cube.polygons for vertex in face.vertices]
    obj = add_object(corners, np.arange(24).reshape(-1, 4))
    surface = read_surface(obj)
    assert surface.distance.volume == pytest.approx(8)
    assert surface.given.finding_counts == {"joined_vertices": 16}
    with pytest.raises(MeshError, match="join vertices at the same place with Mesh > Clean Up > Merge by Distance"):
        read_surface(obj, strict=True)


def test_open_meshes_are_refused_with_their_open_edges_selected():
    obj = tube(12, 3)
    refused(obj, "has one face only, and a solid needs a closed surface: fill the holes")
    with pytest.raises(RuntimeError, match="closed surface"):
        bpy.ops.synch.layers()
    chosen = attribute(obj, ".select_vert")
    heights = attribute(obj, "position")[:, 2]
    np.testing.assert_array_equal(chosen, (heights == 0) | (heights == 2))


def test_the_remedies_for_open_and_double_faces_work():
    """As the messages name them; Fill Holes leaves holes of more than four sides unless its Sides are 0."""
    obj = tube(12, 3)
    refused(obj, r"fill the holes with Mesh > Clean Up > Fill Holes \(Sides 0\)")
    with editing(obj):
        bpy.ops.mesh.fill_holes(sides=0)
    volume = read_surface(obj).distance.volume
    faces = [*(tuple(face.vertices) for face in obj.data.polygons), tuple(obj.data.polygons[3].vertices)]
    obj = add_object(places(obj), faces)
    with pytest.raises(
        MeshError, match=r"has the same corners as another face: .* Mesh > Delete > Only Faces"
    ) as caught:
        read_surface(obj, strict=True)
    named = int(re.search(r"face (\d+)", str(caught.value))[1])
    with editing(obj, [named]):
        bpy.ops.mesh.delete(type="ONLY_FACE")
    assert read_surface(obj, strict=True).distance.volume == pytest.approx(volume)


def test_meshes_that_meet_themselves_are_refused_with_the_faces_selected():
    first, second = block(), block()
    second.location = (0.3, 0.2, 0.4)
    bpy.context.view_layer.update()
    with bpy.context.temp_override(active_object=first, selected_editable_objects=[first, second]):
        bpy.ops.object.join()
    make_active(first)
    error = refused(first, "faces 4, 5, 6 and 15 more meet other faces of .*: join the parts with a Boolean union")
    assert isinstance(error, MeshError) and 8 <= len(error.vertices) < len(first.data.vertices)


def test_a_part_that_hardly_reaches_through_itself_is_read():
    """A plate with a dent that comes out on the other side, by a hair's breadth or farther."""
    mesh = cube(5)
    places = mesh.vertices * [1, 1, 0.1]
    top = np.flatnonzero(np.isclose(places[:, 2], places[:, 2].max()))
    dent = top[np.linalg.norm(places[top, :2] - places[top, :2].mean(axis=0), axis=1).argmin()]
    lowest = places[:, 2].min()
    for depth in (3e-5, 0.02):
        places[dent, 2] = lowest - depth
        obj = add_object(places, mesh.triangles)
        if depth < 1e-4:
            assert read_surface(obj).distance.volume > 0.05
        else:
            refused(obj, "meet other faces of the mesh")


def test_flat_meshes_are_refused():
    import bmesh  # on the path once bpy is loaded

    obj = grid(2)
    twice = bmesh.new()
    twice.from_mesh(obj.data)
    bmesh.ops.solidify(twice, geom=twice.faces[:], thickness=0.0)
    twice.to_mesh(obj.data)
    twice.free()
    refused(obj, "Merge by Distance|encloses no volume|no area|meet other faces")


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        (
            {"spacing": 0.1, "size": 0.1, "divisions": 1},
            "the spacing 0.1 is finer than tetrahedra of size 0.1 can carry: give a size of 0.03",
        ),
        ({"spacing": 5}, "the spacing 5 is larger than the object .*: no layer would fit, reduce it"),
        ({"spacing": 0.001, "divisions": 1}, r"makes about [\d,]+ tetrahedra, [\d,]+ MB: give \d+ divisions, or a"),
        ({"size": 1e-4}, r"a size of 0.0001 makes about [\d,]+ tetrahedra"),
        ({"guidance": "axis:W"}, "the axis 'W' is unknown"),
        ({"guidance": "up"}, "the guidance 'up' is unknown: use one of axis, harmonic"),
        ({"guidance": "harmonic:Top"}, "'harmonic:Top' is incomplete: write harmonic:, a vertex group, :, another one"),
        ({"guidance": "harmonic:Top:Nowhere"}, "no vertex group 'Nowhere': choose one of its groups .Bottom, Top"),
        ({"guidance": "harmonic:Top:Empty"}, "the vertex group 'Empty' is empty"),
        ({"guidance": "harmonic:Top:Corner"}, "the vertex group 'Corner' holds no whole face"),
        ({"guidance": "harmonic:Top:Side"}, "'Top' and the vertex group 'Side' meet at vertices .*: leave a part"),
        ({"guidance": "distance:Gone"}, "'Gone' is neither a vertex group of Block nor another mesh object"),
        ({"guidance": "curve:Gone"}, "there is no curve object 'Gone'"),
        ({"guidance": "attribute:gone"}, "has no attribute 'gone'"),
        ({"groups": "Top"}, "the group 'Top' lacks its name or its wish: write NAME=layer"),
        ({"groups": "Top=flat"}, "the wish 'flat' of the group 'Top' is unknown: use layer or constant"),
        ({"spacing_map": "gone"}, "has no attribute 'gone'"),
        ({"spacing": -1}, "the spacing is -1.0: give a positive number"),
    ],
)
def test_settings_that_cannot_be_are_refused(settings, match):
    obj = block()
    obj.vertex_groups.new(name="Empty")
    add_group(obj, "Corner", [0])
    add_group(obj, "Side", np.flatnonzero(attribute(obj, "position")[:, 0] > 0.49))
    refused(obj, match, **settings)


def test_a_group_smaller_than_the_tetrahedra_is_refused():
    obj = block((1, 1, 0.3), (40, 40, 1))
    places = attribute(obj, "position")
    add_group(obj, "Spot", np.flatnonzero((np.abs(places[:, :2] - 0.21) < 0.02).all(axis=1) & (places[:, 2] > 0)))
    refused(obj, "the vertex group 'Spot' is smaller than the solid's triangles", groups="Spot=layer", size=0.25)


def test_a_solid_thinner_than_the_spacing_is_told_its_depth():
    match = "no layer lies in the solid, which is about 0.1 deep for them: give a spacing below that"
    obj = block((0.5, 0.5, 0.1))
    refused(obj, match, spacing=0.7, size=0.1)
    assert api.layers(obj, spacing=0.09, size=0.045)["layers"] > 0


@pytest.mark.parametrize("side", [5, 3])
def test_a_thin_plate_is_told_the_size_that_fills_it(side):
    obj = block((side, side, 0.05), (4 * side, 4 * side, 1))
    error = refused(obj, r"tetrahedra of size .* are too large: nothing of the solid is left; give a size of", size=0.1)
    size = float(re.search(r"give a size of ([\d.]+),", str(error)).group(1))
    assert 0.05 < size < 0.1
    if side == 3:
        report = api.layers(obj, spacing=0.5, size=size, guidance="axis:X")
        assert report["status"] == "certified" and report["warnings"] == []
        assert report["layers"] == 6


def test_a_plate_whose_tetrahedra_stay_long_is_reported():
    """Until they have the size that the warning leads to."""
    obj = block((0.6, 0.6, 0.12), (3, 3, 1))
    asked = {"groups": "Bottom=layer,Top=layer", "spacing": 0.04}
    (warning,) = api.layers(obj, size=0.1, divisions=10, **asked)["warnings"]
    assert re.match(r"in \d+% of the thin walls between groups, tetrahedra are longer than 50% of the", warning)
    assert api.layers(obj, size=0.06, divisions=10, **asked)["warnings"] == []


def test_a_solid_of_another_object_is_refused():
    from ...core.solids import block as tetrahedra

    refused(block(), "the solid's boundary is up to .* from the surface of Block", solid=tetrahedra((2, 2, 2)))


def test_texts_of_guides_and_groups_can_hold_any_name():
    for kind, names in (
        ("axis", ("X",)),
        ("harmonic", ('a:"b"', " c ")),
        ("distance", ("a,b=c",)),
        ("distance", ("a\nb",)),
    ):
        guide = LayerGuide(kind, names)
        assert LayerGuide.of_text(str(guide)) == guide == LayerSettings(guidance=str(guide)).guide
    rows = (Flush("Top", "layer"), Flush("a,b=c", "constant"), Flush('"q"', "layer"), Flush("a\nb", "layer"))
    assert groups_of_text(text_of_groups(rows)) == rows and groups_of_text("  ") == ()
    with pytest.raises(SettingError, match="cannot be read"):
        LayerGuide.of_text('harmonic:"a:b')


def test_an_empty_object_is_no_solid():
    refused(add_object([], []), "the mesh is empty")


def _rebuilt(obj, change):
    """An object with the vertices of another one, and with faces that a change makes of its faces."""
    faces = [list(face.vertices) for face in obj.data.polygons]
    return add_object(places(obj), change(faces), "Rebuilt")


SOUPS = {
    "flipped faces": (lambda faces: [face[::-1] if k < 9 else face for k, face in enumerate(faces)], "turned_faces"),
    "doubled faces": (lambda faces: [*faces, faces[3], faces[5][::-1]], "doubled_faces"),
}


@pytest.mark.parametrize("name", SOUPS)
def test_layers_fill_the_surface_nearest_to_a_mesh_that_is_none(name):
    clean = block((1, 1, 1), (4, 4, 4))
    change, kind = SOUPS[name]
    expected = api.layers(clean, spacing=0.25, size=0.12)
    obj = _rebuilt(clean, change)
    add_group(obj, "Top", np.flatnonzero(places(obj)[:, 2] > 0.49))
    report = api.layers(obj, spacing=0.25, size=0.12, groups="Top=layer")
    assert list(report["carrier"]) == [kind] and report["volume"] == pytest.approx(expected["volume"], rel=1e-3)
    assert any("turned over" in line or "count once" in line for line in report["warnings"])
    assert layers_of(made(report))[-1][:, 2].min() == pytest.approx(0.5, abs=1e-6)
    with pytest.raises(SynchError):
        api.layers(obj, spacing=0.25, size=0.15, strict=True)


def test_bodies_that_touch_are_filled_each_by_itself():
    obj = add_object(*boxes([(0, 0, 0), (1, 1, 0)]))
    report = api.layers(obj, spacing=0.3, size=0.14)
    assert report["carrier"] == {"non_manifold_edges": 1} and report["volume"] == pytest.approx(2, rel=0.1)


def test_what_encloses_nothing_is_refused_by_name():
    with pytest.raises(SynchError, match="one-sided and encloses nothing") as caught:
        api.layers(add_object(*klein_bottle()), spacing=0.3)
    assert len(caught.value.vertices)
    with pytest.raises(SynchError, match=r"the edge between vertices 0 and 1 .*three or more faces|has 3 faces"):
        api.layers(add_object(*fans(4)), spacing=0.3)
