# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in closed surfaces without Blender: exact ones, what is told of coarse ones, lengths, and outputs."""

import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from synch_fields.core.errors import Cancelled, SettingError
from synch_fields.core.fields.guidance.filled import along_axis, away_from_area, between_areas, of_vectors
from synch_fields.core.files.tool_paths import polylines_of, table_of
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.closed_surface import Area, ClosedSurface
from synch_fields.core.geometry.filling.lengths import (
    Lengths,
    Measures,
)
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.geometry.tet_mesh import TetMesh
from synch_fields.core.printing.flush import far_share
from synch_fields.core.solve import Options
from synch_fields.core.tasks.layer_outputs import MOST_VOXELS, Layering, PathSettings
from synch_fields.core.tasks.solids import FlushArea, SolidGuide, SolidRequest

from ..expectation import told_at_once
from ..geometry.filling.test_thin_walls import block_with_fin
from ..layered_solids import block
from ..meshes import CLOSED, cube, icosphere

UP = SolidGuide("axis:Z", partial(along_axis, np.array([0.0, 0.0, 2.0])))


def closed(mesh):
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    return ClosedSurface(given, SurfaceDistance(mesh))


def flattened(*lengths):
    """A cube scaled along its axes."""
    mesh = cube(5)
    return TriangleMesh(mesh.vertices * lengths, mesh.triangles)


def flat_area(surface, height, name):
    """The faces of a cube at a height."""
    return Area.of_members(surface.given, surface.mesh.vertices[:, 2] == height, name)


def request_in(surface, spacing=0.22, size=0.1, **parts):
    lengths = Lengths.of(surface.distance, spacing, size)
    return replace(SolidRequest(surface, None, UP, (), lengths, None, Options()), **parts)


def heights_of(surfaces):
    return [surfaces.vertices[surfaces.triangles[surfaces.layers == k], 2] for k in range(surfaces.count)]


def test_layers_across_an_axis_are_planes_a_spacing_apart():
    stages = []
    result = request_in(closed(cube(2))).solve(lambda stage, fraction: stages.append((stage, fraction)))
    heights = heights_of(result.surfaces)
    assert max(map(np.ptp, heights)) < 1e-6 and result.warnings == () and result.curves == result.ends == ()
    np.testing.assert_allclose(np.diff([height.mean() for height in heights]), 0.22, atol=1e-6)
    fractions = [fraction for _, fraction in stages]
    assert fractions == sorted(fractions) and {"filling the surface", "guidance", "layers"} <= {s for s, _ in stages}
    assert set(result.seconds) == {"fill", "build", "extract"}


@pytest.mark.parametrize("divisions", [6, 40])
def test_printed_layers_are_levels_of_a_longer_period(divisions):
    """Layers along an axis are the same planes, the first one half a layer above the floor, whatever the period."""
    surface, size = closed(cube(2)), 0.1
    lengths = Lengths.of(surface.distance, 0.04, size, divisions=divisions)
    result = replace(request_in(surface), lengths=lengths).solve()
    floor = surface.mesh.vertices[:, 2].min()
    heights = [places.mean() for places in heights_of(result.surfaces)]
    np.testing.assert_allclose(heights, floor + 0.04 * (np.arange(25) + 0.5), atol=1e-6)
    assert result.pattern.spacings.mean == pytest.approx(0.04) and result.pattern.solution.iterations == 0
    assert result.warnings == ()


@pytest.mark.parametrize("divisions", [3, 10])
def test_groups_lie_on_the_levels_that_fit(divisions):
    """Floor and top 1 apart are 25 layers of 0.04: not a whole number of periods of 3 or 10."""
    surface = closed(flattened(0.5, 0.5, 1))
    z = surface.mesh.vertices[:, 2]
    areas = [Area(name, np.flatnonzero((z[surface.mesh.triangles] == level).all(axis=1)))
             for name, level in (("the floor", z.min()), ("the top", z.max()))]  # fmt: skip
    asked = tuple(FlushArea(area, np.pi) for area in areas)
    lengths = Lengths.of(surface.distance, 0.04, 0.1 if divisions == 10 else 0.05, divisions=divisions)
    result = replace(request_in(surface), lengths=lengths, flush_areas=asked).solve()
    heights = [places.mean() for places in heights_of(result.surfaces)]
    np.testing.assert_allclose(heights, z.min() + 0.04 * (np.arange(25) + 0.5), atol=1e-6)
    assert result.pattern.solution.energy < 1e-12


