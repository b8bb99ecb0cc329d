# SPDX-License-Identifier: GPL-3.0-or-later
"""The queue of jobs of the window: the first one runs, the others wait for their turn."""

import math
import time

import bpy

from ...core.errors import Cancelled, SynchError
from ...core.monitor import seconds_left
from ..blender.objects import ObjectLink
from ..blender.timers import Timer
from ..blender.translations import translate
from ..settings.preferences import memory_limit
from .job import READING, solves_after_pieces
from .worker import Worker, WorkerGone

# Most that the time of one job counts, as a factor of what was expected.
_FAR = 10.0
# Seconds up to which the first work of a kind says little about longer ones.
_SOON = 1.0
# Most of what is left that the bar shows as done before the next report.
_GUESSED = 0.6
# Letters of a stage that fit into the progress bar beside a time, and seconds from which on times are in minutes.
_SHORT, _MINUTES = 12, 100
# Stages of the solver in the words of an artist.
_WORDS = {
    "relaxation": "searching",
    "spectral relaxation": "searching",
    "continuation": "searching",
    "descent": "improving",
    "polish": "improving",
    "diffusion": "improving",
}
# Seconds after its last job at which the child ends, and between two looks.
_IDLE, _LOOK = 300.0, 30.0


class Work:
    """A job in the queue.

    Attributes
    ----------
    job : see :mod:`.job`
    label : its name in the window
    stage, fraction : stage of the work, and share of the work that is done
    picture : the best result so far as a picture, None before the first
    is_seen : whether a view has been drawn with the picture
    is_kept : whether the solve was asked to end with that result
    result : result of the solve
    peak : largest memory of the solve in MB, None if unknown
    error : the exception that stopped it, or None
    waited : seconds before it began
    expected : seconds that it usually takes in all, None if unknown
    is_quiet : whether the window does not mention it
    is_over : whether it has ended, with a result or an error
    let_go : callable that gives back the window's timer and status line; it may be called more than once
    """

    # By labels, how many times as long as expected such work has taken on this machine.
    _paces: dict[str, float] = {}

    def __init__(self, job, label, is_quiet=False):
        self.job, self.label, self.is_quiet = job, label, is_quiet
        self.stage, self.fraction, self.picture, self.error, self.result, self.peak = "", 0.0, None, None, None, None
        self.is_over = self.has_begun = self.is_seen = self.is_kept = False
        self.let_go = lambda: None
        self.expected, self._estimate = None, None
        self._share, self._reported = 0.0, (0.0, 0.0)
        self.holds_window = hasattr(job, "advance")
        self._start, self.waited = time.monotonic(), 0.0

    def begin(self):
        """Note that its turn has come."""
        now = time.monotonic()
        self.has_begun, self.waited, self._start = True, now - self._start, now
        if hasattr(self.job, "seconds"):
            self._expect(self.job.seconds)

    def advance(self):
        """Run the job's steps in Blender within the time budget; an error ends the work."""
        end = time.monotonic() + self.job.at_once
        try:
            while (piece := self.job.advance()) is not None and time.monotonic() < end:
                pass
        except BaseException as error:  # the caller that waits for the work reports it
            self.fail(error)
            return
        if piece is not None:
            self.stage, self.fraction = piece[0], piece[1] * (READING if self.solves else 1.0)
            return
        self.holds_window = False
        self.is_over = not self.solves
        if self.is_over:
            self._learn()

    @property
    def obj(self):
        """The object that the job is for, None where there is none, or no longer."""
        return None if self.job.link is None else self.job.link.present

    @property
    def age(self):
        """Seconds since its turn came."""
        return time.monotonic() - self._start if self.has_begun else 0.0

    @property
    def solves(self):
        """Whether it solves after its pieces, if it has any."""
        return not hasattr(self.job, "advance") or solves_after_pieces(self.job)

    @property
    def can_be_kept(self):
        """Whether there is a result to end with, and nobody has asked for that yet."""
        return self.shows_result and not (self.is_kept or self.is_over)

    @property
    def shows_result(self):
        """Whether the picture is of a result, and not a glimpse."""
        return self.picture is not None and getattr(self.picture, "is_result", True)

    def hear(self, word, *rest):
        """Handle a message of the worker."""
        if word == "progress":
            stage, fraction = rest
            start = READING if hasattr(self.job, "advance") else 0.0
            self.stage, self.fraction = stage, start + (1 - start) * fraction
        elif word == "expect":
            self._expect(*rest)
        elif word == "shown":
            (self.picture,) = rest
        elif word == "done":
            self.result, self.peak = rest
            self.is_over = True
            self._learn()
        elif word == "failed":
            self.fail(rest[0])
        else:
            self.fail(RuntimeError(f"in the process that solves:\n{rest[0]}"))

    def fail(self, error):
        """End it with an error."""
        self.error, self.is_over, self.picture, self.holds_window = error, True, None, False

    def _expect(self, seconds):
        """Note how long it usually takes from now on."""
        self._estimate = self.age, seconds
        self.expected = self.age + self.seconds_here(self.label, seconds)

    @classmethod
    def seconds_here(cls, label, seconds):
        """Seconds on this machine of work that is estimated at ``seconds`` on one core, as learned for its label."""
        return seconds * cls._paces.get(_kind(label), 1.0)

    def _learn(self):
        """Note at its end how long such work takes on this machine."""
        if self._estimate is not None and not self.is_kept:
            begun, seconds = self._estimate
            measured = min(max((self.age - begun) / seconds, 1 / _FAR), _FAR)
            kind = _kind(self.label)
            before = self._paces.get(kind, measured if seconds > _SOON else 1.0)
            self._paces[kind] = math.sqrt(before * measured)

    @property
    def share(self):
        """Share of the work that is done, as far as it is known.

        Between two reports it grows with time, by a part of what is left, and the slower the longer nothing is
        reported. A report that says that much more time is left than was expected lets it fall back.
        """
        age = self.age
        share, since = self._reported
        if self.fraction != share:
            share, since = self._reported = self.fraction, age
            left = self._left_after(share, since)
            if left and age > 0:
                self._share = max(share, min(self._share, age / (age + left)))
        if self.expected:
            rest = max(self._left_after(share, since), self.expected / _FAR, age - since)
            share += _GUESSED * (1 - share) * -math.expm1((since - age) / rest)
        self._share = max(self._share, share)
        return self._share

    def _left_after(self, share, since):
        """Seconds left at a report of a share that is done, at an age ``since``: by the expected time or, if more, by
        the pace until then; None if unknown."""
        left = self._estimate_left(since, share)
        return left if left is None or not self.expected else max(left, self.expected - since)

    @property
    def line(self):
        """How far it is, for the status bar."""
        return f"{self.share:.0%}  {self._doing}"

    @property
    def short_line(self):
        """How far it is, for the progress bar: the seconds left, or what it does and for how long."""
        left, stage = self._left, self._doing
        text = f"{stage}, {as_time(self.age)}"
        if left is not None:
            text = translate("about {left} left", left=as_time(left))
            text = f"{stage}, {text}" if len(stage) <= _SHORT else text
        return f"{self.share:.0%}  {text}" if self.has_begun else self.line

    @property
    def _doing(self):
        """The stage in an artist's words, without the figures that the solver adds behind a comma; of an animation
        with its frame, as in "Frame 6: improving"."""
        stage = (self.stage or ("starting" if self.has_begun else "waiting")).partition(",")[0]
        frame, _, name = stage.rpartition(": ")
        name = translate(_WORDS.get(name, name))
        return f"{translate('Frame')} {frame.removeprefix('frame ')}: {name}" if frame else name

    @property
    def _left(self):
        """Seconds left, where they can be estimated, and at least one."""
        left = self._estimate_left(self.age, self.fraction)
        return left if left is not None and left >= 1 else None

    def _estimate_left(self, age, fraction):
        """Seconds left at an age; what passed before the expected time was known, such as the start of the process,
        says nothing about the pace."""
        begun = 0.0 if self._estimate is None else self._estimate[0]
        expected = None if self.expected is None else self.expected - begun
        return seconds_left(max(age - begun, 0.0), fraction, expected)

    @property
    def times(self):
        """Seconds that have passed, and about how many are left, where they can be estimated."""
        passed, left = as_time(self.age), self._left
        return passed if left is None else f"{passed}, {translate('about {left} left', left=as_time(left))}"


