# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces for the benchmarks, made by code: closed and open, sharp and smooth, thin, with up to three handles.

    python bench/surface_shapes.py --folder DIR

writes them as .obj files. All are manifold and oriented, in small triangles of about one size, and the same on every
run. The longest side of each is 1 to 2.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.meshes import write_obj
from synch_fields.bench.polyhedra import Polyhedron, circle, convex, prism
from synch_fields.bench.turned import turned
from synch_fields.core.extract.vortices.tubes import isosurface, smooth_surface
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.grid import box_grid

# Share of an edge of the grid that vertices of an implicit surface keep from its nodes, and how often they are spread
# evenly and put back.
MARGIN, EVENINGS = 0.3, 12
# Length of the difference quotients along an implicit surface, and Newton steps to it.
NUDGE, NEWTON_STEPS = 1e-5, 4


@dataclass(frozen=True)
class SurfaceShape:
    """A surface by its name.

    Attributes
    ----------
    name : also of its file
    make : () -> TriangleMesh
    characteristic : Euler characteristic
    boundaries : number of closed boundary curves
    """

    name: str
    make: Callable[[], TriangleMesh]
    characteristic: int
    boundaries: int = 0


def main():
    """Write the files."""
    options = arguments(__doc__, folder="the files go").parse_args()
    for shape in SHAPES:
        write_obj(shape.make(), options.folder / f"{shape.name}.obj")


# Plane faces


def plate_with_hole():
    """A flat sheet with a round hole beside its middle."""
    sheet = Polyhedron()
    outline = sheet.ring(_rectangle(1.6, 1.0))
    sheet.top(outline, sheet.ring(circle(0.28, 0.012, (-0.2, 0.05), clockwise=True)))
    return sheet.triangulated(0.016)


def wavy_sheet():
    """A round sheet with two holes, bent up and down."""
    sheet = Polyhedron()
    rings = [circle(0.8, 0.018), *(circle(0.16, 0.012, (x, 0.1), clockwise=True) for x in (-0.35, 0.35))]
    sheet.top(*map(sheet.ring, rings))
    mesh = sheet.triangulated(0.018)
    x, y, _ = mesh.vertices.T
    return TriangleMesh(np.column_stack([x, y, 0.15 * np.sin(4 * x + 1) * np.cos(3 * y)]), mesh.triangles)


def thin_box():
    """A box of a fiftieth of its length in thickness."""
    return prism(_rectangle(1.5, 1.0), 0.03).triangulated(0.02)


def chamfered_cube():
    """A cube whose edges and corners are cut off."""
    far, near = 0.5, 0.38
    signs = np.stack(np.meshgrid(*3 * [[-1, 1]]), axis=-1).reshape(-1, 3)
    return convex(np.concatenate([signs * np.roll([far, near, near], axis) for axis in range(3)])).triangulated(0.026)


def bracket():
    """An L with a sharp edge inwards."""
    outline = [(0, 0), (1, 0), (1, 0.22), (0.22, 0.22), (0.22, 0.8), (0, 0.8)]
    return prism(outline, 0.6).triangulated(0.024)


def block_with_holes():
    """A block with three square holes, each turned its own way: three handles."""
    holes = [_turned_square(0.26, turn, (x, 0.0)) for x, turn in ((-0.5, 0.0), (0.0, np.pi / 4), (0.5, np.pi / 7))]
    return prism(_rectangle(1.6, 0.6), 0.3, holes).triangulated(0.021)


def link():
    """A machine part: a rounded plate with a bore at each end, one of them with a raised collar."""
    size, thickness, rise, reach = 0.021, 0.16, 0.34, 0.5
    part = Polyhedron()
    outline = np.concatenate([end + [x, 0] for x, end in ((reach, _arc(0.3, size)), (-reach, -_arc(0.3, size)))])
    small = circle(0.13, size, (reach, 0), clockwise=True)
    large = circle(0.15, size, (-reach, 0), clockwise=True)
    collar = circle(0.25, size, (-reach, 0))
    lower, upper = part.ring(outline), part.ring(outline, thickness)
    small_low, small_high = part.ring(small), part.ring(small, thickness)
    large_low, large_high = part.ring(large), part.ring(large, rise)
    collar_low, collar_high = part.ring(collar, thickness), part.ring(collar, rise)
    for below, above in ((lower, upper), (small_low, small_high), (large_low, large_high), (collar_low, collar_high)):
        part.wall(below, above)
    part.bottom(lower, small_low, large_low)
    part.top(upper, small_high, collar_low[::-1])
    part.top(collar_high, large_high)
    return part.triangulated(size)


def _rectangle(width, height):
    return np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * [width / 2, height / 2]


def _turned_square(side, turn, centre):
    """A clockwise square."""
    spread = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return _rectangle(side, side)[::-1] @ spread + centre


def _arc(radius, size):
    """The right half of a circle, from below upwards."""
    turns = np.linspace(-np.pi / 2, np.pi / 2, int(np.pi * radius / size) + 1)
    return radius * np.column_stack([np.cos(turns), np.sin(turns)])


# Surfaces of revolution


def open_cylinder():
    """A tube without ends."""
    return turned(np.array([(0.4, -0.6), (0.4, 0.6)]), 0.021)


