# SPDX-License-Identifier: GPL-3.0-or-later
"""How fine a solid is made, how large it becomes, and the distance between layers that it carries."""

import math
from typing import NamedTuple

import numpy as np

from ...errors import SettingError
from .stuffing import MOST_CUBES, estimated_bytes, estimated_tets

# A solid has about so many tetrahedra where no size is given.
AUTOMATIC_TETS = 100_000
# And its box no more cubes than this, which take some seconds.
AUTOMATIC_CUBES = 10_000_000
# More than that take hours, and more memory than most machines have.
MOST_TETS = 4_000_000
# Measured while layers are solved, for 20 000 to 500 000 tetrahedra: 1600 to 2100.
SOLVED_BYTES = 2000
# Edges of the solid to a layer: where one of spacing and size follows from the other, and at least.
EDGES_PER_LAYER = 3.0
FEWEST_EDGES = 2.0
# Layers across the object, at most, where no spacing is given.
LAYERS_ACROSS = 40
# A period of the pattern carries one layer as long as that takes no more tetrahedra, where no size is given.
UNDIVIDED_TETS = 1_200_000


class Measures(NamedTuple):
    """What a surface encloses.

    Attributes
    ----------
    volume, area : of the space inside, and of the surface
    bounds : (2, 3) lowest and highest corner of its box
    """

    volume: float
    area: float
    bounds: np.ndarray

    @classmethod
    def of(cls, vertices, triangles):
        """From (n, 3) and (m, 3); whichever way a closed surface's faces look, if all look the same way."""
        vertices = vertices - vertices.mean(axis=0)
        a, b, c = np.moveaxis(vertices[triangles], 1, 0)
        normals = np.cross(b - a, c - a)
        return cls(
            abs(float(np.einsum("tx,tx->", a, normals))) / 6,
            float(np.linalg.norm(normals, axis=1).sum()) / 2,
            np.array([vertices.min(axis=0), vertices.max(axis=0)]),
        )


class Estimate(NamedTuple):
    """What a solid will be.

    Attributes
    ----------
    size : longest edge of a tetrahedron well inside, scene units
    tets : number of tetrahedra
    bytes : memory while they are made and layers solved in them
    """

    size: float
    tets: int
    bytes: int

    @property
    def megabytes(self):
        return self.bytes / 2**20

    def __str__(self):
        return f"{self.tets:,} tetrahedra, {self.megabytes:,.0f} MB"


class Lengths(NamedTuple):
    """Distance between layers and longest edge of the tetrahedra, in scene units, and layers in a period of the phase
    that is solved for."""

    spacing: float
    size: float
    divisions: int = 1

    @property
    def period(self):
        """Distance in which the phase that is solved for turns once."""
        return self.spacing * self.divisions

    @classmethod
    def of(cls, distance, spacing, size, lowest=1.0, divisions=None):
        """For a surface that is to be filled, automatic ones where they are None.

        Parameters
        ----------
        distance : SurfaceDistance
        spacing, size : scene units, or None
        lowest : factor on the spacing where layers are thinnest
        divisions : layers in a period; None for 1, or for as many as the tetrahedra need

        Raises
        ------
        SettingError
            for a spacing that does not fit into the surface, or is too fine for the size, and a size that makes
            nothing, or more than a machine can hold
        """
        if size is None:
            size = estimate(distance).size
            if spacing is not None:
                finer = spacing * lowest * (divisions or 1) / EDGES_PER_LAYER
                if divisions or estimate(distance, min(size, finer)).tets <= UNDIVIDED_TETS:
                    size = min(size, finer)
        lengths = cls.carried(distance, spacing, size, lowest, divisions)
        finest = lengths.period * lowest
        if finest < FEWEST_EDGES * lengths.size:
            raise SettingError(
                f"the spacing {finest:g} is finer than tetrahedra of size {lengths.size:g} can carry: give a size of "
                f"{finest / EDGES_PER_LAYER:.3g}, more divisions, or a spacing from "
                f"{FEWEST_EDGES * lengths.size / lowest:.3g} on"
            )
        _refuse_size(distance, lengths.size)
        return lengths

    @classmethod
    def carried(cls, distance, spacing, size, lowest=1.0, divisions=None):
        """With what tetrahedra of a size carry, where it is not given; parameters and errors as :meth:`of`.

        A spacing that is too fine for them is not refused.
        """
        extents = np.ptp(distance.bounds, axis=0)
        if spacing is None:
            spacing = max(float(extents.max()) / LAYERS_ACROSS, EDGES_PER_LAYER * size / lowest)
        reach = float(np.linalg.norm(extents))
        if spacing > reach:
            raise SettingError(
                f"the spacing {spacing:g} is larger than the object ({reach:g}): no layer would fit, reduce it"
            )
        if divisions is None:
            finest = spacing * lowest
            divisions = 1 if finest >= FEWEST_EDGES * size else math.ceil(EDGES_PER_LAYER * size / finest - 1e-9)
        return cls(float(spacing), float(size), divisions)


def estimate(measures, size=None):
    """The :class:`Estimate` of the solid in a surface, for a size or the automatic one.

    Parameters
    ----------
    measures : SurfaceDistance or :class:`Measures`
    size : scene units
    """
    size = max(_size_of(measures, AUTOMATIC_TETS), _coarse_size(measures, AUTOMATIC_CUBES)) if size is None else size
    tets = estimated_tets(measures.volume, size, measures.area)
    return Estimate(size, tets, max(SOLVED_BYTES * tets, estimated_bytes(tets, measures.bounds, size)))


def _size_of(measures, tets):
    """The size at which a solid has about so many tetrahedra."""
    low, high = 0.0, float(np.ptp(measures.bounds, axis=0).max())
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if estimated_tets(measures.volume, middle, measures.area) > tets else (low, middle)
    return high


def _refuse_size(distance, size):
    """Refuse a size that makes nothing, or more than a machine can hold."""
    if not (np.isfinite(size) and size > 0):
        raise SettingError(f"the tetrahedra's size is {size:g}: give a positive length")
    smallest = _smallest_size(distance)
    if size < smallest:
        expected = estimate(distance, size)
        raise SettingError(f"a size of {size:g} makes about {expected}: give one from {smallest:.3g} on")


def _smallest_size(distance):
    """The size that makes as many tetrahedra or cubes as there may be."""
    return max(_size_of(distance, MOST_TETS), _coarse_size(distance, MOST_CUBES))


def _coarse_size(measures, cubes):
    """The size that makes about so many cubes in the surface's box, of which long slanting bodies fill little."""
    return 1.1 * float(np.prod(np.ptp(measures.bounds, axis=0)) / cubes) ** (1 / 3)
