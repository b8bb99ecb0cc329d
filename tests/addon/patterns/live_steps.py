# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that Live follows, and the steps of its timer, taken by hand."""

import time

import bpy

from synch_fields.synch_addon.jobs.job import run
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.job import FieldJob
from synch_fields.synch_addon.patterns.live import live
from synch_fields.synch_addon.settings.fields import stored_settings

from ..scenes import sphere


def striped(make=sphere, command="stripes", spacing=0.4):
    """The active object with a pattern of the panel's settings."""
    obj = make()
    obj.synch.automatic_spacing, obj.synch.spacing = False, spacing
    solve(obj, command)
    return obj


def solve(obj, command="stripes"):
    """What a click does, here and now; returns the report."""
    return run(FieldJob(command, obj, stored_settings(obj)))


def followed(steps=1, seconds=20.0):
    """Look until so many results have been written, or nothing is asked for any more; how many were."""
    written, before, end = 0, live._shown, time.monotonic() + seconds
    while written < steps and time.monotonic() < end:
        live.step(bpy.context)
        if live._shown is not before and live._shown is not None:  # as it is after a rest
            written, before = written + 1, live._shown
        if live._work is None and not _asks():
            break
        time.sleep(0.005)
    return written


def _asks():
    obj = bpy.context.active_object
    shown = memory.state(obj)
    known = (shown.report.settings, shown.report.curves_read), live._asked_last
    return live._is_painted or live._present_settings(obj, shown) not in (None, *known)


def settled(seconds=60.0):
    """Look until the pattern has settled; every energy that was shown meanwhile."""
    obj, energies, end = bpy.context.active_object, [], time.monotonic() + seconds
    while live._changed is not None and time.monotonic() < end:
        live.step(bpy.context)
        if (energy := memory.state(obj).plain["energy"]) not in energies:
            energies.append(energy)
        time.sleep(0.005)
    return energies
