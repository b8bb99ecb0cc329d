# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The child that solves: kept, replaced, ended, and whatever happens to it told in one line."""

import os
import re
import signal
import time
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.jobs import queue as queue_module
from synch_fields.synch_addon.jobs.queue import Work, queue
from synch_fields.synch_addon.jobs.worker import Worker, WorkerGone
from synch_fields.synch_addon.patterns.job import FieldJob

from ..event_loop import begun
from ..scenes import snapshot, sphere
from .striping import Stripes, child, in_work, is_alive


@pytest.fixture
def own_child(blender):
    """The test has a child that no other test has."""
    queue.stop()
    yield
    queue.stop()


def ready_worker():
    """A worker of its own whose child has begun."""
    worker = Worker(2**33)
    while not worker.is_ready:
        worker.exchange()
        time.sleep(0.01)
    return worker


def test_a_child_that_cannot_be_started_gives_one_line(own_child, monkeypatch):
    monkeypatch.setattr("synch_fields.synch_addon.jobs.worker._python", lambda: ["/nowhere/python"])
    sphere()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"CANCELLED"}
    assert operator.reports == [
        ({"ERROR"}, "Icosphere: the process that solves cannot be started: /nowhere/python: No such file or directory")
    ]


def test_a_job_tells_from_the_beginning_how_long_it_takes_and_learns_how_long_it_took(monkeypatch):
    sphere()
    loop, operator = begun(Stripes())
    work = queue.running
    loop.run(operator, lambda: work.expected is not None)
    assert work.fraction < 0.1 and re.fullmatch(r"\d+ s(, about \d+ s left)?", work.times)
    work.expected = work.age + 60.0
    work.fraction = work._share = 0.0
    work._reported = 0.0, work.age  # just now
    assert re.fullmatch(r"\d+ s, about (59|60) s left", work.times)
    assert re.fullmatch(r"\d%  [a-z ]+, about (59|60) s left", work.short_line)
    work.stage = "relaxation"
    assert "searching" in work.short_line and "relaxation" not in work.line
    work.stage = "continuation, gap 46%"  # a riddle to artists
    assert "searching" in work.line and "gap" not in work.line + work.short_line
    work.stage = "frame 6: descent"
    assert "Frame 6: improving" in work.line
    work.expected, work.stage = None, "descent"
    assert re.fullmatch(r"\d%  [a-z ]+, \d+ s", work.short_line)
    work._estimate = work.age, 1e-3  # far less than it will take
    monkeypatch.setitem(Work._paces, work.label, 1.0)
    assert loop.run(operator) == {"FINISHED"}
    assert Work._paces[work.label] > 1.5


