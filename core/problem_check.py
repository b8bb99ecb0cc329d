# SPDX-License-Identifier: GPL-3.0-or-later
"""Validation of a synchronization problem: one line names the first element that is wrong, and the remedy."""

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np

from .connection import Connection, Fibre, Merged, Targets, are_flips
from .errors import SettingError

# Tolerance for orthogonal transports and unit values: the error of single precision.
UNIT = 1e-4


def check_problem(
    connection: Connection,
    mass: np.ndarray | None,
    merged: Merged | None,
    fixed: Targets | None,
    drawn: Targets | None,
    fibre: str,
) -> Fibre:
    """Raise a SettingError for the first wrong part of a problem; doubled constraints are checked elsewhere.

    Returns the :class:`Fibre`, which may be given as a text.
    """
    if fibre not in [*Fibre]:
        raise SettingError(f"the fibre {fibre!r} is unknown: use one of {', '.join(Fibre)}")
    fibre = Fibre(fibre)
    count = connection.node_count
    if not isinstance(count, int | np.integer) or count < 1:
        raise SettingError(f"the connection has {count!r} nodes: give a whole number of at least 1")
    edges = connection.edges
    if edges.ndim != 2 or edges.shape[1] != 2:
        raise SettingError(f"edges have the shape {edges.shape}: give two nodes for each")
    _check_nodes("edge", edges, count)
    _check_numbers("weight", "edge", connection.weights, len(edges))
    _check_transports("edge", connection.transports, len(edges), fibre)
    if mass is not None:
        _check_numbers("mass", "node", mass, count)
    if merged is not None:
        _check_nodes("merged node", merged.nodes, count)
        _check_nodes("root of merged nodes", merged.roots, count)
        _check_length("roots", "merged node", merged.roots, len(merged.nodes))
        _check_transports("merged node", merged.transports, len(merged.nodes), fibre)
    for name, targets in (("fixed node", fixed), ("drawn node", drawn)):
        if targets is not None:
            _check_nodes(name, targets.nodes, count)
            _check_values(name, targets.values, len(targets.nodes), connection, fibre)
    if fixed is not None and fixed.weights is not None:
        raise SettingError("fixed nodes have weights: leave them out, or draw the nodes instead")
    if drawn is not None:
        if drawn.weights is None:
            raise SettingError("drawn nodes have no weights: give one for each, or fix the nodes instead")
        _check_numbers("weight", "drawn node", drawn.weights, len(drawn.nodes))
    return fibre


def _refuse_first(wrong: np.ndarray, line: Callable[[int], str]) -> None:
    """Raise a SettingError with line(number) for the first element that is wrong."""
    if wrong.any():
        raise SettingError(line(int(np.flatnonzero(wrong)[0])))


def _check_nodes(name: str, nodes: np.ndarray, count: int) -> None:
    if nodes.size and not np.issubdtype(nodes.dtype, np.integer):
        raise SettingError(f"{name}s are given as {nodes.dtype}: give whole numbers")
    wrong = ((nodes < 0) | (nodes >= count)).any(axis=tuple(range(1, nodes.ndim)))
    _refuse_first(wrong, lambda k: f"{name} {k} is {nodes[k].tolist()} of {count} nodes: count them from 0")


def _check_length(name: str, element: str, values: np.ndarray, count: int) -> None:
    if len(values) != count:
        raise SettingError(f"there are {len(values)} {name} for {count} {element}s: give one for each")


def _check_numbers(name: str, element: str, values: np.ndarray, count: int) -> None:
    """Numbers that are not negative."""
    values = np.asarray(values)
    if values.shape != (count,):
        raise SettingError(f"{name} of {element}s has the shape {values.shape}: give {count} numbers")
    wrong = ~(np.isfinite(values) & (values >= 0))
    _refuse_first(wrong, lambda k: f"the {name} of {element} {k} is {values[k]}: give a finite number, not below 0")


def _check_transports(element: str, transports: np.ndarray, count: int, fibre: Fibre) -> None:
    _check_length("transports", element, transports, count)
    if transports.ndim == 1:
        wrong = ~(np.abs(np.abs(transports) - 1) < UNIT)
    elif transports.ndim == 3 and transports.shape[1] == transports.shape[2]:
        wrong = _far_from_orthogonal(transports)
    else:
        raise SettingError(f"transports of {element}s have the shape {transports.shape}: give (e,) or (e, d, d)")
    kind = "modulus 1" if transports.ndim == 1 else "orthogonal columns of length 1"
    _refuse_first(wrong, lambda k: f"the transport of {element} {k} is {transports[k].tolist()}: it needs {kind}")
    if fibre is not Fibre.VECTORS and transports.ndim == 1:
        raise SettingError(f"nodes carry {fibre} and the transports are complex numbers: give d x d matrices")
    if fibre is Fibre.ROTATIONS:
        _refuse_reflections(f"transport of {element}", transports)


def _far_from_orthogonal(matrices: np.ndarray) -> np.ndarray:
    size = matrices.shape[1]
    far = np.zeros(len(matrices), bool)
    for a, b in combinations_with_replacement(range(size), 2):  # one product of columns of all matrices after the other
        products = sum(matrices[:, row, a] * matrices[:, row, b] for row in range(size))
        far |= ~(np.abs(products - (a == b)) < UNIT)
    return far


def _refuse_reflections(name: str, matrices: np.ndarray) -> None:
    _refuse_first(
        are_flips(matrices), lambda k: f"the {name} {k} is a reflection: give rotations, or let the nodes be orthogonal"
    )


def _check_values(element: str, values: np.ndarray, count: int, connection: Connection, fibre: Fibre) -> None:
    if fibre is not Fibre.VECTORS:
        _check_frames(element, values, (count, connection.block, connection.block), fibre)
        return
    is_number = np.iscomplexobj(values) or (connection.is_circle and values.ndim == 1)
    shape = (count,) if is_number else (count, connection.block)
    if values.shape != shape:
        raise SettingError(f"values of {element}s have the shape {values.shape}: give {shape}")
    lengths = np.sqrt((np.abs(values) ** 2).sum(axis=tuple(range(1, values.ndim))))
    wrong = ~(np.abs(lengths - 1) < UNIT)
    _refuse_first(wrong, lambda k: f"the value of {element} {k} is {values[k].tolist()}: it needs the length 1")


def _check_frames(element: str, values: np.ndarray, shape: tuple[int, ...], fibre: Fibre) -> None:
    if values.shape != shape:
        raise SettingError(f"values of {element}s have the shape {values.shape}: give {shape}")
    wrong = _far_from_orthogonal(values)
    _refuse_first(wrong, lambda k: f"the value of {element} {k} is {values[k].tolist()}: it needs orthonormal columns")
    if fibre is Fibre.ROTATIONS:
        _refuse_reflections(f"value of {element}", values)
