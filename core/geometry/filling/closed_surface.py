# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed surface that a solid fills, and parts of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ...errors import SettingError
from ..mesh_input import MeshInput
from ..tet_mesh import TetMesh
from ..triangle_mesh import TriangleMesh
from .features import sharpen_edges
from .surface_distance import SurfaceDistance
from .thin_walls import Filling, refine_thin_walls
from .topology_check import fill_with_same_topology, more_holes


@dataclass(frozen=True)
class Area:
    """The (k,) triangles of faces whose vertices are all in a group of that name."""

    name: str
    triangles: np.ndarray

    @classmethod
    def of_members(cls, given: MeshInput, members: np.ndarray, name: str) -> Self:
        """Build from (n,) bool members among a mesh's vertices; a group without a face raises a SettingError."""
        polygons = given.polygons
        whole = np.logical_and.reduceat(members[polygons.corner_vertices], polygons.starts)
        triangles = np.flatnonzero(whole[polygons.triangle_faces])
        if len(triangles) == 0:
            raise SettingError(f"{name} holds no whole face: assign all vertices of at least one face to it")
        return cls(name, triangles)


@dataclass(frozen=True)
class ClosedSurface:
    """A closed mesh that a solid fills, and the distance to it in scene units along the object's axes."""

    given: MeshInput
    distance: SurfaceDistance

    @property
    def mesh(self) -> TriangleMesh:
        return self.given.mesh

    @property
    def reach(self) -> float:
        """Diagonal of the surface's box."""
        return float(np.linalg.norm(np.ptp(self.distance.bounds, axis=0)))

    def filled(self, size: float, areas: Sequence[Area] = ()) -> Filling:
        """Fill the surface with tetrahedra of a size, which follow its sharp edges and the outlines of areas.

        In thin walls between areas they are smaller (:mod:`.thin_walls`). Errors as :func:`fill_with_same_topology`.
        """
        labels = np.zeros(self.mesh.triangle_count, int)  # one bit for each area
        for number, area in enumerate(areas):
            labels[area.triangles] += 1 << number
        nearest = self.distance.nearest
        solid = sharpen_edges(fill_with_same_topology(self.distance, size), self.mesh, nearest, labels)
        return refine_thin_walls(solid, self.mesh, nearest, labels > 0) if len(areas) else Filling(solid)

    def more_holes(self, solid: TetMesh) -> int:
        """Count the holes that a solid has more than the surface; negative if it has fewer."""
        return more_holes(solid, self.distance)

    def lost_share(self, solid: TetMesh) -> float:
        """Compute the share of the volume that a solid leaves out."""
        return 1 - float(solid.volumes.sum()) / self.distance.volume
