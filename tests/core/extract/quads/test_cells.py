# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of quads, one for each region between grid lines."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from synch_fields.core.extract.quads.trace.cells import cells
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.patterns import PatternWishes, solve_pattern
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import evaluate, face_phases

from ...flat_crosses import plane_edge_phases
from ...meshes import as_triangles, bent_square, cube, icosphere, mixed_torus, quad_cube, square, with_split

SURFACES = {
    "triangles-sphere": lambda: as_triangles(icosphere(2)),
    "triangles-bounded": lambda: as_triangles(bent_square()),
    "triangles-cube": lambda: as_triangles(cube(4)),
    "quads-cube": quad_cube,
    "mixed": mixed_torus,
}


def solved(build, symmetry, share):
    """A pattern coarse enough for defects of both kinds, and the polygons and phases of the surface."""
    mesh, polygons = build()
    spacing = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / share
    pattern = solve_pattern(mesh, direction_field(mesh, symmetry), PatternWishes(spacing))
    polygons = with_split(polygons, pattern.on_faces(polygons)[0].unfit)
    return pattern, polygons, pattern.on_faces(polygons)


def has_defect(phases, polygons):
    """(m,) bool: triangles of faces in which phases turn."""
    turns = [phase.index | phase.index_2 | phase.disclination.any(axis=1) for phase in phases]
    return np.any(turns, axis=0)[polygons.triangle_faces]


def flooded(phases, polygons, parts=30):
    """Dense places in cells, clear of their borders, and the connected regions that they fall into.

    Points of a lattice on every triangle are neighbours along its lines; those on an edge are points of both triangles.
    Of stripes these are places near their middle, but for faces that touch one with a defect, where two lines may come
    close; of quads those off the grid lines, but for the neighbourhood of dislocations, where phases turn faster than
    any lattice.
    """
    i, j = (a.ravel() for a in np.meshgrid(np.arange(parts + 1), np.arange(parts + 1), indexing="ij"))
    lattice = np.column_stack([i, j, parts - i - j])[i + j <= parts]
    steps = np.argwhere(np.triu(np.abs(lattice[:, None] - lattice).sum(axis=2) == 2))
    count, size = len(polygons.triangle_faces), len(lattice)
    triangles = np.repeat(np.arange(count), size)
    weights = np.tile(lattice / parts, (count, 1))
    inside = 0.999 * weights + 0.001 / 3
    values = np.stack([evaluate(phase, polygons, triangles, inside) for phase in phases])
    odd = has_defect(phases, polygons)[triangles]
    beside = np.isin(polygons.triangles, polygons.triangles[has_defect(phases, polygons)]).any(axis=1)[triangles]
    if len(phases) == 2:
        usable = (np.abs(np.sin(values)) > np.sin(0.35)).all(axis=0) & ~(odd & (1 - 3 * weights.min(axis=1) < 0.2))
    else:
        usable = (np.cos(values[0]) > 0.96) & ~beside
    places = np.rint(weights * parts).astype(int)
    keys = np.sort(np.where(places == 0, 10**9, polygons.triangles[triangles] * (2 * parts) + places), axis=1)
    alone = np.flatnonzero((places > 0).all(axis=1))
    keys[alone] = -1 - alone[:, None]
    nodes = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    ends = (np.arange(count)[:, None, None] * size + steps).reshape(-1, 2)
    ends = ends[usable[ends].all(axis=1)]
    graph = coo_array((np.ones(len(ends)), nodes[ends].T), shape=(nodes.max() + 1,) * 2)
    _, labels = connected_components(graph, directed=False)
    return triangles[usable], inside[usable], labels[nodes[usable]]


@pytest.mark.parametrize("name", SURFACES)
def test_a_flood_of_the_surface_stays_in_one_quad(name):
    polygons, phases = solved(SURFACES[name], 4, 7)[1:]
    assert has_defect(phases, polygons).any() or name == "triangles-bounded"
    found = cells(phases, polygons)
    triangles, weights, floods = flooded(phases, polygons)
    numbers = found.at(triangles, weights)
    known = numbers > 0
    # Pieces that touch no edge of a coarse triangle are not known.
    assert known.mean() > 0.9 and numbers.max() <= found.count
    met = np.unique(np.column_stack([floods, numbers])[known], axis=0)
    assert (np.bincount(met[:, 0]) <= 1).all(), "one region with two numbers"
    sizes = np.bincount(floods)
    regions = met[sizes[met[:, 0]] > 60]  # the rest are specks at borders
    # But for cells beside the end of a grid line, which are one, where the flood does not find the way around it.
    assert (np.bincount(regions[:, 1]) > 1).sum() <= 0.03 * len(regions), "one number in two regions"


def test_quads_of_a_plane_are_its_squares():
    mesh = square(20)
    phases = face_phases(plane_edge_phases(mesh, 0.0, 0.5, origin=(0.01, 0.02, 0)), Polygons.of_triangles(mesh))
    found = cells(phases, Polygons.of_triangles(mesh))
    assert found.count == 25
