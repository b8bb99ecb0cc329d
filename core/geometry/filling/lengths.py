# SPDX-License-Identifier: GPL-3.0-or-later
"""Size of a solid's tetrahedra, their number, and the spacing of layers that they can carry."""

import math
from collections.abc import Iterator
from typing import NamedTuple, Self

import numpy as np

from ...errors import SettingError, round_up
from .stuffing import MOST_CUBES, estimated_bytes, estimated_tets
from .surface_distance import SurfaceDistance

# Number of tetrahedra of a solid if no size is given.
AUTOMATIC_TETS = 100_000
# Most cubes of its box, which take some seconds.
AUTOMATIC_CUBES = 10_000_000
# More would take hours, and more memory than most machines have.
MOST_TETS = 4_000_000
# Bytes per tetrahedron while layers are solved; measured for 20 000 to 500 000 tetrahedra: 1600 to 2100.
SOLVED_BYTES = 2000
# Edges of the solid per layer: if spacing or size follows from the other, and at least.
EDGES_PER_LAYER = 3.0
FEWEST_EDGES = 2.0
# If no spacing is given: most layers across the object, those that there are by solving for several layers together,
# and the most that are solved for together for that.
LAYERS_ACROSS, WANTED_ACROSS, TOGETHER = 40, 24, 4
# A period of the pattern carries one layer as long as that takes no more tetrahedra, where no size is given.
UNDIVIDED_TETS = 1_200_000


class Measures(NamedTuple):
    """Volume inside a surface, its area, the (2, 3) lowest and highest corner of its box, and the (3,) edges, longest
    first, of the box with the same moments of inertia as the volume."""

    volume: float
    area: float
    bounds: np.ndarray
    extents: np.ndarray

    @classmethod
    def of(cls, vertices: np.ndarray, triangles: np.ndarray) -> Self:
        """Measure a closed surface, (n, 3) vertices and (m, 3) triangles, of consistent orientation; vertices without a
        triangle do not count."""
        corners = vertices[triangles]
        bounds = np.array([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])
        a, b, c = np.moveaxis(corners - bounds.mean(axis=0), 1, 0)
        normals = np.cross(b - a, c - a)
        # Six times the signed volumes of tetrahedra between the triangles and the origin, which add up to the solid.
        signed = np.einsum("tx,tx->t", a, normals)
        volume, sums = signed.sum() / 6, a + b + c
        moments = np.einsum("t,ptx,pty->xy", signed, np.stack([sums, a, b, c]), np.stack([sums, a, b, c])) / 120
        centre = signed @ sums / 24
        spread = (moments - np.outer(centre, centre) / volume) / volume if volume else np.zeros((3, 3))
        return cls(
            abs(float(volume)),
            float(np.linalg.norm(normals, axis=1).sum()) / 2,
            bounds,
            np.sqrt(12 * np.maximum(np.linalg.eigvalsh(spread)[::-1], 0)),
        )


class Estimate(NamedTuple):
    """Estimate of a solid.

    Attributes
    ----------
    size : longest edge of a tetrahedron well inside, scene units
    tets : number of tetrahedra
    bytes : memory while they are made and layers are solved
    """

    size: float
    tets: int
    bytes: int

    @property
    def megabytes(self) -> float:
        return self.bytes / 2**20

    def __str__(self) -> str:
        return f"{self.tets:,} tetrahedra, {self.megabytes:,.0f} MB"


