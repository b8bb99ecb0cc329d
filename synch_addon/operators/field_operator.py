# SPDX-License-Identifier: GPL-3.0-or-later
"""What the field operators share: poll, settings from the panel, progress, errors as one line.

From a script the operator runs to its end. From the window it solves in a thread: the view can be
turned meanwhile, Esc cancels, and the result is written when it is there.
"""

import bpy
from bpy.props import StringProperty

from ...core.errors import Cancelled, SynchError
from .. import api
from ..blender.translations import said
from ..jobs import jobs
from ..jobs.report import counted
from ..patterns import job as field_job
from ..patterns import preview
from ..settings.fields import PROPERTY_NAMES, plain
from ..settings.guide_list import stored_guidance
from .ready import ReadyOperator

_POINTING = {"LEFTMOUSE", "MOUSEMOVE"}
_NAVIGATION = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE"}


class BackgroundOperator:
    """Mixed into an operator that solves: blocking from a script, in a thread from the window.

    A subclass says what it runs: ``_take`` (its settings from where the panel keeps them), ``_job`` (reads the scene,
    see :class:`jobs.BackgroundSolve`), ``_write`` (puts a result into the scene), ``_headline`` (says what was found).
    """

    bl_options = {"REGISTER", "UNDO", "PRESET"}
    work = jobs.BackgroundSolve

    def invoke(self, context, event):
        """From the window: take the panel's settings and solve in the background."""
        return self._reporting(self._begin, context)

    def _begin(self, context):
        self._take(context)
        return self._run(context) if bpy.app.background else self._start(context)

    def execute(self, context):
        """From a script, or again from the redo panel: solve and write before returning."""
        return self._reporting(self._run, context)

    def modal(self, context, event):
        work = jobs.running
        if work is None:  # the extension was taken out meanwhile
            return {"CANCELLED"}
        if event.type == "ESC" and event.value == "PRESS":
            work.cancel()
        elif event.type == "TIMER" and not work.finished and not work.cancelled:
            work.advance()
        if work.cancelled or (event.type == "TIMER" and work.finished):
            return self._reporting(self._finish, context)
        if event.type == "TIMER":
            if work.early is not None:
                early, work.early = work.early, None
                self._try_early(early)
            work.show(f"{said(self.bl_label)}: {work.line}   {work.times}   {said('Esc: cancel')}")
        free = navigates(event) or (event.type in _POINTING and over_sidebar(context, event))
        return {"PASS_THROUGH"} if free else {"RUNNING_MODAL"}

    def cancel(self, context):
        """The window or the file is being closed."""
        if jobs.running is not None:
            self._leave().cancel()

    def _reporting(self, step, context):
        """Run a step; an error becomes one line and CANCELLED."""
        try:
            return step(context)
        except Cancelled as stop:
            self.report({"INFO"}, str(stop))
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            if len(error.vertices):
                api.select(self._target(context), error.vertices)
        return {"CANCELLED"}

    def _target(self, context):
        """The object that errors name vertices of."""
        return context.active_object

    def _run(self, context):
        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            job = self._job(context)
            job.solve(progress_of(manager))
            report = self._write(job)
        finally:
            manager.progress_end()
        return self._announce(report)

    def _start(self, context):
        job = self._job(context)
        jobs.running = self.work(job)
        jobs.running.take(context)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def _finish(self, context):
        work = self._leave()
        if work.cancelled:
            raise Cancelled("cancelled: nothing was changed")
        if work.error is not None:
            raise work.error
        return self._announce(self._write(work.job))

    def _announce(self, report):
        for warning in report["warnings"]:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, self._headline(report))
        return {"FINISHED"}

    def _try_early(self, early):
        """Show a first result of the job; one that cannot be shown does not stop it."""
        try:
            self._show_early(early)
        except Exception as error:
            self.report({"WARNING"}, f"the first result is not shown: {error}")

    def _show_early(self, early):
        """Show a first result of the job."""

    def _leave(self):
        """Give the window back; returns the job. A thread that was cancelled ends by itself: it writes nothing."""
        work, jobs.running = jobs.running, None
        work.give_back()
        preview.hide()
        return work


class ObjectOperator(ReadyOperator, BackgroundOperator):
    """Mixed into an operator that solves for a mesh object, whose name ``_job`` keeps."""

    def _write(self, job):
        obj = bpy.data.objects.get(self._object_name)
        if obj is None:
            raise SynchError(f"the object {self._object_name} is gone: nothing was written")
        return job.write(obj)


class FieldOperator(ObjectOperator):
    """Mixed into an operator with the setting properties; ``command`` names the API function."""

    command = ""

    guidance: StringProperty(
        name="Guidance",
        description="smooth, or what the directions follow, such as curvature-max=2,axis:Z",
        default="smooth",
    )

    def _take(self, context):
        stored = context.active_object.synch
        self.guidance = stored_guidance(stored)
        for name in PROPERTY_NAMES:
            if name != "spacing" or not stored.automatic_spacing:
                setattr(self, name, getattr(stored, name))
        if stored.automatic_spacing:
            self.properties.property_unset("spacing")

    def _settings(self):
        return plain(self, self.spacing if self.properties.is_property_set("spacing") else None)

    def _job(self, context):
        self._object_name = context.active_object.name
        return field_job.FieldJob(self.command, context.active_object, self._settings())

    def _show_early(self, early):
        preview.show(bpy.data.objects.get(self._object_name), *early)

    def _announce(self, report):
        self.spacing = report["settings"]["spacing"]
        return super()._announce(report)

    def _headline(self, report):
        made = report.get("quad_mesh")
        if made is not None:
            return f"{made['object']}: {made['faces']} faces, {made['quad_share']:.1%} of them quads"
        counts = ", ".join(counted(len(report[kind + "s"]), kind) for kind in ("disclination", "dislocation"))
        if report["energy"] is None:
            return counts
        proof = f", proved: no field saves more than {report['gap']:.0%}" if report["certificate"] == "proved" else ""
        return f"energy {report['energy']:.4g}{proof}; {counts}"


class SYNCH_OT_cancel(bpy.types.Operator):
    """Stop the solve that runs; everything stays as it was"""

    bl_idname = "synch.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return jobs.running is not None

    def execute(self, context):
        jobs.running.cancel()
        return {"FINISHED"}


def navigates(event):
    """Whether an event can only move the view: others could change the mesh while an operator waits."""
    return event.type in _NAVIGATION or event.type.startswith("NUMPAD_")


def over_sidebar(context, event):
    """Whether the mouse is over a sidebar, which lies over the view."""
    return any(
        region.type == "UI"
        and 0 <= event.mouse_x - region.x < region.width
        and 0 <= event.mouse_y - region.y < region.height
        for area in context.screen.areas
        if area.type == "VIEW_3D"
        for region in area.regions
    )


def progress_of(manager):
    def update(stage, fraction):
        manager.progress_update(fraction)
        return True

    return update
