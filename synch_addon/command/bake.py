# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``bake`` of the command line: the pattern of an object of a .blend file as images."""

from ...core.errors import SettingError
from ...core.settings.bake import BakeSettings
from .. import api
from ..blender import files
from .flags import Made, add_input, add_outputs, save_scene
from .settings import add_settings, settings_of


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "bake", help="the pattern of an object as images", description="Bake solved stripes or quads into images."
    )
    add_input(command)
    add_settings(command, BakeSettings, "bake")
    add_outputs(command, "files, sizes and times")


def run(options, open_object, progress):
    """Run the command."""
    settings = settings_of(options, BakeSettings)
    files.check_outputs(options.output, report=options.report)
    if not (options.folder or options.output):
        raise SettingError("the images have nowhere to go: add --folder, or --output for a .blend that holds them")
    report = api.run_bake(open_object(), settings, progress)
    lines = [f"baked {report['pattern']} of {report['object']}: {report['size']} pixels, {report['seconds']:.1f} s"]
    for name, entry in report["maps"].items():
        lines.append(f"{name}: {entry['bytes'] / 2**20:.2f} MB, {entry['seconds']:.1f} s")
    images = [entry["file"] for entry in report["maps"].values() if "file" in entry]
    return Made(report, lines, images + save_scene(options))
