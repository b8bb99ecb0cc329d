# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups that tests take from a file are those that the add-on draws."""

import bpy
import pytest

from synch_fields.synch_addon.nodes import globe, quads, stripes, vortices
from synch_fields.synch_addon.patterns import relief

from .faults import tree_state

DRAWN = {
    "Synch Stripes": stripes.stripes_group,
    "Synch Quads": quads.quads_group,
    "Synch Tubes": vortices.tubes_group,
    "Synch Relief": lambda: relief.relief_group("stripes"),
    "Synch Quad Relief": lambda: relief.relief_group("quads"),
}


def groups_now():
    """All node groups: nodes, their values, links, sockets and properties."""
    found = {}
    for tree in bpy.data.node_groups:
        places = [
            (node.name, node.label, node.parent and node.parent.label, tuple(node.location)) for node in tree.nodes
        ]
        links = [(link.from_node.name, link.from_socket.identifier, link.to_node.name) for link in tree.links]
        found[tree.name] = str((tree_state(tree), tree.users, dict(tree.items()), places, sorted(links)))
    return found


@pytest.mark.parametrize("name", DRAWN)
def test_a_group_of_the_file_is_the_one_that_is_drawn(name, monkeypatch):
    draw = stripes.group_tree.__wrapped__
    assert DRAWN[name]().name == name and not bpy.data.libraries
    taken = groups_now()
    bpy.ops.wm.read_homefile(use_empty=True)
    for module in (globe, quads, relief, stripes, vortices):
        monkeypatch.setattr(module, "group_tree", draw)
    DRAWN[name]()
    assert groups_now() == taken and len(taken) > 1
