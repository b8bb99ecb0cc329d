# SPDX-License-Identifier: GPL-3.0-or-later
"""A solve in a thread of its own, so that the window stays alive."""

import threading
import time

import bpy

from ...core.errors import Cancelled, SynchError
from ..blender.translations import said

# Share of the work after which its time can be told.
_TELLING = 0.15
# Of the threads.
_NAME = "synch"
# Vertices from which on a first, spectral result is worth its time, a fifth to a third of all; and that share.
EARLY_FROM, EARLY_SHARE = 20_000, 0.25
# The job that the window is waiting for, or None: the panel shows its progress.
running = None


def stop():
    """End the running job, if there is one, without writing: the add-on is being taken out."""
    global running
    work, running = running, None
    if work is not None:
        work.cancel()
        work.give_back()
    for thread in threading.enumerate():
        if thread.name == _NAME:  # those that were cancelled, too: their code goes
            thread.join()


@bpy.app.handlers.persistent
def _cancel(*_):
    """Another file is about to be opened: the running job is of no use any more."""
    if running is not None:
        running.cancel()


def register():
    bpy.app.handlers.load_pre.append(_cancel)


def unregister():
    bpy.app.handlers.load_pre.remove(_cancel)
    stop()


class _Work:
    """A job that the window waits for.

    Attributes
    ----------
    stage, fraction : how far it is
    early : a first result, as soon as there is one
    error : what stopped it, or None
    """

    def __init__(self, job):
        self.job = job
        self.stage, self.fraction, self.error, self.early = "", 0.0, None, None
        self._start = time.monotonic()
        self._cancelled = threading.Event()
        self._taken = None

    def take(self, context):
        """Take a timer, the progress cursor and the status bar's line of a window, until :meth:`give_back`."""
        manager = context.window_manager
        manager.progress_begin(0, 1)
        self._taken = manager, context.workspace, manager.event_timer_add(0.1, window=context.window)

    def show(self, text):
        """Put a line into the status bar that was taken, or give it back, and redraw the panels."""
        manager, workspace, _ = self._taken
        if workspace is not None:
            workspace.status_text_set(text)
        manager.progress_update(self.fraction)
        for window in manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()

    def give_back(self):
        """Give back what was taken of the window, where anything was."""
        if self._taken is not None:
            manager, _, timer = self._taken
            manager.event_timer_remove(timer)
            self.show(None)
            manager.progress_end()
            self._taken = None

    def cancel(self):
        """Ask it to stop; nobody has to wait for that."""
        self._cancelled.set()

    def _next_piece(self):
        """Do a piece of the job in this thread; returns whether there was one. What goes wrong is the error."""
        try:
            piece = self.job.advance()
        except BaseException as error:  # handed to the operator, as that of a thread
            piece, self.error = None, error
        if piece is not None:
            self.stage, self.fraction = piece
        return piece is not None

    @property
    def cancelled(self):
        """Whether it was asked to stop."""
        return self._cancelled.is_set()

    @property
    def line(self):
        """How far it is, for the progress bar."""
        name, comma, rest = (self.stage or "starting").partition(",")
        return f"{self.fraction:.0%}  {said(name)}{comma}{rest}"

    @property
    def times(self):
        """Seconds that have passed, and about how many are left, once that can be told."""
        passed = time.monotonic() - self._start
        if self.fraction <= _TELLING:
            return said("{passed:.0f} s", passed=passed)
        left = passed * (1 / self.fraction - 1)
        return said("{passed:.0f} s, about {left:.0f} s left", passed=passed, left=left)


class BackgroundSolve(_Work):
    """Solves a :class:`FieldJob` in a thread, which touches no Blender data.

    A large one that has ``solve_early`` gives its first result as ``early``.
    """

    def __init__(self, job):
        super().__init__(job)
        self._thread = threading.Thread(target=self._run, name=_NAME, daemon=True)
        self._begin()

    def _begin(self):
        self._thread.start()

    def _run(self):
        try:
            self.job.solve(self._after_early())
        except BaseException as error:  # handed to the window's thread
            self.error = error
        if self._cancelled.is_set() and self.error is None:
            self.error = Cancelled("cancelled: nothing was changed")

    def _after_early(self):
        """Make a first result where that pays; returns the callback for what is left to be done."""
        if getattr(self.job, "vertex_count", 0) < EARLY_FROM:
            return self._callback
        try:
            self.early = self.job.solve_early(portion(self._callback, 0.0, EARLY_SHARE))
        except Cancelled:
            raise
        except SynchError:  # what is wrong is told by the solve itself
            return self._callback
        return portion(self._callback, EARLY_SHARE, 1 - EARLY_SHARE)

    def _callback(self, stage, fraction):
        self.stage, self.fraction = stage, fraction
        return not self._cancelled.is_set()

    def advance(self):
        """Nothing: the thread goes on by itself."""

    @property
    def finished(self):
        """Whether the thread has ended."""
        return not self._thread.is_alive()

    def wait(self):
        """Until the thread has ended."""
        self._thread.join()


class Pieces(_Work):
    """Does a job in the window's own thread, one piece at each tick of its timer, because it needs Blender's data.

    The job has ``advance``, see :meth:`bake.BakeJob.advance`, and ``close``.
    """

    def __init__(self, job):
        super().__init__(job)
        self.finished = False

    def advance(self):
        """Do the next piece."""
        self.finished = not self._next_piece()

    def cancel(self):
        """Stop it between two pieces, and leave no trace of it."""
        super().cancel()
        self.job.close()


class ReadAndSolve(BackgroundSolve):
    """Reads in pieces in the window's own thread, as :class:`Pieces`, and solves in another when all is read."""

    def _begin(self):
        """Nothing yet."""

    def advance(self):
        """Read the next piece, or begin to solve."""
        if not self._is_begun and not self._next_piece() and self.error is None:
            self._thread.start()

    @property
    def finished(self):
        """Whether the thread has ended, or reading has failed."""
        return (self._is_begun or self.error is not None) and super().finished

    @property
    def _is_begun(self):
        return self._thread.ident is not None


def portion(callback, start, share):
    """A callback for a part of the whole work."""
    if callback is None:
        return None
    return lambda stage, fraction: callback(stage, start + share * fraction)
