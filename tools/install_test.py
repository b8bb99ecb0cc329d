# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Install a release into a Blender as a user would, use it, and take it out again; prints a line for each step.

    python tools/install_test.py out/package/extensions [BLENDER ...]

Without more words, Blender is the module bpy of the Python that runs this; with them, they are the command that starts
one. That Python has no SciPy of its own where the zip has wheels for it: each step is a process of its own, since
Blender looks for wheels that it has just installed last. Where no wheel is for its Python, as in Blenders that Linux
distributions build with a Python of theirs, the zip without wheels is built and SciPy is that Python's.

Steps: install the zip; enable, make stripes, disable, enable, make stripes; run the Python that README and manual show
from the Text Editor; run the command line of a Blender program; uninstall; nothing is left; the same from the
repository of extensions, by the address of its index.json.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

NAME, REPOSITORY = "synch_fields", "Release"
PLATFORMS = {"linux": "linux_x64", "darwin": "macos_arm64", "win32": "windows_x64"}
MARK = "install-test: "
ROOT = Path(__file__).resolve().parents[1]
# Where the manual shows how Python finds an extension, and the names of the two ways.
MANUAL = ROOT / "docs" / "scripting.md"
DRAGGED, PACKAGE = f"bl_ext.user_default.{NAME}", NAME
# Words behind `--command synch` on a mesh, with the status that Blender ends with.
COMMANDS = {
    ("info", "mesh.obj", "--report", "info.json"): 0,
    ("stripes", "mesh.obj", "--spacing", "0.3", "--output", "out.blend", "--report", "out.json", "--quiet"): 0,
    ("--help",): 0,
    ("stripes", "missing.obj", "--output", "missing.blend"): 1,
    ("stripes", "mesh.obj", "--spacing", "-1"): 1,
    ("stripes", "mesh.obj", "--no-such-flag"): 2,
}


def main(arguments):
    folder, blender = Path(arguments[0]).resolve(), arguments[1:]
    facts = step(blender, None, "about")
    listed = json.loads((folder / "index.json").read_text(encoding="utf-8"))["data"]
    (archive,) = folder.glob(f"*-{PLATFORMS[sys.platform]}.zip")
    (fit,) = [entry for entry in listed if entry["archive_url"].endswith(archive.name)]
    has_wheels = facts["python"] in fit["python_versions"]
    if has_wheels and facts["scipy"]:
        sys.exit(f"install-test: this Python has SciPy {facts['scipy']} already: use an environment with bpy alone")
    with tempfile.TemporaryDirectory() as home:
        if not has_wheels:
            build = [sys.executable, Path(__file__).with_name("extension.py"), "--output-dir", home]
            archive = Path(subprocess.run(build, check=True, capture_output=True, text=True).stdout.strip())
        print(f"Blender {facts['blender']}, Python {facts['python']}: {archive.name}", flush=True)
        ways = {"zip": str(archive)} | ({"repository": (folder / "index.json").as_uri()} if has_wheels else {})
        for way, source in ways.items():
            resources = Path(home, way)
            step(blender, resources, "install", source)
            found = step(blender, resources, "use", source, "wheels" if has_wheels else "own")
            print(f"  from {way}: stripes, disabled, enabled, stripes; SciPy {found['scipy']}", flush=True)
            count = step(blender, resources, "run examples", source)["told"]
            print(f"  {count} examples of README and manual ran from the Text Editor", flush=True)
            if blender:
                run_commands(blender, resources, step(blender, resources, "write a mesh", source)["told"])
                print(f"  --command synch: {len(COMMANDS)} commands ended with their status", flush=True)
            step(blender, resources, "uninstall", source)
            step(blender, resources, "look for what is left", source)
            left = [path for path in resources.rglob("*") if NAME in path.name or "scipy" in path.name]
            if left:
                sys.exit(f"install-test: left behind: {left[0]}")
            print("  uninstalled, nothing is left", flush=True)
            shutil.rmtree(resources)


def step(blender, resources, *words):
    """What a step in a process of its own tells; it must succeed, without an error on the console."""
    here = str(Path(__file__).resolve())
    if blender:
        command = [*blender, "--background", "--python-exit-code", "1", "--python", here, "--", "--step", *words]
    else:
        command = [sys.executable, here, "--step", *words]
    result = subprocess.run(command, capture_output=True, text=True, env=environment(resources))
    told = [line for line in result.stdout.splitlines() if line.startswith(MARK)]
    if result.returncode or not told or "Traceback" in result.stderr:
        sys.exit(f"install-test: {words[0]}: {result.stdout}{result.stderr}")
    return json.loads(told[-1].removeprefix(MARK))


def environment(resources):
    """The variables of a process whose Blender keeps the user's own in a folder, made where it is missing."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    if resources is None:
        return kept
    resources.mkdir(exist_ok=True)
    return kept | {"BLENDER_USER_RESOURCES": str(resources)}


def run_commands(blender, resources, mesh):
    """Run the extension's commands on a mesh; each must end with its status, those that succeed with their files."""
    folder = Path(mesh).parent
    for words, status in COMMANDS.items():
        command = [*blender, "--background", "--command", "synch", *words]
        result = subprocess.run(command, capture_output=True, text=True, env=environment(resources), cwd=folder)
        written = [folder / word for word in words if Path(word).stem in ("info", "out") and "." in word]
        if result.returncode != status or not all(path.stat().st_size for path in written):
            sys.exit(f"install-test: {words}: status {result.returncode}: {result.stdout}{result.stderr}")


