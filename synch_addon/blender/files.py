# SPDX-License-Identifier: GPL-3.0-or-later
"""Files in and out for the command line, by Blender's own importers."""

import math
import tempfile
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import bmesh
import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.files.directions import SUFFIXES as FIELD_SUFFIXES
from ...core.files.meshes import check_glb, check_ply, is_whole
from ...core.files.obj_files import ObjMesh, far_centre, write_centred, write_obj
from ...core.files.whole import check_writable, unwritten, write_whole
from ...core.geometry.check import coarse_places
from ...core.interrupts import hold_interrupts
from ...core.memory import check_memory
from ...core.unit_vectors import unit_vectors
from .attributes import read_all
from .quiet import quiet_stderr
from .transaction import only_for_now
from .translations import operator_error

_IMPORTERS = {
    ".obj": lambda path: bpy.ops.wm.obj_import(filepath=path),
    ".ply": lambda path: bpy.ops.wm.ply_import(filepath=path),
    ".stl": lambda path: bpy.ops.wm.stl_import(filepath=path),
    ".glb": lambda path: bpy.ops.import_scene.gltf(filepath=path),
}
# Bytes of memory that an importer takes for each byte of a file, without which Blender would crash: a third more than
# measured on spheres of 160,000 and a million vertices.
_BYTES = {".obj": 8, ".ply": 34, ".stl": 4}
# Headers that are looked at before an importer allocates what they promise.
_CHECKS = {".ply": check_ply, ".glb": check_glb}
_EXPORTERS = {
    ".ply": lambda **to: bpy.ops.wm.ply_export(
        export_selected_objects=True, export_uv=False, export_normals=False, export_colors="NONE", **to
    ),
    ".stl": lambda **to: bpy.ops.wm.stl_export(export_selected_objects=True, **to),
}
MESH_SUFFIXES = (".obj", *_EXPORTERS)
# What an .obj file's axes are where it has Y up: of the world's.
_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
# Formats that keep one normal and one UV for each vertex, and so tear a surface at every seam and sharp edge.
_TORN = (".glb", ".ply")
# Files without normals are shown smooth, apart from edges bent by more than this.
_SHARP = math.radians(40)


def open_input(path):
    """Open a .blend, or import a mesh into an empty scene.

    Raises SynchError for a missing or damaged file, a kind that is not supported, or one that memory does not hold.
    """
    suffix = Path(path).suffix.lower()
    if suffix != ".blend" and suffix not in _IMPORTERS:
        raise SettingError(
            f"{path}: files of the kind {suffix or 'without suffix'} cannot be read: "
            f"use .blend, {', '.join(_IMPORTERS)}"
        )
    if not Path(path).is_file():
        raise SettingError(f"{path}: no such file")
    if suffix in _CHECKS:
        _CHECKS[suffix](path)
    check_memory(_BYTES.get(suffix, 0) * Path(path).stat().st_size, str(path), reserved=1.0)
    centre = far_centre(path) if suffix == ".obj" else None
    try:
        with quiet_stderr(), hold_interrupts():
            if centre is None:
                _read(suffix, str(Path(path).resolve()))
            else:
                _read_far(path, centre)
    except RuntimeError as error:
        reason = _reason(error)
        raise SettingError(f"{path}: cannot be read ({reason}): export it again") from None
    if suffix == ".blend":
        return
    for mesh in bpy.data.meshes:
        if suffix in _TORN:
            _weld(mesh)
        if not mesh.has_custom_normals:
            mesh.shade_smooth()
            mesh.set_sharp_from_angle(angle=_SHARP)


def _reason(error):
    """An importer's error as one line: the last line of a Python traceback, or all lines joined."""
    lines = [line.strip() for line in operator_error(error).splitlines()]
    lines = [line for line in lines if line and not line.startswith("Location: ")]
    return lines[-1] if any("Traceback" in line for line in lines) else " ".join(lines)


