# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stuffing: angles within the paper's bounds, boundary on the surface, volume and topology of known shapes."""

from itertools import product

import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SettingError
from synch_fields.core.geometry import TriangleMesh, check_mesh
from synch_fields.core.geometry.filling.lattice import build_lattice
from synch_fields.core.geometry.filling.stencils import stencil
from synch_fields.core.geometry.filling.stuffing import (
    DIHEDRAL_BOUNDS,
    MOST_CUBES,
    WARP_LONG,
    WARP_SHORT,
    estimated_bytes,
    estimated_cubes,
    estimated_tets,
    fill_surface,
)
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.tet_mesh import TET_EDGES, TetMesh, signed_volumes

from ...meshes import shared_mesh
from ...solids import ball_distance, box_distance, dihedral_angles, enclosed_volume, shell_distance, torus_distance

BALL = np.array([[-1.0] * 3, [1.0] * 3])
TORUS = np.array([[-1.4, -1.4, -0.4], [1.4, 1.4, 0.4]])
TURN = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]


def turned_box(points):
    return box_distance(points @ TURN)


def check_stuffed(mesh, signed_distance, chi, tolerance=1e-6):
    """What holds of every stuffed solid whose surface has Euler characteristic ``chi``."""
    angles = dihedral_angles(mesh)
    assert DIHEDRAL_BOUNDS[0] <= angles.min() <= angles.max() <= DIHEDRAL_BOUNDS[1]
    surface, source = mesh.boundary_surface
    check_mesh(surface)
    assert len(surface.boundary_edges) == 0
    assert surface.euler_characteristic == chi
    assert enclosed_volume(surface) == pytest.approx(mesh.volumes.sum(), rel=1e-9)
    reach = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    assert np.abs(signed_distance(mesh.vertices[source])).max() <= tolerance * reach
    assert signed_distance(mesh.vertices[~mesh.boundary_vertices]).max() < 0
    assert len(mesh.loose_vertices) == 0


@pytest.mark.parametrize(
    ("signed_distance", "bounds", "sizes", "volume", "chi", "share"),
    [
        pytest.param(ball_distance, BALL, (0.25, 0.125), 4 / 3 * np.pi, 2, 0.3, id="ball"),
        pytest.param(torus_distance, TORUS, (0.2, 0.1), 2 * np.pi**2 * 0.16, 0, 0.6, id="torus"),
        pytest.param(shell_distance, BALL, (0.2, 0.1), 4 / 3 * np.pi * 0.875, 4, 0.2, id="shell"),
        pytest.param(turned_box, 0.9 * BALL, (0.16, 0.08), 1.0, 2, 1.3, id="turned-cube"),
    ],
)
def test_volume_converges_quadratically_and_topology_is_right(signed_distance, bounds, sizes, volume, chi, share):
    """The volume misses a ``share`` of the square of the size, which is that of the surface's curvatures and edges."""
    for size in sizes:
        mesh = fill_surface(signed_distance, bounds, size)
        check_stuffed(mesh, signed_distance, chi)
        assert mesh.edge_lengths.max() < 1.6 * size
        assert abs(mesh.volumes.sum() / volume - 1) < share * size**2


def test_a_cube_on_the_lattice_is_filled_exactly():
    mesh = fill_surface(box_distance, BALL / 2, 0.1)
    check_stuffed(mesh, box_distance, 2)
    assert mesh.volumes.sum() == pytest.approx(1, abs=1e-12)
    assert dihedral_angles(mesh).min() > 44.9


def test_inside_the_lattice_is_regular():
    """Far from the surface every tetrahedron has four angles of 60 degrees and two of 90."""
    size = 0.1
    mesh = fill_surface(ball_distance, BALL, size)
    deep = (ball_distance(mesh.vertices[mesh.tets].reshape(-1, 3)).reshape(-1, 4) < -2 * size).all(axis=1)
    assert deep.sum() > 10000
    np.testing.assert_allclose(np.sort(dihedral_angles(mesh)[deep]), [[60, 60, 60, 60, 90, 90]] * deep.sum())
    np.testing.assert_allclose(mesh.volumes[deep], size**3 / 12)


@pytest.mark.parametrize("seed", range(4))
def test_angles_stay_within_bounds_on_a_surface_too_fine_for_the_lattice(seed):
    random = np.random.default_rng(seed)
    waves, phases, heights = random.normal(size=(6, 3)) * 7, random.uniform(0, 7, 6), random.normal(size=6)
    steepest = (np.abs(heights) * np.linalg.norm(waves, axis=1)).sum()

    def rough(points):
        return np.maximum((np.cos(points @ waves.T + phases) @ heights) / steepest, ball_distance(points))

    mesh = fill_surface(rough, BALL, 0.1)
    angles = dihedral_angles(mesh)
    assert DIHEDRAL_BOUNDS[0] <= angles.min() < 25
    assert 130 < angles.max() <= DIHEDRAL_BOUNDS[1]
    source = mesh.boundary_surface[1]
    assert np.abs(rough(mesh.vertices[source])).max() < 1e-6