def _kind(label):
    """Label of the work that takes as long: a quad mesh takes as long again."""
    return label.removesuffix(" Again")


def as_time(seconds):
    """A number of seconds as a person says it."""
    return f"{seconds:.0f} s" if seconds < _MINUTES else f"{seconds / 60:.0f} min"


class Queue:
    """The jobs that wait or run, and the worker that solves them one after the other."""

    def __init__(self):
        self.works: list[Work] = []
        self._worker, self._asked, self._last = None, None, 0.0

    @property
    def running(self):
        """The work whose turn it is, or None."""
        return self.works[0] if self.works else None

    def add(self, job, label, is_quiet=False):
        """Put a job at the end of the queue; returns its :class:`Work`.

        The window does not mention a quiet one, which ends soon. Raises SynchError if the queue has a job of the same
        object.
        """
        if job.link is not None and self.holds(job.link):
            raise SynchError(f"{job.link.name} is being solved: wait for it, or cancel it")
        work = Work(job, label, is_quiet)
        self.works.append(work)
        if not work.holds_window:
            self.advance()
        return work

    def holds(self, obj):
        """Whether a job for an object, or what a link leads to, runs or waits; for None, one for no object."""
        number = None if obj is None else obj.number if isinstance(obj, ObjectLink) else obj.session_uid
        heard = [work for work in self.works if not work.is_quiet]
        return number in [None if work.job.link is None else work.job.link.number for work in heard]

    @property
    def holds_window(self):
        """Whether a job runs that needs Blender's data to stay as they are."""
        return self.running is not None and self.running.holds_window

    def advance(self):
        """Run some steps of the job in Blender, or read the messages of the worker."""
        work = self.running
        if work is None:
            return
        if not work.has_begun:
            work.begin()
        if work.holds_window:
            work.advance()
        elif not work.is_over:
            self._solve(work)
        if work.is_over:
            self._next(work)

    def cancel(self, work):
        """End a job, whatever it is doing, without writing."""
        work.fail(Cancelled("cancelled: nothing was changed"))
        if hasattr(work.job, "close"):
            work.job.close()
        if self._asked is work:
            self._end_worker()
        work.let_go()
        if work in self.works:
            self._next(work)

    def keep(self, work):
        """Take the result whose picture a job shows for the whole one."""
        if self._asked is work and work.can_be_kept:
            work.is_kept = True
            self._worker.tell(("keep",))

    def end(self, work):
        """Ask the worker to end a job; unlike :meth:`cancel`, this keeps the worker, and takes until it reads the
        message."""
        if self._asked is work:
            self._worker.tell(("end",))

    def stop(self):
        """End all jobs, and the worker: the file is being closed, or the add-on disabled."""
        for work in reversed(self.works.copy()):
            self.cancel(work)
        self._end_worker()

    def end_when_idle(self):
        """End a worker that has long had nothing to do; returns the seconds to the next look."""
        if not self.works and time.monotonic() > self._last + _IDLE:
            self._end_worker()
        return _LOOK

    def _solve(self, work):
        """Send a work to the child if it is not there yet, then handle the child's messages; errors end the work."""
        try:
            if self._asked is not work:
                limit = memory_limit()
                if self._worker is not None and not (self._worker.is_alive and self._worker.limit == limit):
                    self._end_worker()
                if self._worker is None:
                    self._worker = Worker(limit)
                self._asked = work
                self._worker.ask(work.job.request)
            for message in self._worker.exchange():
                work.hear(*message)
        except WorkerGone as error:
            self._worker = None
            work.fail(error)
        except MemoryError:
            self._end_worker()
            work.fail(
                SynchError("there is not enough memory for the result: use a coarser mesh, or close other programs")
            )
        except Exception as error:  # the caller that waits for the work reports it
            self._end_worker()
            work.fail(error)

    def _next(self, work):
        self.works.remove(work)
        self._asked = None if self._asked is work else self._asked
        self._last = time.monotonic()
        if self.running is not None:
            self.advance()

    def _end_worker(self):
        if self._worker is not None:
            self._worker.end()
        self._worker = self._asked = None


queue = Queue()


@bpy.app.handlers.persistent
def _stop(*_):
    """Another file is about to be opened: what runs is of no use any more."""
    queue.stop()


_timer = Timer(queue.end_when_idle, first=_LOOK, is_persistent=True)


def register():
    bpy.app.handlers.load_pre.append(_stop)
    _timer.start()


def unregister():
    queue.stop()
    _timer.stop()
    bpy.app.handlers.load_pre.remove(_stop)
