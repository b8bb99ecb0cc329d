# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that several threads share: the same results in order, one of them asks, and all end together."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from synch_fields.core.algebra import products, workers
from synch_fields.core.algebra.workers import idle_workers, share_out
from synch_fields.core.errors import Cancelled
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.monitor import SILENT, Monitor, OutOfTime
from synch_fields.core.solution import Clock
from synch_fields.core.solve import Certificate, Options, Status, solve
from synch_fields.core.solve.methods import rounding, staircase
from synch_fields.core.solve.methods.stage import Workspace
from synch_fields.core.solve.methods.staircase import relax

from ..graphs import only_piece
from ..meshes import bumpy_torus


@pytest.fixture(params=[1, 2, 5])
def count(request, monkeypatch):
    monkeypatch.setattr(workers, "WORKERS", request.param)
    return request.param


def test_results_come_in_the_order_of_the_parts(count):
    def work(part, monitor):
        time.sleep(0.01 * (part % 3))
        return part

    assert share_out(work, range(7), SILENT) == list(range(7))


def test_parts_share_the_threads_that_others_leave(count):
    both, first_has_ended = threading.Barrier(min(count, 2), timeout=5), threading.Event()

    def work(part, monitor):
        both.wait()
        found = [idle_workers()]
        both.wait()
        if part == 1 and count > 1:
            assert first_has_ended.wait(5)
            while idle_workers() < count:
                time.sleep(0.001)
            found.append(idle_workers())
        first_has_ended.set()
        return found

    expected = {1: [[1], [1]], 2: [[1], [1, 2]], 5: [[2], [2, 5]]}
    assert share_out(work, range(2), SILENT) == expected[count]
    assert idle_workers() == count


def test_threads_of_the_pool_share_nothing_again(count):
    with workers.solving():
        assert workers.pool.map(lambda part: (part, idle_workers()), range(4))[1:] == [(part, 1) for part in (1, 2, 3)]


def test_threads_outlast_the_solve_that_started_them_as_long_as_others_use_them(count):
    """Solves in several threads that begin and end at random, each of which shares parts."""

    def solves(seed):
        rng, found = np.random.default_rng(seed), []
        for size in rng.integers(2, 9, 200).tolist():
            with workers.solving():
                found.append(workers.pool.map(lambda part: part, range(size)) == list(range(size)))
            found.append(workers.pool.map(lambda part: part, range(size)) == list(range(size)))
        return all(found)

    with ThreadPoolExecutor(4) as executor:
        running = [executor.submit(solves, seed) for seed in range(4)]
        assert all(future.result(timeout=60) for future in running)
    assert not [thread for thread in threading.enumerate() if thread.name == "synch_fields"]


def test_an_error_in_a_part_comes_out_when_all_parts_have_ended(count):
    ended = []

    def work(part):
        if part == 0:
            raise ZeroDivisionError
        time.sleep(0.02)
        ended.append(part)

    with workers.solving(), pytest.raises(ZeroDivisionError):
        workers.pool.map(work, range(3))
    assert sorted(ended) == ([1, 2] if count > 1 else [])  # one thread stops at once


def test_all_threads_work_at_once(count):
    together = threading.Barrier(count, timeout=5)
    share_out(lambda part, monitor: together.wait(), range(count), SILENT)


def test_only_the_calling_thread_is_asked_and_all_end_when_it_says_so(count):
    asked, ended = set(), []
    begin = time.perf_counter()

    def callback(stage, fraction):
        asked.add(threading.get_ident())
        return time.perf_counter() < begin + 0.1

    def work(part, monitor):
        try:
            while time.perf_counter() < begin + 20:
                monitor.check()
                time.sleep(0.002)
        finally:
            ended.append(part)

    with pytest.raises(Cancelled):
        share_out(work, range(count), Monitor(callback))
    assert asked == {threading.get_ident()}
    while len(ended) < count:
        assert time.perf_counter() < begin + 10
        time.sleep(0.01)


def test_time_limits_end_shared_work(count):
    def work(part, monitor):
        while True:
            monitor.check()
            time.sleep(0.002)

    with pytest.raises(OutOfTime):
        share_out(work, range(3), Monitor(time_limit=0.05))


def test_work_that_returns_what_it_has_when_time_runs_out_is_kept(count):
    def work(part, monitor):
        try:
            while True:
                monitor.check()
                time.sleep(0.002)
        except OutOfTime:
            return part

    assert share_out(work, range(3), Monitor(time_limit=0.05)) == [0, 1, 2]


def test_errors_come_out_where_the_work_was_given_and_end_the_rest(count):
    def work(part, monitor):
        if part == 0:
            raise ZeroDivisionError("part 0")
        while True:
            monitor.check()
            time.sleep(0.002)

    begin = time.perf_counter()
    with pytest.raises(ZeroDivisionError, match="part 0"):
        share_out(work, range(4), SILENT)
    assert time.perf_counter() < begin + 5


def test_no_more_parts_than_wanted_are_worked_on_at_once(count):
    at_work, most = [], []

    def work(part, monitor):
        at_work.append(part)
        most.append(len(at_work))
        time.sleep(0.005)
        at_work.remove(part)

    share_out(work, range(12), SILENT, at_once=2)
    assert max(most) <= min(2, count)