# One tetrahedron of the lattice, positively oriented; corners 0 and 1, 2 and 3 are a cube's edge apart.
TET = np.array([(0, 0, 0), (2, 0, 0), (1, 1, -1), (1, 1, 1)], float)
STEPS = np.array([s for s in product((-2, 0, 2), repeat=3) if np.abs(s).sum() == 2] + list(product((-1, 1), repeat=3)))
LIMITS = np.where(np.abs(STEPS).sum(axis=1) == 2, WARP_LONG, WARP_SHORT)
PATTERNS = [sides for sides in product((1, 0, -1), repeat=4) if 1 in sides]
TARGETS = np.array([[next((w for w in range(4) if (TET[v] + s == TET[w]).all()), -1) for s in STEPS] for v in range(4)])


def possible_moves(sides, random, count):
    """Directions, for as many samples, in which corners on the surface may have come there: (count, 4) indices.

    They were inside or outside before, and moved towards a vertex of the other side; two do not swap places.
    """
    moves = random.integers(0, len(STEPS), (count, 4))
    before = np.where(np.array(sides) == 0, random.choice([-1, 1], (count, 4)), sides)
    towards = np.take_along_axis(TARGETS[None].repeat(count, 0), moves[:, :, None], axis=2)[:, :, 0]
    fits = (towards < 0) | (np.take_along_axis(before, np.maximum(towards, 0), axis=1) == -before)
    swaps = np.take_along_axis(towards, np.maximum(towards, 0), axis=1) == np.arange(4)
    zero = np.array(sides) == 0
    swaps &= (towards >= 0) & np.take_along_axis(np.broadcast_to(zero, towards.shape), np.maximum(towards, 0), axis=1)
    return moves, (fits & ~swaps | ~zero).all(axis=1)


def test_no_place_of_the_cut_points_leaves_the_bounds():
    """The paper's proof by trial: all stencils, with cut points at the ends of their ranges and in between."""
    random = np.random.default_rng(1)
    lowest, highest = 180, 0
    for sides in PATTERNS:
        moves, fits = possible_moves(sides, random, 2500)
        amounts = random.choice([0, 1, 1, 0.5], moves.shape) * LIMITS[moves] * (np.array(sides) == 0)
        points = [TET + amounts[..., None] * STEPS[moves]]
        for i, j in TET_EDGES:
            limit = WARP_LONG if (i, j) in ((0, 1), (2, 3)) else WARP_SHORT
            share = random.choice([limit, 1 - limit, 0.5], len(moves))
            points.append((TET[i] + share[:, None] * (TET[j] - TET[i]))[:, None])
        points = np.concatenate(points, axis=1)[fits]
        for tet in stencil(sides, True, True):
            # Every sample is one tetrahedron of a mesh of separate ones.
            separate = TetMesh(points[:, tet].reshape(-1, 3), np.arange(4 * len(points)).reshape(-1, 4))
            angles = dihedral_angles(separate)
            lowest, highest = min(lowest, angles.min()), max(highest, angles.max())
    assert DIHEDRAL_BOUNDS[0] <= lowest <= 11.5
    assert 163 <= highest <= DIHEDRAL_BOUNDS[1]


@pytest.mark.parametrize("picks", list(product((True, False), repeat=2)))
def test_stencils_of_both_sides_fill_the_tetrahedron(picks):
    random = np.random.default_rng(2)
    shares = random.uniform(0.1, 0.9, len(TET_EDGES))
    for sides in PATTERNS:
        if 0 in sides:
            continue
        cuts = [TET[i] + s * (TET[j] - TET[i]) for s, (i, j) in zip(shares, TET_EDGES, strict=True)]
        points = np.vstack([TET, cuts])
        inside = np.array(stencil(sides, *picks))
        turned = tuple(-s for s in sides)
        outside = np.array(stencil(turned, *picks)) if 1 in turned else np.zeros((0, 4), int)
        volumes = signed_volumes(points, np.concatenate([inside, outside]))
        assert volumes.min() > 0
        # The cut of two and two corners is a bent quadrilateral, split along another diagonal on either side.
        if sides.count(1) != 2:
            assert volumes.sum() == pytest.approx(signed_volumes(TET, [[0, 1, 2, 3]])[0])


def test_the_lattice_fills_its_inside_once():
    lattice = build_lattice(BALL, 0.5, 1)
    tets, are_positive, _, _ = lattice.tets_inside(np.ones(lattice.vertex_count, np.int8))
    points = lattice.points(np.arange(lattice.vertex_count))
    volumes = signed_volumes(points, tets)
    np.testing.assert_array_equal(volumes > 0, are_positive)
    np.testing.assert_allclose(np.abs(volumes), lattice.size**3 / 12)
    mesh = TetMesh(points, np.where(are_positive[:, None], tets, tets[:, [0, 1, 3, 2]]))
    # Four around the square between each two cubes.
    nx, ny, nz = lattice.cells
    assert mesh.tet_count == 4 * ((nx - 1) * ny * nz + nx * (ny - 1) * nz + nx * ny * (nz - 1))
    assert mesh.boundary_surface[0].euler_characteristic == 2
    assert enclosed_volume(mesh.boundary_surface[0]) == pytest.approx(mesh.volumes.sum())


