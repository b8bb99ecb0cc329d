# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests and results of surfaces and frames are plain data: no object of Blender's is in them, and a copy that went
through a pipe gives the same to the last bit."""

import types

import bpy
import numpy as np
import pytest

from synch_fields.core.process.ipc import Unpacker, pack_parts
from synch_fields.core.settings.constraints import Constraint
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.frames.job import AnimationJob, Span
from synch_fields.synch_addon.patterns.job import FieldJob

from ..moving_meshes import swaying
from ..scenes import add_group, quad_sphere, sphere


def through_a_pipe(message, own=(), theirs=()):
    """A copy of a message as the other end of a pipe gets it."""
    (found,) = Unpacker(theirs).feed(b"".join(bytes(part) for part in pack_parts(message, own)))
    return found


def everything_in(value, seen=None):
    """All objects that a value holds, each once."""
    seen = {} if seen is None else seen
    if id(value) in seen:
        return seen
    seen[id(value)] = value
    if isinstance(value, dict):
        parts = [*value.keys(), *value.values()]
    elif isinstance(value, list | tuple | set | frozenset):
        parts = list(value)
    elif hasattr(value, "func") and hasattr(value, "keywords"):  # a partial
        parts = [value.func, *value.args, *value.keywords.values()]
    elif isinstance(value, types.FunctionType):
        parts = [cell.cell_contents for cell in value.__closure__ or ()]
    else:
        parts = list(vars(value).values()) if hasattr(value, "__dict__") and not isinstance(value, type) else []
    for part in parts:
        everything_in(part, seen)
    return seen


def of_blender(value):
    """Whether something is an object of Blender's, or code that needs it."""
    module = getattr(value, "__module__", None) or type(value).__module__ or ""
    return (
        isinstance(value, bpy.types.bpy_struct)
        or module.split(".")[0] in ("bpy", "mathutils", "bmesh")
        or (".synch_addon" in module)
    )


def assert_same(first, second):
    """Two values are the same to the last bit, arrays inside included."""
    assert type(first) is type(second)
    if isinstance(first, np.ndarray):
        np.testing.assert_array_equal(first, second)
    elif isinstance(first, list | tuple):
        assert len(first) == len(second)
        for one, other in zip(first, second, strict=True):
            assert_same(one, other)
    elif isinstance(first, float | int | str | bool | type(None)):
        assert first == second or (first != first and second != second)


def phases_and_angles(result):
    found = [result.field.angles, result.field.energy]
    if result.pattern is not None:
        found += [result.pattern.phases, result.pattern.energy, result.pattern.solution.lower_bound]
    if result.quads is not None:
        found += [result.quads.vertices, result.quads.corner_vertices]
    return found


REQUESTS = {
    "directions": dict(symmetry="vector"),
    "stripes": dict(guidance="curvature-max=2,axis:Z,distance:half", spacing_map="half"),
    "quads": dict(aspect=1.0, mirror="X", constraints=(Constraint("group", "phase", "half"),)),
    "quad_mesh": dict(smoothing=2, branching=0.5, singularities=0.5),
}


@pytest.mark.parametrize("command", REQUESTS)
def test_a_request_that_went_through_a_pipe_gives_the_same(command):
    obj = quad_sphere(9)
    add_group(obj, "half", attribute_above(obj))
    request = FieldJob(command, obj, SurfaceSettings(spacing=0.5, **REQUESTS[command])).request
    copy = through_a_pipe(request)
    assert copy.shared[0] is not request.shared[0]
    assert not [value for value in everything_in(request).values() if of_blender(value)]
    result, other = request.solve(), copy.solve()
    assert not [value for value in everything_in(result).values() if of_blender(value)]
    assert_same(phases_and_angles(result), phases_and_angles(other))
    back = through_a_pipe(other, copy.shared, request.shared)
    assert_same(phases_and_angles(result), phases_and_angles(back))
    assert back.field.mesh is request.given.mesh  # nothing of the mesh came back


def attribute_above(obj):
    return [vertex.index for vertex in obj.data.vertices if vertex.co.z > 0.3]


def test_frames_that_went_through_a_pipe_give_the_same():
    job = AnimationJob(swaying(sphere(3)), SurfaceSettings(spacing=0.5), Span(1, 3))
    while job.advance() is not None:
        pass
    request = job.request
    copy = through_a_pipe(request)
    assert not [value for value in everything_in(request).values() if of_blender(value)]
    result, other = request.solve(), copy.solve()
    for frame, same in zip(result.frames, other.frames, strict=True):
        assert frame.figures == same.figures
        assert_same([frame.directions, frame.edge_phases.arguments], [same.directions, same.edge_phases.arguments])
    assert not [value for value in everything_in(result).values() if of_blender(value)]
