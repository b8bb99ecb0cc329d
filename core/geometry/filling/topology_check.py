# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that a solid of tetrahedra is the body whose surface it fills.

Parts thinner than about one edge of the lattice are lost: plates vanish or become sieves, rods fall apart into beads.
Solid and surface are compared by their pieces, by their tunnels (Euler characteristic), and by distance. Small losses,
such as the tip of a cone or a speck, are permitted.
"""

import numpy as np
from scipy.spatial import cKDTree

from ...errors import MeshError, SettingError
from ..tet_mesh import TetMesh
from ..triangle_mesh import TriangleMesh
from .stuffing import NothingInside, estimated_cubes, estimated_tets, fill_surface
from .surface_distance import SurfaceDistance

# Share of the surface that may be farther from the solid than FAR sizes, measured at this number of places.
LOST_AREA, FAR, PLACES = 0.05, 1.5, 4000
# Share of the solid that may lie in more pieces than the surface has bodies.
LOOSE_VOLUME = 0.05
# Holes that the solid may have in addition, where a gap is closed, or lack, where one is too narrow. They are reported.
MOST_HOLES = 20
# Search for a size that fits: factor between sizes, and most tetrahedra and cubes, which take some seconds each.
FINER, MOST_TRIED, MOST_TRIED_CUBES = 0.7, 500_000, 10_000_000


def fill_with_same_topology(distance: SurfaceDistance, size: float) -> TetMesh:
    """Fill a closed surface with tetrahedra; its sharp edges and corners are cut off within ``size``, the longest edge.

    Raises SettingError for a size that makes another body than the surface encloses; names a size that was tried and is
    fine; MeshError as :func:`fill_surface`, and if no size up to ``MOST_TRIED`` tetrahedra and ``MOST_TRIED_CUBES``
    cubes is fine.
    """
    flaw = _try_filling(distance, size)
    if isinstance(flaw, TetMesh):
        return flaw
    finer = float(f"{FINER * size:.2g}")  # rounded as in the message, so that the size in it is the one tried
    tried = ""
    while (count := estimated_tets(distance.volume, finer, distance.area)) <= MOST_TRIED and estimated_cubes(
        distance.bounds, finer
    ) <= MOST_TRIED_CUBES:
        if isinstance(_try_filling(distance, finer), TetMesh):
            raise SettingError(
                f"tetrahedra of size {size:.3g} are too large: {flaw}; give a size of {finer:g}, which makes about "
                f"{count:,} of them"
            )
        finer, tried = float(f"{FINER * finer:.2g}"), f"sizes down to {finer:g} were tried, too: "
    raise MeshError(
        f"tetrahedra of size {size:.3g} are too large for the thin parts of the surface: {flaw}; {tried}thicken these "
        "parts, or give a smaller size"
    )


def _try_filling(distance: SurfaceDistance, size: float) -> TetMesh | str:
    """Fill the surface; returns the solid, or what is wrong with it."""
    try:
        solid = fill_surface(distance, distance.bounds, size)
    except NothingInside:
        return "nothing of the solid is left"
    return _describe_flaw(solid, distance, size) or solid


def _describe_flaw(solid: TetMesh, distance: SurfaceDistance, size: float) -> str | None:
    """Describe how a solid differs from the surface's body, None if it does not."""
    mesh = distance.mesh
    shells = np.bincount(mesh.pieces[mesh.triangles[:, 0]], _cone_volumes(mesh))
    volumes = np.sort(np.bincount(solid.pieces[solid.tets[:, 0]], solid.volumes))[::-1]
    bodies, pieces = np.count_nonzero(shells > 0), np.count_nonzero(volumes)
    if volumes[bodies:].sum() > LOOSE_VOLUME * volumes.sum():
        return f"the solid falls apart into {pieces} pieces"
    more = more_holes(solid, distance)
    if more > MOST_HOLES:
        return f"the solid has {more} holes where the surface has none"
    if -more > MOST_HOLES:
        return f"the solid lacks {-more} holes that the surface has"
    boundary = solid.boundary_surface[0]
    far = cKDTree(boundary.vertices).query(_draw_places(mesh))[0] > FAR * size
    if far.mean() > LOST_AREA:
        return f"the solid leaves out {far.mean():.0%} of the surface"
    return None


def more_holes(solid: TetMesh, distance: SurfaceDistance) -> int:
    """Count the tunnels and cavities that a solid has more than the surface; negative if it has fewer."""
    return _count_tunnels(solid.boundary_surface[0]) - _count_tunnels(distance.mesh)


def _cone_volumes(mesh: TriangleMesh) -> np.ndarray:
    """Compute (m,) six times the volumes of cones from triangles to their piece's first vertex, positive if outward."""
    owners = mesh.pieces[mesh.triangles[:, 0]]
    _, first, inverse = np.unique(owners, return_index=True, return_inverse=True)
    apex = mesh.vertices[mesh.triangles[first, 0]][inverse]
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles] - apex[:, None], 1, 0)
    return np.einsum("tx,tx->t", np.cross(a, b), c)


def _count_tunnels(mesh: TriangleMesh) -> int:
    """Count the handles of all shells of a closed mesh."""
    return len(np.unique(mesh.pieces[mesh.triangles[:, 0]])) - mesh.euler_characteristic // 2


def _draw_places(mesh: TriangleMesh) -> np.ndarray:
    """Draw (PLACES, 3) points evenly from the surface, the same for the same mesh."""
    random = np.random.default_rng(0)
    triangles = random.choice(mesh.triangle_count, PLACES, p=mesh.areas / mesh.areas.sum())
    shares = random.dirichlet([1, 1, 1], PLACES)
    return np.einsum("kc,kcx->kx", shares, mesh.vertices[mesh.triangles[triangles]])