def test_the_start_of_the_process_says_nothing_about_the_pace(monkeypatch):
    """Four seconds until the process that solves is there, and then a fifth of ten seconds' work in two."""
    now = [100.0]
    monkeypatch.setattr(queue_module, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(Work, "_paces", {})
    work = Work(SimpleNamespace(link=None), "Quad Mesh")
    work.begin()
    now[0] = 104.0
    work.hear("expect", 10.0)
    now[0] = 106.0
    work.hear("progress", "building", 0.2)
    assert work.times == "6 s, about 8 s left"


def test_the_first_work_of_a_kind_teaches_how_long_the_next_one_takes(monkeypatch):
    """A mesh of quads that took five times as long as expected takes five times as long again."""
    now = [100.0]
    monkeypatch.setattr(queue_module, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(Work, "_paces", {})
    work = Work(SimpleNamespace(link=None), "Quad Mesh")
    work.begin()
    work.hear("expect", 12.0)
    now[0] += 60.0
    work.hear("done", None, None)
    assert Work.seconds_here("Quad Mesh Again", 10.0) == pytest.approx(50.0)
    assert Work.seconds_here("Stripes", 10.0) == 10.0


def test_the_bar_moves_steadily_between_two_reports(monkeypatch):
    """Where the work tells nothing for a while, as a factorization does, time goes on."""
    now = [100.0]
    monkeypatch.setattr(queue_module, "time", SimpleNamespace(monotonic=lambda: now[0]))
    work = Work(SimpleNamespace(link=None), "Layers")
    work.begin()
    work.expected = 10.0
    shares = []
    for seconds in np.arange(0.0, 10.01, 0.25):
        now[0] = 100 + seconds
        work.fraction = 0.05 if seconds < 1 else 0.2 if seconds < 4 else 0.5 if seconds < 8 else 0.9
        shares.append(work.share)
    steps = np.diff(shares)
    assert steps.min() > 0.002 and steps.max() < 0.27 and steps[:31].min() > 0.006
    assert shares[0] == 0.05 and 0.9 < shares[-1] < 1


def test_the_bar_falls_back_where_an_estimate_was_far_too_short(monkeypatch):
    """Work of 100 seconds that was expected to take two: the bar is never far ahead of the time."""
    now = [100.0]
    monkeypatch.setattr(queue_module, "time", SimpleNamespace(monotonic=lambda: now[0]))
    work = Work(SimpleNamespace(link=None), "Layers")
    work.begin()
    work.expected = 2.0
    ahead = []
    for seconds in np.arange(0.25, 100, 0.25):
        now[0] = 100 + seconds
        work.fraction = np.floor(seconds / 10) / 10  # a report every ten seconds
        ahead.append(work.share - seconds / 100)
    assert max(ahead) < 0.4 and max(ahead[40:]) < 0.32 and min(ahead) > -0.1


def test_a_result_that_memory_cannot_hold_gives_one_line(monkeypatch):
    def exchange(worker):
        raise MemoryError

    sphere()
    loop, operator = begun(Stripes())
    monkeypatch.setattr(Worker, "exchange", exchange)
    assert loop.run(operator) == {"CANCELLED"} and "not enough memory" in operator.reports[-1][1]


def test_the_child_stays_for_the_next_job_and_goes_when_it_is_idle(own_child, monkeypatch):
    sphere()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"FINISHED"}
    number = child()
    loop, operator = begun(Stripes(spacing=0.5))
    assert loop.run(operator) == {"FINISHED"} and child() == number
    queue.end_when_idle()
    assert is_alive(number)
    monkeypatch.setattr(queue_module, "_IDLE", 0.0)
    queue.end_when_idle()
    assert not is_alive(number) and queue._worker is None


def test_the_child_goes_behind_the_window_and_is_not_meant_by_its_ctrl_c():
    sphere()
    loop, operator = begun(Stripes())
    loop.run(operator, until=in_work)
    number = child()
    assert os.getsid(number) == os.getsid(0)  # niceness counts within a session
    assert os.getpriority(os.PRIO_PROCESS, number) > os.getpriority(os.PRIO_PROCESS, 0)
    assert os.getpgid(number) == number
    loop.send(operator, "ESC", "PRESS")


@pytest.mark.parametrize("when", ["at the start", "amid"])
def test_a_child_that_is_killed_gives_one_line_and_the_next_job_a_new_one(when):
    sphere(5)
    before = snapshot()
    loop, operator = begun(Stripes())
    if when == "amid":
        loop.run(operator, until=in_work)
    os.kill(child(), signal.SIGKILL)
    assert loop.run(operator) == {"CANCELLED"} and snapshot() == before and loop.free
    (report,) = operator.reports
    assert report == (
        {"ERROR"},
        "Icosphere: the process that solves has ended (signal 9): nothing was changed, run again",
    )
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"FINISHED"}


def test_a_limit_of_memory_gives_one_line(own_child, monkeypatch):
    monkeypatch.setattr(queue_module, "memory_limit", lambda: 200 * 2**20)
    sphere(6)
    before = snapshot()
    loop, operator = begun(Stripes(spacing=0.05))
    assert loop.run(operator) == {"CANCELLED"} and snapshot() == before
    assert operator.reports[-1][0] == {"ERROR"} and "more than 200 MB of memory" in operator.reports[-1][1]