@pytest.mark.parametrize("divisions", [1, 4])
def test_a_fin_beside_a_block_has_its_own_levels(divisions):
    """The tops of both are one group: 3 and 25 layers above the floor, which is not the same place in a period of 4."""
    surface, areas = block_with_fin()
    lengths = Lengths(0.04, 0.1, divisions)
    asked = tuple(FlushArea(area, np.pi) for area in areas)
    result = replace(request_in(surface), lengths=lengths, flush_areas=asked).solve()
    assert result.pattern.solution.energy < 1e-12 and result.surfaces.count == 25
    heights = [places.mean() for places in heights_of(result.surfaces)]
    np.testing.assert_allclose(heights, 0.04 * (np.arange(25) + 0.5), atol=1e-6)
    if divisions > 1:
        np.testing.assert_allclose(result.surfaces.areas, np.repeat([2, 1], [3, 22]), rtol=1e-2)


@pytest.mark.parametrize(("cells", "told"), [(1, True), (6, False)])
def test_a_guide_without_directions_of_its_own_is_told_about(cells, told):
    """A plate of a cell with one vertex inside: the distance from the boundary has a slope around that one alone."""
    mesh = block((6, 6, cells), (1, 1, 0.3))
    first, rest = mesh.tets[0], mesh.tets[1:]
    parts = [np.where(np.arange(4) == k, mesh.vertex_count, first) for k in range(4)]
    solid = TetMesh(np.vstack([mesh.vertices, mesh.vertices[first].mean(axis=0)]), np.vstack([rest, *parts]))
    surface = closed(solid.boundary_surface[0])
    everywhere = Area("all", np.arange(surface.mesh.triangle_count))
    guide = SolidGuide("distance:boundary", partial(away_from_area, everywhere))
    lengths = Lengths.carried(surface.distance, 0.1, 0.2)
    result = SolidRequest(surface, solid, guide, (), lengths, None, Options()).solve()
    assert told == any("distance:boundary has no direction of its own in" in line for line in result.warnings)
    if told:
        beside = solid.vertex_masses[first].sum()
        assert result.continued == pytest.approx(1 - beside / 0.3, abs=solid.vertex_masses[-1] / 0.3 + 1e-9)
        assert result.continued > 0.9
    else:
        assert result.continued < 0.05


def test_a_copy_from_a_pickle_solves_to_the_same_bits():
    surface = closed(cube(2))
    areas = [flat_area(surface, height, f"at {height}") for height in (0, 1)]
    guide = SolidGuide("harmonic", partial(between_areas, *areas))
    request = request_in(surface, guide=guide, flush_areas=(FlushArea(areas[0], 0.0), FlushArea(areas[1], None)))
    results = [request.solve(), pickle.loads(pickle.dumps(request)).solve()]
    ours, theirs = ([r.solid.vertices, r.pattern.solution.phases, r.surfaces.vertices, r.phases.edge_phases.changes]
                    for r in results)  # fmt: skip
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(one, other)
    lowest = heights_of(results[0].surfaces)[0]
    np.testing.assert_allclose(lowest, 0, atol=1e-6)


def test_spacings_are_those_of_the_surface_times_its_factors():
    surface = closed(cube(4))
    result = request_in(surface, 0.15, 0.09, factors=1 + surface.mesh.vertices[:, 2]).solve()
    steps = np.diff([height.mean() for height in heights_of(result.surfaces)])
    assert (np.diff(steps) > 0).all() and 0.15 < steps[0] < 0.2 and 0.22 < steps[-1] < 0.3


def test_vectors_of_the_surface_go_into_the_solid():
    surface = closed(cube(3))
    guide = SolidGuide("attribute", partial(of_vectors, np.tile([0.0, 0.0, 3.0], (surface.mesh.vertex_count, 1))))
    np.testing.assert_allclose(
        request_in(surface, guide=guide).solve().surfaces.vertices, request_in(surface).solve().surfaces.vertices
    )


def test_errors_of_a_guide_name_it():
    request = request_in(closed(cube(2)), guide=SolidGuide("axis:none", partial(along_axis, np.zeros(3))))
    with pytest.raises(SettingError, match=r"^axis:none: the axis .* has no direction"):
        request.solve()


def test_a_spacing_that_no_layer_fits_is_told_the_depth():
    request = request_in(closed(flattened(0.5, 0.5, 0.1)), 0.7, 0.1)
    with pytest.raises(SettingError, match=r"no layer lies in the solid, which is about .* deep"):
        request.solve()


