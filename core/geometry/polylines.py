# SPDX-License-Identifier: GPL-3.0-or-later
"""Polylines: lengths, places along them, and values there."""

import math
from collections.abc import Sequence

import numpy as np

from ..errors import SettingError
from ..graphs import ragged_arange

# Each place takes one to ten microseconds and some hundred bytes.
MOST_PLACES = 1_000_000


def check_length(name: str, length: float, step: float) -> None:
    """Refuse named curves of a length that would have more than ``MOST_PLACES`` places a step apart, or whose length is
    not finite, by a SettingError."""
    if not math.isfinite(length):
        raise SettingError(f"{name} has points without a finite place: set their coordinates, or delete them")
    if length > MOST_PLACES * step:
        raise SettingError(
            f"{name} has a length of {length:.3g}, and no more than {MOST_PLACES * step:.3g} can be followed along "
            "this mesh: delete the points that are far away from it"
        )


def values_along(points: np.ndarray, values: np.ndarray, ways: Sequence[float]) -> np.ndarray:
    """Interpolate (p, d) values of a polyline, (p, 3), at (w,) distances along it from each point, negative backwards.

    Returns (w, p, d) values; beyond the ends those of the ends. A polyline that ends where it begins is closed.
    """
    along = ways_along(points)
    places, length = along, along[-1]
    if np.linalg.norm(points[-1] - points[0]) < 1e-6 * length:
        along = np.concatenate([along[:-1] - length, along, along[1:] + length])
        values = np.concatenate([values[:-1], values, values[1:]])
    return np.array([np.column_stack([np.interp(places + way, along, column) for column in values.T]) for way in ways])


def close_polyline(points: np.ndarray, is_closed: bool) -> np.ndarray:
    """Append the first of (p, 3) points at the end of a closed polyline."""
    return np.vstack([points, points[:1]]) if is_closed else points


def piece_lengths(points: np.ndarray) -> np.ndarray:
    """Compute (p - 1,) distances between (p, 3) points."""
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def polyline_length(points: np.ndarray) -> float:
    """Compute the length along (p, 3) points."""
    return float(piece_lengths(points).sum())


def ways_along(points: np.ndarray) -> np.ndarray:
    """Compute (p,) lengths from the first point of a polyline, (p, 3), to each."""
    return np.append(0, np.cumsum(piece_lengths(points)))


def places_at(points: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Compute the (k, 3) points at (k,) lengths along a polyline, (p, 3)."""
    along = ways_along(points)
    return np.column_stack([np.interp(ways, along, column) for column in points.T])


def resample_polyline(points: np.ndarray, step: float) -> np.ndarray:
    """Resample a polyline, (p, 3), evenly and at most a step apart."""
    length = polyline_length(points)
    return places_at(points, np.linspace(0, length, max(int(np.ceil(length / step)), 1) + 1))


def divide_pieces(begins: np.ndarray, ends: np.ndarray, size: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places along straight pieces between (n, 3) points, from each begin on, without its end, at most a size apart,
    one or (n,): (k,) the piece of each place, and (k, 3) places."""
    ways = ends - begins
    counts = np.maximum(np.ceil(np.linalg.norm(ways, axis=1) / size).astype(int), 1)
    piece, place = ragged_arange(counts)
    return piece, begins[piece] + (place / counts[piece])[:, None] * ways[piece]
