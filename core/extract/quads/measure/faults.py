# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of a quad mesh, described for the user."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ....geometry import TriangleMesh
from ....geometry.nearest import NearestTriangles
from ....graphs import components
from ..trace.quad_mesh import QuadMesh
from .quality import quality

# Most corners of a face.
MOST_CORNERS = 8
# Largest distance of a quad mesh from its surface, in mean edges.
FARTHEST = 1.0
# Largest share of faces with a corner turned over.
FOLDED = 0.01
# Largest mean of |angle - 90| over the corners, in degrees, of meshes with at least so many faces, most of them quads.
WORST_ANGLE, FEWEST_FACES = 12.0, 100
# Share of this mean below which another mesh is called better.
BETTER = 0.9
# What to do about faults, in messages.
REMEDY = "ask for more faces, or a smaller spacing"


def quad_faults(
    quads: QuadMesh, mesh: TriangleMesh, closed: bool, tried: Mapping[int, float] = MappingProxyType({})
) -> tuple[str, ...]:
    """A line for each fault of a quad mesh on a surface.

    Parameters
    ----------
    closed : whether the surface has no boundary
    tried : mean |angle - 90| of meshes of the surface that were tried, in degrees, by their numbers of faces
    """
    figures = quality(quads)
    lengths = quads.edge_lengths
    short = len(quads.edges_without_length)
    large = int((quads.sizes > MOST_CORNERS).sum())
    away = distance(quads, mesh, FARTHEST * figures["edge_length"])
    faces, (lost, handles), (parts, pieces) = (
        len(quads.sizes),
        count_lost_handles(quads, mesh),
        count_parts(quads, mesh),
    )
    found = (
        (short, f"{short} of {len(lengths)} edges of the quad mesh have no length"),
        (large, f"{large} of {faces} faces have more than {MOST_CORNERS} corners"),
        (figures["folds"] > FOLDED * faces, f"{figures['folds']} of {faces} faces have a corner that is folded over"),
        (
            figures["angle_deviation"] > WORST_ANGLE and figures["quad_share"] > 0.5 and faces >= FEWEST_FACES,
            f"corners are {figures['angle_deviation']:.0f} degrees off right angles on average"
            + _better_count(faces, figures["angle_deviation"], tried),
        ),
        (closed and not figures["closed"], "the surface is closed and the quad mesh is not"),
        (lost > 0, f"{lost} of {handles} tunnels or handles of the surface are narrower than the quads and left out"),
        (
            parts > pieces,
            f"the quad mesh has {parts} pieces instead of {pieces}, since it is cut where the surface is narrower than "
            "the quads",
        ),
        (
            away > FARTHEST * figures["edge_length"],
            f"the quad mesh is {away:.3g} away from the surface where it is farthest, at an edge of "
            f"{figures['edge_length']:.3g}",
        ),
    )
    return tuple(f"{line}: {REMEDY}" for is_there, line in found if is_there)


def _better_count(faces: int, deviation: float, tried: Mapping[int, float]) -> str:
    """The end of a line about bad corners: a mesh that was tried, whose mean deviation is clearly less, and whose
    number of faces is nearest; or that there is none."""
    others = {count: mean for count, mean in tried.items() if count != faces}
    better = [count for count, mean in others.items() if mean < BETTER * deviation]
    if better:
        nearest = min(better, key=lambda count: abs(count - faces))
        return f", and {others[nearest]:.0f} in a mesh with {nearest} faces that was tried"
    return ", and not much less in the other meshes that were tried" if others else ""


def count_lost_handles(quads: QuadMesh, mesh: TriangleMesh) -> tuple[int, int]:
    """Count the handles that a surface has and its quad mesh lacks, and all handles of the surface.

    Pieces of the surface that the quad mesh leaves out do not count. A boundary counts as closed by a disk.
    """
    kept = np.isin(mesh.pieces, mesh.pieces[mesh.triangles[quads.triangles, 0]])
    edges, counts = quads.edges
    characteristic = int(mesh.piece_euler_characteristics[np.unique(mesh.pieces[kept])].sum())
    rims = mesh.edges[mesh.boundary_edges]
    of_surface = _count_handles(mesh.pieces[kept], characteristic, rims[kept[rims[:, 0]]])
    return of_surface - _count_handles(_parts(quads), quads.euler_characteristic, edges[counts == 1]), of_surface


def count_parts(quads: QuadMesh, mesh: TriangleMesh) -> tuple[int, int]:
    """Count the pieces of a quad mesh, and the pieces of the surface that it is on."""
    return int(_parts(quads).max(initial=-1)) + 1, len(np.unique(mesh.pieces[mesh.triangles[quads.triangles, 0]]))


def _parts(quads: QuadMesh) -> np.ndarray:
    """(n,) label of the connected part of each vertex."""
    return components(len(quads.vertices), quads.half_edges)


def _count_handles(pieces: np.ndarray, characteristic: int, rims: np.ndarray) -> int:
    """The handles of a surface with labels of pieces, V - E + F, and (k, 2) vertices of boundary edges."""
    vertices, ends = np.unique(rims, return_inverse=True)
    loops = components(len(vertices), ends.reshape(-1, 2)).max(initial=-1) + 1
    return (2 * len(np.unique(pieces)) - characteristic - int(loops)) // 2


def distance(quads: QuadMesh, mesh: TriangleMesh, enough: float = 0.0) -> float:
    """Hausdorff distance between a quad mesh, with faces divided into triangles at their middles, and its surface.

    It is measured at vertices and middles of faces. Distances up to ``enough`` may be found too large, up to that.
    """
    triangles = np.column_stack([quads.half_edges, len(quads.vertices) + quads.corner_faces])
    places = np.concatenate([quads.vertices, quads.middles(quads.vertices)])
    there, _ = mesh.finder.nearest(places, enough)
    of_surface = mesh.vertices[np.unique(mesh.triangles)]
    back, _ = NearestTriangles(places, triangles).nearest(of_surface, enough)
    return max(float(np.linalg.norm(a - b, axis=1).max()) for a, b in ((there, places), (back, of_surface)))