@pytest.mark.parametrize("words", ["print('hello')", "import os; os.write(1, os.urandom(1 << 20))"])
def test_a_child_that_says_nonsense_gives_one_line(own_child, monkeypatch, words):
    program = f"{words}\nimport sys, time\nsys.stdout.flush()\ntime.sleep(20)\n"
    if "hello" in words:
        program = program.replace("time.sleep(20)", "sys.exit(3)")
    monkeypatch.setattr("synch_fields.synch_addon.jobs.worker._BEGIN", program)
    sphere()
    before = snapshot()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"CANCELLED"} and snapshot() == before
    (report,) = operator.reports
    assert report[0] == {"ERROR"} and ("status 3" in report[1] or "a broken message" in report[1])


def test_a_child_ends_when_its_parent_is_gone():
    worker = ready_worker()
    number = worker.number
    worker._child.stdin.close()
    end = time.monotonic() + 1
    while worker._child.poll() is None and time.monotonic() < end:
        time.sleep(0.01)
    assert worker._child.poll() == 0 and number
    worker._child.stdout.close()


@dataclass(frozen=True)
class Unreadable:
    """A request that the child cannot read: it has no tests."""

    shared = ()


class ReadByMainThread:
    """A spacing that no other thread of the child can read."""

    def __reduce__(self):
        own = "__import__('threading').current_thread() is __import__('threading').main_thread()"
        return eval, (f"{{True: 0.4}}[{own}]",)


def asked_for(request, monkeypatch):
    """The operator of a job with another request, begun in a loop."""
    sphere()
    operator = Stripes()
    make = operator._job

    def job_of(context):
        job = make(context)
        job.request = request
        return job

    monkeypatch.setattr(operator, "_job", job_of)
    return begun(operator)


def test_a_fault_in_the_child_is_told_with_its_place(monkeypatch):
    broken = replace(FieldJob("stripes", sphere(), SurfaceSettings(spacing=0.4)).request, spacings="wide")
    loop, operator = asked_for(broken, monkeypatch)
    with pytest.raises(RuntimeError, match=r"(?s)in the process that solves:.*Traceback.*ValueError"):
        loop.run(operator)
    assert queue.running is None and loop.free


def test_a_request_that_cannot_be_read_gives_one_line(monkeypatch):
    loop, operator = asked_for(Unreadable(), monkeypatch)
    number = child()
    assert loop.run(operator) == {"CANCELLED"} and not is_alive(number)
    assert operator.reports == [
        ({"ERROR"}, "Icosphere: the process that solves could not read what it was asked: nothing was changed")
    ]


def test_requests_are_read_by_the_thread_that_loads_modules(monkeypatch):
    """Two threads that import at once may wait for one another."""
    request = FieldJob("stripes", sphere(), SurfaceSettings(spacing=0.4)).request
    loop, operator = asked_for(replace(request, spacings=ReadByMainThread()), monkeypatch)
    assert loop.run(operator) == {"FINISHED"}


def test_a_child_that_has_died_meanwhile_is_replaced():
    sphere()
    loop, operator = begun(Stripes())
    assert loop.run(operator) == {"FINISHED"}
    number = child()
    os.kill(number, signal.SIGKILL)
    time.sleep(0.1)
    loop, operator = begun(Stripes(spacing=0.5))
    assert loop.run(operator) == {"FINISHED"} and child() != number


def test_what_came_before_the_end_of_the_child_counts(monkeypatch):
    """A result that was read in the same look as the closed pipe is a result."""
    worker = ready_worker()
    worker.ask(FieldJob("directions", sphere(), SurfaceSettings()).request)
    while worker._outgoing:
        worker.exchange()
    worker._child.stdin.close()
    worker._child.wait()  # it ends when its pipe does, perhaps in the middle
    messages = []
    with pytest.raises(WorkerGone):
        while True:
            messages += worker.exchange()
    assert all(message[0] in ("expect", "progress", "done") for message in messages)


def test_megabytes_are_handed_over_in_few_looks():
    """Between two ticks of the window's timer pipes are emptied and filled as fast as the child is."""
    worker = ready_worker()
    request = FieldJob("directions", sphere(), SurfaceSettings()).request
    request = replace(request, source=replace(request.source, turns=np.zeros(4_000_000)))
    worker.ask(request)
    ticks = 0
    while worker._outgoing:
        worker.exchange()
        ticks += 1
    worker.end()
    assert ticks <= 20  # 32 MB: at 50 ms a tick each moves more than a megabyte, at 64 KB a tick it would be 500
