# SPDX-License-Identifier: GPL-3.0-or-later
"""The solids of the paper's Figure 3: layers in them, spectral, semidefinite, and flush with two surfaces.

    python bench/solids.py MESHES

A ring with a wavy top, MESHES/bunny.mesh, and MESHES/stanford-bunny.obj with its holes closed and stuffed with
tetrahedra. Layers follow the gradient of the harmonic function between two chosen surfaces: bottom and top of the
ring, base and tips of the ears. Prints energies, bounds, dislocation curves and how far the layers are from the chosen
surfaces, and checks that the energies are in the order of Eq. (23). docs/make/layers.py draws them.
"""

from time import process_time

import numpy as np
from scipy.spatial import cKDTree

from synch_fields.bench.command import arguments
from synch_fields.bench.solid_shapes import ring, solid_bunny, stuffed_bunny
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.extract.layers.defect_curves import defect_curves
from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.fields.guidance.potentials import harmonic_function
from synch_fields.core.fields.guidance.solids import extend_directions, gradient_vectors
from synch_fields.core.fields.layers import LayerPattern, SolidTargetOneForm, solve_layers
from synch_fields.core.geometry.nearest import nearest_in_triangles
from synch_fields.core.solve import Options

# Size of the stuffed bunny's lattice, whose surface has an area of 1.
BUNNY_SIZE = 0.014
# Distance between layers over the diagonal of the solid's box.
SPACINGS = {"ring": 0.021, "bunny.mesh": 0.06, "bunny": 0.035}
WAYS = (("spectral", "spectral", False), ("SDP", "sdp", False), ("SDP, flush", "sdp", True))
COLUMNS = (
    Column("vertices", "vertices", "d"),
    Column("tetrahedra", "tets", "d"),
    Column("spectral bound", "spectral bound", ".3f"),
    Column("lower bound", "bound", ".3f"),
    Column("SDP", "sdp", ".3f"),
    Column("energy", "energy", ".3f"),
    Column("certificate", "certificate", ""),
    Column("curves", "curves", "d"),
    Column("their length / size", "length", ".2f"),
    Column("layers", "layers", "d"),
    Column("spacing off", "deviation", ".1%"),
    Column("from the surfaces / size: mean", "mean off", ".1e"),
    Column("worst", "worst off", ".1e"),
    Column("s CPU", "seconds", ".1f"),
)
# Triangles among which the nearest to a point is looked for, by their centres.
CANDIDATES = 40


def main():
    """Print the table."""
    options = arguments(__doc__, "bunny.mesh and stanford-bunny.obj").parse_args()
    rows = []
    for name in SPACINGS:
        _, results = compared(name, shape_of(name, options.meshes))
        rows += [row for row, _ in results]
        check_order([row for row, _ in results])
    print_table("Figure 3: layers in solids", COLUMNS, rows)


def shape_of(name, meshes):
    """The solid of a name among :data:`SPACINGS`."""
    if name == "ring":
        return ring()
    return solid_bunny(meshes) if name == "bunny.mesh" else stuffed_bunny(meshes, BUNNY_SIZE)


def compared(name, shape):
    """The harmonic function of a solid, and for each way a row of the table and the pattern."""
    mesh, spacing = shape.mesh, SPACINGS[name] * shape.size
    function = harmonic_function(mesh, shape.low, shape.high)
    directions = extend_directions(mesh, gradient_vectors(mesh, function))
    results = []
    for way, method, is_flush in WAYS:
        groups = shape.groups if is_flush else []
        start = process_time()
        pattern = solve_layers(mesh, directions, spacing, groups, Options(method=method))
        seconds = process_time() - start
        if not is_flush:
            pattern = turned(pattern, SolidTargetOneForm.of(mesh, directions, spacing), shape.low | shape.high)
        row = measured(pattern, shape) | {"label": f"{shape.name}: {way}", "seconds": seconds}
        results.append((row, pattern))
    return function, results


def turned(pattern, growth, vertices):
    """The same solution with the common phase that brings its layers nearest to some vertices."""
    common = pattern.solution.phases[vertices].sum()
    return LayerPattern(
        pattern.mesh, pattern.solution, growth.edge_phases(pattern.solution.phases * np.exp(-1j * np.angle(common)))
    )


def measured(pattern, shape):
    """What the table says of a pattern."""
    mesh, solution = pattern.mesh, pattern.solution
    curves = defect_curves(mesh, pattern.face_numbers)
    assert all(curve.is_closed or ends_on_boundary(mesh, curve) for curve in curves)
    surfaces = layer_surfaces(pattern.edge_phases, pattern.heights)
    off = distances(mesh.vertices[shape.low | shape.high], surfaces) / shape.size
    spacings = pattern.spacings
    return {
        "vertices": mesh.vertex_count,
        "tets": mesh.tet_count,
        "spectral bound": solution.spectral_bound,
        "bound": solution.lower_bound if solution.spectral_bound is None else None,
        "sdp": solution.sdp_value,
        "energy": solution.energy,
        "certificate": solution.certificate,
        "curves": len(curves),
        "length": sum(lengths(curve) for curve in curves) / shape.size,
        "layers": surfaces.count,
        "deviation": spacings.deviation / spacings.mean,
        "mean off": off.mean(),
        "worst off": off.max(),
    }


def ends_on_boundary(mesh, curve):
    return np.isin(curve.faces[[0, -1]], mesh.boundary_faces).all()


def lengths(curve):
    points = np.vstack([curve.points, curve.points[:1]]) if curve.is_closed else curve.points
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def distances(points, surfaces):
    """(k,) distances of points to the nearest layer, at most: of the triangles whose centres are near."""
    corners = surfaces.vertices[surfaces.triangles]
    _, near = cKDTree(corners.mean(axis=1)).query(points, k=CANDIDATES)
    shares = nearest_in_triangles(points[:, None], np.moveaxis(corners[near], -2, 0))
    places = np.einsum("pcx,pcxy->pcy", shares, corners[near])
    return np.linalg.norm(places - points[:, None], axis=2).min(axis=1)


def check_order(rows):
    """Eq. (23): spectral bound, lower bound, value of the relaxation, energy, energy of the spectral phases."""
    spectral, free, flush = rows
    chain = [spectral["spectral bound"], free["bound"], free["sdp"], free["energy"], spectral["energy"]]
    others = [free["bound"], flush["bound"], flush["sdp"], flush["energy"]]
    for name, values in (("free", chain), ("flush", others)):
        if (np.diff(values) < -1e-9 * abs(values[-1])).any():
            raise SystemExit(f"out of order at {free['label']} ({name}): {values}")


if __name__ == "__main__":
    main()
