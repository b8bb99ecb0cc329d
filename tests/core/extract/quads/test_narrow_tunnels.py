# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads through which a tunnel or a handle passes that is narrower than they are."""

from itertools import pairwise

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.quads.finishing import sound_quads
from synch_fields.core.extract.quads.measure.faults import count_lost_handles, count_parts, quad_faults
from synch_fields.core.extract.quads.repair.narrow_tunnels import close_narrow_tunnels, find_flat_faces
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.geometry import TriangleMesh

# A box of 3 x 3 x 1 cells; the corners of the cells in the middle of its top and of its bottom, seen from outside.
TOP, BOTTOM = ("110", "210", "220", "120"), ("111", "121", "221", "211")
TETRAHEDRON = TriangleMesh(np.eye(4)[:, :3], np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]))


def of_faces(*faces):
    """The mesh of faces with named vertices; digits of a name are coordinates."""
    names = sorted({name for face in faces for name in face})
    places = np.array([[int(digit) for digit in name[:3]] for name in names], float)
    count = len(names)
    corners = np.array([names.index(name) for face in faces for name in face])
    sizes = np.array([len(face) for face in faces])
    return QuadMesh(places, np.zeros(count, int), np.eye(3)[np.zeros(count, int)], corners, sizes)


def box(*left_out):
    """The faces of the box, outward, with z downward, but those with the given corners."""
    faces = []
    for x in range(3):
        for y in range(3):
            square = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
            faces += [[f"{a}{b}0" for a, b in square], [f"{a}{b}1" for a, b in square[::-1]]]
    rim = [(x, 0) for x in range(3)] + [(3, y) for y in range(3)]
    rim += [(3 - x, 3) for x in range(3)] + [(0, 3 - y) for y in range(3)]
    for (a, b), (c, d) in zip(rim, rim[1:] + rim[:1], strict=True):
        faces.append([f"{c}{d}0", f"{a}{b}0", f"{a}{b}1", f"{c}{d}1"])
    return [face for face in faces if set(face) not in [set(one) for one in left_out]]


def cycles(quads):
    """Each face as places, from its first place on."""
    found = []
    for corners in np.split(quads.corner_vertices, quads.starts[1:]):
        places = [tuple(place) for place in quads.vertices[corners]]
        first = places.index(min(places))
        found.append(tuple(places[first:] + places[:first]))
    return sorted(found)


def is_closed(quads):
    return set(quads.edges[1].tolist()) == {2}


@pytest.mark.parametrize(
    "through",
    [
        # The tunnel is inside of one face, which leads along an edge from the top to the bottom and back.
        [[*TOP, "110", *BOTTOM, "111"]],
        # Two faces share the tunnel, between two edges with the same ends.
        [[*TOP, "110", "111"], [*BOTTOM, "111", "110"]],
    ],
)
def test_a_tunnel_through_a_quad_is_closed(through):
    given = of_faces(*box(TOP, BOTTOM), *through)
    assert given.is_unsound.any() and given.euler_characteristic < 2
    made = close_narrow_tunnels(given)
    assert cycles(made) == cycles(of_faces(*box()))
    assert not made.is_unsound.any() and is_closed(made) and made.euler_characteristic == 2


def test_a_tube_of_two_quads_around_is_cut_off():
    rings = [("110", "220"), ("112", "222"), ("113", "223"), ("111", "221")]
    tube = [face for (a, b), (c, d) in pairwise(rings) for face in ([a, c, d, b], [b, d, c, a])]
    ends = [["110", "210", "220"], ["110", "220", "120"], ["111", "221", "211"], ["111", "121", "221"]]
    given = of_faces(*box(TOP, BOTTOM), *tube, *ends)
    assert not is_closed(given)
    made = close_narrow_tunnels(given)
    assert cycles(made) == cycles(of_faces(*box(TOP, BOTTOM), *ends))
    assert not made.is_unsound.any() and is_closed(made)


def test_a_mesh_without_narrow_tunnels_stays_as_it_is():
    given = of_faces(*box())
    made = close_narrow_tunnels(given)
    assert cycles(made) == cycles(given) and len(made.vertices) == len(given.vertices)


def test_what_has_no_thickness_is_left_out():
    """A fin of the box whose two sides have the same vertices, and a piece that consists of two such faces."""
    fin = [["110", "115", "215", "210"], ["210", "215", "115", "110"]]
    leaf = [["770", "780", "880", "870"], ["870", "880", "780", "770"]]
    made = close_narrow_tunnels(of_faces(*box(), *fin, *leaf))
    assert cycles(made) == cycles(of_faces(*box())) and not made.is_unsound.any() and is_closed(made)


