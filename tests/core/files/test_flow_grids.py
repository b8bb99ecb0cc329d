# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows in the files of other programs: each is the one that was written, and damaged ones are refused in one line."""

import numpy as np
import pytest
from scipy.io import netcdf_file

from synch_fields.core.errors import SynchError
from synch_fields.core.files.flows import flow_file
from synch_fields.core.files.regular_flows import GridFlow
from synch_fields.core.files.volumes import choose_flow

from .flow_writers import AXES, ORIGIN, SHAPE, SPACING, UVW, VELOCITY, hdf5, netcdf, vti, vtk_mesh


def check(flow, velocity=VELOCITY, shape=SHAPE, spacing=SPACING, origin=ORIGIN, rough=1e-12):
    """The flow has these vectors, at these places."""
    assert isinstance(flow, GridFlow) and flow.own.shape == tuple(shape)
    np.testing.assert_allclose(flow.own.spacing, spacing, atol=1e-6)
    np.testing.assert_allclose(flow.own.origin, origin, atol=1e-6)
    np.testing.assert_allclose(flow.velocity.reshape(*shape, 3), velocity, atol=rough)


def refusal(path):
    with pytest.raises(SynchError) as caught:
        flow_file(path).read()
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)
    return str(caught.value)


# Images of VTK


@pytest.mark.parametrize("kind", ["ascii", "binary", "zlib", "raw"])
def test_images_of_points_in_each_way_of_writing(tmp_path, kind):
    other = np.arange(np.prod(SHAPE), dtype=float).reshape(SHAPE)
    check(flow_file(vti(tmp_path / "flow.vti", {"p": other, "velocity": VELOCITY}, kind)).read())


def test_images_of_cells_are_a_grid_of_their_middles(tmp_path):
    flow = flow_file(vti(tmp_path / "flow.vti", {"U": VELOCITY}, where="CellData")).read()
    check(flow, origin=np.array(ORIGIN) + 0.5 * np.array(SPACING))


def test_vectors_of_cells_are_found_beside_numbers_of_points(tmp_path):
    path = vti(tmp_path / "flow.vti", {"U": VELOCITY}, where="CellData")
    numbers = b'<PointData><DataArray type="UInt8" Name="vtkGhostType" format="ascii"/></PointData>'
    path.write_bytes(path.read_bytes().replace(b"<CellData>", numbers + b"<CellData>"))
    check(flow_file(path).read(), origin=np.array(ORIGIN) + 0.5 * np.array(SPACING))


def test_images_of_components_of_other_names_and_of_vorticity(tmp_path):
    parts = {f"vel_{axis}": VELOCITY[..., k] for k, axis in enumerate("xyz")}
    check(flow_file(vti(tmp_path / "parts.vti", parts)).read())
    check(flow_file(vti(tmp_path / "uvw.vti", dict(zip("uvw", parts.values(), strict=True)))).read())
    two = vti(tmp_path / "two.vti", {"Wind": VELOCITY, "B": -VELOCITY})
    check(flow_file(two, "B").read(), -VELOCITY)
    (warning,) = flow_file(two).read().warnings
    assert warning.startswith("Wind is used as the velocity (there are Wind, B)")
    curl = flow_file(vti(tmp_path / "curl.vti", {"Vorticity": VELOCITY})).read()
    assert curl.is_vorticity and not flow_file(two).read().is_vorticity


@pytest.mark.parametrize(
    ("name", "axes"),
    [
        ("{} Velocity", "XYZ"),
        ("{}-velocity", "xyz"),
        ("U{}", "XYZ"),
        ("B/{}", "xyz"),
        ("{}wnd", "uvw"),
        ("vx{}", "123"),
        ("vel[{}]", "012"),
        ("velocity:{}", "012"),
    ],
)
def test_components_differ_in_one_letter_or_digit(tmp_path, name, axes):
    parts = {name.format(axis): VELOCITY[..., k] for k, axis in enumerate(axes)}
    check(flow_file(vti(tmp_path / "parts.vti", parts)).read())


