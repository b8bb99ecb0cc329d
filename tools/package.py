# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything of a release, from the files as they are; prints the paths of what it makes.

    python tools/package.py [--python] [--output-dir out/package]

With --python, only the package of Python and the recipe are made.


extensions/            a static repository of extensions: a zip for each platform, index.json, index.html. A web server
                       or a folder can serve it; Blender takes the address of index.json, http: or file:
synch_fields-*.tar.gz  the package of Python as source, and
synch_fields-*.whl     as a wheel that is built from that
conda/recipe.yaml      the recipe of conda that builds from that source, at the place where a release has it
SHA256SUMS             of all of them

Two runs on the same files give the same bytes.
"""

import argparse
import gzip
import hashlib
import html
import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path
from urllib.parse import urlencode

from extension import ROOT, BuildError, blender_ext, build, first_error, repack

# What the package of Python is built from.
SOURCES = (
    *("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "CHANGELOG.md", "CITATION.cff", "LICENSE"),
    *("blender_manifest.toml", "py.typed", "__init__.py", "__main__.py", "core", "synch_addon", "examples"),
)
BUILD_SDIST = "import sys; from setuptools.build_meta import build_sdist; build_sdist(sys.argv[1])"
PAGE = """<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<title>Synch Fields {version}</title>
<h1>Synch Fields {version}</h1>
<p>Drag the link of your system into Blender {oldest} or later. To be told of updates, add the address of
<a href="index.json">index.json</a> in Preferences &gt; Get Extensions &gt; Repositories &gt; Add Remote Repository.</p>
<ul>
{rows}
</ul>
</html>
"""
ROW = '<li><a href="{link}">{platforms}</a> (Python {pythons}, {size:.0f} MB, sha256 {checksum})</li>'


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Make all packages of a release.")
    parser.add_argument("--output-dir", type=Path, default=ROOT / "out" / "package", metavar="DIR")
    parser.add_argument("--python", action="store_true", help="only the package of Python and the recipe")
    options = parser.parse_args(arguments)
    folder = options.output_dir
    try:
        shutil.rmtree(folder, ignore_errors=True)  # an older version would be listed, too
        made = [] if options.python else repository(folder / "extensions")
        made += python_packages(folder)
    except BuildError as error:
        print(f"package: {error}", file=sys.stderr)
        return 1
    made.append(recipe(folder))
    made.append(checksums(folder, made))
    print(*made, sep="\n")
    return 0


def repository(folder: Path) -> list[Path]:
    """The zips of all platforms, and what makes their folder a repository of extensions."""
    archives = build(folder, with_wheels=True)
    blender_ext("server-generate", "--repo-dir", folder)
    index = folder / "index.json"
    listed = json.loads(index.read_text(encoding="utf-8"))
    listed["data"].sort(key=lambda entry: entry["archive_url"])  # in the order of the disk before
    index.write_text(json.dumps(listed, indent=2) + "\n", encoding="utf-8")
    page = folder / "index.html"
    page.write_text(page_of(listed["data"]), encoding="utf-8")
    return [*archives, index, page]


def page_of(entries: list[dict]) -> str:
    """A page whose links Blender takes when they are dragged into it: they say what it is to look for."""
    rows = []
    for entry in entries:
        asked = {"repository": "./index.json", "blender_version_min": entry["blender_version_min"]}
        asked |= {name: ",".join(entry[name]) for name in ("platforms", "python_versions")}
        row = ROW.format(
            link=html.escape(f"{entry['archive_url']}?{urlencode(asked)}"),
            platforms=" ".join(entry["platforms"]),
            pythons=" and ".join(version for version in entry["python_versions"] if "." in version),
            size=entry["archive_size"] / 1e6,
            checksum=entry["archive_hash"].removeprefix("sha256:"),
        )
        rows.append(row)
    first = entries[0]
    return PAGE.format(version=first["version"], oldest=first["blender_version_min"], rows="\n".join(rows))


def python_packages(folder: Path) -> list[Path]:
    """The sdist, made of a copy so that nothing of earlier builds gets in, and the wheel that pip builds from it."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        source = Path(place, "source")
        source.mkdir()
        for name in SOURCES:
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(ROOT / name, source)
        run_python("-c", BUILD_SDIST, place, cwd=source)
        (sdist,) = Path(place).glob("*.tar.gz")
        pip = ["-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
        run_python(*pip, "--wheel-dir", place, str(sdist), cwd=source)
        (wheel,) = Path(place).glob("*.whl")
        repack_tar(sdist, folder / sdist.name)
        repack(wheel, folder / wheel.name)
        return [folder / sdist.name, folder / wheel.name]


def run_python(*arguments: str, cwd: Path) -> None:
    result = subprocess.run([sys.executable, *arguments], cwd=cwd, capture_output=True, text=True)
    if result.returncode:
        raise BuildError(f"the package of Python cannot be built: {first_error(result.stdout + result.stderr)}")


def repack_tar(archive: Path, target: Path) -> None:
    """Copy a .tar.gz with its entries in order, without times, owners and the modes of this machine."""
    with (
        tarfile.open(archive) as source,
        gzip.GzipFile(target, "wb", mtime=0) as compressed,
        tarfile.open(fileobj=compressed, mode="w", format=tarfile.PAX_FORMAT) as packed,
    ):
        for entry in sorted(source.getmembers(), key=lambda entry: entry.name):
            plain = tarfile.TarInfo(entry.name)
            plain.type, plain.size, plain.mode = entry.type, entry.size, 0o755 if entry.isdir() else 0o644
            packed.addfile(plain, source.extractfile(entry) if entry.isfile() else None)


def recipe(folder: Path) -> Path:
    """The recipe of the checkout, with the source of a release in place of the checkout."""
    (sdist,) = folder.glob("*.tar.gz")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    name = sdist.name.replace(sdist.name.split("-")[1].removesuffix(".tar.gz"), "${{ version }}")
    address = f"{project['urls']['Repository']}/releases/download/v${{{{ version }}}}/{name}"
    text = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    source = f"url: {address}\n  sha256: {hashlib.sha256(sdist.read_bytes()).hexdigest()}\n"
    made = folder / "conda" / "recipe.yaml"
    made.parent.mkdir()
    made.write_text(text.replace("path: ../..\n", source), encoding="utf-8")
    return made


def checksums(folder: Path, files: list[Path]) -> Path:
    """A file that `sha256sum --check` reads, with all others in it."""
    path = folder / "SHA256SUMS"
    found = {file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
    path.write_text("".join(f"{found[name]}  {name}\n" for name in sorted(found)), encoding="utf-8")
    return path


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