def examples(module):
    """Python that README and manual show for an extension of this module's name, as a user adapts it."""
    readme = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE | re.DOTALL)
    manual = re.findall(r"^```python\n(.*?)^```", MANUAL.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    found = [source for source in (*readme, manual[0]) if source]
    return [re.sub(rf"\bfrom ({DRAGGED}|{PACKAGE})\b", f"from {module}", source) for source in found]


def inside(words):
    """Do a step in Blender; a dict that it tells."""
    import bpy

    if len(words) > 1 and not words[1].endswith(".zip"):
        add_repository(bpy, words[1])  # a module does not save preferences
    told = STEPS[words[0]](bpy, *words[1:])
    scipy = sys.modules.get("scipy")
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {"blender": bpy.app.version_string, "python": python, "scipy": scipy and scipy.__version__, "told": told}


def about(_bpy):
    try:
        import scipy  # noqa: F401
    except ImportError:
        pass


def add_repository(bpy, address):
    """Add a repository to the preferences where it is not there."""
    bpy.context.preferences.system.use_online_access = True
    if not any(repository.remote_url == address for repository in bpy.context.preferences.extensions.repos):
        bpy.ops.preferences.extension_repo_add(name=REPOSITORY, remote_url=address, type="REMOTE")


def install(bpy, source):
    if source.endswith(".zip"):
        done = bpy.ops.extensions.package_install_files(filepath=source, repo="user_default", enable_on_install=True)
    else:
        number = number_of(bpy, lambda repository: repository.remote_url == source)
        assert bpy.ops.extensions.repo_sync(repo_index=number) == {"FINISHED"}
        done = bpy.ops.extensions.package_install(repo_index=number, pkg_id=NAME, enable_on_install=True)
    assert done == {"FINISHED"}, done
    assert module_name(bpy)
    bpy.ops.wm.save_userpref()


def number_of(bpy, is_it):
    """Of a repository."""
    return next(k for k, found in enumerate(bpy.context.preferences.extensions.repos) if is_it(found))


def use(bpy, _source, scipy_of):
    import addon_utils  # on the path once bpy is loaded

    name = module_name(bpy)
    for _ in range(2):
        module = addon_utils.enable(name, default_set=False)
        assert module is not None, "the extension cannot be enabled"
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
        assert bpy.ops.synch.stripes() == {"FINISHED"}
        surfaces = sys.modules[f"{name}.synch_addon.blender.pattern_surface"]
        carrier = surfaces.surface_of(bpy.context.object)  # the object, or a finer surface
        values = [element.value for element in carrier.data.attributes["synch_phase"].data]
        assert max(values) - min(values) > 1, "the phase is constant"
        addon_utils.disable(name, default_set=False)
        assert not hasattr(bpy.types, "SYNCH_OT_stripes") and not hasattr(bpy.types.Object, "synch")
    import scipy

    own = Path(bpy.utils.user_resource("EXTENSIONS")).resolve()
    assert Path(scipy.__file__).resolve().is_relative_to(own) == (scipy_of == "wheels"), scipy.__file__


def run_examples(bpy, _source):
    """Run the examples from a Text Editor; returns how many."""
    import addon_utils

    name = module_name(bpy)
    addon_utils.enable(name, default_set=False)
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda area: area.width * area.height)
    area.type = "TEXT_EDITOR"
    sources = examples(name)
    for source in sources:
        area.spaces.active.text = bpy.data.texts.new("example")
        area.spaces.active.text.write(source)
        with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
            assert bpy.ops.text.run_script() == {"FINISHED"}  # an error in it is raised here
    assert json.loads(bpy.context.object.synch.result)["settings"]["seed"] == 3, "the manual's stripes are missing"
    return len(sources)


def write_mesh(bpy, _source):
    """Write a mesh for the command line; returns its path."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    path = os.path.join(os.environ["BLENDER_USER_RESOURCES"], "mesh.obj")
    bpy.ops.wm.obj_export(filepath=path)
    return path


def uninstall(bpy, _source):
    name = module_name(bpy).split(".")[1]
    number = number_of(bpy, lambda repository: repository.module == name)
    assert bpy.ops.extensions.package_uninstall(repo_index=number, pkg_id=NAME) == {"FINISHED"}


def look(bpy, _source):
    import addon_utils

    names = [module.__name__ for module in addon_utils.modules(refresh=True)]
    assert not [name for name in names if NAME in name] and not hasattr(bpy.types, "SYNCH_OT_stripes")


def module_name(bpy):
    """Of the extension, with its repository; the one that is installed."""
    import addon_utils

    names = [module.__name__ for module in addon_utils.modules(refresh=True)]
    (found,) = [name for name in names if name.startswith("bl_ext.") and name.endswith(f".{NAME}")]
    return found


STEPS = {
    "about": about,
    "install": install,
    "use": use,
    "run examples": run_examples,
    "write a mesh": write_mesh,
    "uninstall": uninstall,
    "look for what is left": look,
}


if __name__ == "__main__":
    if "--step" in sys.argv:
        print(MARK + json.dumps(inside(sys.argv[sys.argv.index("--step") + 1 :])), flush=True)
    else:
        main(sys.argv[1:])
