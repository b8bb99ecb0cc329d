# SPDX-License-Identifier: GPL-3.0-or-later
"""Solids of mesh objects: a closed surface filled with tetrahedra, and what was solved in it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...core.errors import MeshError, SettingError, name_elements
from ...core.extract.defect_curves import DefectCurve
from ...core.extract.layer_surfaces import LayerSurfaces
from ...core.fields.layers import LayerPattern
from ...core.geometry import mesh_input
from ...core.geometry.filling.features import sharpened
from ...core.geometry.filling.stuffing import MOST_CUBES, estimated_bytes, estimated_tets, stuffed
from ...core.geometry.filling.surface_distance import SurfaceDistance
from ...core.geometry.tet_mesh import TetMesh
from ..blender import meshes
from ..blender.bvh import surface_tree

# A solid has about so many tetrahedra where no size is given.
AUTOMATIC_TETS = 100_000
# More than that take hours, and more memory than most machines have.
MOST_TETS = 4_000_000
# Measured while layers are solved, for 100 000 to 500 000 tetrahedra: 1600 to 2100.
SOLVED_BYTES = 2000
# A solid that has lost more than this share of the surface's volume has lost a part that can be seen.
LOST_VOLUME = 0.1


@dataclass(frozen=True)
class Layering:
    """The last layers that were solved in an object (:func:`memory.recall_layers` gives them back).

    Attributes
    ----------
    solid : TetMesh in scene units, along the object's axes: its scale has been applied, its place and turn have not
    pattern : LayerPattern
    surfaces : LayerSurfaces in the solid's space
    curves : DefectCurves in the solid's space
    matrix : (4, 4) from the solid's space to the world: the place, turn and mirroring of the object, without its scale;
        it is the ``matrix_world`` of objects that are made of the solid's points
    """

    solid: TetMesh
    pattern: LayerPattern
    surfaces: LayerSurfaces
    curves: tuple[DefectCurve, ...]
    matrix: np.ndarray


class Estimate(NamedTuple):
    """What a solid will be.

    Attributes
    ----------
    size : longest edge of a tetrahedron well inside, scene units
    tets : number of tetrahedra
    bytes : memory while they are made and layers solved in them
    """

    size: float
    tets: int
    bytes: int

    @property
    def megabytes(self):
        return self.bytes / 2**20

    def __str__(self):
        return f"{self.tets:,} tetrahedra, {self.megabytes:,.0f} MB"


@dataclass(frozen=True)
class Surface:
    """A closed mesh that a solid fills.

    Attributes
    ----------
    given : MeshInput
    distance : SurfaceDistance to it, in scene units along the object's axes
    """

    given: mesh_input.MeshInput
    distance: SurfaceDistance

    @property
    def mesh(self):
        return self.given.mesh

    @property
    def reach(self):
        """Diagonal of the surface's box."""
        return float(np.linalg.norm(np.ptp(self.distance.bounds, axis=0)))

    def filled(self, size, labels=None):
        """The TetMesh inside, its edges as long as a size, with the surface's sharp edges and where labels change."""
        return sharpened(stuffed(self.distance, self.distance.bounds, size), self.mesh, self.distance.nearest, labels)

    def lost_share(self, solid):
        """Share of the volume that a solid does not have."""
        return 1 - float(solid.volumes.sum()) / self.distance.volume


def read_surface(obj):
    """The closed :class:`Surface` of a mesh object in object mode.

    Raises
    ------
    MeshError
        naming the first element that is in the way, and carrying vertices where the surface is open or meets itself
    """
    given = meshes.read_mesh(obj)
    mesh = given.mesh
    distance = SurfaceDistance(mesh)
    _refuse_crossings(given)
    if distance.volume <= 1e-9 * float(np.ptp(distance.bounds, axis=0).max()) ** 3:
        raise MeshError(f"{obj.name} encloses no volume: give it thickness, with Solidify for instance")
    return Surface(given, distance)


def _refuse_crossings(given):
    """Refuse faces that meet others without sharing a vertex with them."""
    triangles = given.mesh.triangles
    tree = surface_tree(given.mesh.vertices, triangles)
    pairs = np.array(tree.overlap(tree), int).reshape(-1, 2)
    apart = (triangles[pairs[:, 0], :, None] != triangles[pairs[:, 1], None, :]).all(axis=(1, 2))
    met = np.unique(pairs[apart])
    if len(met):
        faces = np.unique(given.polygons.triangle_faces[met])
        verb = "meets" if len(faces) == 1 else "meet"
        raise MeshError(
            f"{name_elements('face', faces)} {verb} other faces of the mesh, where inside and outside cannot be told: "
            "join the parts with a Boolean union or a Remesh modifier, and apply it",
            triangles[met],
        )


def estimate(distance, size=None):
    """The :class:`Estimate` of the solid in a surface, for a size or the automatic one.

    Parameters
    ----------
    distance : SurfaceDistance, or what else has ``volume``, ``area`` and ``bounds``
    size : scene units
    """
    size = _size_of(distance, AUTOMATIC_TETS) if size is None else size
    tets = estimated_tets(distance.volume, size, distance.area)
    return Estimate(size, tets, max(SOLVED_BYTES * tets, estimated_bytes(tets, distance.bounds, size)))


def _size_of(distance, tets):
    """The size at which a solid has about so many tetrahedra."""
    low, high = 0.0, float(np.ptp(distance.bounds, axis=0).max())
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if estimated_tets(distance.volume, middle, distance.area) > tets else (low, middle)
    return high


def refuse_size(distance, size):
    """Raise SettingError for a size that makes nothing, or more than a machine can hold."""
    if not (np.isfinite(size) and size > 0):
        raise SettingError(f"the tetrahedra's size is {size:g}: give a positive length")
    smallest = _smallest_size(distance)
    if size < smallest:
        expected = estimate(distance, size)
        raise SettingError(f"a size of {size:g} makes about {expected}: give one from {smallest:.3g} on")


def _smallest_size(distance):
    """The size that makes as many tetrahedra or cubes as there may be."""
    cubes = np.prod(np.ptp(distance.bounds, axis=0)) / MOST_CUBES
    return max(_size_of(distance, MOST_TETS), 1.1 * cubes ** (1 / 3))