def lobe(*ends, height):
    """Four faces around a box of the cells in the middle that are open between two vertices, and a lid far away."""
    p, q = ends
    a, b, c, d = (f"{x}{y}{height}" for x, y in [(1, 1), (2, 1), (2, 2), (1, 2)])
    return [[a, b, q, p], [b, c, q], [c, d, p, q], [d, a, p], [d, c, b, a]]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("count", [2, 3, 5])
def test_lobes_that_meet_in_edges_with_the_same_ends_are_cut_apart(count, seed):
    """The order of faces does not matter. Small lobes are left out, but for the large one, and one of two like it."""
    p, q = "773", "883"
    large = [[*face] for face in box(TOP)] + lobe(p, q, height=0)[:4]
    small = [face for height in range(4, 3 + count) for face in lobe(p, q, height=height)]
    faces = [*large, *small]
    made = close_narrow_tunnels(of_faces(*(faces[k] for k in np.random.default_rng(seed).permutation(len(faces)))))
    assert cycles(made) == cycles(of_faces(*large)) and not made.is_unsound.any() and is_closed(made)


def test_both_halves_of_an_hourglass_are_kept():
    """Its waist is around two edges with the same ends; where it is cut, a warning counts the pieces."""
    p, q = "773", "883"
    lower = [*box(TOP), *lobe(p, q, height=0)[:4]]
    upper = [
        [name.replace("0", "9").replace("1", "8") if name not in (p, q) else name for name in face] for face in lower
    ]
    given = of_faces(*lower, *upper)
    made = close_narrow_tunnels(given)
    assert cycles(made) == cycles(of_faces(*lower, *upper)) and len(made.vertices) == len(given.vertices) + 2
    assert not made.is_unsound.any() and is_closed(made) and count_parts(made, TETRAHEDRON) == (2, 1)
    assert "has 2 pieces instead of 1, since it is cut where the surface is narrower" in " ".join(
        quad_faults(made, TETRAHEDRON, True)
    )


@pytest.mark.parametrize("faces", [[["110", "220", "110", "220"]], [["110", "210", "220"], ["220", "210", "110"]]])
def test_nothing_is_left_of_what_has_no_volume(faces):
    made = close_narrow_tunnels(of_faces(*faces))
    assert len(made.sizes) == 0
    with pytest.raises(SettingError, match="no grid lines cross"):
        sound_quads(of_faces(*faces), TETRAHEDRON, True)


def test_faces_that_cross_on_the_same_vertices_are_not_two_sides():
    given = of_faces(["110", "210", "220", "120"], ["110", "220", "210", "120"])
    assert not find_flat_faces(given).any()
    assert find_flat_faces(of_faces(["110", "210", "220", "120"], ["220", "210", "110", "120"])).all()


def test_quads_that_meet_themselves_are_refused_unless_tunnels_may_be_closed():
    surface = TETRAHEDRON
    given = of_faces(*box(TOP, BOTTOM), [*TOP, "110", *BOTTOM, "111"])
    with pytest.raises(SettingError, match="some would meet themselves"):
        sound_quads(given, surface, False)
    assert not sound_quads(given, surface, True).is_unsound.any()


def torus(rings, sides):
    """Triangles of a torus."""
    ring, side = np.divmod(np.arange(rings * sides), sides)
    along, around = 2 * np.pi * ring / rings, 2 * np.pi * side / sides
    width = 2 + np.cos(around)
    places = np.column_stack([width * np.cos(along), width * np.sin(along), np.sin(around)])
    beside = ring * sides + (side + 1) % sides
    ahead, across = (np.arange(len(ring)) + sides) % len(ring), (beside + sides) % len(ring)
    first = np.column_stack([np.arange(len(ring)), ahead, across])
    return TriangleMesh(places, np.concatenate([first, np.column_stack([np.arange(len(ring)), across, beside])]))


def test_lost_handles_are_counted():
    surface = torus(6, 5)
    assert surface.piece_euler_characteristics.tolist() == [0]
    assert count_lost_handles(of_faces(*box()), surface) == (1, 1)
    ring = of_faces(*box(TOP, BOTTOM), *([a, d, c, b] for a, b, c, d in walls()))
    assert is_closed(ring) and ring.euler_characteristic == 0
    assert count_lost_handles(ring, surface) == (0, 1)
    # A piece without quads adds no handles.
    both = TriangleMesh(
        np.concatenate([surface.vertices, surface.vertices + 9]),
        np.concatenate([surface.triangles, surface.triangles + surface.vertex_count]),
    )
    assert count_lost_handles(ring, both) == (0, 1)
    opened = TriangleMesh(surface.vertices, surface.triangles[1:])
    assert count_lost_handles(of_faces(*box()), opened) == (1, 1)
    assert count_lost_handles(of_faces(*box()[1:]), opened) == (1, 1)


def walls():
    """The walls of the tunnel between the middles of the top and the bottom."""
    for a, b in zip(TOP, [*TOP[1:], TOP[0]], strict=True):
        yield a, b, b[:2] + "1", a[:2] + "1"
