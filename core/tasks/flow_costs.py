# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory and time solves of flows take."""

from ..settings.flow import FlowSettings

# Nodes above which fields are searched for on a coarse stage: half the time, energies larger by some per mille.
COARSE_ROUNDING = 60_000
# Approximate seconds of a solve for each node, on one core: up to COARSE_ROUNDING nodes, beyond, and on a surface.
_NODE_SECONDS, _LARGE_NODE_SECONDS, _VERTEX_SECONDS = 2e-4, 1e-4, 1.1e-4
# Factors for a circulation that is searched for, for methods but the default one, and for each frame after the first.
_SOUGHT, _QUICK, _NEXT = 3.5, 0.4, 0.8
# For curves, whose circulation gives a first guess: seconds for each node up to COARSE_ROUNDING, and the factor for
# the search.
_CURVE_SECONDS, _TRIED = 2.8e-4, 1.2
# Bytes of a solve for each node with a proved bound; the nodes up to which that is tried; bytes without one; and the
# largest number of nodes, which take 47 GB.
_PROVED, _PROVED_NODES, _ESTIMATED, MOST_NODES = 22_000, 36_000, 5_000, 10_000_000


def solve_memory(nodes: int) -> int:
    """The peak memory of a solve in bytes, measured on 24^3 to 64^3 nodes."""
    return nodes * (_PROVED if nodes <= _PROVED_NODES else _ESTIMATED)


def solve_seconds(
    nodes: int,
    settings: FlowSettings,
    frames: int | None = None,
    is_surface: bool = False,
    is_of_curves: bool = False,
) -> float:
    """About how long a solve takes on one core, measured on 18^3 to 64^3 nodes, and on 900 to 40,000 vertices of a
    surface. All ``frames`` of a sequence are solved for the same circulation."""
    small, sought = (_CURVE_SECONDS, _TRIED) if is_of_curves else (_NODE_SECONDS, _SOUGHT)
    seconds = nodes * (_LARGE_NODE_SECONDS if nodes > COARSE_ROUNDING else small)
    if is_surface:
        seconds = nodes * _VERTEX_SECONDS
    if settings.method != "sdp":
        seconds *= _QUICK
    if settings.quantum is None and frames is None:
        seconds *= sought
    return seconds * (1 + _NEXT * ((frames or 1) - 1))
