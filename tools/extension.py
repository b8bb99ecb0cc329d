# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension: stage it, validate it strictly, pack it; prints the path of every zip.

    python tools/extension.py [--wheels] [--output-dir out]

Without --wheels the manifest goes in without its wheels, for a Blender whose Python has SciPy already.
With it, the wheels are downloaded once into wheels/, compared with tools/wheels.sha256, and one zip is built for each
platform. Two builds of the same files are the same to the last byte, whenever and wherever these lie.
"""

import argparse
import hashlib
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = "blender_manifest.toml"
CHECKSUMS = ROOT / "tools" / "wheels.sha256"
# Of every entry of a zip: the earliest time that zips know, a file that all may read, as of Unix.
TIME, MODE, UNIX = (1980, 1, 1, 0, 0, 0), 0o100644 << 16, 3


class BuildError(Exception):
    """The extension cannot be built; the message is one line that says why."""


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Build the Blender extension.")
    parser.add_argument("--wheels", action="store_true", help="bundle SciPy; one zip for each platform")
    parser.add_argument("--output-dir", type=Path, default=ROOT / "out", metavar="DIR")
    options = parser.parse_args(arguments)
    try:
        for archive in build(options.output_dir, options.wheels):
            print(archive)
    except BuildError as error:
        print(f"extension: {error}", file=sys.stderr)
        return 1
    return 0


def build(output_dir: Path, with_wheels: bool) -> list[Path]:
    """Stage, validate and pack the extension into output_dir; returns the zips written."""
    with tempfile.TemporaryDirectory() as folder:
        stage, packed = Path(folder, "stage"), Path(folder, "packed")
        packed.mkdir()
        stage_tree(stage, with_wheels)
        tags = blender_file("scripts/modules/_bpy_internal/extensions/tags.py")
        blender_ext("validate", "--valid-tags", tags, stage)
        split = ["--split-platforms"] if with_wheels else []
        blender_ext("build", "--valid-tags", tags, "--source-dir", stage, "--output-dir", packed, *split)
        output_dir.mkdir(parents=True, exist_ok=True)
        made = []
        for archive in sorted(packed.glob("*.zip")):
            made.append(output_dir / archive.name)
            repack(archive, made[-1])
            blender_ext("validate", "--valid-tags", tags, made[-1])
        return made


def repack(archive: Path, target: Path) -> None:
    """Copy a zip, or a wheel, with its entries in order and without their times and modes.

    Nothing is compressed: wheels and pictures are already, and libraries that compress differ in what they make of it.
    """
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as packed:
        for name in sorted(source.namelist()):
            entry = zipfile.ZipInfo(name, TIME)
            entry.create_system, entry.external_attr = UNIX, MODE
            packed.writestr(entry, source.read(name))


def stage_tree(stage: Path, with_wheels: bool) -> None:
    """Copy the manifest and what its [build] section lets in to the new folder stage."""
    text = (ROOT / MANIFEST).read_text(encoding="utf-8")
    manifest = tomllib.loads(text)
    stage.mkdir()
    for pattern in manifest["build"]["paths_exclude_pattern"]:
        if pattern.startswith("!/"):
            copy_into(stage, pattern.removeprefix("!/"))
    if with_wheels:
        for wheel in manifest["wheels"]:
            download_wheel(ROOT / wheel)
            copy_into(stage, wheel)
    (stage / MANIFEST).write_text(text if with_wheels else without_wheels(text), encoding="utf-8")


def copy_into(stage: Path, name: str) -> None:
    source, target = ROOT / name, stage / name
    if not source.exists():
        raise BuildError(f"{name} is missing, but {MANIFEST} lists it")
    if source.is_dir():
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
    else:
        target.parent.mkdir(exist_ok=True)
        shutil.copy(source, target)


def without_wheels(text: str) -> str:
    """The manifest without its wheels, and without the platforms that only the wheels restrict it to."""
    text = re.sub(r"^(wheels|platforms) = \[[^\]]*\]\n", "", text, flags=re.MULTILINE)
    if left := {"wheels", "platforms"} & tomllib.loads(text).keys():
        raise BuildError(f"cannot take {' and '.join(sorted(left))} out of {MANIFEST}: write plain lists of strings")
    return text


def download_wheel(wheel: Path) -> None:
    """Fetch a wheel with pip by the tags in its own name (name-version-python-abi-platforms.whl); it must be the known.

    The checksums are those of the files as their authors published them.
    """
    if not wheel.exists():
        download(wheel)
    known = dict(reversed(line.split()) for line in CHECKSUMS.read_text(encoding="utf-8").splitlines())
    if wheel.name not in known:
        raise BuildError(f"{CHECKSUMS.name} has no line for {wheel.name}: add what sha256sum says of it")
    if hashlib.sha256(wheel.read_bytes()).hexdigest() != known[wheel.name]:
        raise BuildError(f"{wheel.name} is not what {CHECKSUMS.name} says: remove it, so that it is fetched anew")


def download(wheel: Path) -> None:
    package, version, python, abi, platforms = wheel.stem.split("-")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
    command += ["--dest", str(wheel.parent)]
    if abi != "none":
        command += ["--implementation", "cp", "--abi", abi, "--python-version", python.removeprefix("cp")]
        for platform in platforms.split("."):
            command += ["--platform", platform]
    print(f"extension: downloading {wheel.name}", file=sys.stderr)
    result = subprocess.run([*command, f"{package}=={version}"], capture_output=True, text=True)
    if result.returncode or not wheel.exists():
        raise BuildError(f"pip could not download {wheel.name}: {first_error(result.stderr)}")


def blender_file(path: str) -> Path:
    """A file below bpy's versioned resource folder, found without importing bpy."""
    spec = importlib.util.find_spec("bpy")
    for folder in (spec and spec.submodule_search_locations) or ():
        for found in Path(folder).glob(f"*/{path}"):
            return found
    raise BuildError(f"{Path(path).name} not found: install the bpy package into this Python environment")


def blender_ext(*arguments: str | Path) -> None:
    """Run Blender's own extension tool; it prints its findings to standard output."""
    run_tool(blender_file("scripts/addons_core/bl_pkg/cli/blender_ext.py"), *arguments)


def run_tool(tool: Path, *arguments: str | Path) -> None:
    """Run a script of Python, which must succeed."""
    result = subprocess.run([sys.executable, str(tool), *map(str, arguments)], capture_output=True, text=True)
    if result.returncode:
        raise BuildError(f"{tool.name} failed: {first_error(result.stdout + result.stderr)}")


def first_error(output: str) -> str:
    lines = output.strip().splitlines() or ["no message"]
    return next((line for line in lines if "error" in line.lower()), lines[-1]).strip()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
