# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortex filaments of a Clebsch map on a grid: where its phase has no value (paper, Section 3.6.1, Eq. 9)."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from ...fields.clebsch import ClebschMap
from ...geometry.face_crossing_curves import FaceCrossingCurve, join_curves
from ...geometry.polylines import polyline_length
from ...geometry.smoothing import smooth_line
from ...geometry.surface import Surface
from ...interpolate import TURN
from .vortex_fit import fitted_places

# Smoothing goes there and back by these shares (Taubin's own), so short that the smallest rings, of six points, last.
_STEPS = 0.33, -0.34


@dataclass(frozen=True)
class Filament:
    """One vortex filament.

    Attributes
    ----------
    points : (p, 3), in one piece also where they leave a periodic box; a closed one continues from the last to the
        first, moved by ``shift``
    strength : circulation around it, counterclockwise seen from its head
    winding : how often it goes around the box along each axis until it closes; zeros for a loop
    shift : (3,) the box times the winding
    cuts : first point of each part that lies in the box, 0 the first one
    moves : (k, 3) translations of the parts into the box
    share : of the flow's vorticity that it carries
    """

    points: np.ndarray
    strength: float
    is_closed: bool
    winding: tuple[int, int, int] = (0, 0, 0)
    shift: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))
    cuts: tuple[int, ...] = (0,)
    moves: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((1, 3)))
    share: float = 0.0

    @property
    def is_loop(self) -> bool:
        """Whether it closes without going around the box."""
        return self.is_closed and not any(self.winding)

    @property
    def length(self) -> float:
        """Its length, that of a closed one once around."""
        return polyline_length(self.whole)

    @property
    def whole(self) -> np.ndarray:
        """(k, 3) points in one piece; a closed one ends where it closes."""
        return np.vstack([self.points, self.points[:1] + self.shift]) if self.is_closed else self.points

    @property
    def course(self) -> np.ndarray:
        """(k, 3) points in one piece; one that goes around the box ends where it closes."""
        return self.whole if any(self.winding) else self.points

    @property
    def parts(self) -> list[np.ndarray]:
        """(k, 3) points of each part in the box, with the first point of the next part; a loop that stays in the box is
        one part, which does not repeat its first point."""
        if len(self.cuts) == 1 and not any(self.winding):
            return [self.points + self.moves[0]]
        whole = self.whole
        ends = [*(cut + 1 for cut in self.cuts[1:]), len(whole)]
        return [whole[cut:end] + move for cut, end, move in zip(self.cuts, ends, self.moves, strict=True)]


def filaments(found: ClebschMap, smoothing: int = 0) -> list[Filament]:
    """Filaments of a map in space, through the points where they pass the grid's faces.

    A filament that leaves through a periodic side continues from the other one. Smoothing is how often each point moves
    towards the middle of its neighbours and back, which keeps the filaments' size.
    """
    grid, numbers = found.regular_grid, found.face_numbers
    places = np.empty((len(numbers), 3))
    passed = np.flatnonzero(numbers)
    places[passed] = puncture_places(found, passed)
    curves = join_curves(numbers, grid.cell_faces, grid.outward)
    return [_filament(found, curve, places, smoothing) for curve in curves if len(curve.cells)]


