# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``animate`` of the command line: a pattern in each frame of a moving mesh of a .blend file."""

import bpy

from ...core.settings.surface import SurfaceSettings
from ..blender import files
from ..frames.job import HOLD, run_animate
from ..jobs.report import count_text
from .flags import Made, add_choice, add_input, add_number, add_outputs, save_scene
from .settings import add_settings, settings_of


def add_parser(commands):
    """Add the command to the parser's."""
    command = commands.add_parser(
        "animate",
        help="stripes or quads in each frame of a moving mesh",
        description="Solve stripes or quads in each frame of a moving mesh, each from the one before.",
    )
    add_input(command)
    add_choice(command, "--pattern", ("stripes", "quads"), "stripes")
    command.add_argument("--frames", nargs=2, type=int, metavar=("FIRST", "LAST"), help="default: the scene's")
    add_number(command, "--hold", HOLD, "how strongly the pattern holds on to the frame before")
    add_settings(command, SurfaceSettings, "animate")
    add_outputs(command, "energies, defects and changes of each frame")


def run(options, open_object, progress):
    """Run the command."""
    settings = settings_of(options, SurfaceSettings, assign_material=True)
    files.check_outputs(options.output, report=options.report)
    obj = open_object()
    scene = bpy.context.scene
    frames = options.frames or (scene.frame_start, scene.frame_end)
    report = run_animate(obj, settings, frames, options.pattern, options.hold, progress)
    return Made(report, summary(report), save_scene(options))


def summary(report):
    """The lines that a person wants to read."""
    frames = report["frames"]
    lines = [
        f"{report['pattern']} on {report['object']}: {report['nodes']} vertices, {count_text(len(frames), 'frame')}"
    ]
    energies = [frame["energy"] for frame in frames]
    lines.append(f"energies {min(energies):.6g} to {max(energies):.6g}")
    changes = [frame["change"] for frame in frames if frame["change"] is not None]
    if changes:
        mean = sum(changes) / len(changes)
        lines.append(f"change from frame to frame {mean:.3f} on average, {max(changes):.3f} at most")
    return [*lines, f"{report['times']['total']:.2f} s"]
