# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as triangles: complete, manifold, in order, and exactly on the surfaces that are to carry one."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from synch_fields.core.defects import wrap
from synch_fields.core.extract.layer_surfaces import layer_surfaces
from synch_fields.core.fields.layers import LayerGroup, solve_layers
from synch_fields.core.fields.solid_guidance import axis_directions, distance_directions
from synch_fields.core.geometry.tet_mesh import TetMesh, positive
from synch_fields.core.interpolate import EdgePhases
from synch_fields.core.interpolate_solid import evaluate_in_tets, face_numbers, tet_phases

from .layered_solids import bent_bar, block, random_phases, shell
from .meshes import icosphere

NOISES = [0.3, 2, 12]


def phases_of(mesh, angles):
    """Phases that change along edges as given angles do."""
    i, j = mesh.edges.T
    asked = (angles[j] - angles[i])[:, None]
    return EdgePhases.of(mesh, np.exp(1j * angles)[:, None], asked, np.zeros(len(asked), int))


def surfaces_of(pattern, **options):
    return layer_surfaces(pattern.edge_phases, pattern.heights, **options)


def normals(layers):
    """(t, 3) twice the areas, along the triangles' normals."""
    a, b, c = np.moveaxis(layers.vertices[layers.triangles], 1, 0)
    return np.cross(b - a, c - a)


def rims(layers):
    """(k, 2) vertices of the edges with one triangle; every other one has two that run along it both ways."""
    tails, heads = layers.triangles.ravel(), np.roll(layers.triangles, -1, axis=1).ravel()
    ways = list(zip(tails.tolist(), heads.tolist(), strict=True))
    assert len(set(ways)) == len(ways), "two triangles run the same way along an edge"
    met = set(ways)
    return np.array([way for way in ways if way[::-1] not in met], int).reshape(-1, 2)


def is_manifold_at_vertices(layers):
    """Whether the triangles around every vertex are one fan."""
    corners = np.arange(layers.triangles.size).reshape(-1, 3)
    ends = {}
    for tail, head, one, other in zip(
        layers.triangles.ravel(),
        np.roll(layers.triangles, -1, 1).ravel(),
        corners.ravel(),
        np.roll(corners, -1, 1).ravel(),
        strict=True,
    ):
        ends[tail, head] = one, other
    pairs = [
        pair
        for (a, b), (one, other) in ends.items()
        if (b, a) in ends
        for pair in zip((one, other), ends[b, a][::-1], strict=True)
    ]
    graph = coo_matrix((np.ones(len(pairs)), np.array(pairs).T), shape=(corners.size, corners.size))
    return connected_components(graph, directed=False)[0] == len(np.unique(layers.triangles)) == len(layers.vertices)


def lies_on_boundary(mesh, layers, edges):
    """(k,) whether both ends lie on one face of the solid's boundary."""
    faces = {tuple(face) for face in np.sort(mesh.boundary_triangles, axis=1).tolist()}
    used = layers.weights[edges] > 0
    result = []
    for corners, of in zip(layers.corners[edges], used, strict=True):
        support = np.unique(corners[of])
        around = (set(support) <= set(face) for face in faces)
        result.append(any(around))
    return np.array(result, bool)


def is_singular(layers, edges):
    """(k,) whether an edge runs from the centre of a face to that of a tetrahedron."""
    return (np.sort((layers.weights[edges] > 0).sum(axis=2), axis=1) == [3, 4]).all(axis=1)


def vertices_met(layers):
    """(t, 3) vertices of the solid at the triangles' corners, -1 where there is none."""
    at_vertex = layers.weights.max(axis=1) == 1
    vertex = np.where(at_vertex, layers.corners[np.arange(len(layers.corners)), layers.weights.argmax(axis=1)], -1)
    return vertex[layers.triangles]


def faces_carried(layers, triangles):
    """How often each of the solid's triangles is a triangle of a layer."""
    found = [tuple(row) for row in np.sort(vertices_met(layers), axis=1).tolist()]
    return [found.count(tuple(sorted(row))) for row in np.asarray(triangles).tolist()]


