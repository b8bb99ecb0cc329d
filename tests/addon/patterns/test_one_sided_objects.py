# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Moebius strips and Klein bottles: patterns go on across the seam along which they are opened."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes

from ...corpus.makers import klein_bottle, moebius_strip
from ..rebuilt_pattern import largest_jump
from ..scenes import add_object, attribute, places


@pytest.mark.parametrize(
    ("build", "symmetry"), [(lambda: moebius_strip(60, 8), "line"), (klein_bottle, "vector"), (klein_bottle, "cross")]
)
def test_patterns_go_on_all_around_a_one_sided_surface(build, symmetry):
    obj = add_object(*build())
    if symmetry == "cross":
        report = api.quads(obj, spacing=0.3)
    else:
        report = api.stripes(obj, spacing=0.3, symmetry=symmetry)
    jump, compared = largest_jump(obj)
    assert jump < 1e-4 and compared > 800
    assert list(report["carrier"]) == ["one_sided_edges"]
    assert report["euler_characteristic"] == 0 and report["closed"] == (build is klein_bottle)


def test_a_seam_is_no_boundary():
    obj = add_object(*moebius_strip(60, 8))
    report = api.stripes(obj, spacing=0.25, boundary="phase")
    # The circle in the middle would turn its phase over: with 5 lines on a width of 1 all is even.
    assert report["energy"] < 3 and largest_jump(obj)[0] < 1e-4
    rim = np.bincount(np.concatenate([edge.vertices for edge in obj.data.edges if _faces(obj, edge) == 1])) > 0
    waves = np.cos(attribute(obj, "synch_vertex_phase"))
    np.testing.assert_allclose(waves[rim.nonzero()], 1, atol=1e-5)
    assert (waves < 0).any()
    seam = places(obj)[:, 1] ** 2 < 1e-12
    assert waves[seam & (places(obj)[:, 0] > 0)].min() < 0
    with pytest.raises(SynchError, match="the mesh has no boundary"):
        api.stripes(add_object(*klein_bottle()), spacing=0.3, boundary="along")
    assert api.stripes(obj, spacing=0.25, guidance="distance:boundary")["energy"] > 0


def _cut_at(obj, chosen):
    """The report of a field on an object with a cut along edges for whose two ends (n,) bool holds."""
    for edge in obj.data.edges:
        edge.use_seam = bool(chosen[list(edge.vertices)].all())
    return api.directions(obj, constraints=[{"where": "seams", "what": "cut"}])


def test_cuts_go_across_the_seam_of_a_one_sided_surface():
    """Along the middle a Moebius strip becomes a ring of two sides, and across a disk, be the cut the seam or not."""
    points, faces = moebius_strip(60, 8)
    across = np.arange(len(points)) % 9
    assert _cut_at(add_object(points, faces), across == 4)["euler_characteristic"] == 0
    for place in range(0, 60, 7):
        assert _cut_at(add_object(points, faces), np.arange(len(points)) // 9 == place)["euler_characteristic"] == 1
    (seam,) = (f.elements for f in meshes.read_mesh(bpy.context.active_object).findings if f.name == "one_sided_edges")
    on_seam = np.isin(np.arange(len(points)), seam)
    report = _cut_at(add_object(points, faces), on_seam)
    assert report["euler_characteristic"] == 1 and not report["closed"]


def test_a_fin_along_the_seam_has_a_boundary_of_its_own():
    """Edges of three faces along which a Moebius strip is open: those of the fin are a boundary, the seam is not."""
    points, faces = moebius_strip(40, 6)
    (seam,) = (f.elements for f in meshes.read_mesh(add_object(points, faces)).findings if f.name == "one_sided_edges")
    line = np.unique(seam)
    fin = np.arange(len(line)) + len(points)
    edges = [(line.searchsorted(a), line.searchsorted(b)) for a, b in seam]
    obj = add_object(
        np.vstack([points, points[line] + [0, 0, 0.5]]),
        [*faces, *([int(line[a]), int(line[b]), int(fin[b]), int(fin[a])] for a, b in edges)],
    )
    given = meshes.read_mesh(obj)
    found = {finding.name: finding.elements for finding in given.findings}
    assert len(found["non_manifold_edges"]) == len(edges) == 6
    # The strip has the rim of 80 edges; the fin has one around it of 6 along, 6 free, and 2 at its ends.
    assert len(given.boundary_edges) == 80 + 14
    assert given.euler_characteristic == 0 + 1
    assert api.stripes(obj, spacing=0.3)["status"] == "certified"


def _faces(obj, edge):
    return sum(set(edge.vertices) <= set(face.vertices) for face in obj.data.polygons)
