# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors in solids, from files of other programs, and in the solids that they are asked for."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields.filled_surface import FilledSurface
from synch_fields.core.fields.guidance.filled import (
    line_matrices,
    of_given_lines,
    of_given_vectors,
    orient_vectors,
    principal_vectors,
    vectors_at,
)
from synch_fields.core.fields.guidance.solids import have_directions
from synch_fields.core.files.solid_vectors import SolidVectors, read_vectors
from synch_fields.core.geometry.tet_mesh import TetMesh

from ..layered_solids import bent_bar, block

SOLID = block((4, 3, 3), jitter=0.2)
LINEAR = np.array([[1.0, 0.3, -0.2], [0.1, 2.0, 0.4], [-0.3, 0.2, 0.5]])


def medit(keyword, numbers):
    """Text of a .mesh, and of a .sol with a number and a vector for each row."""
    rows = [" ".join(map(repr, [1.0, *row])) for row in numbers.tolist()]
    sol = ["MeshVersionFormatted 2", "Dimension 3", keyword, str(len(rows)), "2 1 2", *rows, "End"]
    vertices = [" ".join(map(repr, row)) + " 0" for row in SOLID.vertices.tolist()]
    tets = [" ".join(map(str, row)) + " 0" for row in (SOLID.tets + 1).tolist()]
    mesh = ["MeshVersionFormatted 2", "Dimension 3", "Vertices", str(len(vertices)), *vertices]
    return "\n".join([*mesh, "Tetrahedra", str(len(tets)), *tets, "End"]), "\n".join(sol)


def vtu(points, cells):
    """Text of a .vtu with vectors on points and cells by name, and a triangle among the tetrahedra."""

    def array(name, kind, values, width=1):
        numbers = " ".join(map(repr, np.asarray(values).ravel().tolist()))
        return (
            f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">{numbers}</DataArray>'
        )

    corners = [*SOLID.tets[:2].tolist(), SOLID.tets[0, :3].tolist(), *SOLID.tets[2:].tolist()]
    types = [10, 10, 5, *[10] * (SOLID.tet_count - 2)]
    data = {
        "PointData": [array(name, "Float64", values, 3) for name, values in points.items()],
        "CellData": [array(name, "Float32", np.insert(v, 2, 9, axis=0), 3) for name, v in cells.items()],
        "Points": [array("Points", "Float64", SOLID.vertices, 3)],
        "Cells": [
            array("connectivity", "Int64", np.concatenate(corners)),
            array("offsets", "Int64", np.cumsum([len(c) for c in corners])),
            array("types", "UInt8", types),
        ],
    }
    inside = "".join(f"<{name}>{''.join(parts)}</{name}>" for name, parts in data.items())
    piece = f'<Piece NumberOfPoints="{SOLID.vertex_count}" NumberOfCells="{len(types)}">{inside}</Piece>'
    return f'<VTKFile type="UnstructuredGrid"><UnstructuredGrid>{piece}</UnstructuredGrid></VTKFile>'


def test_vectors_of_medit_are_read(tmp_path):
    at_vertices = SOLID.vertices @ LINEAR.T
    in_tets = SOLID.vertices[SOLID.tets].mean(axis=1) @ LINEAR.T
    for keyword, values in (("SolAtVertices", at_vertices), ("SolAtTetrahedra", in_tets)):
        for suffix, text in zip((".mesh", ".sol"), medit(keyword, values), strict=True):
            (tmp_path / f"stress{suffix}").write_text(text)
        found = read_vectors(tmp_path / "stress.sol")
        np.testing.assert_array_equal(found.values, values)
        assert found.at_vertices == (keyword == "SolAtVertices")
        np.testing.assert_array_equal(found.mesh.tets, SOLID.tets)


def test_vectors_around_the_solid_are_left_out_with_its_tetrahedra(tmp_path):
    """Where triangles of the file enclose some of its tetrahedra, these alone are the solid."""
    middles = SOLID.vertices[SOLID.tets].mean(axis=1)
    own = np.flatnonzero((middles > 0.3).all(axis=1) & (middles < 0.7).all(axis=1))
    skin = TetMesh(SOLID.vertices, SOLID.tets[own]).boundary_triangles
    mesh, sol = medit("SolAtTetrahedra", middles @ LINEAR.T)
    triangles = "\n".join(["Triangles", str(len(skin)), *(" ".join(map(str, [*row, 0])) for row in skin + 1), "End"])
    (tmp_path / "stress.mesh").write_text(mesh.replace("End", triangles))
    (tmp_path / "stress.sol").write_text(sol)
    found = read_vectors(tmp_path / "stress.sol")
    assert 0 < len(own) < SOLID.tet_count
    np.testing.assert_array_equal(found.mesh.tets, SOLID.tets[own])
    np.testing.assert_array_equal(found.values, (middles @ LINEAR.T)[own])


