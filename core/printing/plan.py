# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads in the order in which they are printed, and what is wrong with that: where they lie on air, and where the tool
meets what it has printed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..errors import SettingError
from ..extract.layers.surfaces import LayerSurfaces
from ..extract.lines.isolines import Isolines
from ..geometry.polylines import divide_pieces
from ..geometry.tet_mesh import TetMesh
from ..graphs import pairs_within
from .beads import Beads
from .coverage import even_along, point_lengths
from .flat import flat_below, is_flat
from .gcode import GAP, INNER, SPARSE, WALL, Course
from .heights import NOTHING, OUTSIDE, Below, below
from .machine import Machine
from .order import carrying_pairs, count_levels, layer_order, order_lines
from .overlaps import find_overlaps
from .ramps import Sheets, lie_upon_themselves, split_lines
from .reach import collisions, tilts, tool_axes

KINDS = (WALL, INNER, GAP, SPARSE)
# What is this near to the lowest place, in spacings, lies on the bed.
_ON_BED = 0.5
# A bead leans on an earlier layer that is no farther than this, in spacings: 45 degrees aside of what is below.
_LEAN = 1.5
# The tool meets what is higher above its tip than this, in spacings.
_SLACK = 0.25
# Points of overhangs per batch.
_BATCH = 8192
# Less high than this, in spacings, a bead is not printed.
_NO_HEIGHT = 0.02
# How often parts of beads that reach into others are left out, and the others enlarged.
_ROUNDS = 8
# Seams at the back lie as far in this direction as can be: on a side across Y at its left end.
_BACK = np.array([-0.1, 1.0, 0.0])


@dataclass(frozen=True)
class PrintPlan:
    """Beads in the order in which they are printed.

    Attributes
    ----------
    lines : Isolines over the triangles of the layers
    layers : (l,) the layer of each line
    sheets : (l,) the sheet of each line, see :mod:`.ramps`; its layer where none is a ramp
    levels : (l,) how many sheets lie below that of each line, one on the other
    widths : (n,) at the lines' points
    down, up : (n,) how far the bead reaches below and above the layer: half way to the next layer, or to the end of the
        solid; the tip is at its top
    kinds : (l,) what each line is, as :mod:`.gcode` calls it
    volume : of the solid, scene units
    matrix : (4, 4) from the solid's space to the world, Z upwards
    step, spacing : between beads, and mean distance of layers
    covered : (c,) share of each layer's area that is covered
    covered_share : of all layers
    overhangs : (n,) bool, on air: neither on the bed nor on a layer that was printed before, nor 45 degrees
        aside of one
    met : (n,) the point at which what the tool meets was printed, -1 for none
    lowest : (3,) of the solid in the world: X and Y of its middle, Z of its lowest place
    """

    lines: Isolines
    layers: np.ndarray
    sheets: np.ndarray
    levels: np.ndarray
    widths: np.ndarray
    below: Below
    down: np.ndarray
    up: np.ndarray
    kinds: np.ndarray
    volume: float
    matrix: np.ndarray
    machine: Machine
    step: float
    spacing: float
    covered: np.ndarray
    covered_share: float
    overhangs: np.ndarray
    met: np.ndarray
    lowest: np.ndarray

    @cached_property
    def places(self) -> np.ndarray:
        """(n, 3) the lines' points in the world."""
        return _place_bead(self.matrix, self.lines.points)

    @cached_property
    def normals(self) -> np.ndarray:
        """(n, 3) of the layers there, in the world: turned and mirrored like them, a matrix of layers has no scale."""
        return self.lines.normals @ self.matrix[:3, :3].T

    @property
    def heights(self) -> np.ndarray:
        """(n,) of the beads at the lines' points."""
        return self.down + self.up

    @cached_property
    def is_printed(self) -> np.ndarray:
        """(n,) bool: where beads have a height."""
        return self.heights > _NO_HEIGHT * self.spacing

    @cached_property
    def tips(self) -> np.ndarray:
        """(n, 3) of the nozzle in the world, at the top of the bead."""
        return self.places + self.up[:, None] * self.normals

    @cached_property
    def printed_volume(self) -> float:
        """Volume of the beads, scene units."""
        sections = self.widths * self.heights
        return float((self.lines.steps * (sections + sections[self.lines.next]) / 2).sum())

    @property
    def collided(self) -> np.ndarray:
        """(n,) bool, whether the tool meets something there."""
        return self.met >= 0

    @cached_property
    def tilts(self) -> np.ndarray:
        """(n,) degrees between the layers' normals and upright, in the world."""
        return tilts(self.normals)

    @cached_property
    def shares(self) -> np.ndarray:
        """(n,) length of the lines at each point, half of each piece at its ends, as a share of all."""
        lengths = point_lengths(self.lines)
        return lengths / max(lengths.sum(), np.finfo(float).tiny)

    @property
    def course(self) -> Course:
        """The :class:`Course` of the program, in the machine's space; without pieces that have no height."""
        machine, heights = self.machine, self.heights
        points = (self.tips - self.lowest) * machine.scale
        runs, of = [], []
        for number, run in enumerate(self.lines.runs):
            printed = self.is_printed[run]
            cuts = np.flatnonzero(np.diff(printed)) + 1
            for piece, is_printed in zip(np.split(run, cuts), printed[np.append(0, cuts)], strict=True):
                if is_printed and len(piece) > 1:
                    runs.append(piece)
                    of.append(number)
        if not runs:
            raise SettingError("no bead has a height: the layers lie on the bed, or have nothing below them")
        return Course(
            points + [*machine.middle, 0],
            tool_axes(self.normals, machine),
            self.places * machine.scale,
            self.widths * machine.scale,
            heights * machine.scale,
            runs,
            self.sheets[of],
            self.step * machine.scale,
            [KINDS[kind] for kind in self.kinds[of]],
            self.levels[of],
        )

    def runs_of(self, chosen: np.ndarray) -> list[np.ndarray]:
        """Lists of consecutive points of a line that are all chosen, (n,) bool."""
        following = self.lines.next
        inner = chosen & chosen[following] & (following == np.arange(len(following)) + 1)
        groups = np.split(np.arange(len(chosen)), np.flatnonzero(~inner) + 1)
        return [group for group in groups if len(group) and chosen[group[0]]]


