# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists see: stripes in shaders, materials, defect empties and the product picture."""

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from synch_fields.core.errors import MeshError, SettingError
from synch_fields.synch_addon import nodes, render
from synch_fields.synch_addon.defect_empties import Defect, defect_empties, write_defects
from synch_fields.synch_addon.materials import pattern_material
from synch_fields.synch_addon.render import render_picture

PIXELS = 160
VIEW_WIDTH = 2.0
THIRD = np.pi / 3.0
TRIANGLE = [(-0.85, -0.7), (0.9, -0.5), (-0.1, 0.8)]
CONVEX_QUAD = [(-0.8, -0.75), (0.9, -0.5), (0.6, 0.85), (-0.7, 0.4)]
DART = [(-0.85, -0.85), (0.05, -0.3), (0.85, -0.8), (0.1, 0.9)]


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


# The formulas, point by point: an evaluation that shares nothing with the node groups.


def ell(b_p, b_q, b_r):
    """lArg of Knöppel et al. 2015."""
    if b_r <= min(b_p, b_q):
        return THIRD * (1 + (b_q - b_p) / (1 - 3 * b_r))
    if b_p <= min(b_q, b_r):
        return THIRD * (3 + (b_r - b_q) / (1 - 3 * b_p))
    return THIRD * (5 + (b_p - b_r) / (1 - 3 * b_q))


def triangle_disclination(b, x):
    if b[2] <= min(b[0], b[1]):
        return (b[0] - b[2]) * x[0] + (b[1] - b[2]) * x[1]
    if b[0] <= min(b[1], b[2]):
        return (b[1] - b[0]) * x[1] + (b[2] - b[0]) * x[2]
    return (b[2] - b[1]) * x[2] - (b[0] - b[1]) * x[0]


def quad_disclination(b_a, b_b, b_c, b_d, first, x):
    u = b_a - b_c
    turn = (x[0] * u if first else -x[0] * u) if u > 0 else -x[2] * u
    return turn + x[1] * b_b + x[3] * b_d


def barycentric(point, corners):
    matrix = np.vstack([np.array(corners).T, np.ones(3)])
    return np.linalg.solve(matrix, [*point, 1.0])


class Face:
    """One planar face with the attributes of a phase, and its theta at a point."""

    def __init__(self, corners, phases, numbers=(0, 0), disclination=(0, 0, 0, 0), start=0):
        self.corners, self.phases = corners, np.asarray(phases, float)
        self.numbers, self.disclination, self.start = numbers, disclination, start

    def theta(self, point):
        """(theta, least weight, 1 - 3 * least weight) at a point; None outside the face."""
        if len(self.corners) == 3:
            triangles = [(0, 1, 2)]
        else:
            a, b, c, d = ((self.start + k) % 4 for k in range(4))
            triangles = [(a, b, c), (c, d, a)]
        for which, triangle in enumerate(triangles):
            b = barycentric(point, [self.corners[k] for k in triangle])
            if b.min() < 0:
                continue
            theta = b @ self.phases[list(triangle)]
            turn = ell(*b)
            if len(self.corners) == 4:
                turn += THIRD * b[1] + 2 * THIRD * b[2]
            theta += self.numbers[which] * turn + self._disclination(b, which)
            return theta, b.min(), 1 - 3 * b.min()
        return None

    def _disclination(self, b, which):
        if len(self.corners) == 3:
            return triangle_disclination(b, self.disclination)
        if which == 0:
            return quad_disclination(b[0], b[1], b[2], 0.0, True, self.disclination)
        return quad_disclination(b[2], 0.0, b[0], b[1], False, self.disclination)

    def build(self):
        """The object in Blender, with the attributes that the shader reads."""
        mesh = bpy.data.meshes.new("face")
        mesh.from_pydata([(x, y, 0) for x, y in self.corners], [], [range(len(self.corners))])
        corner = mesh.attributes.new("synch_phase", "FLOAT", "CORNER")
        corner.data.foreach_set("value", np.float32(self.phases))
        place = mesh.attributes.new("synch_barycentric", "FLOAT_VECTOR", "CORNER")
        place.data.foreach_set("vector", np.float32(self._places()).ravel())
        mesh.attributes.new("synch_index", "INT", "FACE").data[0].value = self.numbers[0]
        if self.numbers[1]:
            mesh.attributes.new("synch_index_2", "INT", "FACE").data[0].value = self.numbers[1]
        if any(self.disclination):
            values = mesh.attributes.new("synch_disclination", "FLOAT_COLOR", "FACE")
            # Setting one item would clamp negative values to zero.
            values.data.foreach_set("color", np.float32(self.disclination))
        obj = bpy.data.objects.new("face", mesh)
        bpy.context.scene.collection.objects.link(obj)
        return obj

    def _places(self):
        if not any(self.numbers) and not any(self.disclination):
            return np.zeros((len(self.corners), 3))
        if len(self.corners) == 3:
            return np.eye(3)
        places = np.array([(0, 0, -1), (1, 0, -1), (0, 1, -1), (-1, 0, -1)])
        return np.roll(places, self.start, axis=0)


