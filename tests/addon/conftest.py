# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests inside Blender: the extension registered once from the source tree, a clean scene before each test.

SYNCH_LANGUAGE names a language of Blender, such as de_DE, in which they run, with the names of new data translated.
A Blender as a module has English alone; `tests/ui/test_languages.py` runs these tests in a real one.
"""

import importlib.util
import os
import shutil
import sys
from functools import wraps

import pytest

_STATUS = pytest.StashKey[int]()
# Files whose tests are about how node groups are drawn, beside the rooms that are.
DRAWN = {"test_saved", "test_transaction"}


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session, exitstatus):
    session.config.stash[_STATUS] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """End at once: where tracebacks of failed tests hold Blender's module, its own exit may wait for ever."""
    bpy = sys.modules.get("bpy")
    if bpy is None or _STATUS not in config.stash:
        return
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    if "coverage" in sys.modules and (measured := sys.modules["coverage"].Coverage.current()):
        measured.stop()
        measured.save()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(config.stash[_STATUS])


class _SkippedModule(pytest.Module):
    def collect(self):
        pytest.skip("bpy is not installed", allow_module_level=True)


def pytest_pycollect_makemodule(module_path, parent):
    """Skip every module here where there is no bpy, so that they may import it at their top."""
    if importlib.util.find_spec("bpy") is None:
        return _SkippedModule.from_parent(parent, path=module_path)
    return None


@pytest.fixture(scope="session")
def extension():
    """The package `synch_fields`, registered in this Blender from the source tree."""
    import bpy

    import synch_fields

    view = bpy.context.preferences.view
    view.language = os.environ.get("SYNCH_LANGUAGE", view.language)
    view.use_translate_new_dataname = True
    synch_fields.register()
    yield synch_fields
    synch_fields.unregister()


@pytest.fixture(scope="session")
def drawn_groups(extension, tmp_path_factory):
    """The larger node groups as the add-on draws them, once, in a .blend file: its path, and for each group its stamp,
    its type and the names of all that come with it."""
    import bpy

    from synch_fields.synch_addon.nodes import canvas, quads, stripes, vortices
    from synch_fields.synch_addon.patterns import relief

    path, found = tmp_path_factory.mktemp("groups") / "groups.blend", {}
    for draw in (
        stripes.stripes_group,
        quads.quads_group,
        vortices.tubes_group,
        lambda: relief.relief_group("stripes"),
        lambda: relief.relief_group("quads"),
    ):
        before = set(bpy.data.node_groups)
        draw()
        trees = {tree.name: tree for tree in set(bpy.data.node_groups) - before}
        found |= {name: (tree[canvas._STAMP], tree.bl_idname, [*trees]) for name, tree in trees.items()}
    bpy.data.libraries.write(str(path), set(bpy.data.node_groups))
    return path, found


@pytest.fixture(scope="module", autouse=True)
def groups_of_a_file(request, drawn_groups):
    """Take node groups from a file, which is quicker than drawing them, save in rooms and files that are about that."""
    import bpy

    from synch_fields.synch_addon.nodes import canvas

    path, found = drawn_groups
    draw = canvas.group_tree

    @wraps(draw)
    def take(name, stamp, inputs, outputs, kind=canvas.Canvas):
        kept_stamp, kept_type, names = found.get(name, (None, None, ()))
        is_kept = (kept_stamp, kept_type) == (stamp, kind.tree_type) and not {*names} & {*bpy.data.node_groups.keys()}
        if is_kept and sys.gettrace() is None:  # faults come to the drawing too
            with bpy.data.libraries.load(str(path)) as (_, wanted):
                wanted.node_groups = [name]
            bpy.data.libraries.remove(bpy.data.libraries[path.name])
        return draw(name, stamp, inputs, outputs, kind)

    with pytest.MonkeyPatch.context() as patch:
        if request.path.parent.name not in ("looks", "nodes") and request.path.stem not in DRAWN:
            for name, module in list(sys.modules.items()):
                if name.startswith("synch_fields.synch_addon.") and getattr(module, "group_tree", None) is draw:
                    patch.setattr(module, "group_tree", take)
        yield


@pytest.fixture(autouse=True)
def blender(extension):
    """bpy with an empty scene and the extension's operators registered. The child process that an earlier test has left
    stays, since its start takes a second, and no job does."""
    import bpy

    from synch_fields.synch_addon.jobs.queue import queue

    worker, queue._worker = queue._worker, None
    bpy.ops.wm.read_homefile(use_empty=True)
    queue._worker = worker
    yield bpy
    assert queue.running is None


@pytest.fixture(autouse=True)
def small_meshes(extension, request):
    """Meshes of most tests are coarse, to be solved in a moment: they carry their patterns themselves all the same. A
    test that is marked with ``any_surface`` sees what users see."""
    with pytest.MonkeyPatch.context() as patch:
        if request.node.get_closest_marker("any_surface") is None:
            patch.setattr("synch_fields.synch_addon.reading.refinement.is_fine", lambda *_: True)
        yield


@pytest.fixture(autouse=True)
def kept_results(extension, request):
    """A request that another test has solved is not solved again, save by tests that replace parts of the program by
    `monkeypatch`, and by those that are about the search. What a test asks for twice it compares: that is solved."""
    from .kept_results import KINDS, kept

    with pytest.MonkeyPatch.context() as patch:
        marks, asked = {mark.name for mark in request.node.iter_markers()}, set()
        if "monkeypatch" not in request.fixturenames and not marks & {"full_search", "slow"}:
            for kind in KINDS:
                patch.setattr(kind, "solve", kept(kind.solve, asked))
        yield