def test_parts_that_touch_in_an_edge_are_separated():
    corner = np.array([0.5, 0.5, 0.5])

    def two_boxes(points):
        low, high = box_distance(points, -corner, [0, 0, 0.5]), box_distance(points, [0, 0, -0.5], corner)
        return np.minimum(low, high)

    mesh = fill_surface(two_boxes, BALL / 2, 0.1)
    check_stuffed(mesh, two_boxes, 4)
    assert len(np.unique(mesh.pieces)) == 2
    assert mesh.volumes.sum() == pytest.approx(0.5, abs=1e-12)


def test_real_surfaces_are_stuffed():
    distance = SurfaceDistance(shared_mesh("spot"))
    mesh = fill_surface(distance, distance.bounds, 0.09)
    check_stuffed(mesh, distance, 2)
    assert mesh.volumes.sum() == pytest.approx(distance.volume, rel=0.015)
    assert mesh.tet_count == pytest.approx(estimated_tets(distance.volume, 0.09, distance.area), rel=0.05)


def test_handles_of_real_surfaces_are_kept():
    distance = SurfaceDistance(shared_mesh("rocker-arm"))
    mesh = fill_surface(distance, distance.bounds, 0.045)
    check_stuffed(mesh, distance, 0)


def test_the_surface_of_a_solid_can_be_stuffed_again():
    """Distances from a triangle surface or from a formula make the same solid, up to the flatness of the triangles."""
    surface = fill_surface(torus_distance, TORUS, 0.08).boundary_surface[0]
    distance = SurfaceDistance(surface)
    mesh = fill_surface(distance, distance.bounds, 0.16)
    check_stuffed(mesh, distance, 0)
    assert np.abs(torus_distance(mesh.vertices[mesh.boundary_vertices])).max() < 0.01


def test_far_points_are_judged_in_blocks():
    points = []

    def counted(some):
        points.append(len(some))
        return ball_distance(some)

    mesh = fill_surface(counted, BALL, 0.06)
    lattice = build_lattice(BALL, 0.06, 8)
    assert sum(points) < 0.8 * lattice.vertex_count
    assert mesh.tet_count > 230_000


def test_float32_distances_do_for_the_boundary():
    """Blender's distances are single precision."""

    def single(points):
        near = points.astype(np.float32)
        return (np.sqrt((near**2).sum(axis=1)) - np.float32(1)).astype(float)

    mesh = fill_surface(single, BALL, 0.2)
    assert np.abs(ball_distance(mesh.vertices[mesh.boundary_vertices])).max() < 1e-6


@pytest.mark.parametrize("size", [0.2, 0.1])
def test_estimates(size):
    exact = fill_surface(ball_distance, BALL, size).tet_count
    assert estimated_tets(4 / 3 * np.pi, size, 4 * np.pi) == pytest.approx(exact, rel=0.05)
    box, sides = fill_surface(turned_box, 0.9 * BALL, size).tet_count, np.ptp(BALL / 2, axis=0)
    area = 2 * (sides * np.roll(sides, 1)).sum()
    assert estimated_tets(sides.prod(), size, area) == pytest.approx(box, rel=0.12)
    assert 700 * exact < estimated_bytes(exact, BALL, size) < 760 * exact


@pytest.mark.parametrize("size", [0, -1.0, np.nan, np.inf])
def test_sizes_that_make_no_lattice_are_refused(size):
    with pytest.raises(SettingError, match="choose a positive length"):
        fill_surface(ball_distance, BALL, size)


def test_a_size_that_no_memory_holds_is_refused_with_one_that_fits():
    with pytest.raises(SettingError, match=r"a size of 0\.001 makes 8\.\de\+09 cubes: choose one from 0\.0055 on"):
        fill_surface(ball_distance, BALL, 0.001)
    assert estimated_cubes(BALL, 0.0055) < MOST_CUBES < estimated_cubes(BALL, 0.0053)


def test_a_surface_beyond_its_box_is_refused():
    with pytest.raises(MeshError, match="leaves the bounds"):
        fill_surface(lambda points: ball_distance(points, 2.0), BALL, 0.2)


def test_what_slips_through_the_lattice_is_refused():
    with pytest.raises(MeshError, match=r"no vertex of a lattice of size 0\.5 is inside"):
        fill_surface(lambda points: ball_distance(points - [0.1, 0.3, 0.2], 0.02), BALL, 0.5)


def test_open_surfaces_are_refused_with_their_vertices():
    mesh = shared_mesh("spot")
    with pytest.raises(MeshError, match="has one face only, and a solid needs a closed surface") as caught:
        SurfaceDistance(TriangleMesh(mesh.vertices, mesh.triangles[1:]))
    assert caught.value.vertices.tolist() == sorted(mesh.triangles[0].tolist())
