# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers beside dislocation curves: where sheets end, and which lines on faces they join."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from synch_fields.core.defects import wrap
from synch_fields.core.extract.layers.surfaces import layer_surfaces
from synch_fields.core.interpolate import EdgePhases
from synch_fields.core.interpolate_solid import evaluate_in_tets, face_numbers, tet_phases

from ...layered_solids import (
    block,
    is_manifold_at_vertices,
    is_singular,
    lies_on_boundary,
    normals,
    random_phases,
    rims,
    shell,
)

NOISES = [0.3, 2, 12]


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


@pytest.mark.parametrize("seed", [1, 3])
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
