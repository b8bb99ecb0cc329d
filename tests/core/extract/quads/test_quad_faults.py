# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A quad mesh that is not as it should be is said to be so, and one that is has nothing said of it."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.measure.faults import distance, quad_faults
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.geometry import TriangleMesh

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
SURFACE = TriangleMesh(CUBE, np.concatenate([FACES[:, [0, 1, 2]], FACES[:, [0, 2, 3]]]))


def quads(vertices=CUBE, faces=FACES):
    return QuadMesh(
        np.array(vertices, float),
        np.zeros(len(vertices), int),
        None,
        np.ravel(faces),
        np.full(len(faces), len(faces[0])),
    )


def moved(number, place):
    vertices = CUBE.copy()
    vertices[number] = place
    return quads(vertices)


def test_a_cube_has_no_faults():
    assert quad_faults(quads(), SURFACE, True) == ()
    assert distance(quads(), SURFACE) == pytest.approx(0)


@pytest.mark.parametrize(
    "made, line",
    [
        (moved(0, CUBE[1]), "1 of 12 edges of the quad mesh have no length"),
        (moved(0, (0.9, 0.9, 0)), "folded over"),
        (quads(faces=FACES[:5]), "the surface is closed and the quad mesh is not"),
        (moved(0, (-3, -3, -3)), "the quad mesh is 5.2 away from the surface"),
    ],
)
def test_each_fault_is_said_with_a_remedy(made, line):
    found = quad_faults(made, SURFACE, True)
    assert any(line in said and said.endswith("ask for more faces, or a smaller spacing") for said in found), found


def slanted(degrees):
    """Places and faces of a hundred quads with corners that far from right angles, and their surface."""
    x, y = np.meshgrid(np.arange(11.0), np.arange(11.0))
    places = np.column_stack([(x + np.tan(np.radians(degrees)) * y).ravel(), y.ravel(), np.zeros(121)])
    first = (np.arange(10) + 11 * np.arange(10)[:, None]).reshape(-1, 1)
    faces = first + [0, 1, 12, 11]
    return places, faces, TriangleMesh(places, np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]))


@pytest.mark.parametrize("degrees", [11, 13])
def test_a_hundred_quads_aslant_are_said(degrees):
    places, faces, sheet = slanted(degrees)
    line = f"corners are {degrees} degrees off right angles on average: ask for more faces, or a smaller spacing"
    assert quad_faults(quads(places, faces), sheet, False) == ((line,) if degrees > 12 else ())


@pytest.mark.parametrize(
    ("tried", "told"),
    [
        ({100: 20.0}, ""),
        ({100: 20.0, 90: 19.0}, ", and not much less in the other meshes that were tried"),
        ({100: 20.0, 90: 19.0, 150: 11.0, 400: 4.0}, ", and 11 in a mesh with 150 faces that was tried"),
    ],
)
def test_a_mesh_that_was_tried_and_has_better_corners_is_named(tried, told):
    places, faces, sheet = slanted(20)
    line = f"corners are 20 degrees off right angles on average{told}: ask for more faces, or a smaller spacing"
    assert quad_faults(quads(places, faces), sheet, False, tried) == (line,)


def test_a_face_of_many_corners_is_said():
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    disk = quads(ring, [np.arange(12)])
    flat = TriangleMesh(ring, [[0, k, k + 1] for k in range(1, 11)])
    assert quad_faults(disk, flat, False) == (
        "1 of 1 faces have more than 8 corners: ask for more faces, or a smaller spacing",
    )


def test_an_open_surface_may_have_an_open_quad_mesh():
    assert quad_faults(quads(faces=FACES[:5]), SURFACE, False) == ()