@pytest.mark.parametrize(
    ("vectors", "numbers", "chosen"),
    [
        (["vel"], ["density", "temperature"], ("vel",)),  # Houdini, Pyro
        (["rest", "v"], ["density"], ("v",)),  # Houdini, geometry
        ([], ["density", "vel.x", "vel.y", "vel.z"], ("vel.x", "vel.y", "vel.z")),  # Houdini, not merged
        (["velocity"], ["density", "heat", "flame"], ("velocity",)),  # Mantaflow
        (["Velocity"], ["density", "flames", "temperature"], ("Velocity",)),  # a capital
        (["color"], ["velocity_x", "velocity_y", "velocity_z"], ("velocity_x", "velocity_y", "velocity_z")),
    ],
)
def test_velocities_are_found_by_the_names_that_simulators_give_them(vectors, numbers, chosen):
    assert choose_flow("flow.vdb", vectors, numbers, "velocity") == (chosen, False, ())


def test_numbers_that_are_no_components_are_refused(tmp_path):
    names = ("u", "v", "p", "t0", "t1", "flux")
    assert "has no vectors" in refusal(vti(tmp_path / "flow.vti", dict.fromkeys(names, VELOCITY[..., 0])))


def test_masks_and_missing_numbers_are_solid(tmp_path):
    holes = VELOCITY.copy()
    holes[1, 2, 3] = np.nan
    solid, mask = np.zeros(SHAPE), np.ones(SHAPE)
    solid[4, 5, 6], mask[0, 0, 0] = 1, 0
    flow = flow_file(vti(tmp_path / "flow.vti", {"velocity": holes, "solid": solid, "mask": mask}, "raw")).read()
    assert {tuple(place) for place in np.argwhere(flow.own.solid).tolist()} == {(1, 2, 3), (4, 5, 6), (0, 0, 0)}
    assert np.isfinite(flow.integrals(flow.own)).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.replace(b'"ImageData" version', b'"PolyData" version'), "is not VTK's ImageData"),
        (lambda t: t.replace(b'Spacing="0.5', b'Spacing="wide'), "cannot be read"),
        (lambda t: t.replace(b'Spacing="0.5 ', b'Spacing="'), "its Spacing is '0.25 0.125': give 3 numbers"),
        (lambda t: t.replace(b'WholeExtent="0 4', b'WholeExtent="0 3'), "its piece is not the whole"),
        (lambda t: t.replace(b'Extent="0 4', b'Extent="0 9'), "cannot be read"),
        (lambda t: t.replace(b'Extent="0 4', b'Extent="0 400000000'), "takes about"),
        (
            lambda t: t.replace(b'"velocity"', b'"other"').replace(b'Components="3"', b'Components="2"'),
            "has no vectors",
        ),
        (lambda t: t[: len(t) // 2], "export it again"),
        (lambda t: t.replace(b"ImageData W", b'ImageData Direction="0 1 0 1 0 0 0 0 1" W'), "its axes are turned"),
        (lambda t: t.replace(b"<Piece", b"<Piece/><Piece"), "it has 2 pieces"),
    ],
)
def test_damaged_images_are_refused(tmp_path, change, message):
    path = vti(tmp_path / "flow.vti", {"velocity": VELOCITY})
    path.write_bytes(change(path.read_bytes()))
    assert message in refusal(path)


# NetCDF and HDF5


def test_netcdf_counts_z_y_x_and_has_its_coordinates(tmp_path):
    check(flow_file(netcdf(tmp_path / "flow.nc", UVW, AXES)).read())
    steps = {
        name: np.stack([values, 0 * values, 0 * values]) for name, values in UVW.items()
    }  # three are no components
    flow = flow_file(netcdf(tmp_path / "steps.nc", steps, AXES, 3)).read()
    check(flow)
    assert flow.warnings[0].startswith("of 3 times the first one is shown")


