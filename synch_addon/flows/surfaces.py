# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows on surfaces: a vector attribute of a mesh object, or arrays of a plane, which become a mesh of squares."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.files.flows import VELOCITY, ArrayFile
from ...core.geometry.mesh_input import MeshInput
from ...core.geometry.squares import grid_squares
from ..blender import attributes, meshes
from ..blender.new_geometry import new_mesh
from ..blender.objects import ObjectLink
from .sources import objects_of


@dataclass(frozen=True)
class SurfaceFlow:
    """A flow on a mesh.

    Attributes
    ----------
    name : of the object, or of the file of a plane
    velocity : (n, 3) at the vertices
    link : ObjectLink, None for a plane, whose object is made when it is written to
    warnings : lines that the user should read
    """

    name: str
    given: MeshInput
    velocity: np.ndarray
    link: ObjectLink | None
    warnings: tuple[str, ...] = ()


def surface_flow(source, attribute, strict=False):
    """The :class:`SurfaceFlow` of a mesh object with faces, by a vector attribute on its vertices, or of a .npz file
    with a plane; None for other sources. Where ``strict``, a mesh that is not manifold is refused instead of repaired.
    """
    if isinstance(source, str | Path):
        path = Path(source)
        is_plane = path.suffix.lower() == ".npz" and path.is_file() and ArrayFile(path).is_plane
        return _of_plane(path) if is_plane else None
    objects = objects_of(source)
    surfaces = [obj for obj in objects if obj.type == "MESH" and len(obj.data.polygons)]
    if surfaces and len(objects) > 1:
        raise SettingError(f"{surfaces[0].name} is a surface with a flow of its own: choose it alone")
    return _of_object(surfaces[0], attribute, strict) if surfaces else None


def _of_object(obj, attribute, strict):
    reason = meshes.refusal(obj)
    if reason:
        raise SettingError(reason)
    with meshes.object_mode(obj):
        given = meshes.read_mesh(obj, strict=strict)
        velocity = attributes.read_vectors(obj, attribute, given)
    warnings = tuple(finding.line for finding in given.findings)
    return SurfaceFlow(obj.name, given, velocity, ObjectLink.to(obj), warnings)


def _of_plane(path):
    flow = ArrayFile(path).read()
    open_now = "a plane is shown open: what leaves it on one side does not come in on the other"
    warnings = (open_now,) if any(flow.own.periodic) else ()
    return SurfaceFlow(path.stem, grid_squares(flow.own), np.pad(flow.velocity, ((0, 0), (0, 1))), None, warnings)


def plane_object(flow):
    """A new object with the squares and the velocity of a plane, in no scene yet."""
    faces = flow.given.polygons.corner_vertices.reshape(-1, 4)
    obj = bpy.data.objects.new(flow.name, new_mesh(flow.name, flow.given.mesh.vertices, faces))
    attributes.write_attribute(obj, VELOCITY, "POINT", "FLOAT_VECTOR", flow.velocity)
    return obj
