# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python that README and manual show, run from Blender's Text Editor with the extension installed from its zip."""

import json
import sys

from .conftest import ROOT

EDITOR = """
editor = area()
editor.type = "TEXT_EDITOR"
"""
# Runs inside: shows a program in the editor.
SHOW = """
editor.spaces.active.text = bpy.data.texts.new("example")
editor.spaces.active.text.write({source!r})
answer = [editor.x + editor.width / 2, editor.y + editor.height / 2]
"""


def examples():
    """The programs, for an extension from a zip that was dragged into Blender."""
    sys.path.insert(0, str(ROOT / "tools"))
    try:
        import install_test
    finally:
        sys.path.pop(0)
    return install_test.examples(install_test.DRAGGED)


def test_examples_run_from_the_text_editor(blender):
    blender.run(EDITOR)
    for number, source in enumerate(examples()):
        mark = f"\nimport bpy\nbpy.app.driver_namespace['ran'] = {number}\n"
        blender.move(blender.run(SHOW.format(source=source + mark)))
        blender.press("P", alt=True)
        blender.until(f"bpy.app.driver_namespace.get('ran') == {number}")
    assert json.loads(blender.value("active().synch.result"))["settings"]["seed"] == 3
    assert "Traceback" not in blender.log.read_text()
