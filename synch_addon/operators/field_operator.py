# SPDX-License-Identifier: GPL-3.0-or-later
"""What the field operators share: poll, settings from the panel, progress, errors as one line."""

from ...core.errors import Cancelled, SynchError
from .. import api
from ..scene_io import refusal
from ..settings import PROPERTY_NAMES, plain


class FieldOperator:
    """Mixed into an operator with the setting properties; ``command`` names the API function."""

    bl_options = {"REGISTER", "UNDO"}
    command = ""

    @classmethod
    def poll(cls, context):
        reason = refusal(context.active_object)
        if reason is None and context.mode not in {"OBJECT", "EDIT_MESH"}:
            reason = "leave the present mode: fields are solved in object or edit mode"
        if reason:
            cls.poll_message_set(reason)
        return reason is None

    def invoke(self, context, event):
        """From the panel: take the object's settings."""
        stored = context.active_object.synch
        for name in PROPERTY_NAMES:
            if name != "spacing" or not stored.automatic_spacing:
                setattr(self, name, getattr(stored, name))
        if stored.automatic_spacing:
            self.properties.property_unset("spacing")
        return self.execute(context)

    def execute(self, context):
        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            spacing = self.spacing if self.properties.is_property_set("spacing") else None
            report = api.run(self.command, context.active_object, plain(self, spacing), self._progress(manager))
        except Cancelled as stop:
            self.report({"INFO"}, str(stop))
            return {"CANCELLED"}
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        self.spacing = report["settings"]["spacing"]
        for warning in report["warnings"]:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, _headline(report))
        return {"FINISHED"}

    @staticmethod
    def _progress(manager):
        def update(stage, fraction):
            manager.progress_update(fraction)
            return True

        return update


def _headline(report):
    """What the status bar says after a run."""
    counts = f"{len(report['disclinations'])} disclinations, {len(report['dislocations'])} dislocations"
    if report["energy"] is None:
        return counts
    proof = f", proved within {report['gap']:.0%} of the best" if report["certificate"] == "proved" else ""
    return f"energy {report['energy']:.4g}{proof}; {counts}"
