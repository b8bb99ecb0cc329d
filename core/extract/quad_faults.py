# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a quad mesh, said in lines that the user should read."""

import numpy as np

from ..geometry import TriangleMesh
from ..geometry.nearest import NearestTriangles
from .quad_mesh import SHORTEST, QuadMesh
from .quad_quality import quality

# Faces with more corners than this are no cells of a grid.
MOST_CORNERS = 8
# A quad mesh may be as far from its surface as this part of its mean edge.
FARTHEST = 1.0
# Share of the faces that may have a corner turned over.
FOLDED = 0.01


def quad_faults(quads: QuadMesh, mesh: TriangleMesh, closed: bool) -> tuple[str, ...]:
    """Lines that say what is wrong with a quad mesh, none where it is as it should be.

    Parameters
    ----------
    quads : QuadMesh
    mesh : TriangleMesh that it was made on
    closed : whether that surface has no boundary
    """
    figures = quality(quads)
    edges, _ = quads.edges
    lengths = np.linalg.norm(quads.vertices[edges[:, 1]] - quads.vertices[edges[:, 0]], axis=1)
    short = int((lengths < SHORTEST * np.median(lengths)).sum())
    large = int((quads.sizes > MOST_CORNERS).sum())
    away = distance(quads, mesh)
    faces = len(quads.sizes)
    found = (
        (short, f"{short} of {len(edges)} edges of the quad mesh have no length"),
        (large, f"{large} of {faces} faces have more than {MOST_CORNERS} corners"),
        (figures["folds"] > FOLDED * faces, f"{figures['folds']} of {faces} faces have a corner that is folded over"),
        (closed and not figures["closed"], "the surface is closed and the quad mesh is not"),
        (
            away > FARTHEST * figures["edge_length"],
            f"the quad mesh is {away:.3g} away from the surface where it is farthest, at an edge of "
            f"{figures['edge_length']:.3g}",
        ),
    )
    return tuple(f"{line}: ask for more faces, or a smaller spacing" for is_there, line in found if is_there)


def distance(quads, mesh):
    """Hausdorff distance of a quad mesh, with each face as triangles around its middle, and its surface; taken at
    vertices and middles of faces."""
    middles = np.add.reduceat(quads.vertices[quads.corner_vertices], quads.starts) / quads.sizes[:, None]
    triangles = np.column_stack([quads.half_edges, len(quads.vertices) + quads.corner_faces])
    places = np.concatenate([quads.vertices, middles])
    there, _ = NearestTriangles(mesh.vertices, mesh.triangles).nearest(places)
    of_surface = mesh.vertices[np.unique(mesh.triangles)]
    back, _ = NearestTriangles(places, triangles).nearest(of_surface)
    return max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in ((there, places), (back, of_surface)))
