# SPDX-License-Identifier: GPL-3.0-or-later
"""Two patterns of stripes across each other along a field of crosses, and the mesh of quads between them.

    minimize  sum over edges ij and both directions k of  w_ij |phi_j,s(k) - exp(i omega_ij,k) phi_i,k|^2  (Section 3.5)

over pairs of unit numbers at the vertices. Around a singular point of the crosses the two change places (s), so that
both are one problem on a cover of the surface.

    python examples/quads.py [VERTICES_ACROSS] [SPACING]
"""

import sys

from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.fields import direction_field, quad_pattern
from synch_fields.examples.shapes import torus


def main(across=30, spacing=0.25):
    mesh = torus(int(across))
    pattern = quad_pattern(mesh, direction_field(mesh, symmetry=4), float(spacing), branching=0.0)  # nothing but quads
    quads = quad_mesh(pattern.edge_phases)
    solution = pattern.solution
    print(
        f"energy {solution.energy:.2f}, at least {solution.lower_bound:.2f} ({solution.certificate}) for any pattern;"
    )
    print(f"{len(quads.vertices)} vertices and {len(quads.sizes)} faces, {(quads.sizes == 4).mean():.1%} of them quads")
    return pattern, quads


if __name__ == "__main__":
    main(*sys.argv[1:])