def on_faces(layers, vertices):
    """(t,) triangles with corners at these vertices only."""
    return np.isin(vertices_met(layers), vertices).all(axis=1)


# Planes


@pytest.mark.parametrize("offset", [0.0, 2.0])
@pytest.mark.parametrize("spacing", [0.23, 0.07])
def test_constant_directions_give_whole_planes_at_exact_distances(spacing, offset):
    mesh = block((5, 4, 6), (1, 1.2, 1.1), jitter=0.2)
    pattern = solve_layers(
        mesh, axis_directions(mesh, (0, 0, 1)), spacing, [LayerGroup.of_vertices(mesh, mesh.vertices[:, 2] == 0, 0.0)]
    )
    layers = surfaces_of(pattern, offset=offset)
    expected = np.arange(offset / (2 * np.pi) * spacing, 1.1, spacing)
    assert layers.count == len(expected)
    heights = layers.vertices[layers.triangles][:, :, 2]
    np.testing.assert_allclose(heights, np.tile(expected[layers.layers, None], 3), atol=1e-6 * spacing)
    np.testing.assert_allclose(layers.areas, 1.2, rtol=1e-6)
    assert (normals(layers)[:, 2] > 0).all() and (np.diff(layers.layers) >= 0).all()
    assert lies_on_boundary(mesh, layers, rims(layers)).all()


def test_tilted_planes_are_cut_off_by_the_solid():
    """The area of a level is the derivative of the volume below it: areas add up to the volume over the spacing."""
    mesh = block((6, 6, 6), jitter=0.2)
    axis, spacing = np.array([3, 2, 6]) / 7, 0.04
    layers = surfaces_of(solve_layers(mesh, axis_directions(mesh, axis), spacing))
    places = layers.vertices[layers.triangles] @ axis
    assert np.ptp(places, axis=1).max() < 1e-6
    steps = np.diff([places[layers.layers == k].mean() for k in range(layers.count)])
    np.testing.assert_allclose(steps, spacing, atol=1e-6 * spacing)
    assert layers.areas.sum() * spacing == pytest.approx(1, rel=2e-3)
    assert ((normals(layers) @ axis) > 0).all()


def test_places_in_between_take_values_in_between():
    mesh = block((4, 4, 4), jitter=0.2)
    pattern = solve_layers(mesh, axis_directions(mesh, (1, 1, 2)), 0.21)
    layers = surfaces_of(pattern)
    np.testing.assert_allclose(layers.interpolated(mesh.vertices), layers.vertices, atol=1e-12)
    np.testing.assert_allclose(layers.interpolated(mesh.vertices[:, 0]), layers.vertices[:, 0], atol=1e-12)


# Exactly on surfaces


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_vertices_on_a_level_leave_neither_slivers_nor_holes(jitter, direction):
    """Every plane of the grid is a level, the two ends of the block too."""
    mesh = block((4, 4, 4), jitter=0)
    vertices = mesh.vertices + jitter / 4 * np.random.default_rng(0).uniform(-1, 1, mesh.vertices.shape) * [1, 1, 0]
    mesh = TetMesh(vertices, mesh.tets)
    random = np.random.default_rng(1)
    angles = direction * 8 * np.pi * mesh.vertices[:, 2] + 1e-10 * random.standard_normal(mesh.vertex_count)
    layers = layer_surfaces(phases_of(mesh, angles), angles)
    assert layers.count == 5 and len(layers.triangles) == 5 * 32
    assert layers.weights.max(axis=1).min() == 1 and is_manifold_at_vertices(layers)
    assert np.ptp(layers.vertices[layers.triangles][:, :, 2], axis=1).max() < 1e-12
    flat = np.unique(
        np.sort(layers.corners[layers.triangles, layers.weights[layers.triangles].argmax(axis=2)], axis=1), axis=0
    )
    assert len(flat) == 5 * 32
    assert (direction * normals(layers)[:, 2] > 0).all()
    # From the bottom of the growth upwards.
    levels = layers.vertices[layers.triangles][:, 0, 2]
    np.testing.assert_allclose(levels, layers.layers / 4 if direction > 0 else 1 - layers.layers / 4)


