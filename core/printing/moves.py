# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points of a bead its moves need: the others lie on the straight way between those."""

import numpy as np

# What a move extrudes for its length differs from what its parts ask for by less, as a share.
SECTION = 0.05


def simplify_moves(along: np.ndarray, stations: np.ndarray, sections: np.ndarray, tolerance: float) -> np.ndarray:
    """(m,) the points of a bead, with both ends, between which straight moves stay near it (Ramer, Douglas and Peucker,
    with both ways at the same share of the length).

    Parameters
    ----------
    along : (k,) length of the bead up to each point
    stations : (k, d) the machine's axes there, in which moves are straight, all as lengths
    sections : (k - 1,) of the bead between points
    tolerance : sum of the distances along the axes below which a point can be left out; 0 keeps all
    """
    kept, spans = np.zeros(len(along), bool), [(0, len(along) - 1)]
    kept[[0, -1]] = True
    volumes = np.append(0.0, np.cumsum(sections * np.diff(along)))
    while spans:
        first, last = spans.pop()
        length = along[last] - along[first]
        if last - first < 2:
            continue
        shares = (along[first + 1 : last] - along[first]) / (length or 1.0)
        straight = stations[first] + shares[:, None] * (stations[last] - stations[first])
        away = np.abs(stations[first + 1 : last] - straight).sum(axis=1)
        mean = (volumes[last] - volumes[first]) / (length or 1.0)
        split = first + 1 + int(away.argmax())
        if away.max() < tolerance:
            if np.abs(sections[first:last] - mean).max() <= SECTION * mean:
                continue
            split = (first + last) // 2
        kept[split] = True
        spans += [(first, split), (split, last)]
    return np.flatnonzero(kept)