def print_plan(
    surfaces: LayerSurfaces,
    solid: TetMesh,
    beads: Beads,
    matrix: np.ndarray,
    machine: Machine,
    step: float,
    spacing: float,
) -> PrintPlan:
    """The :class:`PrintPlan` of :class:`Beads` on layers of a solid.

    The (4, 4) matrix leads from the solid's space to the world, without scale. Beads are a step apart, layers a spacing
    on average, in scene units.
    """
    lines, widths, layers, kinds = beads.lines, beads.widths, beads.layers, beads.kinds
    sheets, count, flat = layers, surfaces.count, is_flat(surfaces)

    def look(side: int) -> Below:
        search = flat_below if flat else below
        return search(surfaces, solid, lines.points, side * lines.normals, layers[lines.numbers], spacing)

    found = look(1)
    is_stack = flat or not lie_upon_themselves(layers[lines.numbers], found.layers, count).any()
    ramps = None if is_stack else Sheets.find(surfaces, solid, spacing)
    if ramps is not None:
        numbers = lines.numbers
        lines, sheets, points = split_lines(lines, ramps.at(lines), step)
        widths, kinds, layers, count = (
            widths[points],
            kinds[numbers[points[lines.starts]]],
            ramps.layers[sheets],
            len(ramps.layers),
        )
        found = found.at(points)
    over = look(-1)
    lower = found.layers if ramps is None else ramps.below(lines.points, lines.normals, found)
    carried, carrying = carrying_pairs(sheets[lines.numbers], lower, count)
    order = layer_order(count, carried, carrying)
    back = _BACK @ matrix[:3, :3] if machine.seam == "back" else None
    made, chosen, points = order_lines(lines, sheets, order, back)
    sheets, found, over, lower, widths = (
        sheets[chosen],
        found.at(points),
        over.at(points),
        lower[points],
        widths[points],
    )
    places = _place_bead(matrix, made.points)
    world = _place_bead(matrix, solid.vertices)
    lowest = np.append((world.min(axis=0) + world.max(axis=0))[:2] / 2, world[:, 2].min())
    normals = made.normals @ matrix[:3, :3].T
    feet = places[:, 2] - found.heights * normals[:, 2] - lowest[2]
    rank = np.empty(count + 2, int)
    rank[order], rank[OUTSIDE], rank[NOTHING] = np.arange(count), count, count
    on_bed = (found.layers < 0) & (feet < _ON_BED * spacing)
    ranks = rank[sheets[made.numbers]]
    overhangs = (rank[lower] > ranks) & ~on_bed
    overhangs &= ~_leaning(made, places, ranks, overhangs, _LEAN * spacing)
    scaled = replace(
        machine,
        nozzle_radius=machine.nozzle_radius / machine.scale,
        nozzle_length=machine.nozzle_length / machine.scale,
    )
    lengths, volume = point_lengths(made), float(solid.volumes.sum())
    axes = tool_axes(normals, machine)

    def reaches(lengths: np.ndarray) -> list[np.ndarray]:
        ways = _own_ways(found, over, lengths * widths, volume, spacing)
        return [np.maximum(even_along(made, lengths * way, step), 0) for way in ways]

    down, up = reaches(lengths)
    if not flat:
        for _ in range(_ROUNDS):
            overlaps = find_overlaps(made, places + up[:, None] * normals, axes, widths, down + up, step)
            if not (overlaps & (down + up > 0)).any():
                break
            # The other beads take the volume. They may now reach into one another again.
            down, up = (np.where(overlaps, 0, way) for way in reaches(np.where(overlaps, 0, lengths)))
    met = collisions(places + up[:, None] * normals, axes, scaled, step, _SLACK * spacing)
    return PrintPlan(
        made, layers[chosen], sheets, count_levels(order, carried, carrying)[sheets], widths, found, down, up,
        kinds[chosen], volume, matrix, machine, step, spacing, beads.covered, beads.covered_share, overhangs, met,
        lowest,
    )  # fmt: skip