@pytest.mark.parametrize("count", [3, 4])
def test_between_concentric_spheres_every_layer_is_a_closed_sphere(count):
    mesh = shell(np.linspace(1, 1.8, 6), 3, jitter=0.005)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    inner, outer = mesh.boundary_vertices & (radius < 1.01), mesh.boundary_vertices & (radius > 1.79)
    groups = [LayerGroup.of_vertices(mesh, chosen, 0.0) for chosen in (inner, outer)]
    spacing = 0.8 / count
    layers = surfaces_of(solve_layers(mesh, mesh.vertices / radius[:, None], spacing, groups))
    assert layers.count == count + 1 and len(rims(layers)) == 0 and is_manifold_at_vertices(layers)
    for group in groups:
        assert faces_carried(layers, group.triangles) == [1] * len(group.triangles)
    assert (layers.layers == 0).sum() == len(groups[0].triangles)
    assert (layers.layers == count).sum() == len(groups[1].triangles)
    found = [
        np.linalg.norm(layers.vertices[layers.triangles[layers.layers == k]], axis=2).mean() for k in range(count + 1)
    ]
    np.testing.assert_allclose(np.diff(found), spacing, rtol=0.02)
    centres = layers.vertices[layers.triangles].mean(axis=1)
    assert (np.einsum("tx,tx->t", normals(layers), centres) > 0).all()
    for k in range(count + 1):
        piece = layers.triangles[layers.layers == k]
        assert len(np.unique(piece)) - len(piece) // 2 == 2


@pytest.mark.parametrize("sign", [1, -1])
def test_tetrahedra_with_all_corners_on_the_surface_do_not_hide_it(sign):
    """A ball whose tetrahedra all have their faces on the surface but for the centre, and some have nothing else."""
    ball = icosphere(1)
    tets = np.column_stack([ball.triangles, np.full(ball.triangle_count, ball.vertex_count)])
    vertices = np.vstack([ball.vertices, np.zeros(3)])
    peak = np.array([len(vertices)])
    # A tent on three vertices of one face, whose four corners all lie on the boundary.
    vertices = np.vstack([vertices, 1.4 * ball.vertices[ball.triangles[0]].mean(axis=0)])
    tets = np.vstack([tets, np.concatenate([ball.triangles[0], peak])])
    mesh = TetMesh(vertices, positive(vertices, tets))
    group = LayerGroup.of_vertices(mesh, mesh.boundary_vertices, 0.0)
    assert len(group.triangles) == len(mesh.boundary_triangles) == ball.triangle_count + 2
    inwards = distance_directions(mesh, mesh.boundary_vertices)
    pattern = solve_layers(mesh, sign * inwards, 1.7, [group])
    layers = surfaces_of(pattern)
    assert layers.count == 1 and len(layers.triangles) == len(group.triangles)
    assert faces_carried(layers, group.triangles) == [1] * len(group.triangles)
    assert len(rims(layers)) == 0


def test_a_layer_goes_on_where_its_surface_ends():
    """Half the floor is a layer; where it ends, the layer goes on inside the solid as the same piece."""
    mesh = block((8, 4, 8), (2, 1, 1))
    x, _, z = mesh.vertices.T
    angles = 2 * np.pi * np.where(x <= 1, z, z - 0.4 * (x - 1)) / 0.5
    layers = layer_surfaces(phases_of(mesh, angles), angles)
    floor = mesh.boundary_triangles[(mesh.vertices[mesh.boundary_triangles][:, :, 2] == 0).all(axis=1)]
    left = floor[(mesh.vertices[floor][:, :, 0] <= 1).all(axis=1)]
    assert faces_carried(layers, left) == [1] * len(left)
    lowest = layers.triangles[layers.layers == 0]
    expected = 1 + np.hypot(1, 0.4)
    assert layers.areas[0] == pytest.approx(expected, rel=0.01) and layers.count == 3
    assert np.ptp(layers.vertices[lowest][:, :, 0]) == 2