def test_coarse_solids_are_told_about():
    """Layers finer than the edges, a thin rod that loses its edges, and a pad whose rim the tetrahedra cut off."""
    surface = closed(cube(5))
    middle = (np.abs(surface.mesh.vertices[:, :2] - 0.5) < 0.31).all(axis=1) & (surface.mesh.vertices[:, 2] == 1)
    pad = Area.of_members(surface.given, middle, "the pad")
    request = request_in(surface, 0.3, 0.13, flush_areas=(FlushArea(pad, 0.0),))
    (line,) = request.solve().warnings
    assert line.startswith("the solid's triangles cover 9") and "% of the pad" in line and "reduce the size" in line
    (line,) = replace(request, flush_areas=(), lengths=Lengths(0.1, 0.13)).solve().warnings
    assert line.startswith("the spacing is finer than the solid can carry on ")
    rod = flattened(1, 0.1, 0.1)
    rod = TriangleMesh(rod.vertices @ Rotation.from_rotvec([0.8, 0.2, 0.1]).as_matrix().T, rod.triangles)
    lines = request_in(closed(rod), 0.3, 0.066).solve().warnings
    assert len(lines) == 1 and "of the surface's volume: what is thinner than 0.066 is lost" in lines[0]


def test_how_flush_layers_are_is_told():
    """A layer on both ends of a block, moved by less and by more than a twentieth of the spacing, and tilted."""
    surface = closed(cube(4))
    floor, lid = (flat_area(surface, height, name) for height, name in ((0, "floor"), (1, "lid")))
    request = request_in(surface, 0.22, 0.1, flush_areas=(FlushArea(floor, 0.0), FlushArea(lid, 0.0)))
    result = request.solve()
    assert result.far == {"floor": 0, "lid": 0} and not any("farther than" in line for line in result.warnings)
    mesh = surface.mesh
    for count, moved in ((0, 0.04), (1, 0.06)):
        shifted = replace(result.surfaces, vertices=result.surfaces.vertices + [0, 0, moved * 0.22])
        assert far_share(mesh, floor.triangles, shifted, 0.22) == count
    # Tilted about its middle, a layer is near up to where it rises to a twentieth of the spacing.
    x = result.surfaces.vertices[:, 0] - 0.5
    tilted = replace(result.surfaces, vertices=result.surfaces.vertices + np.outer(x, [0, 0, 0.05]))
    assert far_share(mesh, floor.triangles, tilted, 0.22) == pytest.approx(1 - 2 * 0.05 * 0.22 / 0.05, abs=0.03)
    held = replace(request, flush_areas=(FlushArea(floor, 0.0),)).solve()
    assert held.far == {"floor": 0}
    assert far_share(mesh, lid.triangles, held.surfaces, 0.22) == 1  # more than half a spacing above the last one


def test_a_plate_too_thin_to_be_filled_is_refused():
    """Points of the lattice are inside, and all of them move onto the surface."""
    with pytest.raises(SettingError, match=r"too large: nothing of the solid is left; give a size of 0\.1"):
        request_in(closed(flattened(1, 1, 0.12)), 0.5, 0.24).solve()


@pytest.mark.parametrize("stage", ["filling", "guidance", "layers"])
def test_a_solve_stops_where_it_is_told_to(stage):
    with pytest.raises(Cancelled):
        request_in(closed(cube(2))).solve(lambda now, _: not now.startswith(stage))


def _used(mesh):
    """Vertices that have a triangle, and the triangles."""
    used, triangles = np.unique(mesh.triangles, return_inverse=True)
    return mesh.vertices[used], triangles.reshape(-1, 3)


@pytest.mark.parametrize(("build", "chi"), CLOSED)
def test_measures_are_those_of_the_distance(build, chi):
    mesh = build()
    loose = np.array([[90.0, 0, 0], [np.nan, 0, 0]])
    distance = SurfaceDistance(TriangleMesh(*_used(mesh)))
    for more in (loose[:0], loose[:1], loose):  # vertices without a face are no part of the surface
        measures = Measures.of(np.vstack([mesh.vertices, more]) + [5, 0, 0], mesh.triangles)
        assert measures.volume == pytest.approx(distance.volume, rel=1e-9)
        assert measures.area == pytest.approx(distance.area, rel=1e-9)
        np.testing.assert_allclose(measures.bounds, distance.bounds + [5, 0, 0], atol=1e-12)
        assert Lengths.of(measures, None, None) == pytest.approx(Lengths.of(distance, None, None), rel=1e-9)