def test_axes_are_those_that_dimensions_are_named_after(tmp_path):
    cube = VELOCITY[:5, :5, :5]
    parts = {name: cube[..., k].transpose(1, 0, 2) for k, name in enumerate("uvw")}
    axes = dict.fromkeys("uvw", ("lat", "lon", "depth"))
    flow = flow_file(netcdf(tmp_path / "flow.nc", parts, {}, axes=axes)).read()
    check(flow, cube, cube.shape[:3], (1, 1, 1), (0, 0, 0))
    assert "longitude, latitude and level" in flow.warnings[0]
    firsts = {"velocity": VELOCITY.transpose(3, 2, 1, 0)}  # components before x, y and z
    check(flow_file(netcdf(tmp_path / "3.nc", firsts, AXES, axes={"velocity": ("part", "z", "y", "x")})).read())


def test_staggered_components_are_moved_to_the_cells(tmp_path):
    """A linear flow, each component half a cell before the cells along its own axis, with coordinates or without."""
    middles = {axis: np.arange(n) + 0.5 for axis, n in zip("xyz", SHAPE, strict=True)}
    sides = {f"{axis}u": np.arange(n + 1.0) for axis, n in zip("xyz", SHAPE, strict=True)}
    axes = {"u": ("z", "y", "xu"), "v": ("z", "yu", "x"), "w": ("zu", "y", "x")}
    places = middles | sides
    parts = {
        name: 2 * places[x] - places[y][:, None] + 3 * places[z][:, None, None] for name, (z, y, x) in axes.items()
    }
    expected = 2 * middles["x"][:, None, None] - middles["y"][:, None] + 3 * middles["z"]
    for coordinates, origin in ((places, 0.5), ({}, 0.0)):
        flow = flow_file(netcdf(tmp_path / "flow.nc", parts, coordinates, axes=axes)).read()
        check(flow, np.repeat(expected[..., None], 3, axis=3), spacing=(1, 1, 1), origin=(origin,) * 3)


def test_two_components_are_a_level_flow(tmp_path):
    parts = {name: UVW[name] for name in "uv"}
    flow = flow_file(netcdf(tmp_path / "flow.nc", parts, AXES)).read()
    check(flow, VELOCITY * [1, 1, 0])
    assert "two components" in flow.warnings[0]


def test_flows_in_a_plane_are_refused_with_what_helps(tmp_path):
    flat = {name: values[:1] for name, values in UVW.items()}
    axes = {"u": ("time", "lat", "lon"), "v": ("time", "lat", "lon")}
    plane = {name: values[0] for name, values in UVW.items()}
    paths = [
        netcdf(tmp_path / "flat.nc", flat, AXES | {"z": [0.0]}),
        netcdf(tmp_path / "times.nc", {name: UVW[name] for name in "uv"}, {}, axes=axes),
        netcdf(tmp_path / "plane.nc", plane, {}, axes=dict.fromkeys("uvw", ("y", "x"))),
        vti(tmp_path / "cells.vti", {"velocity": VELOCITY[:, :, :1]}, where="CellData", shape=(*SHAPE[:2], 1)),
    ]
    for path in paths:
        assert "its flow is in a plane: save it as .npz with velocity (nx, ny, 2)" in refusal(path)


def test_a_mask_without_times_is_that_of_all_times(tmp_path):
    steps = {name: np.stack([values, 0 * values]) for name, values in UVW.items()}
    path = netcdf(tmp_path / "masked.nc", steps, AXES, 2)
    with netcdf_file(path, "a") as file:
        file.createVariable("mask", "f8", ("z", "y", "x"))[:] = np.arange(SHAPE[0]) != 4
    flow = flow_file(path).read()
    assert flow.own.solid[4].all() and not flow.own.solid[:4].any()


