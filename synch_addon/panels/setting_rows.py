# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of settings in panels, drawn from their records."""

from ...core.settings.setting import records

# Share of the width that Blender gives to the names of settings.
NAMES = 0.4


def property_column(layout):
    """A column of settings with their names on the left, as in Blender's own panels."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_settings(column, settings, kind, group, own=None):
    """Draw the settings of a group of the panel, in the order of their declaration.

    Parameters
    ----------
    column : UILayout
    settings : the object's, or an operator's
    kind : class of the settings
    group : of the panel, as the records have it
    own : by name, callables (column) that draw a setting in a way of their own
    """
    own = own or {}
    for name, record in records(kind):
        if record.group != group or record.part_of:
            continue
        if name in own:
            own[name](column)
        else:
            draw_setting(column, settings, name, record.zero)


def draw_setting(column, settings, name, zero="", text=None):
    """Draw a setting with its name on the left; beside a number that is 0, ``zero`` says what that means.

    ``text``: its name, where it is not the property's own.
    """
    if not zero or getattr(settings, name):
        column.prop(settings, name, **({} if text is None else {"text": text}))
        return
    split = column.split(factor=NAMES)
    split.use_property_split = False
    label, row = split.row(), split.row(align=True)
    label.alignment = "RIGHT"
    owner = getattr(settings, "properties", settings)  # where an operator has its own
    label.label(text=owner.bl_rna.properties[name].name if text is None else text)
    row.prop(settings, name, text="")
    row.label(text=zero)


def draw_automatic(column, settings, name):
    """The field of a number that may be automatic, and its button: see :mod:`..settings.automatic`; grey where the
    number is not known."""
    row = column.row(align=True)
    row.enabled = getattr(settings, name) > 0
    row.prop(settings, name)
    row.prop(settings, f"{name}_auto", text="Auto", toggle=True)


def skip(column):
    """Draw nothing of a setting that stands elsewhere."""