def bowl():
    """Half of a sphere with its rim."""
    turns = np.linspace(-np.pi / 2, 0, 200)
    return turned(0.7 * np.column_stack([np.cos(turns), np.sin(turns)]), 0.022)


def lens():
    """Two flat caps that meet in a sharp round edge."""
    lower = np.linspace(0, 1, 200)[:, None] * [0.7, 0.0]
    lower[:, 1] = -0.15 * (1 - (lower[:, 0] / 0.7) ** 2)
    profile = np.vstack([lower, (lower * [1, -1])[-2::-1]])
    profile[[0, -1], 0] = 0
    return turned(profile, 0.019)


def thin_torus():
    """A ring of a tenth of its radius in thickness."""
    turns = 2 * np.pi * np.arange(400) / 400
    return turned(np.column_stack([0.8 + 0.08 * np.cos(turns), 0.08 * np.sin(turns)]), 0.02, closed=True)


def bumpy_sphere():
    """A sphere with rounded bumps and dents."""
    turns = np.linspace(-np.pi / 2, np.pi / 2, 400)
    mesh = turned(0.6 * np.column_stack([np.cos(turns), np.sin(turns)]), 0.026)
    x, y, z = mesh.vertices.T / 0.6
    height = 1 + 0.16 * np.sin(4 * x) * np.cos(3 * y + 1) + 0.1 * np.sin(5 * z - 2 * x)
    return TriangleMesh(height[:, None] * mesh.vertices, mesh.triangles)


# Implicit surfaces


def double_torus():
    """Two rings that have grown together."""
    return implicit_surface(lambda p: union_of([ring_distance(p, (x, 0), 0.3, 0.13) for x in (-0.38, 0.38)], 0.2), 40)


def triple_torus():
    """Three rings around a middle."""
    turns = np.pi / 2 + 2 * np.pi * np.arange(3) / 3
    centres = 0.43 * np.column_stack([np.cos(turns), np.sin(turns)])
    return implicit_surface(lambda p: union_of([ring_distance(p, centre, 0.29, 0.12) for centre in centres], 0.2), 42)


def cup():
    """A thin-walled cup with a handle."""
    return implicit_surface(_cup, 31)


def _cup(points):
    """Signed distance, nearly: a rounded shell of revolution, and a piece of a ring outside of it."""
    x, y, z = points.T
    radius, height, wall = 0.42, 0.42, 0.08
    around = np.hypot(x, y)
    side = np.hypot(around - radius, np.maximum(np.abs(z) - height, 0))
    floor = np.hypot(np.maximum(around - radius, 0), z + height)
    shell = union_of([side - wall, floor - wall], 0.05)
    handle = np.hypot(np.hypot(x - radius, z) - 0.3, y) - 0.07
    return union_of([shell, np.maximum(handle, radius - around)], 0.12)


def ring_distance(points, centre, large, small):
    """Signed distance to a torus around a vertical axis."""
    x, y, z = points.T
    return np.hypot(np.hypot(x - centre[0], y - centre[1]) - large, z) - small


def union_of(distances, blend):
    """The least of several distances, rounded where two differ by less than a length."""
    whole = distances[0]
    for other in distances[1:]:
        share = np.maximum(blend - np.abs(whole - other), 0) / blend
        whole = np.minimum(whole, other) - share**2 * blend / 4
    return whole


def implicit_surface(distance, resolution):
    """The surface on which a function of (n, 3) points that grows outwards is 0, between -1.2 and 1.2."""
    corner = np.full(3, 1.2)
    coarse = box_grid(-corner, corner, 24)
    near = coarse.places[distance(coarse.places) < 0.1]
    grid = box_grid(near.min(axis=0) - 0.1, near.max(axis=0) + 0.1, resolution)
    mesh = isosurface(grid, -distance(grid.places), 0.0, MARGIN).mesh
    for _ in range(EVENINGS):
        mesh = TriangleMesh(_put_back(distance, smooth_surface(mesh, mesh.vertices, 1)), mesh.triangles)
    return mesh


def _put_back(distance, points):
    """Points moved to where a function is 0."""
    for _ in range(NEWTON_STEPS):
        values = distance(points)
        slopes = [(distance(points + step) - values) / NUDGE for step in NUDGE * np.eye(3)]
        slopes = np.column_stack(slopes)
        points = points - (values / (slopes**2).sum(axis=1))[:, None] * slopes
    return points


SHAPES = (
    SurfaceShape("plate-with-hole", plate_with_hole, 0, 2),
    SurfaceShape("wavy-sheet", wavy_sheet, -1, 3),
    SurfaceShape("thin-box", thin_box, 2),
    SurfaceShape("chamfered-cube", chamfered_cube, 2),
    SurfaceShape("bracket", bracket, 2),
    SurfaceShape("block-with-holes", block_with_holes, -4),
    SurfaceShape("link", link, -2),
    SurfaceShape("open-cylinder", open_cylinder, 0, 2),
    SurfaceShape("bowl", bowl, 1, 1),
    SurfaceShape("lens", lens, 2),
    SurfaceShape("thin-torus", thin_torus, 0),
    SurfaceShape("bumpy-sphere", bumpy_sphere, 2),
    SurfaceShape("double-torus", double_torus, -2),
    SurfaceShape("triple-torus", triple_torus, -4),
    SurfaceShape("cup", cup, 0),
)


if __name__ == "__main__":
    main()