@pytest.mark.parametrize("sign", [1, -1])
def test_a_level_that_is_only_touched_is_no_layer(sign):
    mesh = block((3, 3, 4))
    z = mesh.vertices[:, 2]
    assert layer_surfaces(phases_of(mesh, sign * np.abs(z - 0.5)), z).count == 0
    assert layer_surfaces(phases_of(mesh, sign * (z - 0.5)), z).count == 1


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("noise", NOISES)
def test_a_surface_is_whole_whatever_is_beside_it(noise, seed):
    mesh = block((4, 4, 3), jitter=0.2)
    z = mesh.vertices[:, 2]
    groups = [LayerGroup.of_vertices(mesh, chosen, 0.0) for chosen in (z == 0, z == 1)]
    random = np.random.default_rng(seed)
    # Many more vertices on levels than chance has it.
    resting = np.flatnonzero((z == 0) | (z == 1) | (random.random(len(z)) < 0.3))
    edge_phases = random_phases(mesh, noise, seed, resting)
    for group in groups:
        edge = mesh.edges_between(*group.sides.T)
        edge_phases.changes[edge] = 0
    layers = layer_surfaces(edge_phases, z)
    for group in groups:
        assert faces_carried(layers, group.triangles) == [1] * len(group.triangles)
        assert len(np.unique(layers.layers[on_faces(layers, group.vertices)])) == 1
    rims(layers)
    assert is_manifold_at_vertices(layers)
    assert (np.linalg.norm(normals(layers), axis=1) > 0).all()


# Dislocations


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("build", [lambda: block((3, 3, 3), jitter=0.2), lambda: shell(np.linspace(1, 2, 3), 1)])
def test_sheets_end_on_the_boundary_and_at_dislocation_curves_only(build, noise):
    mesh = build()
    edge_phases = random_phases(mesh, noise)
    layers = layer_surfaces(edge_phases, mesh.vertices[:, 2])
    edges = rims(layers)
    singular = is_singular(layers, edges)
    assert (singular | lies_on_boundary(mesh, layers, edges)).all()
    assert is_manifold_at_vertices(layers)
    # Each of the singular segments of number N bounds |N| sheets.
    assert singular.sum() == np.abs(tet_phases(edge_phases).numbers).sum() > 0


@pytest.mark.parametrize("noise", NOISES)
def test_every_edge_is_crossed_as_often_as_the_phase_passes_a_level(noise):
    mesh = block((3, 3, 3), jitter=0.2)
    edge_phases = random_phases(mesh, noise)
    layers = layer_surfaces(edge_phases, mesh.vertices[:, 2])
    on_edge = (layers.weights > 0).sum(axis=1) == 2
    found = {}
    for corners, weights in zip(layers.corners[on_edge], layers.weights[on_edge], strict=True):
        i, j = sorted(corners[weights > 0].tolist())
        found.setdefault((i, j), []).append(weights[corners == j].max())
    for edge, (i, j) in enumerate(mesh.edges.tolist()):
        begin, change = edge_phases.arguments[i, 0], edge_phases.changes[edge, 0]
        levels = [k for k in range(-40, 41) if min(begin, begin + change) < 2 * np.pi * k < max(begin, begin + change)]
        expected = sorted((2 * np.pi * k - begin) / change for k in levels)
        np.testing.assert_allclose(sorted(found.get((i, j), [])), expected, atol=1e-6)