def _read(suffix, path):
    if suffix == ".blend":
        bpy.ops.wm.open_mainfile(filepath=path)
        return
    bpy.ops.wm.read_homefile(use_empty=True)
    if suffix == ".glb":
        import addon_utils

        addon_utils.enable("io_scene_gltf2")
    _IMPORTERS[suffix](path)


def _read_far(path, centre):
    """Import an .obj file that is far from the origin, its vertices relative to a centre at which its objects are."""
    with tempfile.TemporaryDirectory(prefix="synch_") as folder:
        near = Path(folder) / Path(path).name
        write_centred(path, centre, near)
        _read(".obj", str(near))
    for obj in bpy.context.scene.objects:
        obj.location = _Y_UP[:3, :3].T @ centre


def _weld(mesh):
    """Join boundary vertices at the very same place, as Blender's importer of .stl does by itself."""
    edited = bmesh.new()
    edited.from_mesh(mesh)
    first, targets = {}, {}
    for vertex in edited.verts:
        if vertex.is_boundary:
            target = first.setdefault(vertex.co.to_tuple(), vertex)
            if target is not vertex:
                targets[vertex] = target
    if targets:
        normals = read_all(mesh.corner_normals, "vector", 3, np.float32)
        bmesh.ops.weld_verts(edited, targetmap=targets)
        edited.to_mesh(mesh)
        # Custom normals are stored relative to the faces around a vertex, which have changed.
        if mesh.has_custom_normals and len(mesh.loops) == len(normals):
            mesh.normals_split_custom_set(normals)
    edited.free()


def choose_object(name=None):
    """The mesh object to work on: by name, the only one, or the active one."""
    meshes = {obj.name: obj for obj in bpy.context.scene.objects if obj.type == "MESH"}
    if name is not None:
        if name not in meshes:
            raise SettingError(f"there is no mesh object {name!r}: choose one of {', '.join(meshes) or 'none'}")
        chosen = meshes[name]
    elif not meshes:
        raise SettingError("the file has no mesh object: a field needs the faces of a mesh")
    elif len(meshes) == 1:
        chosen = next(iter(meshes.values()))
    elif bpy.context.view_layer.objects.active in meshes.values():
        chosen = bpy.context.view_layer.objects.active
    else:
        raise SettingError(f"the file has {len(meshes)} mesh objects: choose with --object ({', '.join(meshes)})")
    bpy.context.view_layer.objects.active = chosen
    return chosen


def open_object(path, name=None):
    """The mesh object to work on of a file, as :func:`open_input` and :func:`choose_object` have it."""
    open_input(path)
    return choose_object(name)


def named_object(name):
    """An object of the file by its name."""
    obj = bpy.data.objects.get(name)
    if obj is None:
        raise SettingError(f"there is no object {name!r}: choose one of {', '.join(bpy.data.objects.keys()) or 'none'}")
    return obj


def check_outputs(blend=None, picture=None, report=None, field=None, mesh=None):
    """Refuse, before any work, outputs whose folder does not exist or whose suffix is wrong."""
    own = (blend, [".blend"]), (picture, [".png"]), (report, [".json"])
    for path, suffixes in (*own, (field, FIELD_SUFFIXES), (mesh, MESH_SUFFIXES)):
        if path:
            check_output(path, suffixes)


def check_output(path, suffixes):
    """Refuse an output that has another suffix, is a folder, or lies in one that does not exist."""
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise SettingError(f"{path}: the name of this output must end in {' or '.join(suffixes)}")
    if not path.resolve().parent.is_dir():
        raise SettingError(f"{path}: its folder does not exist, create it first")
    if path.is_dir():
        raise SettingError(f"{path}: this is a folder, choose another name")
    check_writable(path)


