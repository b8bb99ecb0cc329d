# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators share that solve: poll, settings from the panel, progress, errors as one line.

From a script such an operator runs to its end. From the window it queues a job and stays modal until the result is
written; meanwhile all events but Esc over the 3D view go on to Blender.
"""

import time

import bpy
from bpy.props import StringProperty

from ...core.errors import Cancelled, SynchError
from ...core.settings.guidance import AUTOMATIC
from .. import api
from ..blender.translations import operator_error, translate
from ..blender.undo_steps import undo_steps
from ..jobs.job import run
from ..jobs.queue import queue
from ..jobs.report import count_defects
from ..panels.row_operators import others_selected
from ..panels.sidebar import draw_redo
from ..patterns import job as field_job
from ..patterns.live import from_shown
from ..settings.fields import PROPERTY_NAMES, plain
from ..settings.guide_list import stored_guidance
from .ready import ReadyOperator

_POINTING = {"LEFTMOUSE", "MOUSEMOVE"}
_NAVIGATION = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE"}
# Seconds between two looks at the queue.
_TICK = 0.05
# Seconds between two drawings of how far a job is, in turns in the status bar and in the panels.
_TURN = 0.25
# What Esc does, in the status bar.
_KEEPS, _CANCELS = "Esc over the 3D view: keep what is shown", "Esc over the 3D view: cancel"
# Seconds of a look after which nothing is drawn until the next.
_MOMENT = 0.01


class Click:
    """The jobs that one click has begun, of which the last to end makes the step that undo takes back."""

    def __init__(self):
        self._left, self._wrote = 0, False

    def begin(self):
        """One more."""
        self._left += 1

    def end(self, result, label):
        """What an operator returns to Blender whose job has ended with a result."""
        self._left -= 1
        self._wrote |= result == {"FINISHED"}
        if self._left:
            if self._wrote:
                undo_steps.owe(label)
            return {"CANCELLED"}
        if self._wrote and result != {"FINISHED"}:
            undo_steps.push(label)
        undo_steps.settle()
        return result


class BackgroundOperator:
    """Mixed into an operator that solves: blocking from a script, queued from the window.

    A subclass says what it runs: ``_take`` (its settings from where the panel keeps them), ``_job`` (reads the scene,
    see :mod:`..jobs.job`), ``_headline`` (says what was found).
    """

    bl_options = {"REGISTER", "UNDO", "PRESET"}
    _work = _click = None

    def invoke(self, context, event):
        """From the window: take the panel's settings and solve in the background."""
        return self._reporting(self._begin, context)

    def _take(self, context):
        """Take the settings from where the panel keeps them, if it does."""

    def _begin(self, context):
        self._take(context)
        return self._run(context) if bpy.app.background else self._start(context)

    def execute(self, context):
        """From a script, or again from the redo panel: solve and write before returning."""
        return self._reporting(self._run, context)

    def modal(self, context, event):
        start, work = time.monotonic(), self._work
        meant = work is queue.running or work.is_over
        if meant and event.type == "ESC" and event.value == "PRESS" and _over_view(context, event):
            (queue.keep if work.can_be_kept else queue.cancel)(work)
        elif event.type == "TIMER" and not work.is_over:
            queue.advance()
            self._look_after(work)
        if work.is_over and (work.error is not None or not self._postponed(context)):
            return self._click.end(self._reporting(self._finish, context), self.bl_label)
        if event.type == "TIMER" and (work.holds_window or time.monotonic() < start + _MOMENT):
            self._tell(context, work)
        if not (work.holds_window and work is queue.running):
            return {"PASS_THROUGH"}
        free = navigates(event) or (event.type in _POINTING and over_sidebar(context, event))
        return {"PASS_THROUGH"} if free else {"RUNNING_MODAL"}

    def cancel(self, context):
        """The window, the file or the choice of a file is being closed."""
        if self._work is not None:
            queue.cancel(self._work)

    def _reporting(self, step, context):
        """Run a step; an error becomes one line and CANCELLED."""
        try:
            return step(context)
        except Cancelled as stop:
            self.report({"INFO"}, self._name_object(context, str(stop)))
        except SynchError as error:
            self.report({"ERROR"}, self._name_object(context, str(error)))
            target = self._target(context)
            if len(error.vertices) and target is not None:
                api.select(target, error.vertices)
        return {"CANCELLED"}

    def _target(self, context):
        """The object that errors name vertices of: the one that was read, or that is to be."""
        if self._work is None:
            return context.active_object
        return self._work.obj

    def _name_object(self, context, line):
        """A message with the name of the object that it is about."""
        if self._work is not None and self._work.job.link is not None:
            name = self._work.job.link.name
        elif isinstance(self, ReadyOperator) and self._target(context) is not None:
            name = self._target(context).name
        else:
            return line
        return line if name in line else f"{name}: {line}"

    def _run(self, context):
        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            report = run(self._job(context), progress_of(manager))
        finally:
            manager.progress_end()
        return self._announce(context, report)

    def _start(self, context):
        self._work = queue.add(self._job(context), self.bl_label)
        self._click = self._click or Click()
        self._click.begin()
        self._taken = _Taken(context, self._work)
        self._work.let_go = self._taken.give_back
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _finish(self, context):
        work = self._work
        work.let_go()
        if work.error is not None:
            raise work.error
        if isinstance(work.job, field_job.FieldJob):
            work.job.ended_early = work.is_kept
        report = dict(work.job.write(work.result))  # what is kept of it stays as it is
        if work.peak is not None:
            report["peak_memory_mb"] = work.peak
        if "times" in report:
            report["times"] = report["times"] | {"total": report["times"]["total"] - work.waited}
        return self._announce(context, report)

    def _announce(self, context, report):
        self.report({"INFO"}, self._name_object(context, self._headline(report)))
        for warning in report.get("warnings", ()):  # last, since the window shows the last line alone
            self.report({"WARNING"}, self._name_object(context, warning))
        return {"FINISHED"}

    def _look_after(self, work):
        """End a job whose object is gone."""
        link = work.job.link
        if link is not None and link.present is None and not work.is_over:
            queue.cancel(work)
            work.error = SynchError(f"the object {link.name} is gone: nothing was written")

    def _postponed(self, context):
        """Why the result cannot be written yet, in one line, or None."""
        if bpy.app.is_job_running("RENDER"):
            return translate("the result waits for the end of the render")
        link = self._work.job.link
        if link is None:
            return None if bpy.context.mode == "OBJECT" else translate("the result waits for object mode")
        obj = link.present
        if obj is None or obj.mode == "OBJECT":
            return None
        # Edit mode has to be left, which is not possible while another modal operator works.
        is_free = obj.mode == "EDIT" and bpy.context.view_layer.objects.active == obj and not _others_at_work(context)
        return None if is_free else translate("the result waits for object mode of {name}", name=obj.name)

    def _tell(self, context, work):
        """Say how far the first job is, or what a result waits for."""
        if work is queue.running:
            escape = translate(_KEEPS if work.can_be_kept else _CANCELS)
            line = f"{translate(work.label)}: {work.line}   {work.times}   {escape}"
        elif work.is_over:
            line = self._postponed(context)
        else:
            return
        self._taken.say(line)


