# SPDX-License-Identifier: GPL-3.0-or-later
"""Evenness of a pattern: the distance of its lines in each triangle, and the angles at which they cross.

On a triangle without a defect the phases are linear. Lines of a phase with the gradient g are 2 pi / |g| apart, while
the target is 2 pi / r for rates r at the corners.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..interpolate import EdgePhases
from ..matchings import after_turns
from .guidance.face_directions import face_gradients

# Quantiles in the report, as shares of the area.
SHARES = 0.01, 0.05, 0.5, 0.95, 0.99
# Lines are off where their distance is this many times the target, or the target this many times their distance.
OFF = 1.25
# The largest ratio of distance to target, for lines of a phase that hardly grows.
WIDEST = 1e3


@dataclass(frozen=True)
class Evenness:
    """Distances of the lines of k phases on the triangles of a mesh, and the angles at which they cross.

    Attributes
    ----------
    areas : (f,) of the triangles
    spacings : (f, k) distance of the lines over the target; nan in triangles with a defect, or without area
    angles : (f,) radians between the gradients of two phases, nan likewise; None for one phase
    """

    areas: np.ndarray
    spacings: np.ndarray
    angles: np.ndarray | None

    @cached_property
    def errors(self) -> np.ndarray:
        """(f,) spacing over the target less 1, of the phase that is further off; 0 where that is not known."""
        logarithms = np.nan_to_num(np.log(self.spacings))
        furthest = np.abs(logarithms).argmax(axis=1)
        return np.expm1(np.take_along_axis(logarithms, furthest[:, None], axis=1)[:, 0])

    @cached_property
    def figures(self) -> dict[str, Any] | None:
        """For the report: quantiles of the spacing over the target at :data:`SHARES` of the area, the share of the area
        that is off, and for two phases quantiles of the corners of quads, in degrees; None where all triangles have
        defects."""
        counted = np.isfinite(self.spacings[:, 0])
        if not counted.any():
            return None
        areas, spacings = self.areas[counted], self.spacings[counted]
        off = (spacings > OFF) | (spacings < 1 / OFF)
        figures: dict[str, Any] = {
            "spacing": quantiles(spacings.T.ravel(), np.tile(areas, spacings.shape[1]), SHARES).tolist(),
            "off_share": float(np.average(off.mean(axis=1), weights=areas)),
        }
        if self.angles is not None:
            angles = np.degrees(self.angles[counted])
            # A quad has each corner's angle twice, and twice its supplement.
            corners = quantiles(np.concatenate([angles, 180 - angles]), np.tile(areas, 2), SHARES)
            figures["angles"] = corners.tolist()
        return figures


def evenness(edge_phases: EdgePhases, rates: np.ndarray) -> Evenness:
    """The evenness of k phases, for (n, k) target rates at the vertices, phase per unit length."""
    mesh = edge_phases.mesh
    values, turns = edge_phases.around(mesh.triangles)
    closed = (turns == 0) & (np.abs(values[:, 3] - values[:, 0]) < np.pi).all(axis=1) & (mesh.areas > 0)
    slopes = np.stack(
        [face_gradients(mesh.plane_half_edges, values[:, :3, phase]) for phase in range(values.shape[2])], axis=1
    )
    slopes /= np.where(closed, mesh.areas, np.inf)[:, None]
    asked = _mean_rates(edge_phases, rates)
    spacings = np.where(closed[:, None], asked / np.maximum(np.abs(slopes), asked / WIDEST), np.nan)
    angles = None
    if edge_phases.phase_count == 2:
        angles = np.where(closed, np.abs(np.angle(slopes[:, 1] * slopes[:, 0].conj())), np.nan)
    return Evenness(mesh.areas, spacings, angles)


def _mean_rates(edge_phases: EdgePhases, rates: np.ndarray) -> np.ndarray:
    """(f, k) mean of the corners' rates, for the phases of each triangle's first corner."""
    corners = edge_phases.mesh.triangles
    if edge_phases.phase_count == 1:
        return rates[corners].sum(axis=1) / 3
    turns = np.zeros(len(corners), int)
    total = rates[corners[:, 0]]
    for step in range(2):
        edges = edge_phases.mesh.triangle_edges[:, step]
        turns = turns + edge_phases.between(corners[:, step], corners[:, step + 1], edges)[1]
        total = total + np.abs(after_turns(rates[corners[:, step + 1]], -turns))
    return total / 3


def quantiles(values: np.ndarray, weights: np.ndarray, shares: ArrayLike) -> np.ndarray:
    """The smallest values up to which the values have given shares of the weight."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return values[order[np.searchsorted(reached, np.multiply(shares, reached[-1]))]]
