# SPDX-License-Identifier: GPL-3.0-or-later
"""Taking away what an object shows, before a job of another kind writes phases to its own mesh."""

from . import frame_attributes, memory, numbers, own_surface


def remove_former(obj):
    """Remove the frames, the pattern's own surface and the numbers of stripes of an object, which would hide the new
    phases or not fit them, and what is kept of its last solve."""
    frame_attributes.remove_frames(obj)
    own_surface.release(obj)
    numbers.remove_numbers(obj)
    memory.show_nothing(obj)