class _Taken:
    """The timer and the status bar's line that a window gives to a job."""

    def __init__(self, context, work):
        self._manager, self._workspace, self._work = context.window_manager, context.workspace, work
        self._timer = self._manager.event_timer_add(_TICK, window=context.window)
        self._said, self._drawn, self._picture, self._last = "", None, None, 0.0

    def give_back(self):
        """Give them back, if that has not been done."""
        if self._timer is not None:
            self._manager.event_timer_remove(self._timer)
            self._timer = None
            self._set_status(None)
            self._draw_again("UI")
            if self._work.is_seen:
                self._draw_again("WINDOW")

    def say(self, line):
        """Show how far the job is, in the status bar and the panels, and each new picture at once.

        Drawing takes time from the user: status bar and panels take turns, unless the job holds the window anyway.
        """
        now = time.monotonic()
        if self._work.picture is not self._picture:
            self._picture = self._work.picture
            self._draw_again("WINDOW")
        elif self._work.holds_window:
            self._set_status(line)
            self._draw_again("UI")
        elif now > self._last + _TURN and self._drawn != self._said:
            self._drawn, self._last = self._said, now
            self._draw_again("UI")
        elif now > self._last + _TURN and line != self._said:
            self._said, self._last = line, now
            self._set_status(line)

    def _set_status(self, line):
        try:
            if self._workspace is not None:
                self._workspace.status_text_set(line)
        except ReferenceError:  # it was deleted meanwhile
            self._workspace = None

    def _draw_again(self, kind):
        for window in self._manager.windows:
            for area in window.screen.areas:
                for region in area.regions if area.type == "VIEW_3D" else ():
                    if region.type == kind:
                        region.tag_redraw()


