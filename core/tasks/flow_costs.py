# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory and time solves of flows take."""

# Nodes above which fields are searched for on a coarse stage: half the time, energies larger by some per mille.
COARSE_ROUNDING = 60_000
# Approximate seconds of a solve for each node, on one core: up to so many nodes, and beyond.
_NODE_SECONDS, _LARGE_NODE_SECONDS = 2e-4, 1e-4
# Bytes of a solve for each node with a proved bound, which is tried up to so many nodes, and without; and the most
# nodes, 47 GB.
_PROVED, _PROVED_NODES, _ESTIMATED, MOST_NODES = 22_000, 36_000, 5_000, 10_000_000


def solve_memory(nodes: int) -> int:
    """The peak memory of a solve in bytes, measured on 24^3 to 64^3 nodes."""
    return nodes * (_PROVED if nodes <= _PROVED_NODES else _ESTIMATED)


def solve_seconds(nodes: int) -> float:
    """About how long a solve takes on one core, measured on 24^3 to 64^3 nodes."""
    return nodes * (_LARGE_NODE_SECONDS if nodes > COARSE_ROUNDING else _NODE_SECONDS)
