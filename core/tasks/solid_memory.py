# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimate of the memory that layers take, before the solid is made: from the measures of its surface.

Peaks were measured in processes of their own, for balls, cubes, bars, plates and two meshes of 15,000 to 220,000
tetrahedra, on one core and on two (bench/README.md). A proof takes as much as the dense blocks of its factorization,
which grow with the square of the front: about a section across the longest extent.
"""

from typing import NamedTuple

from ..algebra.workers import WORKERS
from ..extract.layers.crossings import BYTES_PER_CROSSING
from ..geometry.filling.lengths import SOLVED_BYTES, Lengths, Measures
from ..geometry.filling.stuffing import estimated_bytes, estimated_tets
from ..solve.methods.certificate import LONGEST_ELIMINATION

# Bytes for each tetrahedron where the phase is integrated; where it is searched for, and while a bound is proved, both
# on one core and on several (True), which do both at a time.
_INTEGRATED = 1250
_SEARCHED, _PROVING = {False: 2100, True: 2600}, {False: 1800, True: 2800}
# Crossings of levels with edges in each cube of the lattice, for each of its sizes in the spacing.
_CROSSINGS = 6.3
# Vertices per cube of the lattice, further vertices per square of the surface; entries per row of the matrix.
_INSIDE, _AT_SURFACE, _ROW_ENTRIES = 2.0, 1.3, 13.4
# Nodes of a front for each square of a section, and for each side of a square around the section.
_FRONT = 1.8
# Bytes of dense blocks for each square of a front, and of a matrix for each row; products for each cube of a front.
_BLOCKS, _ROW, _PRODUCTS = 110, 1080, 6


class LayerMemory(NamedTuple):
    """Peak memory of a solve of layers, in bytes.

    Attributes
    ----------
    needed : without a proved bound, which is left out where memory lacks, and without the layers' triangles, which are
        counted before they are made (:func:`..extract.layers.crossings.refuse_too_many_layers`)
    expected : with both
    """

    needed: int
    expected: int


def is_searched(is_axis: bool, is_even: bool, areas: int) -> bool:
    """Whether the phase of layers is searched for, and not integrated.

    Directions of an axis have no curl if the spacing is even, and layers that are flush with one area add none.
    """
    return not (is_axis and is_even and areas <= 1)


def layer_memory(measures: Measures, lengths: Lengths, searched: bool = True, tets: int | None = None) -> LayerMemory:
    """Estimate the :class:`LayerMemory` of layers in the solid of a surface.

    Parameters
    ----------
    searched : see :func:`is_searched`
    tets : of a given solid; None for one that is made
    """
    size = lengths.size
    filling = 0
    if tets is None:
        tets = estimated_tets(measures.volume, size, measures.area)
        filling = estimated_bytes(tets, measures.bounds, size)
    else:
        size = (12 * measures.volume / tets) ** (1 / 3)
    layers = BYTES_PER_CROSSING * _CROSSINGS * measures.volume / (lengths.spacing * size**2)
    if not searched:
        return LayerMemory(max(filling, _INTEGRATED * tets), max(filling, round(_INTEGRATED * tets + layers)))
    searching, proved = (kind[WORKERS > 1] * tets for kind in (_SEARCHED, _PROVING))
    proved += round(_proof_bytes(measures, size))
    return LayerMemory(max(filling, SOLVED_BYTES * tets), max(filling, round(searching + layers), proved))


def _proof_bytes(measures: Measures, size: float) -> float:
    """Bytes of a proof; 0 where none is tried, and for surfaces that enclose no body: moments of inertia of
    open surfaces and of surfaces inside out can be negative, and extents are then 0."""
    longest, _, shortest = measures.extents
    if not shortest > 0:
        return 0.0
    rows = _INSIDE * measures.volume / size**3 + _AT_SURFACE * measures.area / size**2
    section, rim = measures.volume / longest / size**2, measures.area / longest / size
    front = _FRONT * (section + rim)
    is_tried = _PRODUCTS * front**3 <= LONGEST_ELIMINATION * _ROW_ENTRIES * rows
    return _BLOCKS * front**2 + _ROW * rows if is_tried else 0.0