class ObjectOperator(ReadyOperator, BackgroundOperator):
    """Mixed into an operator that solves for a mesh object."""


def take_settings(operator, stored, names):
    """Give an operator the settings with these names that are kept with an object."""
    for name in names:
        if name != "spacing" or not stored.automatic_spacing:
            setattr(operator, name, getattr(stored, operator.stored_as.get(name, name)))


class FieldOperator(ObjectOperator):
    """Mixed into an operator with the setting properties; ``command`` names the API function.

    ``stored_as`` says which settings the panel keeps for this operator alone, and as what.
    """

    command = ""
    stored_as = {}

    guidance: StringProperty(
        name="Guidance",
        description="automatic, smooth, or what the directions follow, such as curvature-max=2,axis:Z",
        default=AUTOMATIC,
    )

    def invoke(self, context, event):
        """From the window: the active object first, and then the other selected ones, each with its own settings."""
        others = others_selected(context)
        started = super().invoke(context, event)
        before, FieldOperator._click = FieldOperator._click, self._click  # that of the others
        try:
            for obj in others if started != {"CANCELLED"} else ():
                with context.temp_override(active_object=obj, object=obj, selected_objects=[obj]):
                    self._begin_another(obj)
        finally:
            FieldOperator._click = before
        return started

    def _begin_another(self, obj):
        operator = getattr(bpy.ops.synch, self.bl_idname.split("_OT_")[-1])
        try:
            if operator.poll("INVOKE_DEFAULT"):
                operator("INVOKE_DEFAULT")
        except RuntimeError as error:  # its error, as Blender hands it on
            line = operator_error(error)
            self.report({"WARNING"}, line if obj.name in line else f"{obj.name}: {line}")

    def draw(self, context):
        draw_redo(self.layout, self)

    def _take(self, context):
        stored = context.active_object.synch
        self.guidance = stored_guidance(stored)
        self.properties.property_unset("spacing")
        take_settings(self, stored, PROPERTY_NAMES)

    def _settings(self):
        return plain(self, self.spacing if self.properties.is_property_set("spacing") else None)

    def _job(self, context):
        job = field_job.FieldJob(self.command, context.active_object, self._settings())
        job.request = from_shown(context.active_object, job.request)
        return job

    def _announce(self, context, report):
        self.spacing = report["settings"]["spacing"]
        return super()._announce(context, report)

    def _headline(self, report):
        made = report.get("quad_mesh")
        if made is not None:
            return f"{made['object']}: {made['faces']} faces, {made['quad_share']:.1%} of them quads"
        counts = count_defects(report)
        if report["energy"] is None:
            return f"{report['object']}: {counts}"
        proof = f", proved: no field saves more than {report['gap']:.0%}" if report["certificate"] == "proved" else ""
        cost = report.get("pins_cost")
        pins = "" if cost is None else f"; with these pins directions bend {cost:+.1%}"
        return f"{report['object']}: energy {report['energy']:.4g}{proof}; {counts}{pins}"


def navigates(event):
    """Whether an event can only move the view: others could change the mesh while an operator waits."""
    return event.type in _NAVIGATION or event.type.startswith("NUMPAD_")


def _others_at_work(context):
    """Whether an operator that is not ours has the window."""
    operators = context.window.modal_operators if context.window is not None else ()
    return any(not operator.bl_idname.startswith("SYNCH_OT_") for operator in operators)


def over_sidebar(context, event):
    """Whether the mouse is over a sidebar, which lies over the view."""
    return any(region.type == "UI" and _is_over(region, event) for area in _views(context) for region in area.regions)


def _over_view(context, event):
    """Whether the mouse is over a 3D view."""
    return any(_is_over(area, event) for area in _views(context))


def _is_over(place, event):
    return 0 <= event.mouse_x - place.x < place.width and 0 <= event.mouse_y - place.y < place.height


def _views(context):
    return [area for area in context.screen.areas if area.type == "VIEW_3D"]


def progress_of(manager):
    def update(stage, fraction):
        manager.progress_update(fraction)
        return True

    return update
