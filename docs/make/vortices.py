# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of vortices: a knot of tubes, five flows, and the paper's Figures 5 and 7 again, which paper.py makes.

    python docs/make/vortices.py [--folder docs]

Figure 5: a trefoil knot on 40 x 40 x 20 nodes at five circulations of a filament, filaments above, tubes below.
Figure 7: a flow in the plane whose curl is constant in the unit disk. The map to the sphere, drawn as a globe; and four
singular maps of the same solve, each with as many vortices as the sphere is covered: they are where the map shows a
point of the globe, marked in the same colour. Needs Blender as a module (bpy).
"""

import bpy
import numpy as np
from mathutils import Euler, Matrix

from synch_fields.bench.clebsch import CUTS, cut_rows, finer_rows
from synch_fields.bench.command import arguments
from synch_fields.bench.flows import abc, jet
from synch_fields.bench.grids import QUANTA, trefoil_grid, trefoil_velocity
from synch_fields.bench.tables import Column
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.geometry.grid import Grid
from synch_fields.docs.make.flat import flat_scene, glowing
from synch_fields.docs.make.sheets import beside, make_pictures
from synch_fields.synch_addon.blender.transaction import only_for_now
from synch_fields.synch_addon.flows.job import clebsch
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.nodes.canvas import find_node
from synch_fields.synch_addon.nodes.globe import SPHERE, globe_group
from synch_fields.synch_addon.nodes.stripes import STRIPES_NAME

NODES_OF_KNOT = 40
# Where all of a knot is seen from, and a surface without highlights, which would show every triangle.
FROM_ABOVE, MATT = (10, 84), (0.85, 0.2)
SMALL, SAMPLES = (330, 290), 16
# Figure 7: quanta of the disk, nodes and half the side of the plane, colours of the points on the globe.
DISK_QUANTA, NODES, HALF = 5, 120, 1.6
COLORS = ((1.0, 0.25, 0.05, 1), (1.0, 0.75, 0.05, 1), (0.75, 0.1, 0.75, 1), (0.05, 0.75, 0.75, 1))
WORDS = ("orange", "yellow", "violet", "cyan")
FLAT = (440, 440)
MAPS = (
    Column("energy", "energy", ".2f"),
    Column("bound", "bound", ".2f"),
    Column("times that the sphere is covered", "coverage", ".2f"),
    Column("vortices", "vortices", "d"),
)
# Outside the disk the map stays near one point: the globe is turned so that it is in a sea, and seen from behind it.
TURN, SEEN = (np.array(Euler(angles).to_matrix()) for angles in ((0.0, 1.75, 0.9), (-1.1, 0.0, 0.3)))


def main():
    """Make the pictures."""
    make_pictures(arguments(__doc__, folder="the pictures go"), PICTURES)


# The trefoil


def figure5(place):
    """Filaments and tubes of the knot at five circulations, and the tables of these and of smaller ones."""
    bpy.ops.wm.read_homefile(use_empty=True)
    source = save_trefoil(place.folder, NODES_OF_KNOT)
    sheets = []
    for show in ("filaments", "tubes"):
        pictures = []
        for cut in CUTS:
            report = clebsch(source, quantum=2 * np.pi * QUANTA / cut, show=show, opening=95, smoothing=4)
            obj = bpy.data.objects[report["object"]]
            obj = in_hues(obj) if show == "tubes" else obj
            picture = place.folder / f"{show}{cut}.png"
            pictures.append(render_picture(obj, picture, resolution=SMALL, samples=SAMPLES, view=FROM_ABOVE))
        sheets.append(place.folder / f"{show}.png")
        beside(pictures, sheets[-1], labels=() if len(sheets) > 1 else [f"quanta: {cut}" for cut in CUTS])
    beside(sheets, place.picture, vertical=True)
    return {"energies": cut_rows(NODES_OF_KNOT), "finer": finer_rows(NODES_OF_KNOT)}


def knot(_options, folder, path):
    """A tube on a finer grid, in the colours of the sphere; with a smaller quantum its strands grow together."""
    bpy.ops.wm.read_homefile(use_empty=True)
    report = clebsch(save_trefoil(folder, 80), quantum=2 * np.pi * QUANTA / 1.5, show="tubes", opening=46, smoothing=12)
    obj = smoothed(in_hues(bpy.data.objects[report["object"]]))
    surface = find_node(obj.active_material.node_tree, "ShaderNodeBsdfPrincipled")
    surface.inputs["Roughness"].default_value, surface.inputs["Specular IOR Level"].default_value = MATT
    render_picture(obj, path, resolution=(1200, 900), samples=16, view=FROM_ABOVE)


def smoothed(obj):
    """A tube of larger triangles, smoothed: those of the grid differ much in size, and their shades too."""
    obj.modifiers.new("Larger", "DECIMATE").ratio = 0.5
    obj.modifiers.new("Smooth", "SMOOTH").iterations = 12
    obj.modifiers.new("Round", "SUBSURF").render_levels = 1
    return obj


def save_trefoil(folder, nodes):
    """A .npz file with the velocity around the knot."""
    grid = trefoil_grid((nodes, nodes, nodes // 2))
    velocity = trefoil_velocity(grid.places).reshape(*grid.shape, 3)
    np.savez(folder / "trefoil.npz", velocity=velocity, spacing=grid.spacing, origin=grid.origin)
    return folder / "trefoil.npz"


def in_hues(obj):
    """A tube in hues instead of the globe."""
    tree = obj.active_material.node_tree
    group = next(node for node in tree.nodes if node.type == "GROUP")
    group.inputs["Wheel"].default_value = 1.0
    return obj


# The disk


def figure7(place):
    """The globe and the map to it on the left, four singular maps on the right."""
    bpy.ops.wm.read_homefile(use_empty=True)
    quantum = np.pi / DISK_QUANTA
    report = clebsch(save_disk(place.folder), quantum=quantum, show="tubes")
    plane = bpy.data.objects[report["object"]]
    whole = {"label": "to the sphere", "energy": report["sphere_energy"], "coverage": report["coverage"]}
    told, maps, marks = [whole], [], []
    for word, spot, color in zip(WORDS, places_on_globe(), COLORS, strict=True):
        point = tuple((-spot @ SEEN @ TURN).tolist())
        seen = clebsch(plane, quantum=quantum, point=point)
        found = [(vortex["position"], color) for vortex in seen["vortices"]]
        figures = {"vortices": len(found), "energy": seen["energy"], "bound": seen["lower_bound"]}
        told.append({"label": f"to the circle, {word}"} | figures)
        maps.append(render_flat(plane, bpy.data.node_groups[STRIPES_NAME], found, place.folder / f"map{len(maps)}.png"))
        marks += found
    sphere = plane.data.attributes[SPHERE]
    values = np.empty(3 * len(sphere.data), np.float32)
    sphere.data.foreach_get("vector", values)
    sphere.data.foreach_set("vector", (values.reshape(-1, 3) @ TURN.T).astype(np.float32).ravel())
    drawn = render_flat(plane, globe_group(), marks, place.folder / "plane.png")
    rows = [place.folder / "below.png", place.folder / "above.png"]
    beside([drawn, *maps[2:]], rows[0])
    beside([render_globe(place.folder / "globe.png"), *maps[:2]], rows[1])
    beside(rows[::-1], place.picture, vertical=True)
    return {"maps": told}


def save_disk(folder):
    """A .npz file with rigid rotation in the unit disk and no vorticity outside."""
    axis = np.linspace(-HALF, HALF, NODES)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    squares = np.maximum(x**2 + y**2, 1)
    velocity = np.stack([-y, x], axis=-1) / (2 * squares[..., None])
    np.savez(folder / "disk.npz", velocity=velocity, spacing=axis[1] - axis[0], origin=-HALF)
    return folder / "disk.npz"


def render_flat(obj, group, marks, path):
    """A mesh in the plane from above, in the colours of a node group without light, with marks at places."""
    with only_for_now():
        scene = flat_scene(path, 1.06 * max(obj.dimensions), FLAT)
        copy = obj.copy()
        copy.data = obj.data.copy()
        scene.collection.objects.link(copy)
        copy.data.materials.clear()
        copy.data.materials.append(glowing(group))
        for place, color in marks:
            add_mark(scene, place, 0.062, color, 0.01)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    return path


def render_globe(path):
    """The globe, with the points that vortices lie at."""
    with only_for_now():
        scene = flat_scene(path, 2.3, FLAT)
        globe = add_ball(scene, (0, 0, 0), 1, 1, glowing(globe_group()))
        places = np.array([vertex.co for vertex in globe.data.vertices], np.float32)
        globe.data.attributes.new(SPHERE, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", places.ravel())
        globe.rotation_euler = Matrix(SEEN).to_euler()
        for place, color in zip(places_on_globe(), COLORS, strict=True):
            add_mark(scene, place, 0.06, color, 1)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    return path


def places_on_globe():
    """Four places on the side of the globe that is seen, in the directions of the picture."""
    turns = np.pi / 2 * np.arange(4) + 0.5
    return [np.array([0.6 * np.cos(turn), 0.6 * np.sin(turn), 0.8]) for turn in turns]


def add_mark(scene, place, size, color, height):
    """A disk of a colour with a white rim, above a place."""
    for share, shade in ((1, (1, 1, 1, 1)), (0.72, color)):
        add_ball(scene, (*place[:2], (2 - share) * height), share * size, 0.01, glowing(shade))


def add_ball(scene, place, radius, height, material):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64)
    obj = bpy.context.active_object
    bpy.context.scene.collection.objects.unlink(obj)
    obj.data.shade_smooth()
    obj.data.materials.append(material)
    obj.location, obj.scale = place, (radius, radius, height)
    scene.collection.objects.link(obj)
    return obj


# Flows


def gallery(_options, folder, path):
    """Five flows with what is shown of them, three by the default settings."""
    bpy.ops.wm.read_homefile(use_empty=True)
    pictures = []
    for name, (make, settings, view) in FLOWS.items():
        np.savez(folder / f"{name}.npz", **make())
        report = clebsch(folder / f"{name}.npz", smoothing=20, **settings)
        obj = bpy.data.objects[report["object"]]
        obj = in_hues(obj) if "tubes" in report else obj
        print(name, f"{report['vorticity_share']:.0%} carried", report["quantum"], report["warnings"], flush=True)
        pictures.append(render_picture(obj, folder / f"{name}.png", resolution=SMALL, samples=SAMPLES, view=view))
    beside(pictures, path, labels=list(FLOWS))


def on_box(half, count, flow):
    """Arrays of a flow on count x count x ... nodes of cubes around the origin, half of whose sides are given."""
    spacing = 2 * max(half) / (count - 1)
    shape = np.maximum(np.rint(2 * np.array(half) / spacing).astype(int) + 1, 4)
    grid = Grid(shape, spacing, -0.5 * spacing * (shape - 1))
    velocity = flow(grid.places).reshape(*shape, 3)
    return {"velocity": velocity, "spacing": spacing, "origin": grid.origin}


def smoke_ring():
    """A vortex ring that has begun to waver, as smoke rings do."""
    turn = np.linspace(0, 2 * np.pi, 241)
    radius, height = 1 + 0.09 * np.cos(7 * turn), 0.12 * np.sin(7 * turn)
    ring = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    return on_box((1.6, 1.6, 0.8), 36, lambda places: filament_velocity(places, [(ring, 1.0)], 0.14))


def round_jet():
    """The shear layer of a jet, rolled up to rings."""
    grid, vorticity = jet(32)
    more = {"spacing": grid.spacing, "origin": grid.origin, "periodic": grid.periodic}
    return {"vorticity": vorticity.reshape(*grid.shape, 3), **more}


def vessel():
    """Flow through a bend of a vessel that bulges on its outer side, with the two vortices that bends have."""
    x, y, z = np.moveaxis(np.stack(np.meshgrid(*[np.linspace(*ends) for ends in VESSEL], indexing="ij")), 0, 0)
    around, across = np.arctan2(y, x), np.hypot(x, y) - 1.2
    bulge = np.exp(-(((around - np.pi / 4) / 0.35) ** 2))
    radius, middle = 0.36 + 0.2 * bulge, 0.22 * bulge
    across = (across - middle) / radius
    share = np.clip(1 - across**2 - (z / radius) ** 2, 0, None)
    forwards = np.stack([-np.sin(around), np.cos(around), 0 * z], axis=-1)
    outwards = np.stack([np.cos(around), np.sin(around), 0 * z], axis=-1)
    upwards = np.stack([0 * z, 0 * z, 0 * z + 1], axis=-1)
    # A stream function psi = share^2 z: along its lines the fluid turns, outwards in the middle and back at the walls.
    inner = share**2 - 4 * share * (z / radius) ** 2
    turning = 0.5 * (inner[..., None] * outwards + (4 * share * across * z / radius)[..., None] * upwards)
    velocity = (share * (0.36 / radius) ** 2)[..., None] * forwards + turning
    solid = (share <= 0) | (x < 0) | (y < 0)
    return {"velocity": velocity, "spacing": VESSEL[0][1] / (VESSEL[0][2] - 1), "solid": solid, "origin": [0, 0, -0.6]}


def abc_flow():
    """Arnold, Beltrami and Childress's flow in its periodic box."""
    grid = Grid((24,) * 3, 2 * np.pi / 24, 0.0, True)
    velocity = np.column_stack(abc(*grid.places.T)).reshape(*grid.shape, 3)
    return {"velocity": velocity, "spacing": grid.spacing, "periodic": True}


def trefoil():
    """The knot of Figure 5 with a thinner core."""
    turn = np.linspace(0, 2 * np.pi, 161)
    knot = [np.sin(turn) + 2 * np.sin(2 * turn), np.cos(turn) - 2 * np.cos(2 * turn), -np.sin(3 * turn)]
    curves = [(np.column_stack(knot), 1.0)]
    return on_box((4.2, 4.2, 2.2), 40, lambda places: filament_velocity(places, curves, 0.3))


# Lowest, highest place and nodes along each axis of the vessel's box, whose cells are cubes.
VESSEL = ((0.0, 2.0, 41), (0.0, 2.0, 41), (-0.6, 0.6, 25))
FLOWS = {
    "smoke ring": (smoke_ring, {}, (20, 40)),
    "jet": (round_jet, {}, (25, 25)),
    "bend": (vessel, {"quantum": 0.045}, (45, 50)),
    "ABC": (abc_flow, {"quantum": 2.65, "show": "tubes", "opening": 75}, (30, 30)),
    "trefoil": (trefoil, {}, FROM_ABOVE),
}

PICTURES = {"vortices": knot, "flows": gallery}

if __name__ == "__main__":
    main()
