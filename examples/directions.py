# SPDX-License-Identifier: GPL-3.0-or-later
"""The smoothest field of crosses on a surface.

    minimize  sum over edges ij of  w_ij |phi_j - exp(i 4 rho_ij) phi_i|^2   over unit numbers phi      (Eqs. 1, 2)

with cotangent weights w and the turn rho of the tangent planes along an edge. phi is the fourth power of a direction.
The indices of its singular points add up to the Euler characteristic.

    python examples/directions.py [VERTICES_ACROSS]
"""

import sys

from synch_fields.core.fields import direction_field
from synch_fields.examples.shapes import torus


def main(across=40):
    mesh = torus(across)
    field = direction_field(mesh, symmetry=4)
    indices = [defect.index for defect in field.disclinations]
    solution = field.solution
    print(f"{mesh.vertex_count} vertices: energy {solution.energy:.4f}, at least {solution.lower_bound:.4f}")
    print(
        f"({solution.certificate}) for any field; {len(indices)} singular points, whose indices sum to {sum(indices):g}"
    )
    return field


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
