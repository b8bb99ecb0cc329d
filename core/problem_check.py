# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether arrays make a synchronization problem: one line names the first element that does not, and the remedy."""

import numpy as np

from .errors import SettingError

# How far a transport may be from a rotation or reflection, and a value from unit length: what single precision leaves.
UNIT = 1e-4


def check_problem(connection, mass, merged, fixed, drawn):
    """Raise a SettingError for the first thing wrong with the parts of a problem, but for doubled constraints."""
    count = connection.node_count
    if not isinstance(count, int | np.integer) or count < 1:
        raise SettingError(f"the connection has {count!r} nodes: give a whole number of at least 1")
    edges = connection.edges
    if edges.ndim != 2 or edges.shape[1] != 2:
        raise SettingError(f"edges have the shape {edges.shape}: give two nodes for each")
    _check_nodes("edge", edges, count)
    _check_numbers("weight", "edge", connection.weights, len(edges))
    _check_transports("edge", connection.transports, len(edges))
    if mass is not None:
        _check_numbers("mass", "node", mass, count)
    block, is_circle = connection.block, connection.transports.ndim == 1 or connection.block == 2
    if merged is not None:
        _check_nodes("merged node", merged.nodes, count)
        _check_nodes("root of merged nodes", merged.roots, count)
        _check_length("roots", "merged node", merged.roots, len(merged.nodes))
        _check_transports("merged node", merged.transports, len(merged.nodes))
    for name, targets in (("fixed node", fixed), ("drawn node", drawn)):
        if targets is not None:
            _check_nodes(name, targets.nodes, count)
            _check_values(name, np.asarray(targets.values), len(targets.nodes), block, is_circle)
    if fixed is not None and fixed.weights is not None:
        raise SettingError("fixed nodes have weights: leave them out, or draw the nodes instead")
    if drawn is not None:
        if drawn.weights is None:
            raise SettingError("drawn nodes have no weights: give one for each, or fix the nodes instead")
        _check_numbers("weight", "drawn node", drawn.weights, len(drawn.nodes))


def _check_nodes(name, nodes, count):
    nodes = np.asarray(nodes)
    if nodes.size and not np.issubdtype(nodes.dtype, np.integer):
        raise SettingError(f"{name}s are given as {nodes.dtype}: give whole numbers")
    wrong = ((nodes < 0) | (nodes >= count)).any(axis=tuple(range(1, nodes.ndim)))
    if wrong.any():
        number = int(np.flatnonzero(wrong)[0])
        raise SettingError(f"{name} {number} is {nodes[number].tolist()} of {count} nodes: count them from 0")


def _check_length(name, element, values, count):
    if len(values) != count:
        raise SettingError(f"there are {len(values)} {name} for {count} {element}s: give one for each")


def _check_numbers(name, element, values, count):
    """Numbers that are not negative."""
    values = np.asarray(values)
    if values.shape != (count,):
        raise SettingError(f"{name} of {element}s has the shape {values.shape}: give {count} numbers")
    wrong = ~(np.isfinite(values) & (values >= 0))
    if wrong.any():
        number = int(np.flatnonzero(wrong)[0])
        raise SettingError(f"the {name} of {element} {number} is {values[number]}: give a finite number, not below 0")


def _check_transports(element, transports, count):
    _check_length("transports", element, transports, count)
    if transports.ndim == 1:
        wrong = ~(np.abs(np.abs(transports) - 1) < UNIT)
    elif transports.ndim == 3 and transports.shape[1] == transports.shape[2]:
        squares = np.einsum("eba,ebc->eac", transports, transports)
        wrong = ~(np.abs(squares - np.eye(transports.shape[1])) < UNIT).all(axis=(1, 2))
    else:
        raise SettingError(f"transports of {element}s have the shape {transports.shape}: give (e,) or (e, d, d)")
    if wrong.any():
        number = int(np.flatnonzero(wrong)[0])
        kind = "modulus 1" if transports.ndim == 1 else "orthogonal columns of length 1"
        raise SettingError(f"the transport of {element} {number} is {transports[number].tolist()}: it needs {kind}")


def _check_values(element, values, count, block, is_circle):
    shape = (count,) if np.iscomplexobj(values) or (is_circle and values.ndim == 1) else (count, block)
    if values.shape != shape:
        raise SettingError(f"values of {element}s have the shape {values.shape}: give {shape}")
    wrong = ~(np.abs(np.sqrt((np.abs(values) ** 2).sum(axis=tuple(range(1, values.ndim)))) - 1) < UNIT)
    if wrong.any():
        number = int(np.flatnonzero(wrong)[0])
        raise SettingError(f"the value of {element} {number} is {values[number].tolist()}: it needs the length 1")