class Lengths(NamedTuple):
    """Distance between layers and longest edge of the tetrahedra, in scene units, and layers in a period of the phase
    that is solved for."""

    spacing: float
    size: float
    divisions: int = 1

    @property
    def period(self) -> float:
        """Distance in which the phase that is solved for turns once."""
        return self.spacing * self.divisions

    @classmethod
    def of(
        cls,
        distance: SurfaceDistance | Measures,
        spacing: float | None,
        size: float | None,
        lowest: float = 1.0,
        divisions: int | None = None,
    ) -> Self:
        """Choose the spacing and the size for a surface that is to be filled, automatically where they are None.

        Raises SettingError for a spacing that is larger than the surface or too fine for the size, and a size that
        makes no solid, or more than a machine can hold.

        Parameters
        ----------
        spacing, size : scene units
        lowest : factor on the spacing where layers are thinnest
        divisions : layers in a period; None for 1, or for as many as the tetrahedra need
        """
        asked = size
        if size is None:
            size = estimate(distance).size
            if spacing is not None:
                finer = spacing * lowest * (divisions or 1) / EDGES_PER_LAYER
                fits = finer >= _smallest_size(distance)  # thin, slanting solids have few tetrahedra in many cubes
                if divisions or (fits and estimate(distance, min(size, finer)).tets <= UNDIVIDED_TETS):
                    size = min(size, finer)
        lengths = cls.carried(distance, spacing, size, lowest, divisions)
        finest = lengths.period * lowest
        if not (np.isfinite(lengths.size) and lengths.size > 0):
            raise SettingError(f"the tetrahedra's size is {lengths.size:g}: give a positive length")
        smallest = _smallest_size(distance)
        if lengths.size < smallest:
            limit = round_up(smallest)
            edges = EDGES_PER_LAYER if asked is None else FEWEST_EDGES
            remedies = [] if asked is None else [f"one from {limit} on"]
            if divisions and spacing and finest < edges * float(limit):
                remedies.append(", or ".join(lengths._wider(distance, float(limit), edges, lowest)))
            raise SettingError(
                f"a size of {lengths.size:g} makes about {estimate(distance, lengths.size)}: give "
                + " and ".join(remedies)
            )
        if finest < FEWEST_EDGES * lengths.size:
            finer = float(f"{finest / EDGES_PER_LAYER:.3g}")
            sizes = [f"a size of {finer:g}"] if finer >= smallest else []
            raise SettingError(
                f"the spacing {finest:g} is finer than tetrahedra of size {lengths.size:g} can carry: give "
                + ", or ".join([*sizes, *lengths._wider(distance, lengths.size, FEWEST_EDGES, lowest)])
            )
        return lengths

    def _wider(self, distance: SurfaceDistance | Measures, size: float, edges: float, lowest: float) -> Iterator[str]:
        """Remedies, in words: divisions or a spacing with which a period is as long as ``edges`` edges of a size."""
        divisions = math.ceil(edges * size / (self.spacing * lowest))
        divisions += self.spacing * divisions * lowest < edges * size
        yield f"{divisions} divisions"
        spacing = round_up(edges * size / (self.divisions * lowest))
        if float(spacing) <= np.linalg.norm(np.ptp(distance.bounds, axis=0)):
            yield f"a spacing from {spacing} on"

    @classmethod
    def carried(
        cls,
        distance: SurfaceDistance | Measures,
        spacing: float | None,
        size: float,
        lowest: float = 1.0,
        divisions: int | None = None,
    ) -> Self:
        """Choose the spacing that tetrahedra of a size carry if it is None; parameters and errors as :meth:`of`.

        A spacing that is too fine for them is not refused.
        """
        extents = np.ptp(distance.bounds, axis=0)
        if spacing is None:
            across, single = float(extents.max()), EDGES_PER_LAYER * size / lowest
            wanted = min(across / WANTED_ACROSS, single)
            spacing = max(across / LAYERS_ACROSS, wanted, single / (divisions or TOGETHER))
        reach = float(np.linalg.norm(extents))
        if spacing > reach:
            raise SettingError(
                f"the spacing {spacing:g} is larger than the object ({reach:g}): no layer would fit, reduce it"
            )
        if divisions is None:
            finest = spacing * lowest
            divisions = 1 if finest >= FEWEST_EDGES * size else math.ceil(EDGES_PER_LAYER * size / finest - 1e-9)
        return cls(float(spacing), float(size), divisions)


def estimate(measures: SurfaceDistance | Measures, size: float | None = None) -> Estimate:
    """Estimate the solid in a surface for a size, or for the automatic one."""
    if size is None:
        size = max(_size_for_tets(measures, AUTOMATIC_TETS), _size_for_cubes(measures, AUTOMATIC_CUBES))
    tets = estimated_tets(measures.volume, size, measures.area)
    return Estimate(size, tets, max(SOLVED_BYTES * tets, estimated_bytes(tets, measures.bounds, size)))


def _size_for_tets(measures: SurfaceDistance | Measures, tets: int) -> float:
    """Find the size at which a solid has about ``tets`` tetrahedra."""
    low, high = 0.0, float(np.ptp(measures.bounds, axis=0).max())
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if estimated_tets(measures.volume, middle, measures.area) > tets else (low, middle)
    return high


def _smallest_size(measures: SurfaceDistance | Measures) -> float:
    """Find the size that makes as many tetrahedra as a machine can hold."""
    return max(_size_for_tets(measures, MOST_TETS), _size_for_cubes(measures, MOST_CUBES))


def _size_for_cubes(measures: SurfaceDistance | Measures, cubes: int) -> float:
    """Find the size that divides the surface's box, which oblique bodies fill little of, into about ``cubes`` cubes."""
    return 1.1 * float(np.prod(np.ptp(measures.bounds, axis=0)) / cubes) ** (1 / 3)
