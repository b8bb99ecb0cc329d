# SPDX-License-Identifier: GPL-3.0-or-later
"""The same surfaces in several triangulations: what bad triangles change, beside what other even ones change.

    python bench/triangulations.py FOLDER

FOLDER has fandisk.obj. All follow one smooth vector field weakly, so that there is one best field. "n = 1", "n = 2",
"n = 4": mean angle, in degrees, between the directions and those of the first even triangulation, at points all over
the surface. "stripes", "quads": mean difference of the logarithms of the distance between lines, in per cent. "/ even":
these over the most that any other even triangulation differs by. "energy": over that of the first. "away": the same
outside of balls around singular points and the surface's corners, where energies grow with the logarithm of how near
the next vertices are.
"""

from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import row_of_child
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.subdivide import sphere, subdivided
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.connection import Connection, circle_transports, levi_civita
from synch_fields.core.fields import DirectionWishes, direction_field, quad_pattern, stripe_pattern
from synch_fields.core.fields.guidance.guides import vectors_guide
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh
from synch_fields.core.geometry.nearest import NearestTriangles, nearest_in_triangles

# How strongly the field is followed, and the distance of lines on surfaces of unit area.
STRENGTH, SPACING = 20.0, 0.1
SAMPLES = 4000
NEEDLE, SLIVER = 1e-3, 1e-8
# Edges that bend by more are sharp (radians): their vertices stay. Faces of CAD bend by less than the other.
SHARP, FLAT = np.radians(30), np.radians(3)
SPREAD, ROUNDS = 0.9, 3
# Other even triangulations.
OTHERS = 3
PATTERNS = {"stripes": (2, stripe_pattern), "quads": (4, quad_pattern)}
# Radius of the balls, and the curvature (radians) of the vertices that are corners.
NEAR, CORNER = 0.03, 0.2
FIELDS = {"n = 1": 1, "n = 2": 2, "n = 4": 4}
MEASURES = (*FIELDS, *PATTERNS)
COLUMNS = (
    Column("vertices", "vertices", "d"),
    *(Column(name, name, ".2f") for name in MEASURES),
    *(Column(f"{name} / even", f"{name} ratio", ".2f") for name in MEASURES),
    *(Column(f"{name} energy", f"{name} energy ratio", ".3f") for name in MEASURES),
    *(Column(f"{name} away", f"{name} away ratio", ".3f") for name in FIELDS),
)


def main():
    """Print a table for each surface."""
    parser = arguments(__doc__, "fandisk.obj")
    parser.add_argument("names", nargs="*", default=("sphere", "torus", "fandisk"))
    options = parser.parse_args()
    for name in options.names:
        path = options.meshes / "fandisk.obj"
        rows = [row_of_child(f"{name}, {kind}", measure, name, kind, path) for kind in KINDS]
        first, others = rows[0], rows[1 : 1 + OTHERS]
        for row in rows:
            row |= {what: difference(what, first, row) for what in MEASURES}
            energies = [*(f"{what} energy" for what in MEASURES), *(f"{what} away" for what in FIELDS)]
            row |= {f"{what} ratio": row[what] / first[what] for what in energies}
        for row in rows:
            row |= {f"{what} ratio": row[what] / max(other[what] for other in others) for what in MEASURES}
        print_table(name, COLUMNS, rows)


def measure(name, kind, path):
    """Fields and patterns at points all over the surface; runs in a process of its own."""
    surface = SURFACES[name]
    even = surface(path)
    mesh = KINDS[kind](even, surface, path)
    check_mesh(mesh)
    places, normals = _samples(even)
    _, found = NearestTriangles(mesh.vertices, mesh.triangles).nearest(places)
    corners = mesh.triangles[found]
    shares = nearest_in_triangles(places, np.moveaxis(mesh.vertices[corners], 1, 0))
    row, fields = {"vertices": mesh.vertex_count}, {}
    wishes = DirectionWishes(((vectors_guide(mesh, asked(mesh.vertices)), STRENGTH),))
    x = np.cross(normals, np.roll(normals, 1, axis=1) * [1, -1, 1])
    x /= np.linalg.norm(x, axis=1)[:, None]
    y = np.cross(normals, x)
    for label, symmetry in FIELDS.items():
        fields[symmetry] = direction_field(mesh, symmetry, wishes)
        vectors = fields[symmetry].vectors[corners]
        numbers = np.einsum("pcx,px->pc", vectors, x) + 1j * np.einsum("pcx,px->pc", vectors, y)
        powers = (numbers / np.maximum(np.abs(numbers), 1e-12)) ** symmetry
        row[f"{label} values"] = np.angle((shares * powers).sum(axis=1))
        row[f"{label} energy"] = fields[symmetry].energy
        row[f"{label} away"] = _energy_away(fields[symmetry], even)
    for label, (symmetry, solve) in PATTERNS.items():
        pattern = solve(mesh, fields[symmetry], SPACING)
        row[f"{label} values"] = np.log(pattern.evenness.spacings[found])
        row[f"{label} energy"] = pattern.energy
    return row