def test_coordinates_that_fall_or_are_uneven_become_even(tmp_path):
    fallen = {name: values[::-1] for name, values in UVW.items()}
    check(flow_file(netcdf(tmp_path / "fallen.nc", fallen, AXES | {"z": AXES["z"][::-1]})).read())
    z = np.cumsum([0, 1, 2, 1, 1, 3, 1.0])  # a linear flow stays what it is
    x = AXES["x"][None, None, :]
    y = AXES["y"][None, :, None]
    linear = 2 * x - y + 3 * z[:, None, None]
    flow = flow_file(netcdf(tmp_path / "uneven.nc", dict.fromkeys("uvw", linear), AXES | {"z": z})).read()
    even = np.linspace(0, 9, 7)
    expected = 2 * AXES["x"][:, None, None] - AXES["y"][:, None] + 3 * even
    np.testing.assert_allclose(flow.own.origin[2] + flow.own.spacing[2] * np.arange(7), even)
    np.testing.assert_allclose(flow.velocity[:, 0].reshape(SHAPE), expected, atol=1e-12)


def test_fill_values_are_solid(tmp_path):
    with netcdf_file(tmp_path / "flow.nc", "w") as file:
        for name, count in zip("xyz", SHAPE, strict=True):
            file.createDimension(name, count)
        for name, values in UVW.items():
            variable = file.createVariable(name, "f8", ("z", "y", "x"))
            variable._FillValue = -999.0
            variable[:] = np.where(np.arange(SHAPE[0]) == 4, -999.0, values)
    flow = flow_file(tmp_path / "flow.nc").read()
    assert flow.own.solid[4].all() and not flow.own.solid[:4].any() and flow.own.spacing.tolist() == [1, 1, 1]


