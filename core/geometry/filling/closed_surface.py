# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed surface that a solid fills, and parts of it."""

from dataclasses import dataclass

import numpy as np

from ...errors import SettingError
from ..mesh_input import MeshInput
from .features import sharpen_edges
from .surface_distance import SurfaceDistance
from .topology_check import fill_with_same_topology, more_holes


@dataclass(frozen=True)
class Area:
    """Faces of a surface that all their vertices' membership in a group marks.

    Attributes
    ----------
    name : of the group
    triangles : (k,) of the surface
    """

    name: str
    triangles: np.ndarray

    @classmethod
    def of_members(cls, given, members, name):
        """From a :class:`MeshInput` and (n,) bool of its vertices.

        Raises
        ------
        SettingError
            where they mark no face
        """
        polygons = given.polygons
        whole = np.logical_and.reduceat(members[polygons.corner_vertices], polygons.starts)
        triangles = np.flatnonzero(whole[polygons.triangle_faces])
        if len(triangles) == 0:
            raise SettingError(f"{name} holds no whole face: assign all vertices of at least one face to it")
        return cls(name, triangles)


@dataclass(frozen=True)
class ClosedSurface:
    """A closed mesh that a solid fills.

    Attributes
    ----------
    given : MeshInput
    distance : SurfaceDistance to it, in scene units along the object's axes
    """

    given: MeshInput
    distance: SurfaceDistance

    @property
    def mesh(self):
        return self.given.mesh

    @property
    def reach(self):
        """Diagonal of the surface's box."""
        return float(np.linalg.norm(np.ptp(self.distance.bounds, axis=0)))

    def filled(self, size, areas=()):
        """The TetMesh inside, its edges as long as a size, with the surface's sharp edges and outlines of areas.

        Errors as :func:`fill_with_same_topology`.
        """
        labels = np.zeros(self.mesh.triangle_count, int)
        for number, area in enumerate(areas):
            labels[area.triangles] += 1 << number
        return sharpen_edges(fill_with_same_topology(self.distance, size), self.mesh, self.distance.nearest, labels)

    def more_holes(self, solid):
        """Holes of a solid that the surface has not; negative where it lacks some."""
        return more_holes(solid, self.distance)

    def lost_share(self, solid):
        """Share of the volume that a solid does not have."""
        return 1 - float(solid.volumes.sum()) / self.distance.volume