def vortices(found: ClebschMap) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vortices of a map in two dimensions.

    Returns
    -------
    faces : (v,) that they lie in
    places : (v, 2), on a surface (v, 3)
    strengths : (v,) circulation, counterclockwise seen from a face's front
    """
    faces = np.flatnonzero(found.face_numbers)
    return faces, puncture_places(found, faces), found.quantum * found.face_numbers[faces]


def _filament(found: ClebschMap, curve: FaceCrossingCurve, places: np.ndarray, smoothing: int) -> Filament:
    """The :class:`Filament` of a curve, whose steps from face to face each lie in a cell; points on a periodic side are
    taken beside that cell."""
    grid, faces, count = found.regular_grid, curve.faces, len(curve.cells)
    middles = grid.places[grid.faces[grid.cell_faces[curve.cells, 0], 0]] + grid.spacing / 2
    box = grid.spacing * grid.shape
    starts, ends = places[faces[:count]], places[np.roll(faces, -1)[:count]]
    starts, ends = (p + box * np.rint((middles - p) / box * grid.periodic) for p in (starts, ends))
    # Boxes between the end of each step and the start of the next.
    leaps = np.rint((ends - np.roll(starts, -1, axis=0)) / box)
    if curve.is_closed and leaps.any():
        first = np.flatnonzero(leaps.any(axis=1))[0] + 1
        starts, ends, leaps = (np.roll(values, -first, axis=0) for values in (starts, ends, leaps))
    passed = np.vstack([np.zeros(3), np.cumsum(leaps[:-1], axis=0)])
    points, winding = starts + box * passed, np.zeros(3, int)
    if curve.is_closed:
        winding = leaps.sum(axis=0).astype(int)
    else:
        points = np.vstack([points, ends[-1:] + box * passed[-1:]])
    # Smoothing leaves the even part of the way around the box as it is.
    ramp = np.linspace(0, 1, len(points), endpoint=False)[:, None] * (box * winding)
    points = ramp + smooth_line(points - ramp, curve.is_closed, smoothing, _STEPS)
    cuts = (0, *(np.flatnonzero(leaps[:-1].any(axis=1)) + 1).tolist())
    return Filament(
        points,
        curve.index * found.quantum,
        curve.is_closed,
        tuple(winding.tolist()),
        box * winding,
        cuts,
        -box * passed[list(cuts)],
        float(curve.index * np.sign(found.face_numbers[faces]) @ found.face_shares[faces]),
    )


def puncture_places(found: ClebschMap, faces: np.ndarray) -> np.ndarray:
    """(k, d), on a surface (k, 3), where filaments pass (k,) faces.

    Where the flow around a face is that of one vortex, its best fit (:func:`fitted_places`); elsewhere the zero between
    the values at the four corners, after the mean of opposite edges, the flow past the filament, has been subtracted;
    the middle of the face if there is no zero.
    """
    if isinstance(found.grid, Surface):
        return _triangle_places(found, faces)
    grid = found.grid
    asked = TURN / found.quantum * found.integrals[grid.face_edges[faces]]
    across, upwards = 0.5 * (asked[:, 0] + asked[:, 2]), 0.5 * (asked[:, 1] + asked[:, 3])
    mean = np.column_stack([np.zeros(len(asked)), across, across + upwards, upwards])
    values = found.phases[grid.faces[faces]] * np.exp(-1j * mean)
    zeros = bilinear_zero(values).T
    signs = np.sign(found.face_numbers[faces])
    fitted = fitted_places(grid, TURN / found.quantum * found.integrals, faces, signs)
    s, t = np.where(np.isnan(fitted), zeros, fitted).T
    corner = grid.places[grid.faces[faces, 0]]
    places = corner.copy()
    rows = np.arange(len(corner))
    for share, axis in zip((s, t), grid.face_planes[faces].T, strict=True):
        places[rows, axis] += share * grid.spacing[axis]
    return places


def _triangle_places(found: ClebschMap, faces: np.ndarray) -> np.ndarray:
    """Places of filaments in triangles, after subtracting the circulation asked for from the edges in equal parts."""
    grid = found.grid
    asked = TURN / found.quantum * grid.face_signs[faces] * found.integrals[grid.face_edges[faces]]
    asked = asked - asked.mean(axis=1, keepdims=True)
    passed = np.column_stack([np.zeros(len(asked)), asked[:, 0], asked[:, 0] + asked[:, 1]])
    corners = grid.faces[faces]
    shares = linear_zero(found.phases[corners] * np.exp(-1j * passed))
    return np.einsum("fk,fkx->fx", shares, grid.places[corners])


def linear_zero(values: np.ndarray) -> np.ndarray:
    """(k, 3) barycentric coordinates of the zeros of linear functions with (k, 3) complex corner values; thirds where a
    triangle contains none."""
    following = np.roll(values, -1, axis=1)
    shares = np.roll((values.conj() * following).imag, -1, axis=1)
    total = shares.sum(axis=1, keepdims=True)
    shares = np.divide(shares, total, out=np.full_like(shares, -1), where=total != 0)
    return np.where((shares >= 0).all(axis=1, keepdims=True), shares, 1 / 3)


def bilinear_zero(values: np.ndarray) -> np.ndarray:
    """(2, k) coordinates in 0..1 where bilinear functions of (k, 4) complex corner values, counterclockwise, are
    zero; the middle where they have no zero."""
    a, b = values[:, 0], values[:, 1] - values[:, 0]
    c, d = values[:, 3] - values[:, 0], values[:, 0] - values[:, 1] + values[:, 2] - values[:, 3]
    # a + b s + c t + d s t = 0 with s real: the imaginary part of (a + c t) conj(b + d t) vanishes.
    quadratic = (c * d.conj()).imag, (a * d.conj() + c * b.conj()).imag, (a * b.conj()).imag
    best = np.full((2, len(values)), 0.5)
    for t in _roots(*quadratic):
        t = np.where(np.isfinite(t), t, -1.0)
        denominator = b + d * t
        s = -((a + c * t) * denominator.conj()).real / np.maximum(np.abs(denominator) ** 2, np.finfo(float).tiny)
        inside = (t >= 0) & (t <= 1) & (s >= 0) & (s <= 1)
        best[:, inside] = s[inside], t[inside]
    return best


def _roots(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two real roots of a x^2 + b x + c, NaN where there are none."""
    with np.errstate(all="ignore"):
        half = -0.5 * (b + np.where(b < 0, -1, 1) * np.sqrt(b * b - 4 * a * c))
        return half / a, c / half
