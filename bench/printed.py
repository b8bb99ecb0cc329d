# SPDX-License-Identifier: GPL-3.0-or-later
"""Eleven solids as programs, run by a simulated printer that reads nothing but the text (bench/gcode_simulator.py).

    python bench/printed.py MESHES [--benchy benchy.stl] [--only NAME ...] [--processes N]

Solids along Z stand upright and have 100 layers and more, of half the width of beads; the curved shell, the bent bar
and the ring are printed along their normals on a table that turns around X and Z. MESHES holds bunny.mesh,
fandisk.obj, rocker-arm.obj, spot.obj and botijo.obj. Needs no Blender.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from time import process_time

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.gcode_simulator import (
    Beads,
    deviations,
    filled_shares,
    moves_through,
    read_moves,
    sampled,
    tip_speed,
    turn_speed,
)
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.solid_shapes import bent_bar, box, cup, curved_shell, ring, solid_bunny
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.fields import layers
from synch_fields.core.fields.guidance.filled import along_axis, away_from_area, between_areas
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.closed_surface import Area, ClosedSurface
from synch_fields.core.geometry.filling.lengths import Lengths
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.geometry.tet_mesh import TetMesh
from synch_fields.core.printing.gcode import gcode
from synch_fields.core.printing.machine import read_machine
from synch_fields.core.solve import Options
from synch_fields.core.tasks.layer_outputs import Layering, PathSettings
from synch_fields.core.tasks.solids import FlushArea, SolidGuide, SolidRequest

# Places in the solid that are looked at, and what samples of moves are apart, in beads' widths.
PLACES, APART = 20_000, 0.2
# Edges of triangles without area that are flipped.
FLIPS = 30
COLUMNS = (
    Column("layer, mm", "height", ".2f"),
    Column("bead, mm", "step", ".2f"),
    Column("layers", "layers", "d"),
    Column("volume", "volume", ".1%"),
    Column("in a bead", "filled", ".1%"),
    Column("within half a width", "near", ".1%"),
    Column("tip off, mm", "off", ".3f"),
    Column("tip, mm a second", "tip_speed", ".0f"),
    Column("table, degrees a second", "speed", ".0f"),
    Column("travels through beads", "through", ".2%"),
    Column("beads through beads", "pressed", ".2%"),
    Column("s layers", "solved", ".0f"),
    Column("s program", "planned", ".0f"),
    Column("of both in the solver", "solver", ".1%"),
)


def closed(vertices, triangles):
    """The :class:`ClosedSurface` of vertices and triangles."""
    mesh = TriangleMesh(np.asarray(vertices, float), np.asarray(triangles))
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    return ClosedSurface(given, SurfaceDistance(mesh))


def upright(meshes, name):
    """A mesh of a file whose Y is up."""
    mesh = read_obj(meshes / f"{name}.obj")
    return mesh.vertices[:, [0, 2, 1]] * [1, -1, 1], mesh.triangles.tolist(), {}


def boundary(solid):
    """Vertices and triangles of the boundary of tetrahedra."""
    surface, _ = solid.boundary_surface
    return surface.vertices, surface.triangles


def read_stl(path):
    """Vertices and triangles of a binary .stl file; edges of triangles without area are flipped."""
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    corners = np.frombuffer(Path(path).read_bytes(), record, offset=84)["corners"].astype(float)
    vertices, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    mesh = TriangleMesh(vertices, numbers.reshape(-1, 3))
    triangles = mesh.triangles[(mesh.triangles != np.roll(mesh.triangles, 1, axis=1)).all(axis=1)]
    for _ in range(FLIPS):
        mesh = TriangleMesh(vertices, triangles.copy())
        lengths = np.linalg.norm(vertices[np.roll(triangles, -1, axis=1)] - vertices[triangles], axis=2)
        for flat in np.flatnonzero(mesh.areas < 1e-10 * lengths.max(axis=1) ** 2)[:1]:
            side = int(lengths[flat].argmax())
            other, place = divmod(int(mesh.twins[3 * flat + side]), 3)
            a, b, c = np.roll(triangles[flat], -side)
            d = triangles[other][(place + 2) % 3]
            triangles[flat], triangles[other] = (b, c, d), (c, a, d)
    return vertices, triangles.tolist(), {}


def parts(meshes, benchy):
    """What makes each solid, its length in millimetres, None as it is, and height and width of its beads."""
    made = {
        "cube": (lambda: (*box((1, 1, 1)), {}), 20, 0.2, 0.4),
        "cup": (cup, 60, 0.3, 0.6),
        "bent bar": (bent_bar, 100, 4, 4),
        "curved shell": (curved_shell, 100, 4, 4),
        "ring": (None, 100, 4, 4),
        "bunny": (lambda: (*boundary(solid_bunny(meshes).mesh), {}), 60, 0.4, 0.8),
    }
    for name in ("fandisk", "rocker-arm", "spot", "botijo"):
        made[name] = (partial(upright, meshes, name), 60, 0.4, 0.8)
    if benchy:
        made["Benchy"] = (partial(read_stl, benchy), None, 0.2, 0.4)
    return made


def solved(name, make, length, height):
    """The surface and the :class:`Layering` of a solid, in millimetres."""
    solid = None
    if name == "ring":
        shape = ring()
        places = shape.mesh.vertices
        solid = TetMesh(places * length / np.ptp(places, axis=0).max(), shape.mesh.tets)
        vertices, triangles = boundary(solid)
        used = np.unique(solid.boundary_triangles)
        groups = {"low": shape.low[used], "high": shape.high[used]}
    else:
        vertices, faces, groups, *_ = make()
        triangles = np.array([(face[0], *two) for face in faces for two in pairwise(face[1:])])
        vertices = (length / np.ptp(vertices, axis=0).max() if length else 1.0) * (vertices - np.min(vertices, axis=0))
    surface = closed(vertices, triangles)
    areas = [Area(label, np.flatnonzero(chosen[triangles].all(axis=1))) for label, chosen in groups.items()]
    guides = [partial(along_axis, np.array([0.0, 0.0, 1.0])), away_from_area, between_areas]
    compute = partial(guides[len(areas)], *areas)
    request = SolidRequest(
        surface,
        solid,
        SolidGuide("guide", compute),
        tuple(FlushArea(area, np.pi) for area in areas),
        Lengths.of(surface.distance, height, None)
        if solid is None
        else Lengths.carried(surface.distance, height, float(np.median(solid.edge_lengths))),
        None,
        Options(),
    )
    result = request.solve()
    return surface, Layering(result.pattern, result.surfaces, result.curves, np.eye(4))


def simulated(meshes, benchy, name):
    """The row of a solid."""
    make, length, height, step = parts(meshes, benchy)[name]
    in_solver = timed_solver()
    start = process_time()
    surface, layering = solved(name, make, length, height)
    middle, tilts = process_time(), name in ("bent bar", "curved shell", "ring")
    machine = replace(
        read_machine("five_axis_ac" if tilts else "marlin"),
        bore=0.0, bed_width=0, bed_depth=0, bed_height=0, largest_flow=0.0, largest_tilt=80.0, largest_height=10.0,
    )  # fmt: skip
    plan = layering.paths(PathSettings(step, machine=machine)).solve()
    course = plan.course
    text = gcode(course, machine).text
    end = process_time()
    moves = read_moves(text)
    beads = moves.printing & (moves.kinds != "Skirt/Brim")
    samples = sampled(moves, beads, machine.pivot_z, APART * step)
    travels = sampled(moves, moves.travels, machine.pivot_z, APART * step)
    places = places_in(surface.distance)
    moved = places - plan.lowest + [*machine.middle, 0]
    volume = moves.extruded[beads].sum() * np.pi * machine.filament**2 / 4
    printed = Beads(samples, moves)
    filled, near = filled_shares(printed, moved)
    return {
        "label": name,
        "height": height,
        "step": step,
        "layers": text.count(";LAYER_CHANGE"),
        "volume": volume / surface.distance.volume,
        "filled": filled,
        "near": near,
        "off": float(deviations(samples, [course.points[run] for run in course.runs], APART * step).max()),
        "tip_speed": tip_speed(moves, samples),
        "speed": turn_speed(moves) if tilts else 0.0,
        "through": float(moves_through(printed, travels).mean()),
        "pressed": float(moves_through(printed, samples).mean()),
        "solved": middle - start,
        "planned": end - middle,
        "solver": sum(in_solver) / (end - start),
    }


def timed_solver():
    """The list of the CPU seconds that each solve of a field takes from now on in this process."""
    seconds, solve = [], layers.solve

    def timed(*arguments, **options):
        start = process_time()
        try:
            return solve(*arguments, **options)
        finally:
            seconds.append(process_time() - start)

    layers.solve = timed
    return seconds


def places_in(distance):
    """(PLACES, 3) places inside of a surface, evenly spread."""
    random, found, count = np.random.default_rng(0), [], 0
    while count < PLACES:
        places = random.uniform(*distance.bounds, (PLACES, 3))
        found.append(places[distance(places) < 0])
        count += len(found[-1])
    return np.concatenate(found)[:PLACES]


def main():
    """Print the table."""
    parser = arguments(__doc__, "the meshes")
    parser.add_argument("--benchy", help="binary .stl file of 3DBenchy")
    parser.add_argument("--only", nargs="+", help="names of solids")
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    chosen = [name for name in parts(options.meshes, options.benchy) if name in (options.only or [name])]
    make = partial(simulated, options.meshes, options.benchy)
    with ProcessPoolExecutor(options.processes, get_context("fork")) as pool:
        rows = list(pool.map(make, chosen))
    print_table("Programs as a simulated printer runs them", COLUMNS, rows)


if __name__ == "__main__":
    main()
