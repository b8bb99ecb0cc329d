# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations of the poses of a robot from measured rotations between them.

    minimize  sum over edges ij of  k_ij |R_j - R_i G_ij|^2   over rotations R            (Rosen et al. 2019, SE-Sync)

where G_ij turns pose j into the frame of pose i. Transposed, X_i = R_i^T, an edge asks for X_j = G_ij^T X_i. The
chordal start relaxes to any frames with the right sum of squares: that is the spectral method here. The semidefinite
relaxation's bound proves how far from best a solution is, most often not at all.

    python examples/pose_graph.py [POSES.g2o]     lines VERTEX_SE3:QUAT, EDGE_SE3:QUAT (or VERTEX_SE2, EDGE_SE2)

Without a file, the robot walks in loops, and its measurements are drawn at random.
"""

import sys
import time

import numpy as np
from scipy.spatial.transform import Rotation

from synch_fields.core.connection import Connection, Fibre
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, solve


def read_poses(path):
    """(e, 2) names of poses, (e, d, d) rotations G_ij and (e,) weights of the edges of a g2o text file.

    The weight is the mean of the diagonal of the rotation's information matrix.
    """
    with open(path, encoding="utf-8") as file:
        rows = [line.split() for line in file]
    solid = np.array([row[1:] for row in rows if row and row[0] == "EDGE_SE3:QUAT"], float).reshape(-1, 30)
    flat = np.array([row[1:] for row in rows if row and row[0] == "EDGE_SE2"], float).reshape(-1, 11)
    if len(solid):
        turns = Rotation.from_quat(solid[:, 5:9]).as_matrix()
        return solid[:, :2].astype(int), turns, solid[:, [24, 27, 29]].mean(axis=1)
    cosine, sine = np.cos(flat[:, 4]), np.sin(flat[:, 4])
    turns = np.moveaxis(np.array([[cosine, -sine], [sine, cosine]]), -1, 0)
    return flat[:, :2].astype(int), turns, flat[:, 10]


def walk(loops=6, steps=20, noise=0.1):
    """Edges, rotations and weights as of :func:`read_poses`, for a robot that turns around the z axis as it walks.

    Each pose is measured from the one before and from the one a loop before. Errors are random rotations, by ``noise``
    radians in the mean square.
    """
    random = np.random.default_rng(0)
    count = loops * steps
    truth = Rotation.from_rotvec(2 * np.pi / steps * np.outer(np.arange(count), [0, 0, 1]))
    edges = np.vstack([np.column_stack([np.arange(back, count) - back, np.arange(back, count)]) for back in (1, steps)])
    errors = Rotation.from_rotvec(noise / np.sqrt(3) * random.standard_normal((len(edges), 3)))
    turns = truth[edges[:, 0]].inv() * truth[edges[:, 1]] * errors
    return edges, turns.as_matrix(), np.ones(len(edges))


def main(path=None, target_gap=1e-5):
    names, turns, weights = read_poses(path) if path else walk()
    poses, edges = np.unique(names, return_inverse=True)
    connection = Connection(len(poses), edges.reshape(-1, 2), weights, turns.swapaxes(1, 2))
    problem = SynchronizationProblem(connection, fibre=Fibre.ROTATIONS)
    print(f"{len(poses)} poses, {len(names)} measured rotations")
    found = {}
    for name, method in (("chordal", "spectral"), ("relaxed", "sdp")):
        begin = time.perf_counter()
        found[name] = solve(problem, Options(method=method, target_gap=target_gap))
        print(f"{name}: energy {found[name].energy:.6f}, {time.perf_counter() - begin:.2f} seconds")
    best = found["relaxed"]
    print(f"no rotations have less than {best.lower_bound:.6f} ({best.certificate})")
    return poses, best.phases.swapaxes(1, 2), found


if __name__ == "__main__":
    main(*sys.argv[1:2])
