# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads in the order in which they are printed, and what is wrong with that: where they lie on air, and where the tool
meets what it has printed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..extract.lines.isolines import Isolines
from .gcode import Course
from .heights import NOTHING, OUTSIDE, Below, below
from .machine import Machine
from .order import layer_order, order_lines
from .reach import collisions, tilts, tool_axes

# What is this near to the lowest place, in spacings, lies on the bed.
_ON_BED = 0.5
# A bead leans on an earlier layer that is no farther than this, in spacings: 45 degrees aside of what is below.
_LEAN = 1.5
# The tool meets what is higher above its tip than this, in spacings.
_SLACK = 0.25
# Share of a bead that lies on another layer from which on that has to be there before.
_CARRIED = 0.02


@dataclass(frozen=True)
class PrintPlan:
    """Beads in the order in which they are printed.

    Attributes
    ----------
    lines : Isolines over the triangles of the layers
    layers : (l,) the layer of each line
    widths : (n,) at the lines' points
    below : Below
    matrix : (4, 4) from the solid's space to the world, Z upwards
    machine : Machine
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
    widths: np.ndarray
    below: Below
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
    def places(self):
        """(n, 3) the lines' points in the world."""
        return _place_bead(self.matrix, self.lines.points)

    @cached_property
    def normals(self):
        """(n, 3) of the layers there, in the world: turned and mirrored like them, a matrix of layers has no scale."""
        return self.lines.normals @ self.matrix[:3, :3].T

    @property
    def heights(self):
        """(n,) of the layer at the lines' points: the way down to what is below."""
        return self.below.heights

    @property
    def collided(self):
        """(n,) bool"""
        return self.met >= 0

    @cached_property
    def tilts(self):
        """(n,) degrees between the layers' normals and upright, in the world."""
        return tilts(self.normals)

    @cached_property
    def shares(self):
        """(n,) length of the lines at each point, half of each piece at its ends, as a share of all."""
        steps = self.lines.steps
        lengths = steps / 2
        np.add.at(lengths, self.lines.next, steps / 2)
        return lengths / max(lengths.sum(), np.finfo(float).tiny)

    @property
    def course(self):
        """The :class:`Course` of the program, in the machine's space."""
        machine, lines = self.machine, self.lines
        points = (self.places - self.lowest) * machine.scale
        axes = tool_axes(self.normals, machine)
        # Where nothing was found below, a usual height.
        heights = np.where(self.below.layers == NOTHING, self.spacing, self.heights) * machine.scale
        heights = np.clip(heights, machine.smallest_height, machine.largest_height)
        return Course(
            points + [machine.bed_x, machine.bed_y, 0],
            axes,
            self.widths * machine.scale,
            heights,
            lines.runs,
            self.layers,
            self.step * machine.scale,
        )

    def runs_of(self, chosen):
        """Lists of consecutive points of a line that are all chosen, (n,) bool."""
        following = self.lines.next
        inner = chosen & chosen[following] & (following == np.arange(len(following)) + 1)
        groups = np.split(np.arange(len(chosen)), np.flatnonzero(~inner) + 1)
        return [group for group in groups if len(group) and chosen[group[0]]]


def print_plan(surfaces, solid, beads, matrix, machine, step, spacing):
    """The :class:`PrintPlan` of :class:`Beads`.

    Parameters
    ----------
    surfaces : LayerSurfaces
    solid : TetMesh
    beads : Beads on the layers
    matrix : (4, 4) from the solid's space to the world, without scale
    machine : Machine
    step, spacing : between beads, and mean distance of layers, scene units
    """
    lines = beads.lines
    found = below(surfaces, solid, lines.points, lines.normals, beads.layers[lines.numbers], spacing)
    carried, carrying = _carrying_layers(lines, beads.layers, found, surfaces.count)
    order = layer_order(surfaces.count, carried, carrying)
    made, chosen, points = order_lines(lines, beads.layers, order)
    layers, found = beads.layers[chosen], Below(found.heights[points], found.layers[points])
    places = _place_bead(matrix, made.points)
    world = _place_bead(matrix, solid.vertices)
    lowest = np.append((world.min(axis=0) + world.max(axis=0))[:2] / 2, world[:, 2].min())
    normals = made.normals @ matrix[:3, :3].T
    feet = places[:, 2] - found.heights * normals[:, 2] - lowest[2]
    rank = np.empty(surfaces.count + 2, int)
    rank[order], rank[OUTSIDE], rank[NOTHING] = np.arange(surfaces.count), surfaces.count, surfaces.count
    on_bed = (found.layers < 0) & (feet < _ON_BED * spacing)
    ranks = rank[layers[made.numbers]]
    overhangs = (rank[found.layers] > ranks) & ~on_bed
    overhangs &= ~_leaning(places, ranks, overhangs, _LEAN * spacing)
    scaled = replace(
        machine,
        nozzle_radius=machine.nozzle_radius / machine.scale,
        nozzle_length=machine.nozzle_length / machine.scale,
    )
    met = collisions(places, tool_axes(normals, machine), scaled, step, _SLACK * spacing)
    return PrintPlan(
        made, layers, beads.widths[points], found, matrix, machine, step, spacing,
        beads.covered, beads.covered_share, overhangs, met, lowest,
    )  # fmt: skip


def _leaning(points, ranks, asked, reach):
    """(n,) bool: of the points that are asked for, those with a point of a lower rank within reach; ranks ascend."""
    result = np.zeros(len(points), bool)
    for rank in np.unique(ranks[asked]):
        before, here = np.searchsorted(ranks, rank), np.flatnonzero(asked & (ranks == rank))
        if before:
            result[here] = np.isfinite(cKDTree(points[:before]).query(points[here], distance_upper_bound=reach)[0])
    return result


def _carrying_layers(lines, layers, found, count):
    """Layers that lie on others with more than a small share, and these."""
    of = layers[lines.numbers]
    pairs, numbers = np.unique(np.column_stack([of, found.layers]), axis=0, return_counts=True)
    shares = numbers / np.bincount(of, minlength=count)[pairs[:, 0]]
    kept = (pairs[:, 1] >= 0) & (shares > _CARRIED)
    return pairs[kept].T


def _place_bead(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]
