# SPDX-License-Identifier: GPL-3.0-or-later
"""Evenly spaced layers in a solid around an axis: half planes that come nearer to one another towards it.

    minimize  sum over edges ij of  w_ij |phi_j - exp(i omega_ij) phi_i|^2   over unit numbers phi      (Section 3.4)

with the weights of tetrahedra and omega_ij = 2 pi / spacing times the edge's extent along the direction. Around the
axis the layers would have to be further apart outside: dislocation curves let new ones begin.

    python examples/volumetric_stripes.py [SIZE] [SPACING]
"""

import sys

import numpy as np

from synch_fields.core.fields.layers import solve_layers
from synch_fields.examples.shapes import solid_torus


def main(size=0.12, spacing=0.35):
    mesh = solid_torus(float(size))
    x, y, _ = mesh.vertices.T
    around = np.column_stack([-y, x, np.zeros(len(x))])
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    layers = solve_layers(mesh, around, float(spacing))
    solution, found = layers.solution, layers.spacings
    print(
        f"{mesh.tet_count} tetrahedra: energy {solution.energy:.3f}, at least {solution.lower_bound:.3f} for any layers"
    )
    print(f"({solution.certificate}); {found.mean:.3f} apart, {found.thinnest:.3f} to {found.thickest:.3f}")
    return layers


if __name__ == "__main__":
    main(*sys.argv[1:])
