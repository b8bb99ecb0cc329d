# SPDX-License-Identifier: GPL-3.0-or-later
"""Instant Meshes (Jakob et al. 2015) on a file, as a peer of quads.py: an interpreter that has pynanoinstantmeshes.

    python bench/quads.py MESHES --peer "Instant Meshes=PYTHON bench/instant_meshes.py {input} {output} {faces} [ANGLE]"

PYTHON is of an environment with NumPy and pynanoinstantmeshes 0.0.3, which the project does without. Normals differ
across edges that bend by more than ANGLE degrees, if there is one; as the program comes they do not.
"""

import sys
from pathlib import Path

import numpy as np
from pynanoinstantmeshes import remesh

# As the program comes, but always with the same result.
SETTINGS = {"vertex_count": -1, "rosy": 4, "posy": 4, "scale": -1.0, "align_to_boundaries": False, "extrinsic": True}
STEPS = {"smooth_iter": 2, "knn_points": 10, "deterministic": True}


def main():
    """Read the triangles of an .obj file and write the quads."""
    source, target, faces, angle = [*sys.argv[1:], "-1"][:4]
    lines = [line.split() for line in Path(source).read_text().splitlines()]
    vertices = np.array([words[1:] for words in lines if words[:1] == ["v"]], np.float32)
    triangles = np.array([words[1:] for words in lines if words[:1] == ["f"]], np.int64) - 1
    asked = {"face_count": int(faces), "creaseAngle": float(angle)}
    places, quads = remesh(vertices, triangles.astype(np.uint32), **asked, **SETTINGS, **STEPS)
    rows = [("v", *place) for place in places.tolist()] + [("f", *corners) for corners in (quads + 1).tolist()]
    Path(target).write_text("\n".join(" ".join(map(str, row)) for row in rows) + "\n")


if __name__ == "__main__":
    main()
