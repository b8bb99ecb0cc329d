# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples run, small, and say what is true."""

import ast
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from synch_fields.core.solve import Certificate
from synch_fields.examples import (
    angular_synchronization,
    clebsch,
    directions,
    pose_graph,
    quads,
    stripes,
    volumetric_stripes,
)

from ..core.frame_graphs import random_edges

FOLDER = Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("[a-z]*.py")), ids=lambda path: path.stem)
def test_every_example_is_a_page_on_the_core_alone(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 100
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module.startswith("synch_fields"):
            assert node.module.startswith(("synch_fields.core.", "synch_fields.examples."))
    if path.stem != "shapes":
        assert "minimize" in ast.get_docstring(tree) or "maximize" in ast.get_docstring(tree)
        assert f"python examples/{path.name}" in ast.get_docstring(tree)


def test_indices_of_directions_sum_to_the_euler_characteristic(capsys):
    field = directions.main(16)
    assert sum(defect.index for defect in field.disclinations) == pytest.approx(0, abs=1e-12)
    assert "whose indices sum to 0" in capsys.readouterr().out


def test_stripes_have_a_bound(capsys):
    solution = stripes.main(16, 0.5).solution
    assert 0 < solution.lower_bound <= solution.energy and solution.certificate is Certificate.PROVED
    assert f"energy {solution.energy:.2f}, at least" in capsys.readouterr().out


def test_quads_are_quads():
    pattern, mesh = quads.main(20, 0.4)
    assert (mesh.sizes == 4).all() and len(mesh.sizes) > 50
    assert pattern.solution.lower_bound <= pattern.solution.energy


def test_layers_are_about_as_far_apart_as_asked():
    layers = volumetric_stripes.main(0.2, 0.6)
    assert layers.spacings.mean == pytest.approx(0.6, rel=0.1)
    assert 0 < layers.solution.lower_bound <= layers.solution.energy


def test_clebsch_maps_keep_the_order_of_the_paper():
    energies = [found.energy for found in clebsch.main(14, 4).values()]
    assert (np.diff(energies) <= 1e-6 * energies[0]).all() and energies[-1] < 0.95 * energies[0]


def test_angles_are_found_above_the_threshold_and_not_below():
    rows = angular_synchronization.main(80, (0.3, 3.0, 6.0))
    for (share, theory, spectral, sdp, is_best), found in zip(rows, (False, True, True), strict=True):
        assert is_best == found
        assert (min(spectral, sdp) > 0.9) if found else (max(spectral, sdp) < 0.5 and theory == 0), share


def write_poses(path, noise, seed, is_flat=False):
    """A g2o file of rotations with some noise, half of the quaternions with the other sign; the true rotations."""
    random = np.random.default_rng(seed)
    edges = random_edges(40, 80, random)
    axes = np.array([0, 0, 1]) if is_flat else np.ones(3)
    truth = Rotation.from_rotvec(random.uniform(-1.8, 1.8, (40, 3)) * axes)
    errors = Rotation.from_rotvec(noise * random.standard_normal((len(edges), 3)) * axes)
    measured = truth[edges[:, 0]].inv() * truth[edges[:, 1]] * errors
    lines = []
    for k, (i, j) in enumerate(edges + 7):  # the names of poses are any numbers
        if is_flat:
            lines.append(f"EDGE_SE2 {i} {j} 1 0 {measured[k].as_rotvec()[2]:.17g} 1 0 0 1 0 50")
        else:
            quaternion = measured[k].as_quat() * random.choice([-1, 1])
            information = " ".join("50" if place in (15, 18, 20) else "0" for place in range(21))
            lines.append(f"EDGE_SE3:QUAT {i} {j} 1 0 0 {' '.join(f'{x:.17g}' for x in quaternion)} {information}")
    vertices = [f"VERTEX_SE3:QUAT {i} 0 0 0 0 0 0 1" for i in range(7, 47)]
    path.write_text("\n".join([*vertices, *lines, ""]))
    return truth.as_matrix()


@pytest.mark.parametrize("is_flat", [False, True])
def test_rotations_of_poses_are_found_and_proved(is_flat, tmp_path, capsys):
    path = tmp_path / "poses.g2o"
    truth = write_poses(path, 0.0, 0, is_flat)
    d = 2 if is_flat else 3
    poses, rotations, _ = pose_graph.main(path)
    assert (poses == np.arange(7, 47)).all() and rotations.shape == (40, d, d)
    np.testing.assert_allclose(rotations[0].T @ rotations, truth[0, :d, :d].T @ truth[:, :d, :d], atol=1e-12)
    write_poses(path, 0.15, 0, is_flat)
    _, rotations, found = pose_graph.main(path)
    assert found["relaxed"].certificate is Certificate.PROVED
    assert found["relaxed"].energy < found["chordal"].energy
    assert found["relaxed"].energy == pytest.approx(found["relaxed"].lower_bound, rel=1e-4)
    assert "40 poses," in capsys.readouterr().out
