# SPDX-License-Identifier: GPL-3.0-or-later
"""How far jobs are, and how long they will take, in the panels."""

from ..blender.translations import translate
from ..jobs.queue import Work, as_time, queue
from ..settings.preferences import is_simple

# Jobs whose progress is shown where their button is, in a box of the advanced panel.
_BOXED = {"Animate", "Bake", "Layers", "Vortices"}


def draw_work(bar, row, work):
    """How far a job is, and the buttons that end it, which stand where those that begin one do."""
    bar.progress(factor=work.share, text=work.short_line)
    if work.can_be_kept:
        row.operator("synch.keep", icon="CHECKMARK")
    text = "Discard" if work.shows_result else "Cancel"
    row.operator("synch.cancel", text=text, icon="X").place = queue.works.index(work)


def is_boxed(work):
    """Whether the box of a job's button shows its progress."""
    return work.label in _BOXED and not is_simple()


def draw_begin(layout, operator, label, icon, obj=None):
    """Draw the button of an operator, or the progress of its job while one of this label is queued for the object."""
    row = layout.row(align=True)
    asked = (work for work in queue.works if work.label == label and work.obj == obj and not work.is_quiet)
    work = next(asked, None)
    if work is None:
        row.operator(operator, icon=icon)
        return
    row.progress(factor=work.share, text=work.short_line)
    if work.can_be_kept:
        row.operator("synch.keep", text="", icon="CHECKMARK")
    row.operator("synch.cancel", text="", icon="X").place = queue.works.index(work)


def draw_estimate(layout, label, seconds, megabytes=None):
    """About how long work of a name takes, and how much memory."""
    line = translate("About {time}", time=as_time(max(Work.seconds_here(label, seconds), 1)))
    if megabytes is not None:
        line = f"{line}, {megabytes:,.0f} MB"
    layout.label(text=line, icon="TIME", translate=False)