def difference(what, first, second):
    """Degrees between directions, or per cent between distances of lines."""
    one, other = (row[f"{what} values"] for row in (first, second))
    if what in FIELDS:
        turns = np.angle(np.exp(1j * (one - other))) / FIELDS[what]
        return float(np.degrees(np.abs(turns).mean()))
    return float(100 * np.nanmean(np.abs(np.sort(one, axis=1) - np.sort(other, axis=1))))


def _energy_away(field, even):
    """Of the edges that are not near a singular point of the field or a corner of the even mesh."""
    mesh, solver_mesh = field.mesh, field.mesh.solver_mesh
    curvatures = 2 * np.pi - np.bincount(even.triangles.ravel(), even.corner_angles.ravel(), even.vertex_count)
    faces = mesh.triangles[[defect.triangle for defect in field.disclinations]]
    places = [*even.vertices[np.abs(curvatures) > CORNER], *mesh.vertices[faces].mean(axis=1)]
    away = np.ones(len(solver_mesh.edges), bool)
    if places:
        away = cKDTree(places).query(mesh.vertices[solver_mesh.edges].mean(axis=1))[0] > NEAR
    transports = circle_transports(levi_civita(solver_mesh, field.symmetry))
    connection = Connection(mesh.vertex_count, solver_mesh.edges[away], solver_mesh.weights[away], transports[away])
    return connection.energy(np.exp(1j * field.symmetry * field.angles))


def asked(places):
    """The gradient of a function with nothing of the surfaces' symmetries."""
    x, y, z = (places - places.mean(axis=0)).T * 4
    return np.column_stack([1 + 0.5 * y, 0.5 * x - 0.6 * z, 0.4 - 0.6 * y + 0.3 * z])


def _samples(mesh):
    random = np.random.default_rng(0)
    faces = random.choice(mesh.triangle_count, SAMPLES, p=mesh.areas / mesh.areas.sum())
    places = np.einsum("pc,pcx->px", random.dirichlet(np.ones(3), SAMPLES), mesh.vertices[mesh.triangles[faces]])
    return places, mesh.face_normals[faces]


# Even triangulations


def _sphere(_path):
    return sphere(20)


def _torus(_path):
    return _torus_of(*(2 * np.pi * angles for angles in np.mgrid[:96, :48] / [[[96]], [[48]]]))


def _torus_of(u, v):
    """A torus of unit area in the pairs of triangles of a lattice of angles."""
    around, across = u.shape
    ring = 1 + 0.5 * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), 0.5 * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = np.mgrid[:around, :across]

    def corner(right, up):
        return ((i + right) % around * across + (j + up) % across).ravel()

    a, b, c, d = corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return TriangleMesh(points / np.sqrt(2 * np.pi**2), triangles)


SURFACES = {"sphere": _sphere, "torus": _torus, "fandisk": read_obj}


def _moved(mesh, rounds, seed):
    """Vertices that are on no sharp edge somewhere among their neighbours, then so often in their middle."""
    random = np.random.default_rng(seed)
    sharp = np.zeros(mesh.vertex_count, bool)
    sharp[mesh.edges[np.abs(mesh.dihedral_angles) > SHARP]] = True
    surface = NearestTriangles(mesh.vertices, mesh.triangles)
    places = mesh.vertices
    for step in range(rounds + 1):
        shares = random.exponential(size=2 * len(mesh.edges)) ** 2 if step == 0 else np.ones(2 * len(mesh.edges))
        ends = np.concatenate([mesh.edges, mesh.edges[:, ::-1]])
        sums = np.column_stack(
            [np.bincount(ends[:, 0], shares * column, mesh.vertex_count) for column in places[ends[:, 1]].T]
        )
        wanted = sums / np.bincount(ends[:, 0], shares, mesh.vertex_count)[:, None]
        moved = np.where(sharp[:, None], places, surface.nearest((1 - SPREAD) * places + SPREAD * wanted)[0])
        # Where a face would turn over, its corners stay.
        for _ in range(10):
            turned = TriangleMesh(moved, mesh.triangles)
            bad = np.einsum("tx,tx->t", turned.face_normals, mesh.face_normals) < 0.5
            bad |= turned.areas < 0.05 * mesh.areas
            moved[mesh.triangles[bad]] = places[mesh.triangles[bad]]
        places = moved
    return TriangleMesh(places, mesh.triangles)


