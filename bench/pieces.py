# SPDX-License-Identifier: GPL-3.0-or-later
"""What many connected pieces cost beside one mesh of as many vertices and the same kind.

    python bench/pieces.py [--pieces 10000]

"flat" and "bumpy": patches of 4 x 5 vertices, beside one patch of all; "boxes": closed boxes of 18 vertices, beside a
bumpy torus with edges of the same length. Line fields and stripes along them, with the default options; one run each,
in a process of its own. "/ one": seconds over those of the one mesh.
"""

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import row_of_child, timed
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.fields import direction_field, stripe_pattern
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh

# Standard deviation of the vertices' places, in edges of a patch, and the spacing of stripes.
BUMPS = {"flat": 0.0, "bumpy": 0.12, "boxes": 0.06}
EDGE, SPACING = 1 / 3, 0.3
COLUMNS = (
    Column("pieces", "pieces", "d"),
    Column("nodes", "nodes", "d"),
    Column("s directions", "directions s", ".2f"),
    Column("/ one", "directions ratio", ".2f"),
    Column("gap", "directions gap", ".1e"),
    Column("status", "directions status", ""),
    Column("s stripes", "stripes s", ".2f"),
    Column("/ one", "stripes ratio", ".2f"),
    Column("gap", "stripes gap", ".1e"),
    Column("status", "stripes status", ""),
)


def main():
    """Print a table."""
    parser = arguments(__doc__)
    parser.add_argument("--pieces", type=int, default=10_000)
    count = parser.parse_args().pieces
    rows = []
    for kind in BUMPS:
        one = row_of_child(f"{kind}, one", measure, kind, 1, count)
        many = row_of_child(f"{kind}, many", measure, kind, count, count)
        for what in ("directions", "stripes"):
            many[f"{what} ratio"] = many[f"{what} s"] / one[f"{what} s"]
        rows += [one, many]
    print_table("many pieces", COLUMNS, rows)


def measure(kind, pieces, size):
    """A row of the table; runs in a process of its own."""
    side = round(np.sqrt(20 * size))
    if kind == "boxes":
        mesh = _boxes(pieces) if pieces > 1 else _torus(18 * size)
    else:
        mesh = _patches(4, 5, pieces) if pieces > 1 else _patches(side, side, 1)
    check_mesh(mesh)
    mesh = TriangleMesh(_bumped(mesh.vertices, BUMPS[kind] * EDGE), mesh.triangles)
    field, directions = timed(direction_field, mesh, 2)
    pattern, stripes = timed(stripe_pattern, mesh, field, SPACING)
    row = {"pieces": pieces, "nodes": mesh.vertex_count}
    for what, solution, seconds in (("directions", field.solution, directions), ("stripes", pattern.solution, stripes)):
        row |= {f"{what} s": seconds, f"{what} gap": solution.sdp_gap, f"{what} status": solution.status.value}
    return row


def _bumped(vertices, deviation):
    return vertices + deviation * np.random.default_rng(0).standard_normal(vertices.shape)


def _grid(columns, rows, is_closed=False):
    """Triangles of a grid of vertices."""
    i, j = np.mgrid[: columns if is_closed else columns - 1, : rows if is_closed else rows - 1]
    right, up = (i + 1) % columns, (j + 1) % rows
    corners = [place.ravel() for place in (i * rows + j, right * rows + j, right * rows + up, i * rows + up)]
    return np.concatenate([np.column_stack([corners[k] for k in of]) for of in ((0, 1, 2), (0, 2, 3))])


def _patches(columns, rows, count):
    """Flat rectangles, side by side."""
    x, y = np.meshgrid(EDGE * np.arange(columns), EDGE * np.arange(rows), indexing="ij")
    return _side_by_side(np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]), _grid(columns, rows), count)


def _boxes(count):
    """Square tubes of four rings, closed by a vertex at either end."""
    angles = np.pi / 4 + np.pi / 2 * np.arange(4)
    rings = [np.column_stack([np.cos(angles), np.sin(angles), np.full(4, z)]) for z in np.linspace(0, 2, 4)]
    tube = _grid(4, 4, is_closed=True)
    tube = tube[(np.ptp(tube // 4, axis=1) < 3)]  # open where the last ring would meet the first
    after = np.roll(np.arange(4), -1)
    first, last = np.full(4, 16), np.full(4, 17)
    ends = [np.column_stack([after, np.arange(4), first]), np.column_stack([12 + np.arange(4), 12 + after, last])]
    triangles = np.concatenate([tube[:, ::-1], *ends])
    return _side_by_side(0.5 * np.concatenate([*rings, [[0, 0, 0], [0, 0, 2]]]), triangles, count)


def _side_by_side(vertices, triangles, count):
    """Copies of a small mesh."""
    side = int(np.ceil(np.sqrt(count)))
    places = 3.0 * np.column_stack([*np.divmod(np.arange(count), side), np.zeros(count)])
    numbers = len(vertices) * np.arange(count)
    return TriangleMesh(
        (vertices + places[:, None]).reshape(-1, 3), (triangles + numbers[:, None, None]).reshape(-1, 3)
    )


def _torus(size):
    """Of about so many vertices, half as many around as along."""
    along = int(np.sqrt(2 * size))
    u, v = np.meshgrid(*(2 * np.pi / n * np.arange(n) for n in (along, along // 2)), indexing="ij")
    radius = EDGE * along / (2 * np.pi)
    ring = radius * (1 + 0.3 * np.cos(v))
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), 0.3 * radius * np.sin(v)], axis=-1)
    return TriangleMesh(vertices.reshape(-1, 3), _grid(along, along // 2, is_closed=True))


if __name__ == "__main__":
    main()
