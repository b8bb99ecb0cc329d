# SPDX-License-Identifier: GPL-3.0-or-later
"""How far jobs are, and how long they will take, in the panels."""

from ..blender.translations import translate
from ..jobs.queue import Work, as_time, queue


def draw_work(bar, row, work):
    """How far a job is, and the buttons that end it, which stand where those that begin one do."""
    bar.progress(factor=work.fraction, text=work.short_line)
    if work.can_be_kept:
        row.operator("synch.keep", icon="CHECKMARK")
    text = "Discard" if work.shows_result else "Cancel"
    row.operator("synch.cancel", text=text, icon="X").place = queue.works.index(work)


def draw_estimate(layout, label, seconds, megabytes=None):
    """About how long work of a name takes, and how much memory."""
    line = translate("About {time}", time=as_time(max(Work.seconds_here(label, seconds), 1)))
    if megabytes is not None:
        line = f"{line}, {megabytes:,.0f} MB"
    layout.label(text=line, icon="TIME", translate=False)
