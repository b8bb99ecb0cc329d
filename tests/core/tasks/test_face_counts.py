# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of several quad meshes is taken for a wanted number of faces."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.tasks.face_counts import Trial, choose
from synch_fields.core.tasks.surface_result import SurfaceResult


def row(count, degrees):
    """A quad mesh of count faces in a row, with corners that far from right angles."""
    x, y = np.meshgrid(np.arange(count + 1.0), np.arange(2.0))
    places = np.column_stack([(x + np.tan(np.radians(degrees)) * y).ravel(), y.ravel(), 0 * x.ravel()])
    faces = np.arange(count)[:, None] + [0, 1, count + 2, count + 1]
    return QuadMesh(places, np.zeros(len(places), int), None, faces.ravel(), np.full(count, 4))


def trial(count, degrees, last=None):
    return Trial(SurfaceResult(None, quads=row(count, degrees)), last and (lambda: row(count, last)))


@pytest.mark.parametrize(
    ("trials", "count", "tried"),
    [
        ([(101, 11), (100, 11.5), (104, 2)], 100, {101: 11, 100: 11.5, 104: 2}),
        ([(101, 18), (109, 13), (120, 3)], 109, {101: 18, 109: 13, 120: 3}),
        # The last step is done for what is taken, and for one that may be better.
        ([(101, 18, 11), (109, 13, 10)], 101, {101: 11, 109: 13}),
        ([(101, 18, 14), (103, 17, 13), (95, 16, 14.5)], 101, {101: 14, 103: 17, 95: 14.5}),
        ([(101, 18, 14), (103, 17, 13), (95, 16, 12.5)], 95, {101: 14, 103: 17, 95: 12.5}),
    ],
)
def test_the_nearest_number_is_taken_unless_its_corners_are_bad_and_others_better(trials, count, tried):
    means = {}
    found = choose([trial(*each) for each in trials], 100, means)
    assert len(found.quads.sizes) == count
    assert means == pytest.approx(tried)


def test_the_last_step_counts_as_time_of_extraction():
    result = trial(10, 20, 5).finished({})
    assert result.seconds.keys() == {"extract"}