def test_vectors_of_vtk_are_read_by_name(tmp_path):
    at_points, in_cells = SOLID.vertices @ LINEAR.T, SOLID.vertices[SOLID.tets].mean(axis=1).astype(np.float32)
    path = tmp_path / "stress.vtu"
    path.write_text(vtu({"flow": at_points}, {"stress": in_cells}))
    found = read_vectors(path, "flow")
    np.testing.assert_array_equal(found.values, at_points)
    found = read_vectors(path, "stress")
    assert not found.at_vertices
    np.testing.assert_array_equal(found.values, in_cells)  # the triangle's is left out
    for name in ("", "strain"):
        with pytest.raises(SettingError, match="it has flow on points, stress on cells"):
            read_vectors(path, name)
    path.write_text(vtu({"flow": at_points}, {}))
    np.testing.assert_array_equal(read_vectors(path).values, at_points)
    path.write_text(vtu({"flow": np.where(np.arange(3) == 1, np.nan, at_points)}, {}))
    with pytest.raises(SettingError, match="vector 0 is not finite"):
        read_vectors(path)


@pytest.mark.parametrize(
    ("sol", "words"),
    [
        ("MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n2\n1 2\n1 2 3\n", "cannot be read"),
        ("MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n1\n1 2\n1 2 3\n", "has 1 vectors for"),
        ("MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n1\n1 1\n1\n", "it has none"),
        ("MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n1\n1 7\n1\n", "cannot be read"),
        ("solid", "is not a MEDIT file"),
    ],
)
def test_files_without_vectors_are_refused(tmp_path, sol, words):
    (tmp_path / "s.mesh").write_text(medit("SolAtVertices", SOLID.vertices)[0])
    (tmp_path / "s.sol").write_text(sol)
    with pytest.raises(SettingError, match=words) as caught:
        read_vectors(tmp_path / "s.sol")
    assert str(tmp_path / "s.sol") in str(caught.value)
    for name in ("s.csv", "none.vtu"):
        with pytest.raises(SettingError, match=name):
            read_vectors(tmp_path / name)


def test_between_vertices_linear_vectors_stay_linear():
    random = np.random.default_rng(0)
    points = random.uniform(0, 1, (500, 3))
    found = vectors_at(SOLID, SOLID.vertices @ LINEAR.T, points)
    np.testing.assert_allclose(found, points @ LINEAR.T, atol=1e-12)
    # Outside they are those of a place nearby.
    beside = vectors_at(SOLID, SOLID.vertices, points + [1, 0, 0])
    assert (beside >= -1e-12).all() and (beside <= 1 + 1e-12).all() and beside[:, 0].min() > 0.6


def test_a_solid_gets_the_vectors_of_another_one():
    fine = FilledSurface(None, block((7, 6, 5), jitter=0.1))
    given = SolidVectors(SOLID, SOLID.vertices @ LINEAR.T, True)
    stretch = np.diag([2.0, 1.0, 0.5])
    inside = FilledSurface(None, block((7, 6, 5), (2, 1, 0.5)))
    np.testing.assert_allclose(of_given_vectors(given, np.eye(3), fine), fine.solid.vertices @ LINEAR.T, atol=1e-9)
    places = inside.solid.vertices / np.diag(stretch)
    np.testing.assert_allclose(of_given_vectors(given, stretch, inside), places @ LINEAR.T @ stretch, atol=1e-9)


def test_lines_of_either_sign_agree_with_their_neighbours():
    """Around a bent bar, with signs thrown: one field, which is the bar's own or its opposite."""
    mesh, around = bent_bar((6, 20, 3), 1, 2, np.pi / 2, 0.3)
    thrown = around * np.random.default_rng(1).choice([-1.0, 1.0], mesh.vertex_count)[:, None]
    found = orient_vectors(mesh, thrown)
    dots = np.einsum("nx,nx->n", found, around)
    np.testing.assert_allclose(np.abs(dots.sum()), mesh.vertex_count)
    given = SolidVectors(mesh, thrown[mesh.tets[:, 0]], False)  # in tetrahedra: means of lines, not of vectors
    lines = of_given_lines(given, np.eye(3), FilledSurface(None, mesh))
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    assert np.abs(np.einsum("nx,nx->n", lines, around)).min() > 0.95
    assert (np.einsum("ex,ex->e", *(lines[end] for end in mesh.edges.T)) > 0).all()


def test_lines_that_come_back_turned_over_have_no_direction_there():
    """Half a turn around a ring: on a cut through it nothing can agree, and nowhere else."""
    bar, _ = bent_bar((2, 48, 2), 1, 1.5, 2 * np.pi, 0.3)
    _, first, names = np.unique(np.rint(bar.vertices * 1e6), axis=0, return_index=True, return_inverse=True)
    mesh = TetMesh(bar.vertices[first], names.reshape(-1)[bar.tets])
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) / 2
    lines = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    known = have_directions(mesh, orient_vectors(mesh, lines))
    turns = np.unique(np.rint(48 * angle[~known] / np.pi))
    assert 2 <= len(turns) <= 4 and 2 * 9 <= np.count_nonzero(~known) <= 4 * 9
    np.testing.assert_allclose(np.abs(np.einsum("nx,nx->n", principal_vectors(line_matrices(lines)), lines)), 1)


def test_means_of_lines_do_not_cancel():
    lines = np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 0.5, 0]])
    np.testing.assert_allclose(
        np.abs(principal_vectors(line_matrices(lines).mean(axis=0)[None])), [[2 / 3, 0, 0]], atol=1e-12
    )