def test_measures_know_the_extents_of_turned_boxes_and_balls():
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
    for mesh, extents in (
        (flattened(0.3, 2, 1), (2, 1, 0.3)),
        (icosphere(5), (np.sqrt(12 / 5),) * 3),  # a ball's square distance from a plane through its centre: R^2 / 5
    ):
        for triangles in (mesh.triangles, mesh.triangles[:, ::-1]):
            found = Measures.of(mesh.vertices @ turn.T + [7, 0, 3], triangles).extents
            np.testing.assert_allclose(found, extents, rtol=2e-3)


@pytest.fixture(scope="module")
def layering():
    result = request_in(closed(cube(2)), 0.3, 0.14).solve()
    return Layering(result.pattern, result.surfaces, result.curves, np.eye(4))


def test_paths_are_a_step_apart_and_as_long_as_the_layers_are_large(layering):
    paths = pickle.loads(pickle.dumps(layering.paths(PathSettings(0.1, "across-x")))).solve()
    steps = paths.lines.points[:, 0] / 0.1
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-6)
    assert paths.lines.lengths.sum() == pytest.approx(layering.surfaces.areas.sum() / 0.1, rel=0.15)
    assert layering.paths(PathSettings()).step == pytest.approx(0.3, rel=1e-6)
    with pytest.raises(SettingError, match="no path of the step 50 fits on a layer: reduce it"):
        layering.paths(PathSettings(50.0)).solve()
    for settings, words in (({"step": -1}, "positive number"), ({"fill": "spiral"}, "contour")):
        with pytest.raises(SettingError, match=words):
            PathSettings(**settings)


def test_texts_of_paths_hold_their_points(layering):
    paths = layering.paths(PathSettings(0.2)).solve()
    lines, points, normals = paths.lines, paths.lines.points, paths.lines.normals
    table = np.loadtxt(
        table_of(lines, paths.layers, points, normals, paths.heights, paths.widths, paths.up).splitlines(),
        delimiter=",",
        skiprows=1,
    )
    assert len(table) == len(points) + lines.closed.sum() and lines.closed.any()
    first = table[table[:, 1] == 0]
    np.testing.assert_array_equal(first[0], first[-1])  # it closes
    np.testing.assert_allclose(first[:-1, 2:5], points[: lines.sizes[0]], rtol=1e-8, atol=1e-12)
    rows = polylines_of(lines, paths.layers, points, normals).splitlines()
    kinds = [row[0] for row in rows]
    assert kinds.count("v") == len(points) and kinds.count("l") == len(lines.sizes)
    assert kinds.count("o") == layering.surfaces.count
    runs = [np.array(row.split()[1:], int) for row in rows if row[0] == "l"]
    assert all((run[0] == run[-1]) == closed for run, closed in zip(runs, lines.closed, strict=True))


def test_paths_and_voxels_say_at_once_how_long_they_take(layering):
    paths, other = (told_at_once(layering.paths(PathSettings(step))) for step in (0.3, 0.15))
    assert other == pytest.approx(4 * paths)
    assert told_at_once(layering.voxels(20)) == pytest.approx(8 * told_at_once(layering.voxels(10)))


def test_voxels_hold_the_cosine_of_the_phase(layering):
    voxels = pickle.loads(pickle.dumps(layering.voxels(20))).solve()
    assert voxels.values.shape == (20, 20, 20) and voxels.values.dtype == np.float32
    assert (voxels.values > -1).mean() > 0.9
    places = voxels.origin[2] + voxels.step * np.arange(20)
    level = heights_of(layering.surfaces)[0].mean()
    expected = np.cos(2 * np.pi * (places - level) / 0.3)
    np.testing.assert_allclose(voxels.values[10, 10], expected, atol=1e-5)


def test_as_many_voxels_as_asked_for_lie_along_the_longest_side(layering):
    """Also where an extent over a number, and that into the extent, is a little more than the number: 1 / (1 / 49)."""
    extent = float(np.ptp(layering.solid.vertices, axis=0).max())
    assert any(extent / (extent / number) > number for number in range(40, 60))
    for number in range(40, 60):
        assert layering.voxels(number).solve().values.shape == (number,) * 3


def test_too_many_voxels_are_refused_with_a_number_that_does(layering):
    with pytest.raises(SettingError, match=r"1.0e\+12 voxels, and 5e\+07 is the most: reduce it to ") as caught:
        layering.voxels(10_000)
    fitting = int(str(caught.value).split("reduce it to ")[1])
    assert 0.9 * MOST_VOXELS < (1.06 * fitting) ** 3 and fitting**3 <= MOST_VOXELS
    layering.voxels(fitting)
