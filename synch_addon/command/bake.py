# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``bake`` of the command line: the pattern of an object of a .blend file as images."""

from ...core.errors import SettingError
from .. import api
from ..bakes.settings import MAPS, SIZES, SUFFIXES, BakeSettings
from ..blender import files
from .flags import Made, add_choice, add_input, add_number, add_outputs, saved

_DEFAULT = BakeSettings()


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "bake", help="the pattern of an object as images", description="Bake solved stripes or quads into images."
    )
    add_input(command)
    command.add_argument(
        "--maps", default=",".join(_DEFAULT.maps), metavar="MAPS", help=f"some of {','.join(MAPS)} (%(default)s)"
    )
    command.add_argument(
        "--folder", default="", help="where the images go; default: packed into the .blend of --output"
    )
    command.add_argument("--name", default=_DEFAULT.naming, help="of each image; {object} and {map} are filled in")
    add_choice(command, "--format", SUFFIXES, _DEFAULT.file_format)
    add_number(command, "--size", _DEFAULT.size, f"from {SIZES[0]} to {SIZES[1]}", "PIXELS")
    add_number(command, "--margin", _DEFAULT.margin, "around UV islands", "PIXELS")
    add_number(command, "--samples", _DEFAULT.samples, "a pixel", "N")
    command.add_argument("--uv-map", default="", metavar="NAME", help="default: the active one")
    command.add_argument("--unwrap", action="store_true", help="make the UV map by Smart UV Project if it is missing")
    command.add_argument("--material", action="store_true", help="show the images in place of the pattern")
    command.add_argument("--displacement", action="store_true", help="the material displaces by the height, too")
    add_outputs(command, "files, sizes and times")


def run(options, open_object, progress):
    """Run the command."""
    settings = BakeSettings(
        maps=options.maps,
        size=options.size,
        margin=options.margin,
        samples=options.samples,
        uv_map=options.uv_map,
        unwrap=options.unwrap,
        folder=options.folder,
        naming=options.name,
        file_format=options.format,
        material=options.material,
        displacement=options.displacement,
    )
    files.check_outputs(options.output, report=options.report)
    if not (options.folder or options.output):
        raise SettingError("the images have nowhere to go: add --folder, or --output for a .blend that holds them")
    report = api.run_bake(open_object(), settings, progress)
    lines = [f"baked {report['pattern']} of {report['object']}: {report['size']} pixels, {report['seconds']:.1f} s"]
    for name, entry in report["maps"].items():
        lines.append(f"{name}: {entry['bytes'] / 2**20:.2f} MB, {entry['seconds']:.1f} s")
    images = [entry["file"] for entry in report["maps"].values() if "file" in entry]
    return Made(report, lines, images + saved(options))