def _own_ways(below: Below, above: Below, areas: np.ndarray, volume: float, spacing: float) -> list[np.ndarray]:
    """(n,) how far beads reach down, and up: half way to the next layer, or to the end of the solid.

    Where normals run apart, or layers end inside, ways to the end of the solid pass through what other beads fill: they
    are shortened together until the beads have no more than the solid's volume.
    """
    ways, outside = [], []
    for found in (below, above):
        is_end = found.layers == OUTSIDE
        way = np.where(found.layers >= 0, found.heights / 2, spacing / 2)
        ways.append(np.where(is_end, 0, way))
        outside.append(np.where(is_end, np.minimum(found.heights, spacing), 0))
    left, taken = (float(areas @ (down + up)) for down, up in (ways, outside))
    share = min(max(volume - left, 0) / max(taken, np.finfo(float).tiny), 1)
    return [way + share * end for way, end in zip(ways, outside, strict=True)]


def _leaning(lines: Isolines, points: np.ndarray, ranks: np.ndarray, asked: np.ndarray, reach: float) -> np.ndarray:
    """(n,) bool: of the points that are asked for, those with a line of a lower rank within reach."""
    result, here = np.zeros(len(points), bool), np.flatnonzero(asked)
    if not len(here):
        return result
    piece, places = divide_pieces(points, points[lines.next], reach / 4)
    tree = cKDTree(places)
    for part in np.array_split(here, len(here) // _BATCH + 1):
        which, other = pairs_within(tree, points[part], reach)
        point = part[which]
        is_lower = ranks[piece[other]] < ranks[point]
        result[point[is_lower]] = True
    return result


def _place_bead(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3].T + matrix[:3, 3]
