# SPDX-License-Identifier: GPL-3.0-or-later
"""How long moves take: the feed, the flow, the axes' speeds and the table's acceleration limit them."""

import numpy as np

from ..unit_vectors import unit_vectors
from .machine import Machine

# Rounds in which turns that begin or end too suddenly are slowed down.
_ROUNDS = 60
# Turns of the way by more than this, in degrees, are taken from a stop, where the time is estimated.
_CORNER = 30.0


def move_seconds(
    ways: np.ndarray,
    volumes: np.ndarray,
    places: np.ndarray,
    angles: np.ndarray,
    first: np.ndarray,
    is_low: np.ndarray,
    machine: Machine,
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) seconds of each move, and which are slower than the feed."""
    feed = np.full(len(ways), machine.feed)
    if machine.first_feed:
        feed[is_low] = machine.first_feed
    wanted = 60 * ways / feed
    seconds = wanted.copy()
    if machine.largest_flow:
        seconds = np.maximum(seconds, volumes / machine.largest_flow)
    if machine.turns:
        linear = np.abs(np.diff(places, axis=0, prepend=places[:1])).max(axis=1)
        turns = np.where(first[:, None], 0, np.diff(angles, axis=0, prepend=angles[:1]))
        seconds = np.maximum(seconds, np.abs(turns).max(axis=1) / machine.turn_speed)
        seconds = np.maximum(seconds, np.where(first, 0, 60 * linear / machine.travel_feed))
        for _ in range(_ROUNDS):
            over = turn_accelerations(turns, seconds, first) / machine.turn_acceleration
            if over.max(initial=0) <= 1:
                break
            slower = np.sqrt(np.maximum(1.01 * over, 1))
            factor = np.maximum(np.append(slower, 1), np.append(1, slower))
            seconds *= factor
    return seconds, seconds > 1.001 * wanted


def turn_accelerations(turns: np.ndarray, seconds: np.ndarray, first: np.ndarray) -> np.ndarray:
    """(m - 1,) degrees a second squared of the table from each move to the next one of a bead."""
    moves = ~first & (seconds > 0)
    speeds = turns / np.where(moves, seconds, 1)[:, None]
    both = moves[1:] & moves[:-1]
    middle = np.where(both, (seconds[1:] + seconds[:-1]) / 2, 1)
    return np.where(both, np.abs(np.diff(speeds, axis=0)).max(axis=1, initial=0) / middle, 0)


def feed_words(
    ways: np.ndarray, places: np.ndarray, angles: np.ndarray, seconds: np.ndarray, machine: Machine
) -> np.ndarray:
    """(m,) F words: of the tip's way, of the linear axes' where the dialect counts these, or moves a minute."""
    minutes = np.where(seconds > 0, seconds, 1) / 60
    if not machine.turns or machine.moves == "tcp":
        return ways / minutes
    if machine.moves == "inverse":
        return 1 / minutes
    linear = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=1)
    turned = np.linalg.norm(np.diff(angles, axis=0, prepend=angles[:1]), axis=1)
    # In the digits of the program, a controller counts the turn where no linear axis moves.
    return np.where(linear > 1e-4, linear, turned) / minutes


def overhead_seconds(
    places: np.ndarray, ways: np.ndarray, seconds: np.ndarray, first: np.ndarray, machine: Machine
) -> np.ndarray:
    """(m,) seconds before each move: of the travel to its bead, or to speed up and slow down in a corner."""
    speeds = np.where(first, 0, ways / np.where(seconds > 0, seconds, 1))
    steps = np.diff(places, axis=0, prepend=places[:1])
    lengths = np.linalg.norm(steps, axis=1)
    fastest = machine.travel_feed / 60
    travels = lengths / fastest + fastest / machine.acceleration
    directions = unit_vectors(steps)
    bent = np.einsum("kx,kx->k", directions[1:], directions[:-1]) < np.cos(np.radians(_CORNER))
    stops = np.where(np.append(False, bent), speeds / machine.acceleration, 0)
    return np.where(first, travels, stops)