def test_a_time_limit_while_fields_descend_keeps_them_on_any_number_of_cores(count, monkeypatch):
    piece = only_piece(direction_problem(bumpy_torus(40), 4))
    workspace = Workspace(piece)
    relaxation = relax(workspace, Options(), SILENT, Clock())
    stage, density = workspace.stages[0], relaxation.value / piece.mass.sum()
    monkeypatch.setattr(rounding, "WORTH_SHARING", 1)
    monitor, polish = Monitor(), rounding.polish

    def late(*arguments):
        monitor._deadline = time.perf_counter()
        return polish(*arguments)

    monkeypatch.setattr(rounding, "polish", late)
    fields, timed_out = rounding.continuation(stage, relaxation.lifted, 64, density, np.random.default_rng(0), monitor)
    assert timed_out and fields.shape[1] > 1


def test_a_solve_has_the_same_result_to_the_last_bit_on_any_number_of_cores(monkeypatch):
    monkeypatch.setattr(rounding, "WORTH_SHARING", 1)
    monkeypatch.setattr(products, "WORTH_SHARING", 1)
    results = []
    for cores in (1, 2, 4, 8):
        monkeypatch.setattr(workers, "WORKERS", cores)
        results.append(solve(direction_problem(bumpy_torus(14), 4), Options(seed=3)))
    for other in results[1:]:
        np.testing.assert_array_equal(other.phases, results[0].phases)
        np.testing.assert_array_equal(other.lifted, results[0].lifted)
        assert (other.energy, other.lower_bound) == (results[0].energy, results[0].lower_bound)


@pytest.mark.parametrize("moment", ["at once", "after the search"])
def test_a_proof_that_fails_beside_the_search_changes_nothing(monkeypatch, moment):
    found, prove, finish = [], staircase.prove, rounding.finish
    for cores in (1, 2):
        proofs, is_finished = [], threading.Event()

        def refute_first(*arguments, cores=cores, proofs=proofs, is_finished=is_finished):
            proofs.append(arguments)
            if cores > 1 and moment == "after the search":
                assert is_finished.wait(60)
            return len(proofs) > 1 and prove(*arguments)

        def tell(*arguments, is_finished=is_finished):
            column = finish(*arguments)
            is_finished.set()
            return column

        monkeypatch.setattr(workers, "WORKERS", cores)
        monkeypatch.setattr(staircase, "prove", refute_first)
        monkeypatch.setattr(rounding, "finish", tell)
        found.append(solve(direction_problem(bumpy_torus(14), 4), Options(seed=3)))
        assert len(proofs) == 2
    one, two = found
    np.testing.assert_array_equal(one.phases, two.phases)
    assert (one.energy, one.lower_bound) == (two.energy, two.lower_bound)
    assert one.status is two.status is Status.CERTIFIED


def test_a_search_shows_its_fields_before_the_bound_is_proved(monkeypatch):
    shown, is_shown, prove = [], threading.Event(), staircase.prove

    def prove_late(*arguments):
        assert is_shown.wait(60)
        return prove(*arguments)

    def show(solution):
        shown.append(solution)
        if len(shown) > 1:
            is_shown.set()

    monkeypatch.setattr(workers, "WORKERS", 2)
    monkeypatch.setattr(staircase, "prove", prove_late)
    found = solve(direction_problem(bumpy_torus(24), 4), show=show)
    assert [one.lower_bound for one in shown[:2]] == [0, 0] and shown[1].energy < shown[0].energy
    assert shown[-1].lower_bound == pytest.approx(found.lower_bound) and found.certificate is Certificate.PROVED


@pytest.mark.parametrize("end", ["found", "cancelled between parts"])
def test_no_thread_outlives_the_solve_that_it_works_for(monkeypatch, end):
    """Blender allows threads only where they are joined before its own goes on; a factorization ends by itself."""
    monkeypatch.setattr(workers, "WORKERS", 2)
    monkeypatch.setattr(products, "WORTH_SHARING", 1)
    monkeypatch.setattr(rounding, "WORTH_SHARING", 1)
    before, seen = set(threading.enumerate()), set()

    def callback(stage, fraction):
        seen.update(threading.enumerate())
        return end == "found" or fraction < 0.6

    try:
        solve(direction_problem(bumpy_torus(24), 2), Options(), callback)
        assert end == "found"
    except Cancelled:
        assert end != "found"
    assert any(thread.name.startswith("synch_fields") for thread in seen)
    left = set(threading.enumerate()) - before
    assert not [thread for thread in left if thread.name.startswith("synch_fields")]
    for thread in left:
        thread.join(60)
    assert set(threading.enumerate()) - before == set() and (end != "found" or not left)


def test_a_pool_serves_several_solves_and_ends_with_the_last(monkeypatch):
    monkeypatch.setattr(workers, "WORKERS", 2)

    def threads():
        return [thread for thread in threading.enumerate() if thread.name.startswith("synch_fields")]

    with workers.solving():
        with workers.solving():
            assert workers.pool.map(lambda part: part + 1, range(5)) == [1, 2, 3, 4, 5]
        assert threads()
    assert not threads() and workers.pool.map(lambda part: part + 1, range(5)) == [1, 2, 3, 4, 5] and not threads()