@pytest.mark.parametrize("noise", [0.2, 1.5])
@pytest.mark.parametrize("rate", [12, 35])
def test_in_regular_tetrahedra_layers_lie_where_the_interpolant_says(rate, noise):
    """All over each triangle, and with normals along the growth."""
    mesh = block((3, 3, 3), jitter=0.2)
    wave = mesh.vertices @ [0.4 * rate, 0.2 * rate, rate]
    i, j = mesh.edges.T
    shaken = np.exp(1j * (wave + noise * np.random.default_rng(0).standard_normal(len(wave))))
    edge_phases = EdgePhases.of(mesh, shaken[:, None], (wave[j] - wave[i])[:, None], np.zeros(len(i), int))
    phases = tet_phases(edge_phases)
    assert phases.punctured.any() == (noise > 1)
    layers = layer_surfaces(edge_phases, mesh.vertices[:, 2])
    checked = 0
    for triangle, normal in zip(layers.triangles, normals(layers), strict=True):
        support = np.unique(layers.corners[triangle][layers.weights[triangle] > 0])
        (tet,) = np.flatnonzero(np.isin(mesh.tets, support).sum(axis=1) == len(support))[:1]
        if len(support) < 4 or phases.punctured[tet]:
            continue
        weights = np.zeros((3, 4))
        for row, vertex in zip(weights, triangle, strict=True):
            for corner, weight in zip(layers.corners[vertex], layers.weights[vertex], strict=True):
                row[mesh.tets[tet] == corner] += weight
        inside = np.random.default_rng(0).dirichlet(np.ones(3), 3) @ weights
        np.testing.assert_allclose(wrap(evaluate_in_tets(phases, np.full(3, tet), inside)), 0, atol=1e-9)
        assert normal @ phases.gradients(mesh)[tet] > 0
        checked += 1
    assert checked > 50


@pytest.mark.parametrize("seed", range(1, 4))
def test_on_punctured_faces_lines_join_what_the_interpolant_joins(seed):
    """Brute force: which crossings lie on the same level line of a fine grid on the face."""
    mesh = block((2, 2, 2), jitter=0.2)
    edge_phases = random_phases(mesh, 6, seed)
    layers, phases, numbers = (
        layer_surfaces(edge_phases, mesh.vertices[:, 2]),
        tet_phases(edge_phases),
        face_numbers(edge_phases),
    )
    edges = rims(layers)
    supports = [frozenset(layers.corners[edge][layers.weights[edge] > 0].tolist()) for edge in edges]
    grid, cells = fine_triangle(150)
    punctured = mesh.boundary_faces[numbers[mesh.boundary_faces] != 0]
    turned_around, met = 0, 0
    for face in punctured:
        vertices = mesh.faces[face].tolist()
        lines = edges[[support <= set(vertices) and len(support) == 3 for support in supports]]
        tet = mesh.face_tets[face, 0]
        weights = np.zeros((len(grid), 4))
        weights[:, [mesh.tets[tet].tolist().index(vertex) for vertex in vertices]] = grid
        line_of = level_lines(wrap(evaluate_in_tets(phases, np.full(len(grid), tet), weights)), grid, cells)
        for line in lines:
            places = [[layers.weights[v][layers.corners[v] == vertex].sum() for vertex in vertices] for v in line]
            inner = [np.ptp(place) < 1e-9 for place in places]
            ends = [line_of(np.array(place)) for place, centre in zip(places, inner, strict=True) if not centre]
            assert len(set(ends)) == 1 and (any(inner) == (ends[0] == "centre"))
            turned_around += not any(inner)
            met += any(inner)
    assert met == np.abs(numbers[punctured]).sum() and turned_around > 3


def fine_triangle(count):
    """Barycentric grid points of a triangle, and the small triangles between them."""
    places = [(i, j) for i in range(count + 1) for j in range(count + 1 - i)]
    number = {place: k for k, place in enumerate(places)}
    up = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i, j in places if i + j < count]
    down = [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in places if i + j < count - 1]
    i, j = np.array(places).T / count
    return np.column_stack([1 - i - j, i, j]), np.array(up + down)