@contextmanager
def written_by_operator(path):
    """For an operator of Blender's that writes the file ``path``: signals wait for its end, errors are WriteError."""
    try:
        with hold_interrupts():
            yield
    except RuntimeError as error:
        raise unwritten(path, " ".join(str(error).split())) from None


def export_mesh(obj, path, z_up=False, written=write_whole):
    """Write one mesh object to a file of its own, in the units of the scene.

    Raises SettingError where the file cannot be written.

    Parameters
    ----------
    path : of a kind in MESH_SUFFIXES
    z_up : coordinates of the world in an .obj file too, whose usual way up is Y; the other kinds have them always
    written : what a :func:`write_together` yields, for a file of a set
    """
    seen = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    data, matrix, suffix = seen.data, np.array(seen.matrix_world, float), Path(path).suffix.lower()
    arrived = partial(is_whole, vertices=len(data.vertices), faces=len(data.polygons))
    if suffix == ".obj":
        mesh = _obj_mesh(obj.name, data, matrix if z_up else _Y_UP @ matrix)
        with written(path, arrived) as made, made.open("w", encoding="ascii", newline="\n") as file:
            write_obj(file, mesh)
        return
    coarse = coarse_places(_places(data, matrix), read_all(data.edges, "vertices", 2))
    if coarse:
        raise SettingError(f"{path}: {coarse}, or write an .obj")
    with only_for_now(), written(path, arrived) as made:
        shown = placed_mesh(seen) if seen.matrix_world.is_negative or not obj.visible_get() else obj
        for other in bpy.context.view_layer.objects:
            other.select_set(other == shown)
        with written_by_operator(path):
            _EXPORTERS[suffix](filepath=str(made))


def placed_mesh(seen):
    """A visible mesh object like an evaluated one, with the transform in its mesh: Blender's exporters leave hidden
    objects out, and write mirrored ones to .ply files inside out."""
    data = bpy.data.meshes.new_from_object(seen)
    data.transform(seen.matrix_world)
    if seen.matrix_world.is_negative:
        data.flip_normals()
    placed = bpy.data.objects.new(seen.name, data)
    bpy.context.scene.collection.objects.link(placed)
    bpy.context.view_layer.update()
    return placed


def _places(data, matrix):
    return read_all(data.vertices, "co", 3, np.float32).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]


def _obj_mesh(name, data, matrix):
    """The :class:`ObjMesh` of a mesh that a (4, 4) matrix places; a mirrored one has its faces the other way round."""
    sizes, linear = read_all(data.polygons, "loop_total"), matrix[:3, :3]
    order, ends = np.arange(len(data.loops)), np.cumsum(sizes)
    if np.linalg.det(linear) < 0:
        order = np.repeat(2 * ends - sizes - 1, sizes) - order
    normals = read_all(data.corner_normals, "vector", 3, np.float32)[order] @ np.linalg.pinv(linear)
    uv = data.uv_layers.active
    return ObjMesh(
        name,
        _places(data, matrix),
        read_all(data.loops, "vertex_index")[order],
        sizes,
        read_all(data.polygons, "use_smooth", 1, bool),
        unit_vectors(normals),
        None if uv is None else read_all(uv.uv, "vector", 2, np.float32)[order].astype(float),
    )


def _is_blend(path):
    """Whether a file begins as a .blend does, compressed or not."""
    with path.open("rb") as file:
        return file.read(7).startswith((b"BLENDER", b"\x28\xb5\x2f\xfd"))


def save_blend(path):
    """Save a copy of the scene as a .blend file, without Blender's backup of an older one; returns its path.

    Raises SettingError where the file cannot be written; an older one stays as it was.
    """
    preferences = bpy.context.preferences.filepaths
    backups, preferences.save_version = preferences.save_version, 0
    try:
        with write_whole(path, _is_blend) as made:
            with written_by_operator(path):
                bpy.ops.wm.save_as_mainfile(filepath=str(made), check_existing=False, copy=True)
    finally:
        preferences.save_version = backups
    return str(path)