# Bad triangulations


def needles(mesh, _surface, _path):
    """Of edges that are apart, a point beside one end: needles 1000 times as long as wide."""
    half = _edges_apart(mesh)
    twin = mesh.twins[half]
    a, b, c, d = _corners(mesh, half, 0), _corners(mesh, half, 1), _corners(mesh, half, 2), _corners(mesh, twin, 2)
    points = (1 - NEEDLE) * mesh.vertices[a] + NEEDLE * mesh.vertices[b]
    p = mesh.vertex_count + np.arange(len(half))
    new = ((a, p, c), (p, b, c), (b, p, d), (p, a, d))
    return _with(mesh, points, np.concatenate([half, twin]) // 3, new)


def slivers(mesh, _surface, _path):
    """Beside edges that are apart, a point: slivers of a hundred millionth of the area."""
    half = _edges_apart(mesh)
    a, b, c = (_corners(mesh, half, k) for k in range(3))
    middle = (mesh.vertices[a] + mesh.vertices[b]) / 2
    p = mesh.vertex_count + np.arange(len(half))
    return _with(mesh, middle + SLIVER * (mesh.vertices[c] - middle), half // 3, ((a, b, p), (b, c, p), (c, a, p)))


def _edges_apart(mesh):
    """Half-edges no two of which are of one triangle or of neighbours."""
    ranks = np.random.default_rng(1).permutation(len(mesh.edges))
    best = ranks[mesh.triangle_edges].min(axis=1)
    half = np.flatnonzero(mesh.twins > np.arange(len(mesh.twins)))
    own = ranks[mesh.triangle_edges.ravel()[half]]
    return half[(best[half // 3] == own) & (best[mesh.twins[half] // 3] == own)]


def _corners(mesh, half, step):
    return mesh.triangles[half // 3, (half + step) % 3]


def _with(mesh, points, removed, new):
    triangles = [np.delete(mesh.triangles, removed, axis=0), *(np.column_stack(t) for t in new)]
    return TriangleMesh(np.concatenate([mesh.vertices, points]), np.concatenate(triangles))


def _even_again(mesh, _surface, _path, seed):
    return _moved(mesh, ROUNDS, seed)


def random(mesh, _surface, _path):
    return _moved(mesh, 0, 2)


def cad(mesh, surface, _path):
    """Faces in as few triangles as their rims need, each divided evenly."""
    if surface is _torus:
        u, v = np.meshgrid(*(2 * np.pi * np.arange(n) / n for n in (240, 20)), indexing="ij")
        return _torus_of(u, v)
    if surface is _sphere:
        return _globe(24, 160)
    import bpy  # isort: skip
    import bmesh  # on the path once bpy is loaded

    made = bmesh.new()
    for place in mesh.vertices:
        made.verts.new(place)
    made.verts.ensure_lookup_table()
    for corners in mesh.triangles.tolist():
        made.faces.new([made.verts[corner] for corner in corners])
    made.normal_update()
    bmesh.ops.dissolve_limit(made, angle_limit=FLAT, verts=made.verts, edges=made.edges)
    bmesh.ops.triangulate(made, faces=made.faces, quad_method="FIXED", ngon_method="EAR_CLIP")
    data = bpy.data.meshes.new("cad")
    made.to_mesh(data)
    corners = np.array([polygon.vertices[:] for polygon in data.polygons])
    return subdivided(TriangleMesh(np.array([vertex.co[:] for vertex in data.vertices]), corners), 4)


def _globe(rows, columns):
    """A sphere of unit area along its circles of latitude."""
    u, v = np.meshgrid(2 * np.pi * np.arange(columns) / columns, np.pi * np.arange(1, rows) / rows, indexing="ij")
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    points = np.concatenate([points, [[0, 0, 1], [0, 0, -1]]]) / np.sqrt(4 * np.pi)
    i, j = (a.ravel() for a in np.mgrid[:columns, : rows - 2])
    low, ahead = i * (rows - 1) + j, (i + 1) % columns * (rows - 1) + j
    first = np.arange(columns) * (rows - 1)
    after, top = np.roll(first, -1), np.full(columns, len(points) - 2)
    parts = [(low, low + 1, ahead + 1), (low, ahead + 1, ahead)]
    parts += [(top, first, after), (top + 1, after + rows - 2, first + rows - 2)]
    return TriangleMesh(points, np.concatenate([np.column_stack(t) for t in parts]))


KINDS = {
    "even": lambda mesh, _surface, _path: mesh,
    **{f"even, moved {seed}": partial(_even_again, seed=seed) for seed in range(OTHERS)},
    "needles": needles,
    "random": random,
    "slivers": slivers,
    "CAD": cad,
}


if __name__ == "__main__":
    main()