def level_lines(values, grid, cells):
    """A function from places to the name of the line nearby on which the values are 0: all that come to the middle of
    the triangle are the same one."""
    around = values[cells]
    crossed = (around.min(axis=1) < 0) & (around.max(axis=1) > 0) & (np.abs(around).max(axis=1) < 1.5)
    middles = grid[cells].mean(axis=1)
    crossed &= np.abs(middles - 1 / 3).max(axis=1) > 0.03
    sides = np.sort(cells[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owners = np.repeat(np.arange(len(cells)), 3)
    passed = crossed[owners] & (np.sign(values[sides[:, 0]]) != np.sign(values[sides[:, 1]]))
    keys, owners = sides[passed] @ [len(grid), 1], owners[passed]
    order = np.argsort(keys, kind="stable")
    pair = np.flatnonzero(np.diff(keys[order]) == 0)
    graph = coo_matrix((np.ones(len(pair)), (owners[order][pair], owners[order][pair + 1])), shape=(len(cells),) * 2)
    label = connected_components(graph, directed=False)[1]
    central = np.unique(label[crossed & (np.abs(middles - 1 / 3).max(axis=1) < 0.07)])
    crossed = np.flatnonzero(crossed)

    def line_of(place):
        found = label[crossed[np.abs(middles[crossed] - place).sum(axis=1).argmin()]]
        return "centre" if found in central else int(found)

    return line_of


def test_a_screw_joins_all_layers_to_one_ramp():
    mesh = block((9, 9, 12))
    x, y, z = mesh.vertices.T
    around = np.arctan2(y - 0.49, x - 0.52)
    i, j = mesh.edges.T
    rise = 2 * np.pi * 4 * z
    asked = (wrap(around[j] - around[i]) + rise[j] - rise[i])[:, None]
    edge_phases = EdgePhases.of(mesh, np.exp(1j * (around + rise))[:, None], asked, np.zeros(len(asked), int))
    layers = layer_surfaces(edge_phases, z)
    assert layers.count == 1
    # A helicoid of pitch 1/4, its area in closed form per unit height over the square.
    grid = (np.arange(400) + 0.5) / 400
    radius = np.hypot(*np.meshgrid(grid - 0.52, grid - 0.49))
    pitch = 0.25 / (2 * np.pi)
    assert layers.areas.sum() == pytest.approx(4 * np.sqrt(1 + (pitch / radius) ** 2).mean(), rel=0.02)
    ends = rims(layers)
    curve = layers.vertices[np.unique(ends[is_singular(layers, ends)])]
    assert np.ptp(curve[:, 2]) > 0.98 and np.abs(curve[:, :2] - [0.52, 0.49]).max() < 0.15


def test_half_layers_stand_between_the_layers_that_they_part():
    """Eight layers at the inside of a bent bar and eleven at the outside: three end within."""
    mesh, around = bent_bar((8, 33, 4), 1, 2, np.pi / 2, 0.2)
    x, y, _ = mesh.vertices.T
    radius = np.hypot(x, y)
    spacing = radius * np.pi / 2 / np.where(radius < 1.49, 8, 11)
    groups = [LayerGroup.of_vertices(mesh, end < 1e-9, 0.0) for end in (x, y)]
    pattern = solve_layers(mesh, around, spacing, groups)
    layers = surfaces_of(pattern)
    assert layers.count == 12
    turn = np.arctan2(layers.vertices[:, 1], layers.vertices[:, 0])[layers.triangles].mean(axis=1)
    middles = [turn[layers.layers == k].mean() for k in range(layers.count)]
    assert (np.diff(middles) > 0).all()
    reach = np.hypot(layers.vertices[:, 0], layers.vertices[:, 1])[layers.triangles].min(axis=1)
    halves = [reach[layers.layers == k].min() > 1.2 for k in range(layers.count)]
    assert sum(halves) == 3 and not (halves[0] or halves[-1])
    for end in (0, -1):
        carried = faces_carried(layers, groups[end].triangles)
        assert carried == [1] * len(carried)
    assert (layers.areas[halves] < 0.7 * np.median(layers.areas)).all()
