# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What takes more memory than there is, is refused before it begins; what fits is not."""

import math
import sys

import numpy as np
import pytest

from synch_fields.core import memory
from synch_fields.core.errors import SynchError
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.memory import Room, check_memory, room
from synch_fields.core.solve import Options, solve, solver
from synch_fields.core.solve.methods import certificate
from synch_fields.core.solve.methods.memory_estimate import connection_bytes, elimination_bytes

from .memory_peak import numbers_of_child
from .meshes import icosphere

GIB = 2**30


def leaving(size):
    return lambda *_: Room(size, 1.0, "memory", "use a machine with more")


def test_what_may_be_too_much_is_refused_in_one_line_with_figures(monkeypatch):
    monkeypatch.setattr(memory, "room", leaving(3 * GIB))
    check_memory(3.9 * GIB, "it")  # estimates may be a third too high
    with pytest.raises(SynchError) as caught:
        check_memory(5 * GIB, "a solve of 9 phases")
    assert str(caught.value) == (
        "a solve of 9 phases takes about 5 GB of memory and 3 GB are left: "
        "use a coarser mesh, or use a machine with more"
    )


def test_the_least_of_all_limits_counts(monkeypatch):
    monkeypatch.setattr(memory, "used_bytes", lambda: 1 * GIB)
    monkeypatch.setattr(memory, "machine_bytes", lambda: 9 * GIB)
    for container, space, name, usable in (
        (5, 12, "the container's memory", 4),
        (50, 12, "address space", 6),
        (math.inf, math.inf, "memory", 8),
    ):
        monkeypatch.setattr(memory, "_container_bytes", lambda size=container: size * GIB)
        monkeypatch.setattr(memory, "_space_left", lambda size=space: size * GIB)
        assert room(2.0).name == name and room(2.0).usable == usable * GIB


@pytest.mark.parametrize("version", [1, 2])
def test_limits_of_control_groups_are_found(tmp_path, monkeypatch, version):
    """Of the group itself and of those around it, as far as they can be seen."""
    folder, name = tmp_path / "groups", "memory.max" if version == 2 else "memory.limit_in_bytes"
    (folder / "work" / "job").mkdir(parents=True)
    (folder / "work" / name).write_text("3000000000\n")
    (folder / "work" / "job" / name).write_text("max\n" if version == 2 else "9223372036854771712\n")
    own = tmp_path / "cgroup"
    own.write_text("0::/work/job\n" if version == 2 else "5:cpuset:/\n4:cpu,memory:/work/job\n1:name=systemd:/\n")
    monkeypatch.setattr(memory, "_OWN_GROUPS", own)
    monkeypatch.setattr(memory, "_GROUPS", dict.fromkeys([True, False], (str(folder), name)))
    read = memory._container_bytes.__wrapped__
    assert read() == 3_000_000_000
    own.write_text("0::/elsewhere\n")
    assert read() == math.inf
    own.unlink()
    assert read() == math.inf


def test_a_solve_is_refused_before_it_begins(monkeypatch):
    problem = direction_problem(icosphere(3), 2)
    needed = connection_bytes(642, 1920, 1, True)
    for share, fits in ((0.8, True), (0.7, False)):
        monkeypatch.setattr(memory, "room", leaving(share * needed))
        if fits:
            assert solve(problem, Options(rounding="svd")).energy > 0
            continue
        monkeypatch.setattr(solver, "_solve_piece", None)
        with pytest.raises(SynchError, match=r"a solve of 642 phases takes about .* of memory"):
            solve(problem)


def test_a_proof_that_does_not_fit_is_not_tried(monkeypatch):
    problem = direction_problem(icosphere(3), 2)
    (piece,) = problem.pieces
    plan = certificate.plan_proof(piece)
    assert plan.bytes == elimination_bytes(piece, plan.elimination.entries)
    for more, fits in ((1, True), (-1, False)):
        monkeypatch.setattr(certificate, "room", leaving(plan.bytes + more))
        assert (certificate.plan_proof(piece) is not None) == fits
    assert solve(problem).certificate == "estimated"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere what a process has is told otherwise")
def test_the_peak_of_a_process_is_its_own():
    """Not that of the process that started it; what was freed again counts."""
    large = np.ones(40_000_000)
    code = (
        "import numpy as np; from synch_fields.core import memory; np.ones(20_000_000); print(memory.peak_megabytes())"
    )
    assert large.nbytes / 2**20 > 300 > numbers_of_child(code)[0] > 150


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere what a process has is told otherwise")
def test_a_peak_is_found_where_the_system_tells_less(tmp_path, monkeypatch):
    whole = memory.peak_megabytes()
    for text in ("Name:\tpython\nVmRSS:\t1234 kB\n", None):
        status = tmp_path / "status"
        if text is None:
            status.unlink()
        else:
            status.write_text(text)
        monkeypatch.setattr(memory, "_STATUS", status)
        assert memory.peak_megabytes() >= 0.9 * whole


MEASURE = """
import numpy as np
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.methods import staircase
from synch_fields.core.solve.methods.memory_estimate import connection_bytes
from synch_fields.tests.core.memory_peak import bytes_taken
u, v = (a.ravel() for a in np.mgrid[:120, :60])
number = (60 * u + v).reshape(120, 60)
right, up = np.roll(number, -1, 0), np.roll(number, -1, 1)
both = np.roll(right, -1, 1)
corners = [(number, right, both), (number, both, up)]
triangles = np.concatenate([np.column_stack([a.ravel() for a in three]) for three in corners])
u, v = u * np.pi / 60, v * np.pi / 30
reach = 2 + np.cos(v) * (1 + 0.3 * np.sin(3 * u))
mesh = TriangleMesh(np.column_stack([reach * np.cos(u), reach * np.sin(u), np.sin(v)]), triangles)
problem = direction_problem(mesh, 4)
staircase.plan_proof = lambda *_: None
_, taken = bytes_taken(lambda: solve(problem, Options(target_gap=0.05)))
print(taken / connection_bytes(mesh.vertex_count, len(mesh.edges), 1, True))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere what a process has is told otherwise")
def test_a_solve_takes_no_less_than_was_estimated():
    """But for what was left over before; small meshes take up to about three times as much."""
    (share,) = numbers_of_child(MEASURE)
    assert 0.75 <= share < 4
