# SPDX-License-Identifier: GPL-3.0-or-later
"""All cores for one solve: NumPy and SciPy release the interpreter's lock, so that threads can share the work."""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from queue import Empty, SimpleQueue
from typing import TypeVar, cast

from ..monitor import POLL_SECONDS, Monitor, OutOfTime
from ..threads import FIRST_EXCEPTION, Event, Future, Lock, Thread, ThreadPoolExecutor, local, start_thread, wait
from .blas import one_blas_thread

Part = TypeVar("Part")
Result = TypeVar("Result")
# What threads do next; None ends one.
_Queue = SimpleQueue[Callable[[], None] | None]

MOST_WORKERS = 8
WORKERS = min(int(os.environ.get("SYNCH_THREADS") or os.cpu_count() or 1), MOST_WORKERS)

_thread = local()


def idle_workers() -> int:
    """Count the threads that work started here may use; inside shared work, a part of them."""
    share: _Share | None = getattr(_thread, "share", None)
    return WORKERS if share is None else share.workers


class _Share:
    """The threads for each of some parts of shared work: more of them when only a few parts are left.

    Which threads compute something must not change it: shared work is split into the same parts for any number, or
    by rows that do not depend on one another.
    """

    def __init__(self, total: int, parts: int, at_once: int) -> None:
        self._total, self._left, self._at_once, self._lock = total, parts, at_once, Lock()

    @property
    def workers(self) -> int:
        """Count the threads for a part."""
        return self._total // max(min(self._left, self._at_once), 1)

    def end_part(self) -> None:
        """Share the threads of a part that has ended among the remaining ones."""
        with self._lock:
            self._left -= 1


_ALONE = _Share(1, 1, 1)


class _Pool:
    """Threads for short work that never waits; they end with the last solve inside.

    Queues hand out parts in half the time of ``concurrent.futures``, and the calling thread takes what no other has
    begun, as waking one can take longer than a part.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Reset in a forked process, which does not inherit threads."""
        self._lock, self._inside = Lock(), 0
        self._waiting: _Queue = SimpleQueue()
        self._threads: list[Thread] = []

    def __enter__(self) -> None:
        with self._lock:
            self._inside += 1

    def __exit__(self, *_error: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside:
                return
            ended, waiting = self._threads, self._waiting
            self._threads, self._waiting = [], SimpleQueue()
        for _ in ended:
            waiting.put(None)
        for thread in ended:
            thread.join()

    def _enter_running(self) -> _Queue | None:
        """Enter and return the queue of the threads, which are started if need be; None if no solve is inside."""
        with self._lock:
            if not self._inside or WORKERS == 1:
                return None
            self._inside += 1
            if not self._threads:
                self._threads = [
                    start_thread(self._work, self._waiting, name="synch_fields") for _ in range(WORKERS - 1)
                ]
            return self._waiting

    @staticmethod
    def _work(waiting: _Queue) -> None:
        for task in iter(waiting.get, None):
            task()

    def map(self, work: Callable[[Part], Result], parts: Iterable[Part]) -> list[Result]:
        """Compute [work(part) for part in parts], in threads and the calling one if a solve is inside."""
        parts = list(parts)
        waiting = self._enter_running() if len(parts) > 1 else None
        if waiting is None:
            return [work(part) for part in parts]
        results: list[Result | None] = [None] * len(parts)
        ended: SimpleQueue[BaseException | None] = SimpleQueue()

        def run(number: int) -> None:
            before, _thread.share = getattr(_thread, "share", None), _ALONE
            try:
                results[number] = work(parts[number])
                ended.put(None)
            except BaseException as error:  # raised again by the calling thread
                ended.put(error)
            finally:
                _thread.share = before

        for number in range(1, len(parts)):
            waiting.put(partial(run, number))
        try:
            try:
                results[0] = work(parts[0])
            finally:
                with suppress(Empty):
                    while True:
                        cast(Callable[[], None], waiting.get_nowait())()  # threads are only ended when all have left
                errors = [ended.get() for _ in parts[1:]]
        finally:
            self.__exit__()
        for error in errors:
            if error is not None:
                raise error
        return cast(list[Result], results)


pool = _Pool()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=pool.forget)


@contextmanager
def solving() -> Iterator[None]:
    """Context of a solve: BLAS has one thread, and the threads that share the work end with it."""
    with one_blas_thread(), pool:
        yield


@contextmanager
def beside(work: Callable[[], Result]) -> Iterator[Callable[[], Result]]:
    """Run ``work()`` in its own thread during a ``with`` block, if more than one thread may be used.

    Yields a function that returns the result, for which it waits; with one thread it computes it when it is called. The
    block ends after the work.
    """
    if idle_workers() == 1:
        yield work
    else:
        with ThreadPoolExecutor(1, thread_name_prefix="synch_fields") as executor:
            yield executor.submit(work).result


class _Follower(Monitor):
    """The monitor of threads that work while the calling thread checks its own."""

    def __init__(self) -> None:
        super().__init__()
        self._stopped = Event()

    def stop(self) -> None:
        self._stopped.set()

    def check(self) -> None:
        if self._stopped.is_set():
            raise OutOfTime


def share_out(
    work: Callable[[Part, Monitor], Result], parts: Sequence[Part], monitor: Monitor, at_once: int = MOST_WORKERS
) -> list[Result]:
    """Compute [work(part, monitor) for part in parts] on all cores, at most ``at_once`` parts at a time.

    Only the calling thread calls the callback of the given monitor. ``work`` has to check its own monitor often, which
    raises :class:`OutOfTime` when the caller is stopped or another part fails. When the time limit passes, work may
    return its best result instead.
    """
    idle = idle_workers()
    threads = min(idle, len(parts), at_once)
    if threads <= 1:
        return [work(part, monitor) for part in parts]
    follower, share = _Follower(), _Share(idle, len(parts), threads)

    def alone(part: Part) -> Result:
        _thread.share = share
        try:
            return work(part, follower)
        finally:
            share.end_part()

    executor = ThreadPoolExecutor(threads)
    running = [executor.submit(alone, part) for part in parts]
    try:
        while not _wait_for_all(running):
            monitor.check()
    except OutOfTime:
        follower.stop()
        wait(running)
    finally:
        follower.stop()
        executor.shutdown(cancel_futures=True)
    return [future.result() for future in running]


def _wait_for_all(running: Sequence[Future[Result]]) -> bool:
    """Wait a moment and return whether all are done; raises the error of one that failed."""
    done, waiting = wait(running, POLL_SECONDS, FIRST_EXCEPTION)
    for future in done:
        future.result()
    return not waiting
