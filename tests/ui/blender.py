# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender with a window, driven as a user does it: read by its texts, clicked, typed at.

Tests name labels in English; they are looked for in the window's language.
Places are pixels of the window, x to the right and y up from the bottom left, as Blender's events count.
"""

import json
import os
import shlex
import shutil
import signal
import subprocess
import time
from functools import cache
from pathlib import Path

import numpy as np

from . import reading
from .screen import write_png

# How many times as long all takes where other work has the processors; seconds after which what is waited for counts as
# missing, and that an event needs to reach the window.
SLOWER = max(1.0, os.getloadavg()[1] / os.cpu_count())
PATIENCE = round(300 * SLOWER)
SETTLING = 0.3
# Mean difference of bytes up to which two pictures are the same: samples are still added to what is rendered.
_SAME = 0.2
# Points of the interface's font.
_POINTS = 11


class Blender:
    """Blender in a window that fills a screen.

    Parameters
    ----------
    command : what starts Blender, as a shell would split it
    screen : Screen
    folder : Path, empty; the user's own, and the way to the Blender inside

    Attributes
    ----------
    log : Path, what Blender prints
    """

    def __init__(self, command, screen, folder):
        self.screen, self.folder = screen, folder
        self._template, self._mouse = cache(self._drawn), [0, 0]
        width, height = screen.size
        environment = {
            **os.environ,
            "DISPLAY": screen.name,
            "HOME": str(folder),
            "XDG_RUNTIME_DIR": str(folder),
            "BLENDER_USER_RESOURCES": str(folder / "user"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "SYNCH_UI_FOLDER": str(folder),
        }
        environment.pop("PYTHONPATH", None)  # the extension is tested, not the checkout
        inside = shutil.copy(Path(__file__).with_name("inside.py"), folder)
        arguments = ["--factory-startup", "--gpu-backend", "opengl", "--enable-event-simulate"]
        arguments += ["--window-geometry", "0", "0", str(width), str(height), "--python", inside]
        self.log = folder / "blender.log"
        with self.log.open("wb") as log:
            self._process = subprocess.Popen(
                [*shlex.split(command), *arguments], env=environment, stdout=log, stderr=log
            )
        self.run("")

    def run(self, source):
        """Execute Python inside; returns what it leaves in ``answer``, which JSON can hold."""
        command, answer = self.folder / "command", self.folder / "answer"
        (self.folder / "command.part").write_text(source)
        (self.folder / "command.part").rename(command)
        end = time.monotonic() + PATIENCE
        while not answer.exists():
            if self._process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"Blender does not answer: {self.log.read_text()[-2000:]}")
            time.sleep(0.01)
        result = json.loads(answer.read_text())
        answer.unlink()
        if "error" in result:
            raise RuntimeError(result["error"])
        return result["answer"]

    def value(self, expression):
        """A Python expression's value inside."""
        return self.run(f"answer = {expression}")

    def until(self, expression):
        """Wait for a Python expression to be true inside; returns its value."""
        return self._until(lambda: self.value(expression), expression)

    def region(self, kind="UI"):
        """x, y, width and height of a region of the 3D view: the sidebar UI, the view WINDOW, HEADER ..."""
        return self.value(f"region({kind!r})")

    def picture(self, kind=None):
        """What the screen, or a region of the 3D view, shows: (height, width, 3) bytes, first row on top.

        Of the view itself, WINDOW, only what the sidebar does not cover.
        """
        picture = self.screen.picture()
        if kind is None:
            return picture
        x, y, width, height = self.region(kind)
        if kind == "WINDOW" and self.region("UI")[2] > 1:
            width = self.region("UI")[0] - x
        top = self.screen.size[1] - y - height
        return picture[top : top + height, x : x + width]

    def places(self, text, kind="UI", tab=False):
        """Where a region shows a text, (k, 2) middles, the topmost first; the names of tabs are read downwards."""
        x, y, _, height = self.region(kind)
        found = self._places(self.picture(kind), text, tab)
        return found[found[:, 1].argsort(kind="stable")] * (1, -1) + (x, y + height)

    def shows(self, text, kind="UI"):
        """Whether a region shows a text."""
        return self.reads(self.picture(kind), text)

    def reads(self, picture, text):
        """Whether a picture shows a text."""
        return len(self._places(picture, text)) > 0

    def says(self, text, **parts):
        """A text with parts in braces as the extension puts it together, in the window's language."""
        return self.value(f"part('blender.translations').translate({text!r}, **{parts!r})")

    def counts(self, count, noun):
        """Such as "2 line ends", in the window's language."""
        return self.value(f"part('blender.translations').translate_count({count}, {noun!r})")

    def wait_for(self, text, kind="UI", tab=False, last=False):
        """Wait for a region to show a text; returns its middle, the topmost or the last if there are several."""
        return self._until(lambda: self.places(text, kind, tab), f"the text {text!r}")[-1 if last else 0]

    def click(self, place, kind="UI", tab=False, last=False):
        """Click on a text of a region, the topmost or the last, or at x, y."""
        self.move(self.wait_for(place, kind, tab, last) if isinstance(place, str) else place)
        self.press("LEFTMOUSE")

    def wait_to_see(self, condition, kind, still=0.0):
        """Wait for the picture of a region, which is drawn again and again, to fulfil a condition; returns it.

        With ``still``, the picture must not change for that many seconds either: while shaders compile, which may take
        half a minute, Blender shows what was there before, or objects without their materials.
        """
        last, since = None, time.monotonic()

        def seen():
            nonlocal last, since
            self.run("area().tag_redraw()")
            picture = self.picture(kind)
            if last is None or last.shape != picture.shape or _difference(last, picture) > _SAME:
                since = time.monotonic()
            last = picture
            return time.monotonic() >= since + still and condition(picture)

        self._until(seen, condition.__doc__)
        return last

    def drag(self, places, button="LEFTMOUSE", **modifiers):
        """Press a button at the first of some places, move to the others, let it go; modifiers: ctrl, shift, alt."""
        self.move(places[0])
        self.hold(button, **modifiers)
        for place in places[1:]:
            self.move(place)
        self.release(button)

    def scroll_to(self, text, count=1, up=False):
        """Turn the wheel over the sidebar until it shows a text, this many times."""
        x, y, width, height = self.region()
        self.move((x + width / 3, y + height / 2))

        def seen():
            found = len(self.places(text)) >= count
            if not found:
                self.press("WHEELUPMOUSE" if up else "WHEELDOWNMOUSE")
            return found

        self._until(seen, f"the text {text!r} while scrolling")

    def move(self, place):
        """Move the mouse to x, y."""
        self._event("MOUSEMOVE", "NOTHING", place)

    def hold(self, button="LEFTMOUSE", **modifiers):
        """Press a button or key and keep it down, where the mouse is; modifiers: ctrl, shift, alt."""
        self._event(button, "PRESS", **modifiers)

    def release(self, button="LEFTMOUSE"):
        """Let a button or key go."""
        self._event(button, "RELEASE")

    def press(self, key, **modifiers):
        """Press a key or button and let it go; modifiers: ctrl, shift, alt."""
        self._event(key, "PRESS", **modifiers)
        self._event(key, "RELEASE", **modifiers)

    def open_panel(self):
        """Open the sidebar of the 3D view and its tab "Synch"."""
        x, y, width, height = self.region("WINDOW")
        self.move((x + width / 2, y + height / 2))
        self.press("N")
        self.click("Synch", tab=True)
        self.wait_for("Synch Fields")

    def close(self):
        """End Blender, if it is still there."""
        self._process.terminate()
        self._process.wait(PATIENCE)

    def kill(self):
        """End it without a word to it."""
        os.kill(self.value("os.getpid()"), signal.SIGKILL)
        self._process.wait(PATIENCE)

    def quit(self):
        """Have it quit, as its menu does."""
        (self.folder / "command").write_text("bpy.ops.wm.quit_blender()")
        self._process.wait(PATIENCE)

    def _event(self, kind, value, place=None, **modifiers):
        if place is not None:
            self._mouse = [round(float(number)) for number in place]
        self.run(f"event({kind!r}, {value!r}, *{self._mouse}, **{modifiers})")
        time.sleep(SETTLING)

    def _until(self, condition, wish):
        end = time.monotonic() + PATIENCE
        while True:
            value = condition()
            if np.size(value) and np.all(value):
                return value
            if time.monotonic() > end:
                write_png(picture := self.folder / "missing.png", self.screen.picture())
                raise TimeoutError(f"waited {PATIENCE} s for {wish}; the screen then: {picture}")
            time.sleep(0.05)

    def _places(self, picture, text, tab=False):
        labels = self.value(f"labels({text!r})")
        return np.concatenate([reading.places(picture, self._template(label, tab)) for label in labels])

    def _drawn(self, text, tab):
        drawn = np.array(self.value(f"drawn_text({text!r}, {_POINTS})"), np.uint8)
        return np.rot90(drawn, -1) if tab else drawn


def _difference(first, second):
    """The mean difference of two pictures of bytes."""
    return np.abs(first.astype(int) - second).mean()
