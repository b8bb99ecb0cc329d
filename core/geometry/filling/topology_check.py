# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a solid of tetrahedra is still the body whose surface it fills.

What is thinner than about one edge of the lattice is lost: plates vanish or become sieves, rods fall apart into beads.
The two are compared by their pieces, by the tunnels that the Euler characteristic counts, and by distance. Small
losses, such as the tip of a cone or a speck, are none of the surface's shape.
"""

import numpy as np
from scipy.spatial import cKDTree

from ...errors import MeshError, SettingError
from .stuffing import NothingInside, estimated_cubes, estimated_tets, fill_surface

# Share of the surface that may be farther from the solid than so many sizes, found at so many places.
LOST_AREA, FAR, PLACES = 0.05, 1.5, 4000
# Share of the solid that may lie in other pieces than the surface has bodies.
LOOSE_VOLUME = 0.05
# Holes that the solid may have and the surface has not, where a gap is closed, or lack, where one is too narrow. They
# are told about.
MOST_HOLES = 20
# What is tried for a size that fits: the factor from one to the next, and the most tetrahedra and cubes, which take
# some seconds each.
FINER, MOST_TRIED, MOST_TRIED_CUBES = 0.7, 500_000, 10_000_000


def fill_with_same_topology(distance, size):
    """The TetMesh inside a closed surface, whose sharp edges and corners are cut off within one ``size``.

    Parameters
    ----------
    distance : SurfaceDistance
    size : float, the longest edge inside

    Raises
    ------
    SettingError
        for a size that makes another body than the surface encloses, with one that does not, where one is found
    MeshError
        as :func:`fill_surface`, and where none up to ``MOST_TRIED`` tetrahedra and ``MOST_TRIED_CUBES`` cubes does
    """
    solid, flaw = _try_filling(distance, size)
    if flaw is None:
        return solid
    finer = float(f"{FINER * size:.2g}")  # as it is written, so that what is given is what was tried
    while (count := estimated_tets(distance.volume, finer, distance.area)) <= MOST_TRIED and estimated_cubes(
        distance.bounds, finer
    ) <= MOST_TRIED_CUBES:
        if _try_filling(distance, finer)[1] is None:
            raise SettingError(
                f"tetrahedra of size {size:.3g} are too large: {flaw}; give a size of {finer:g}, which makes about "
                f"{count:,} of them"
            )
        finer = float(f"{FINER * finer:.2g}")
    raise MeshError(
        f"tetrahedra of size {size:.3g} are too large for the thin parts of the surface: {flaw}, and sizes above "
        f"{finer:g} would not do: thicken these parts, or give a size of {finer:g} or below"
    )


def _try_filling(distance, size):
    """The solid and None, or what is wrong with it."""
    try:
        solid = fill_surface(distance, distance.bounds, size)
    except NothingInside:
        return None, "nothing of the solid is left"
    return solid, _flaw(solid, distance, size)


def _flaw(solid, distance, size):
    """In which way a solid is another body than the surface's, or None."""
    mesh = distance.mesh
    shells = np.bincount(mesh.pieces[mesh.triangles[:, 0]], _cones(mesh))
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
    far = cKDTree(boundary.vertices).query(_places_on(mesh))[0] > FAR * size
    if far.mean() > LOST_AREA:
        return f"the solid leaves out {far.mean():.0%} of the surface"
    return None


def more_holes(solid, distance):
    """How many holes a solid has, through it and inside, that the surface has not; negative where it lacks some."""
    return _tunnels(solid.boundary_surface[0]) - _tunnels(distance.mesh)


def _cones(mesh):
    """(m,) volumes between triangles and the first vertex of their piece, six times, positive where they look away."""
    owners = mesh.pieces[mesh.triangles[:, 0]]
    _, first, inverse = np.unique(owners, return_index=True, return_inverse=True)
    apex = mesh.vertices[mesh.triangles[first, 0]][inverse]
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles] - apex[:, None], 1, 0)
    return np.einsum("tx,tx->t", np.cross(a, b), c)


def _tunnels(mesh):
    """Handles of all shells of a closed TriangleMesh."""
    return len(np.unique(mesh.pieces[mesh.triangles[:, 0]])) - mesh.euler_characteristic // 2


def _places_on(mesh):
    """(PLACES, 3) points, the same for the same mesh, spread evenly over it."""
    random = np.random.default_rng(0)
    triangles = random.choice(mesh.triangle_count, PLACES, p=mesh.areas / mesh.areas.sum())
    shares = random.dirichlet([1, 1, 1], PLACES)
    return np.einsum("kc,kcx->kx", shares, mesh.vertices[mesh.triangles[triangles]])
