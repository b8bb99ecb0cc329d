# SPDX-License-Identifier: GPL-3.0-or-later
"""Remove flips from a graph by choosing a sheet at each node."""

import numpy as np

from .graphs import components


def balance(node_count: int, edges: np.ndarray, flips: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Choose for every node whether to turn it over, so that as few components as possible keep flips.

    An edge flips after the choice when ``flip ^ turned[i] ^ turned[j]``. A component whose loops all
    carry an even number of flips is balanced: its flips vanish. Found on the double cover, where a
    balanced component falls into two.

    Parameters
    ----------
    edges : (e, 2) int
    flips : (e,) bool

    Returns
    -------
    turned : (node_count,) bool, False throughout unbalanced components and at the first node
        of each balanced one
    balanced : (node_count,) bool
    """
    i, j = np.asarray(edges).T
    flips = np.asarray(flips, bool)
    shift = np.where(flips, node_count, 0)
    rows = np.concatenate([i, i + node_count])
    columns = np.concatenate([j + shift, j + node_count - shift])
    sheets = components(2 * node_count, np.column_stack([rows, columns]))
    front, back = sheets[:node_count], sheets[node_count:]
    balanced = front != back
    # The first node of a component has its front in the sheet with the lower label.
    first_label = np.minimum(front, back)
    turned = balanced & (front != first_label)
    return turned, balanced
