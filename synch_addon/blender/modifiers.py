# SPDX-License-Identifier: GPL-3.0-or-later
"""Modifiers of an object: which of them change faces, and evaluating without them."""

from contextlib import contextmanager


@contextmanager
def hidden(modifiers):
    """Evaluate without modifiers for a while."""
    shown = [modifier for modifier in modifiers if modifier.show_viewport]
    for modifier in shown:
        modifier.show_viewport = False
    try:
        yield
    finally:
        for modifier in shown:
            modifier.show_viewport = True
