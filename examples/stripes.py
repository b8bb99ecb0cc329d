# SPDX-License-Identifier: GPL-3.0-or-later
"""Evenly spaced stripes along a field of lines on a surface.

    minimize  sum over edges ij of  w_ij |phi_j - exp(i omega_ij) phi_i|^2   over unit numbers phi       (Eqs. 5, 6)

where omega_ij = 2 pi / spacing times the edge's extent across the lines. Where the lines come back turned, the edge
conjugates phi_i first. Stripes begin and end at dislocations, where no phase fits.

    python examples/stripes.py [VERTICES_ACROSS] [SPACING]
"""

import sys

from synch_fields.core.fields import direction_field, stripe_pattern
from synch_fields.examples.shapes import torus


def main(across=40, spacing=0.2):
    mesh = torus(int(across))
    pattern = stripe_pattern(mesh, direction_field(mesh, symmetry=2), float(spacing))
    solution = pattern.solution
    print(
        f"energy {solution.energy:.2f}, at least {solution.lower_bound:.2f} ({solution.certificate}) for any stripes;"
    )
    print(f"{len(pattern.dislocations)} dislocations; {len(solution.variations)} other patterns near the best")
    return pattern


if __name__ == "__main__":
    main(*sys.argv[1:])