def test_netcdf_that_is_none_is_refused(tmp_path):
    (tmp_path / "text.nc").write_text("no file of arrays")
    assert "text.nc" in refusal(tmp_path / "text.nc")
    whole = netcdf(tmp_path / "cut.nc", UVW, AXES).read_bytes()
    (tmp_path / "cut.nc").write_bytes(whole[: len(whole) // 2])
    refusal(tmp_path / "cut.nc")
    assert "do not increase" in refusal(netcdf(tmp_path / "same.nc", UVW, AXES | {"y": 0 * AXES["y"]}))


def test_hdf5_with_numbered_vectors_and_coordinates(tmp_path):
    h5py = pytest.importorskip("h5py")
    check(flow_file(hdf5(tmp_path / "cut.h5")).read(), rough=1e-6)
    with h5py.File(tmp_path / "own.h5", "w") as file:  # x first, as its coordinates tell
        file.create_dataset("flow/vorticity", data=VELOCITY, compression="gzip")
        for axis, values in AXES.items():
            file.create_dataset(f"grid/{axis}", data=values)
    flow = flow_file(tmp_path / "own.h5").read()
    check(flow)
    assert flow.is_vorticity
    with h5py.File(tmp_path / "openpmd.h5", "w") as file:  # its groups name the axes, and have spacing and origin
        for axis, part in zip("xyz", np.moveaxis(VELOCITY.transpose(1, 0, 2, 3), 3, 0), strict=True):
            file[f"data/1/meshes/B/{axis}"] = part
        file["data/1/meshes/B"].attrs["axisLabels"] = [b"y", b"x", b"z"]
        for name, (x, y, z) in (("gridSpacing", SPACING), ("gridGlobalOffset", ORIGIN)):
            file["data/1/meshes/B"].attrs[name] = (y, x, z)
    check(flow_file(tmp_path / "openpmd.h5").read())
    (tmp_path / "bad.h5").write_bytes((tmp_path / "own.h5").read_bytes()[:900])
    assert "\n" not in refusal(tmp_path / "bad.h5")


def test_staggered_components_of_openpmd_lie_where_their_positions_say(tmp_path):
    """Each is half a cell along its own axis: a flow that is linear is read without an error."""
    h5py = pytest.importorskip("h5py")
    nodes = np.stack(np.meshgrid(*(0.5 * np.arange(count) for count in (6, 5, 4)), indexing="ij"), axis=-1)
    with h5py.File(tmp_path / "staggered.h5", "w") as file:
        group = file.create_group("data/1/fields/B")
        group.attrs.update(axisLabels=[b"x", b"y", b"z"], gridSpacing=np.full(3, 0.5), gridGlobalOffset=np.ones(3))
        for axis, name in enumerate("xyz"):
            group[name] = 1 + nodes[..., axis] + 0.25
            group[name].attrs["position"] = 0.5 * np.eye(3)[axis]
    flow = flow_file(tmp_path / "staggered.h5").read()
    np.testing.assert_allclose(flow.velocity, flow.own.places, atol=1e-12)


def test_coordinates_may_be_packed(tmp_path):
    """As whole numbers with a scale and an offset, by the conventions of NetCDF."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(hdf5(tmp_path / "packed.h5"), "r+") as file:
        for axis, (first, second, *_) in AXES.items():
            places = file[f"{axis}coor"]
            places[:] = np.arange(len(places))
            places.attrs.update(scale_factor=second - first, add_offset=first)
    check(flow_file(tmp_path / "packed.h5").read(), rough=1e-6)


@pytest.mark.parametrize("order", ["xyz", "zyx"])
def test_axes_without_names_are_those_along_which_the_flow_does_not_diverge(tmp_path, order):
    """An eddy without sources in a cube, whose sizes tell nothing; its spacing is an array of its own."""
    h5py = pytest.importorskip("h5py")
    x, y, _ = np.meshgrid(*[np.linspace(0, 2, 9)] * 3, indexing="ij")
    eddy = np.stack([np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y), 0.3 * np.cos(x + y)], axis=-1)
    with h5py.File(tmp_path / "eddy.h5", "w") as file:
        for axis, part in zip("uvw", np.moveaxis(eddy, 3, 0), strict=True):
            file[axis] = part if order == "xyz" else part.transpose(2, 1, 0)
        file["dx"] = [[0.5, 0.25, 0.125]]
    flow = flow_file(tmp_path / "eddy.h5").read()
    check(flow, eddy, (9, 9, 9), (0.5, 0.25, 0.125), (0, 0, 0))
    assert not flow.warnings


def test_netcdf_dimensions_without_coordinates_are_none_in_hdf5_too(tmp_path):
    """As the Weather Research and Forecasting model writes its staggered winds: a dimension is an array of zeros."""
    h5py = pytest.importorskip("h5py")
    sides = {"west_east": 5, "south_north": 6, "bottom_top": 7}
    with h5py.File(tmp_path / "wrf.nc", "w") as file:
        for name, count in [*sides.items(), *((f"{name}_stag", count + 1) for name, count in sides.items())]:
            file[name] = np.zeros(count)
            file[name].make_scale(f"This is a netCDF dimension but not a netCDF variable. {count:>9}")
        for letter, along in zip("UVW", sides, strict=True):
            names = [name + "_stag" * (name == along) for name in reversed(sides)]
            variable = file.create_dataset(letter, data=np.zeros([1, *(len(file[name]) for name in names)]))
            for dimension, name in enumerate(names, 1):
                variable.dims[dimension].attach_scale(file[name])
    flow = flow_file(tmp_path / "wrf.nc").read()
    check(flow, np.zeros((5, 6, 7, 3)), spacing=(1, 1, 1), origin=(0, 0, 0))
    assert flow.warnings == ("distances are counted in nodes, as the file has no coordinates along x, y and z",)


# Other libraries


@pytest.mark.parametrize("suffix", [".vti", ".vtk", ".vtr"])
def test_regular_grids_that_pyvista_writes_keep_their_nodes(tmp_path, suffix):
    check(flow_file(vtk_mesh(tmp_path / f"flow{suffix}")).read())


@pytest.mark.parametrize(("library", "suffix"), [("pyvista", ".vts"), ("pyvista", ".vtu"), ("meshio", ".vtu")])
def test_flows_on_other_meshes_are_sampled(tmp_path, library, suffix, monkeypatch):
    """A linear flow on a block with a hole that only cells know of."""
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.ImageData(dimensions=(9, 9, 9), spacing=(0.25,) * 3, origin=(-1,) * 3).cast_to_structured_grid()
    if suffix == ".vtu":
        mesh = mesh.extract_cells(np.linalg.norm(mesh.cell_centers().points, axis=1) > 0.4)
    turn = np.cross([0, 0, 1], mesh.points)
    mesh.point_data["velocity"] = turn
    mesh.save(tmp_path / f"flow{suffix}")
    if library == "meshio":
        pytest.importorskip("meshio")
        monkeypatch.setitem(__import__("sys").modules, "pyvista", None)
    flow = flow_file(tmp_path / f"flow{suffix}").read()
    grid = flow.grid(17)
    assert grid.shape == (17, 17, 17)
    values = flow.sample(grid.places)
    inside = ~grid.solid.ravel()
    np.testing.assert_allclose(values[inside], np.cross([0, 0, 1], grid.places[inside]), atol=1e-6)
    hole = np.linalg.norm(grid.places, axis=1) < 0.2
    assert not inside[hole].any() if library == "pyvista" and suffix == ".vtu" else inside.all()
    assert np.isfinite(flow.integrals(grid)).all()


@pytest.mark.parametrize("library", ["pyvista", "meshio"])
def test_vectors_of_cells_are_found_beside_numbers_of_a_mesh(tmp_path, library, monkeypatch):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.ImageData(dimensions=(9, 9, 9), spacing=(0.25,) * 3, origin=(-1,) * 3).cast_to_structured_grid()
    mesh = mesh.cast_to_unstructured_grid()  # of hexahedra, as meshio knows no voxels
    mesh.point_data["vtkGhostType"] = np.zeros(mesh.n_points, np.uint8)
    mesh.cell_data["U"] = np.cross([0, 0, 1], mesh.cell_centers().points)
    mesh.save(tmp_path / "flow.vtu")
    if library == "meshio":
        pytest.importorskip("meshio")
        monkeypatch.setitem(__import__("sys").modules, "pyvista", None)
    flow = flow_file(tmp_path / "flow.vtu").read()
    places = np.array([[0.25, 0.5, 0.25], [-0.5, 0.25, 0.5]])
    np.testing.assert_allclose(flow.sample(places), np.cross([0, 0, 1], places), atol=1e-6)


@pytest.mark.parametrize(("library", "name", "solid"), [("pyvista", "Mask", 0), ("meshio", "obstacle", 1)])
def test_masks_of_meshes_are_solid_where_these_are_sampled(tmp_path, library, name, solid, monkeypatch):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.ImageData(dimensions=(9, 9, 9), spacing=(0.25,) * 3, origin=(-1,) * 3).cast_to_unstructured_grid()
    mesh.point_data["velocity"] = np.cross([0, 0, 1], mesh.points)
    inside = np.linalg.norm(mesh.points, axis=1) < 0.6
    mesh.point_data[name] = np.where(inside, solid, 1 - solid)
    mesh.save(tmp_path / "flow.vtu")
    if library == "meshio":
        pytest.importorskip("meshio")
        monkeypatch.setitem(__import__("sys").modules, "pyvista", None)
    grid = flow_file(tmp_path / "flow.vtu").read().grid(17)
    distance = np.linalg.norm(grid.places, axis=1)
    is_solid = grid.solid.ravel()
    assert is_solid[distance < 0.55].all() and not is_solid[distance > 0.6 + 0.25 * 3**0.5].any()


def test_own_formats_need_no_library_and_others_name_the_missing_one(tmp_path, monkeypatch):
    for name in ("pyvista", "meshio", "h5py"):
        monkeypatch.setitem(__import__("sys").modules, name, None)
    check(flow_file(vti(tmp_path / "flow.vti", {"velocity": VELOCITY}, "zlib")).read())
    check(flow_file(netcdf(tmp_path / "flow.nc", UVW, AXES)).read())
    for name in ("flow.vtu", "flow.h5"):
        (tmp_path / name).write_bytes(b"\x89HDF")
        assert "pip install synch-fields[flows]" in refusal(tmp_path / name)
