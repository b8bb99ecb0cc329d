# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex groups of an object as arrays, read and written."""

import numpy as np

from ...core.errors import SettingError


def is_group(obj, name):
    """Whether numbers of this name are the weights of a vertex group; an attribute of the name goes first."""
    return name in obj.vertex_groups and name not in obj.data.attributes


def read_group(obj, name):
    """(n,) bool: vertices of a vertex group, on the object's own vertices."""
    members = read_weights(obj, name) > 0
    if not members.any():
        raise SettingError(f"the vertex group {name!r} is empty: assign vertices to it")
    return members


def read_members(obj):
    """Vertices, group indices and weights, (k,) each, of the members of all vertex groups."""
    members = [(vertex.index, one.group, one.weight) for vertex in obj.data.vertices for one in vertex.groups]
    vertices, indices, weights = np.array(members, float).reshape(-1, 3).T
    return vertices.astype(int), indices.astype(int), weights


def read_weights(obj, name, outside=0.0, members=None):
    """(n,) weights of a vertex group, another number for vertices outside; ``members`` as of :func:`read_members`."""
    group = obj.vertex_groups.get(name)
    if group is None:
        names = ", ".join(g.name for g in obj.vertex_groups) or "none yet"
        raise SettingError(f"{obj.name} has no vertex group {name!r}: choose one of its groups ({names})")
    vertices, indices, of_members = read_members(obj) if members is None else members
    weights = np.full(len(obj.data.vertices), outside)
    own = indices == group.index
    weights[vertices[own]] = of_members[own]
    return weights


def write_weights(obj, name, weights):
    """Give a vertex group, which is made if need be, (n,) weights; only vertices whose weight changes are touched."""
    group, before = obj.vertex_groups.get(name), 0.0
    if group is None:
        group = obj.vertex_groups.new(name=name)
    else:
        before = read_weights(obj, name)
    for vertex in np.flatnonzero(weights != before).tolist():
        group.add([vertex], float(weights[vertex]), "REPLACE")