def show_socket(obj, socket_name):
    """Make the object glow with (1 + value) / 2 of one output of the stripes group."""
    material = bpy.data.materials.new("probe")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = nodes.stripes_group()
    scaled = tree.nodes.new("ShaderNodeMath")
    scaled.operation = "MULTIPLY_ADD"
    scaled.inputs[1].default_value = scaled.inputs[2].default_value = 0.5
    glow = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(group.outputs[socket_name], scaled.inputs[0])
    tree.links.new(scaled.outputs[0], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], output.inputs["Surface"])
    obj.data.materials.append(material)
    return group


def point_samples(tmp_path, engine="CYCLES"):
    """The scene from above, one sample in the middle of each pixel, row 0 at the bottom."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", VIEW_WIDTH
    camera.location.z = 5.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine = engine
    render.resolution_x = render.resolution_y = PIXELS
    render.filter_size = 0.01
    scene.cycles.samples, scene.cycles.filter_width = 1, 0.01
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(tmp_path / "samples.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    pixels = np.empty(PIXELS * PIXELS * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(PIXELS, PIXELS, 4)[:, :, 0] * 2 - 1


def pixel_centres():
    line = ((np.arange(PIXELS) + 0.5) / PIXELS - 0.5) * VIEW_WIDTH
    return np.stack(np.meshgrid(line, line), axis=-1)


def differences(face, picture):
    """|shader - formula| of cos(theta), away from edges and singular points."""
    found = []
    for point, value in zip(pixel_centres().reshape(-1, 2), picture.ravel(), strict=True):
        here = face.theta(point)
        if here and here[1] > 0.01 and here[2] > 0.03:
            found.append(abs(value - np.cos(here[0])))
    assert len(found) > 2000
    return np.array(found)


FACES = {
    "regular triangle": Face(TRIANGLE, (0.4, 7.0, -3.0)),
    "regular quad": Face(CONVEX_QUAD, (0.4, 7.0, -3.0, 1.0)),
    "triangle, N = 1": Face(TRIANGLE, (0.4, 2.0, -1.5), (1, 0)),
    "triangle, N = -1": Face(TRIANGLE, (-2.4, 1.0, 0.3), (-1, 0)),
    "triangle, disclination": Face(TRIANGLE, (np.pi,) * 3, disclination=(2.2, -3.1, 1.4, 0.0)),
    "triangle, disclination on a stripe": Face(TRIANGLE, (0.0,) * 3, disclination=(-6.2, 3.1, 4.4, 0.0)),
    "quad, first triangle": Face(CONVEX_QUAD, (0.4, 2.0, -1.5, 0.7), (1, 0)),
    "quad, second triangle": Face(CONVEX_QUAD, (0.4, 2.0, -1.5, 0.7), (0, -1)),
    "quad, both triangles": Face(CONVEX_QUAD, (-2.0, 2.0, 0.5, 0.7), (-1, 1)),
    "quad, disclination": Face(CONVEX_QUAD, (np.pi,) * 4, disclination=(2.2, -3.1, 1.4, 5.0)),
    "dart, both triangles": Face(DART, (1.0, -0.4, 2.0, 3.0), (1, 2), start=1),
    "dart, second triangle": Face(DART, (1.0, -0.4, 2.0, 3.0), (0, 1), start=3),
    "dart, disclination": Face(DART, (0.0,) * 4, disclination=(-2.2, 3.1, 4.0, 0.9), start=1),
}


@pytest.mark.parametrize("name", FACES)
def test_shader_follows_the_formula_at_every_point(name, tmp_path):
    face = FACES[name]
    show_socket(face.build(), "Cosine")
    found = differences(face, point_samples(tmp_path))
    assert found.max() < 2e-4


@pytest.mark.slow
def test_shader_follows_the_formula_in_eevee(tmp_path):
    engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
    for name in ("triangle, disclination", "quad, both triangles", "dart, disclination"):
        bpy.ops.wm.read_homefile(use_empty=True)
        show_socket(FACES[name].build(), "Cosine")
        bpy.context.scene.eevee.taa_render_samples = 1
        # EEVEE renders in half precision: (1 + cos) / 2 has steps of 5e-4 below 1.
        assert differences(FACES[name], point_samples(tmp_path, engine)).max() < 2e-3


@pytest.mark.parametrize("width", [0.0, 0.25, 0.5, 1.0])
def test_width_is_the_part_of_a_period_that_is_stripe(width, tmp_path):
    # Eight periods from left to right over the whole picture.
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    group = show_socket(Face(square, (0, 16 * np.pi, 16 * np.pi, 0)).build(), "Factor")
    group.inputs["Width"].default_value = width
    factor = point_samples(tmp_path)
    assert abs(factor.mean() - width) < 0.01
    assert factor.min() > -1e-6 and factor.max() < 1 + 1e-6


def test_height_is_one_along_the_middle_of_a_stripe_and_zero_outside(tmp_path):
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    phases = (-np.pi, np.pi, np.pi, -np.pi)
    show_socket(Face(square, phases).build(), "Height")
    row = point_samples(tmp_path)[PIXELS // 2]
    theta = np.linspace(-np.pi, np.pi, PIXELS, endpoint=False) + np.pi / PIXELS
    expected = np.where(np.abs(theta) < np.pi / 2, (1 + np.cos(2 * theta)) / 2, 0.0)
    assert np.abs(row - expected).max() < 1e-5


SHAPES = {
    "sine": lambda s, a: 0.5 - 0.5 * np.cos(np.pi * s),
    "square": lambda s, a: np.clip(4 * s, 0, 1) ** 2 * (3 - 2 * np.clip(4 * s, 0, 1)),
    "triangle": lambda s, a: s,
    "rounded": lambda s, a: np.sqrt(s * (2 - s)),
    "thread": lambda s, a: np.sqrt(s * (2 - s)) * (1 - 0.38 * (1 - np.abs(np.sin(3 * np.pi * a)))),
}


def numbered_square():
    """A square with two and a half periods from left to right, stripes of the numbers 7, 4 and 9, going upwards."""
    obj = Face([(-1, -1), (1, -1), (1, 1), (-1, 1)], (-np.pi, 4 * np.pi, 4 * np.pi, -np.pi)).build()
    # Periods 0, 1 and 2 in their slots; the phase of the second grows to the right of its direction.
    obj.data.attributes.new("synch_number", "FLOAT_VECTOR", "FACE").data[0].vector = (7, -4, 9)
    along = obj.data.attributes.new("synch_along", "FLOAT_VECTOR", "CORNER")
    along.data.foreach_set("vector", np.float32([(0, 2, 0), (0, 2, 0), (3, -1, 3), (3, -1, 3)]).ravel())
    return obj


def places_in_stripes():
    """Periods from the left, the stripe that each is in, and periods along the stripes, at the pixels."""
    line = (np.arange(PIXELS) + 0.5) / PIXELS
    periods, along = np.meshgrid(2.5 * line - 0.5, 3 * line)
    slot = np.rint(periods).astype(int)
    return periods, slot, np.where(slot == 1, 2 - along, along)


def test_place_in_a_numbered_stripe(tmp_path):
    obj = numbered_square()
    periods, slot, along = places_in_stripes()
    sure = np.abs(periods - slot) < 0.49
    expected = {
        "Across": 2 * (periods - slot) * np.choose(slot, [1, -1, 1]),
        "Along": along,
        "Index": np.choose(slot, [7, 4, 9]),
    }
    for name, values in expected.items():
        obj.data.materials.clear()
        show_socket(obj, name)
        found = point_samples(tmp_path)
        np.testing.assert_allclose(found[sure], values[sure], atol=2e-4)
    obj.data.materials.clear()
    show_socket(obj, "Random")
    found = point_samples(tmp_path)
    for one in range(3):
        assert np.ptp(found[sure & (slot == one)]) < 1e-5
    assert len({round(float(value), 3) for value in found[sure]}) == 3 and 0 <= found.min() < found.max() <= 1


@pytest.mark.parametrize("profile", SHAPES)
def test_profiles_have_their_closed_forms(profile, tmp_path):
    obj = numbered_square()
    group = show_socket(obj, "Height")
    group.inputs["Profile"].default_value = list(SHAPES).index(profile)
    group.inputs["Width"].default_value = 0.8
    group.inputs["Strands"].default_value = 3
    periods, slot, along = places_in_stripes()
    offset = (periods - slot) * np.choose(slot, [1, -1, 1])
    share = np.clip(1 - np.abs(offset) / 0.4, 0, 1)
    twist = along + np.arcsin(np.clip(offset / 0.4, -1, 1)) / (3 * np.pi)
    np.testing.assert_allclose(point_samples(tmp_path), SHAPES[profile](share, twist), atol=2e-3)


def test_group_is_reused_and_an_outdated_one_is_rebuilt_with_its_users_settings():
    group = show_socket(FACES["regular quad"].build(), "Cosine")
    group.inputs["Width"].default_value = 0.3
    tree = nodes.stripes_group()
    assert group.node_tree == tree
    tree["synch_stamp"] = "of an older version"
    tree.nodes.clear()
    assert nodes.stripes_group() == tree
    assert any(node.type == "GROUP_OUTPUT" for node in tree.nodes)
    assert group.inputs["Width"].default_value == pytest.approx(0.3)
    assert [item.name for item in bpy.data.node_groups] == ["Synch Phase", "Synch Stripes"]


def test_inner_group_reads_other_attributes(tmp_path):
    face = FACES["regular triangle"]
    obj = face.build()
    obj.data.attributes["synch_phase"].name = "synch_phase_x"
    show_socket(obj, "Cosine").node_tree = nodes.phase_group(
        "Synch Phase x", nodes.PhaseAttributes(phase="synch_phase_x")
    )
    tree = obj.data.materials[0].node_tree
    tree.links.new(tree.nodes["Group"].outputs["Cosine"], tree.nodes["Math"].inputs[0])
    assert differences(face, point_samples(tmp_path)).max() < 2e-4


def test_material_edits_survive_a_second_run():
    obj = FACES["regular quad"].build()
    material = pattern_material(obj, "stripes", spacing=0.1)
    group = next(node for node in material.node_tree.nodes if node.type == "GROUP")
    group.inputs["Width"].default_value = 0.2
    material.name = "Zebra"
    assert pattern_material(obj, "stripes", spacing=0.2) == material
    assert group.inputs["Width"].default_value == pytest.approx(0.2)
    assert list(obj.data.materials) == [material]
    assert obj["synch_spacing"] == pytest.approx(0.2)


def test_an_object_without_materials_gets_stripes_and_so_does_an_empty_slot():
    bare, slotted = FACES["regular quad"].build(), FACES["regular triangle"].build()
    slotted.data.materials.append(None)
    material = pattern_material(bare, "stripes")
    assert pattern_material(slotted, "stripes") == material
    assert list(bare.data.materials) == list(slotted.data.materials) == [material]


def test_other_materials_keep_their_faces_unless_all_are_asked_for():
    obj = FACES["regular quad"].build()
    steel = bpy.data.materials.new("steel")
    obj.data.materials.append(steel)
    stripes = pattern_material(obj, "stripes")
    assert list(obj.data.materials) == [steel, stripes]
    assert obj.data.polygons[0].material_index == 0
    assert pattern_material(obj, "stripes", assign_faces=True) == stripes
    assert list(obj.data.materials) == [steel, stripes]
    assert obj.data.polygons[0].material_index == 1


def some_defects():
    return [
        Defect("disclination", 0, 0.5, (0.1, 0.2, 0.0), (0, 0, 1)),
        Defect("disclination", 1, -0.5, (0.3, 0.2, 0.0), (0, 0, 1)),
        Defect("dislocation", 2, 1.0, (0.1, 0.4, 0.0), (1, 0, 0)),
    ]


def test_empties_stand_where_the_defects_are():
    obj = FACES["regular quad"].build()
    obj.location, obj.scale = (1, 2, 3), (2, 2, 2)
    write_defects(obj, some_defects(), length=0.1)
    bpy.context.view_layer.update()
    plus, minus, turn = (bpy.data.objects[name] for name in EMPTY_NAMES)
    assert np.allclose(plus.matrix_world.translation, (1.2, 2.4, 3.0))
    assert plus["synch_index"] == 0.5 and minus["synch_index"] == -0.5
    assert turn["synch_kind"] == "dislocation" and turn["synch_face"] == 2
    assert np.allclose(turn.matrix_world.to_quaternion() @ Vector((0, 0, 1)), (1, 0, 0), atol=1e-6)
    assert plus.color[0] > plus.color[2] and minus.color[2] > minus.color[0]
    assert plus.empty_display_type != turn.empty_display_type
    collection = bpy.data.collections["Synch Defects: face"]
    assert set(collection.objects) == {plus, minus, turn}
    assert collection.name in bpy.data.collections["Synch Defects"].children
    assert "Synch Defects" in bpy.context.scene.collection.children


EMPTY_NAMES = ["disclination +1/2.001", "disclination -1/2.001", "dislocation +1.001"]


def test_a_second_run_replaces_the_empties_of_the_kinds_that_it_is_given():
    obj = FACES["regular quad"].build()
    write_defects(obj, some_defects())
    write_defects(obj, some_defects())
    assert sorted(bpy.data.objects.keys()) == sorted([*EMPTY_NAMES, "face"])
    write_defects(obj, some_defects()[:1], kinds=("disclination",))
    assert sorted(bpy.data.objects.keys()) == sorted([EMPTY_NAMES[0], EMPTY_NAMES[2], "face"])
    assert len(bpy.data.collections) == 2
    write_defects(obj, [], kinds=("dislocation",))
    assert sorted(bpy.data.objects.keys()) == sorted([EMPTY_NAMES[0], "face"])
    write_defects(obj, [])
    assert bpy.data.objects.keys() == ["face"] and not bpy.data.collections


def test_two_objects_keep_their_own_empties_and_hidden_collections_stay_hidden():
    first, second = FACES["regular quad"].build(), FACES["regular quad"].build()
    write_defects(first, some_defects())
    write_defects(second, some_defects())
    bpy.data.collections["Synch Defects: face"].hide_viewport = True
    write_defects(first, some_defects()[:2])
    assert len(defect_empties(first)) == 2 and len(defect_empties(second)) == 3
    assert bpy.data.collections["Synch Defects: face"].hide_viewport
    write_defects(first, [])
    assert "Synch Defects: face" not in bpy.data.collections
    assert len(bpy.data.collections["Synch Defects: face.001"].objects) == 3


def contents():
    lists = (p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION")
    return {(name, block.name, block.users) for name in lists for block in getattr(bpy.data, name)}


@pytest.mark.parametrize("edges", [False, True])
def test_picture_leaves_the_file_as_it_was(edges, tmp_path):
    obj = FACES["regular quad"].build()
    pattern_material(obj, "stripes")
    write_defects(obj, some_defects())
    before, scene = contents(), bpy.context.scene
    path = render_picture(obj, tmp_path / "picture.png", resolution=(64, 48), samples=1, edges=edges)
    assert contents() == before and bpy.context.scene == scene
    image = bpy.data.images.load(str(path))
    assert tuple(image.size) == (64, 48)
    assert np.ptp(np.array(image.pixels[:]).reshape(-1, 4)[:, :3]) > 0.2


def test_picture_of_nothing_is_refused_and_leaves_the_file_as_it_was(tmp_path):
    obj = bpy.data.objects.new("empty", bpy.data.meshes.new("empty"))
    bpy.context.scene.collection.objects.link(obj)
    before = contents()
    with pytest.raises(MeshError, match="no faces"):
        render_picture(obj, tmp_path / "picture.png")
    with pytest.raises(SettingError, match=r"picture\.obj"):
        render_picture(obj, tmp_path / "picture.obj")
    assert contents() == before


def test_picture_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "a_file").touch()
    with pytest.raises(SettingError, match="cannot write"):
        render_picture(FACES["regular quad"].build(), tmp_path / "a_file" / "p.png", resolution=(8, 8), samples=1)


def test_subject_stands_where_its_parents_and_modifiers_put_it():
    obj, parent = FACES["regular quad"].build(), bpy.data.objects.new("parent", None)
    parent.location, parent.scale, obj.parent = (5, 0, 1), (3, 1, 1), parent
    obj.rotation_euler.z = 0.5
    obj.modifiers.new("thick", "SOLIDIFY").thickness = 0.25
    scene = bpy.data.scenes.new("other")
    matrix, points = render._evaluate(render._stand_in(obj, scene), scene)
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    expected = CONVEX_QUAD @ turn.T * (3, 1) + (5, 0)
    assert np.allclose(np.array(matrix)[:3, 3], (5, 0, 1))
    assert all(np.isclose(points[:, :2], corner, atol=1e-5).all(axis=1).sum() == 2 for corner in expected)
    assert np.ptp(points[:, 2]) == pytest.approx(0.25, abs=1e-6)


@pytest.mark.parametrize("size", [(1, 1, 1), (0.01, 0.01, 4), (30, 20, 0), (1e-3, 2e-3, 1e-3)])
@pytest.mark.parametrize("view", [(25, 18), (-130, 0), (0, 90), (10, -40)])
def test_camera_is_as_close_as_a_whole_view_of_the_object_allows(size, view):
    scene = bpy.context.scene
    corners = np.array(np.meshgrid(*((-s / 2, s / 2) for s in size))).reshape(3, -1).T + 5.0
    camera = render._add_camera(scene, render._orientation(view), corners, (400, 200))
    scene.render.resolution_x, scene.render.resolution_y = 400, 200
    bpy.context.view_layer.update()
    seen = np.array([world_to_camera_view(scene, camera, Vector(corner)) for corner in corners])
    assert seen[:, 2].min() > camera.data.clip_start
    free = min((seen[:, :2]).min(), (1 - seen[:, :2]).min())
    assert free == pytest.approx(0.07, abs=2e-3)
