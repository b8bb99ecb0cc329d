# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels at their default width: all of them open in a picture, nothing cut off, nothing that moves while a job
runs."""

import time

import numpy as np
import pytest

from . import reading
from .conftest import SPEAK, _installed
from .test_window import add_ball

# Shows all panels open, as a click on the title of each would.
_OPEN = """
for name in [name for name in dir(bpy.types) if name.startswith("SYNCH_PT_")]:
    kind = getattr(bpy.types, name)
    if hasattr(kind, "bl_options") and name != "SYNCH_PT_presets":
        kind.bl_options = kind.bl_options - {"DEFAULT_CLOSED"}
names = part("panels")
names.unregister(); names.register()
"""
_ACTIVE = (
    "[one.select_set(False) for one in bpy.context.selected_objects]; "
    "bpy.context.view_layer.objects.active = {0}; {0}.select_set(True); area().tag_redraw()"
)
PANEL = "part('settings.preferences').preferences().panel = {!r}; area().tag_redraw()"


@pytest.fixture(scope="module")
def tall(tmp_path_factory):
    """A window that is high enough for all panels at once."""
    with _installed(tmp_path_factory.mktemp("tall"), (800, 3700)) as blender:
        blender.run("bpy.data.objects.remove(bpy.data.objects['Cube'])")
        blender.run(SPEAK)
        blender.run(_OPEN)
        blender.open_panel()
        add_ball(blender, 2)
        blender.run("area().spaces[0].overlay.show_overlays = False; view().view_location = 9, 9, 0")
        yield blender


def panels(blender):
    """The sidebar as far down as it shows something."""
    blender.move((5, 5))
    blender.run("area().tag_redraw()")
    time.sleep(1)
    picture = blender.picture("UI")
    rows = np.flatnonzero(np.isin(picture[:, 12, 0], (54, 61)))  # the greys of panels
    return picture[: rows[-1] + 8]


def in_columns(pictures, height=1100):
    """Tall pictures side by side, cut into columns at rows where nothing is drawn."""
    columns = []
    for picture in pictures:
        body = picture[:, :265]
        quiet = np.flatnonzero((body[:, 14:250].std(axis=1) < 1.5).all(axis=1))
        start = 0
        while start < len(body):
            last = quiet[(quiet > start) & (quiet < start + height)].max()
            stop = len(body) if len(body) <= start + height else last
            columns.append(np.full((height, body.shape[1], 3), 61, np.uint8))
            columns[-1][: stop - start] = body[start:stop]
            start = stop
    return np.concatenate(columns, axis=1)


@pytest.mark.parametrize("kind", ["quads", "quad_mesh", "directions"])
def test_what_only_a_kind_has_is_shown_with_it(tall, kind):
    tall.run(f"active().synch_simple.kind = {kind!r}")
    tall.run(PANEL.format("ADVANCED"))
    tall.wait_for("Surface")
    for text, kinds in (
        ("Face Count", ["quad_mesh"]),
        ("Aspect", ["quads", "quad_mesh"]),
        ("Symmetry", ["directions"]),
    ):
        assert tall.shows(text) == (kind in kinds), text


def cut_off(blender, picture):
    """Where a picture shows a text that is cut off: Blender ends one with three dots.

    These are seen at 0.96 and 0.99, other marks of the panel at 0.81.
    """
    dots = np.array(blender.value("drawn_text('…', 11)"), np.uint8)[:8, 1:13]
    return reading.places(picture, dots, alike=0.9).tolist()


@pytest.mark.parametrize("language", ["en_US", "de_DE"])
def test_no_text_is_cut_off(tall, keep, language):
    tall.run(f"bpy.context.preferences.view.language = {language!r}; active().synch_simple.kind = 'stripes'")
    if not tall.value("bool(active().synch.result)"):
        tall.run("bpy.ops.synch.stripes('INVOKE_DEFAULT')")
        tall.until("bool(active().synch.result)")
    gallery = "part('panels.thumbnails').galleries.of(active())"
    tall.until(f"len({gallery}.made) == {gallery}.count")
    kept = []
    for kind in ("stripes", "quads", "quad_mesh", "directions"):
        for choice in ("SIMPLE", "ADVANCED"):
            tall.run(f"active().synch_simple.kind = {kind!r}; " + PANEL.format(choice))
            picture = panels(tall)
            assert cut_off(tall, picture) == [], (kind, choice)
            kept.append(picture)
    keep(f"panels_{language}", in_columns(kept[:2]))
    tall.run(SPEAK)


def test_nothing_moves_while_a_job_runs(tall, keep):
    tall.run("active().synch_simple.kind = 'stripes'; active().synch_simple.lines = 5")
    tall.run(PANEL.format("ADVANCED"))
    names = ("Direction", "Singularities", "Pattern")
    before = [tall.wait_for(name)[1] for name in names]
    tall.click("Stripes")
    tall.until("part('jobs.queue').queue.running is not None")
    seen = []
    while tall.value("part('jobs.queue').queue.running is not None"):
        seen.append([tall.wait_for(name)[1] for name in names])
    tall.until("bool(active().synch.result)")
    after = [tall.wait_for(name)[1] for name in names]
    assert seen and all(np.allclose(places, before) for places in (*seen, after))


def test_nothing_moves_while_a_job_of_another_object_runs(tall):
    tall.run(PANEL.format("ADVANCED") + "; first = active()")
    names = ("Direction", "Singularities", "Pattern", "Make")
    before = [tall.wait_for(name)[1] for name in names]
    tall.run("bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5); other = active()")
    tall.run(f"bpy.ops.synch.stripes('INVOKE_DEFAULT'); {_ACTIVE.format('first')}")
    tall.wait_for("Jobs")
    assert np.allclose([tall.wait_for(name)[1] for name in names], before)
    tall.run("queue = part('jobs.queue').queue; queue.cancel(queue.running); area().tag_redraw()")
    tall.until("queue.running is None")
    assert not tall.shows("Jobs") and np.allclose([tall.wait_for(name)[1] for name in names], before)
    tall.run("bpy.data.objects.remove(other)")


@pytest.fixture(scope="module")
def made(tall):
    """The tall window with layers, a quad mesh and filaments: the code that makes each of them the active object."""
    ball = tall.value("active().name")
    ways = {
        "layers": "bpy.ops.synch.layers()",
        "quad_mesh": "bpy.ops.synch.quad_mesh(faces=200)",
        "filaments": "bpy.ops.curve.primitive_bezier_circle_add(radius=1); "
        "bpy.ops.synch.clebsch(resolution=16, by='CIRCULATION', quantum=1.0, show='BOTH', target_gap=0.05)",
    }
    chosen = {}
    for kind, way in ways.items():
        tall.run(f"made_of = bpy.data.objects[{ball!r}]; made_of.hide_set(False); {_ACTIVE.format('made_of')}; {way}")
        chosen[kind] = _ACTIVE.format(f"bpy.data.objects[{tall.value('active().name')!r}]")
    yield chosen
    tall.run(f"bpy.data.objects[{ball!r}].hide_set(False); {_ACTIVE.format(f'bpy.data.objects[{ball!r}]')}")


@pytest.mark.parametrize("language", ["en_US", "de_DE"])
def test_no_text_of_what_was_made_is_cut_off(tall, made, keep, language):
    tall.run(f"bpy.context.preferences.view.language = {language!r}; " + PANEL.format("ADVANCED"))
    kept = []
    for kind, choose in made.items():
        tall.run(choose)
        kept.append(panels(tall))
        keep(f"made_{kind}_{language}", kept[-1])
        assert cut_off(tall, kept[-1]) == [], kind
    tall.run(SPEAK)


def test_nothing_moves_while_a_job_of_layers_runs(tall, made):
    """The job is of the solid, and the active object shows its layers."""
    tall.run(made["layers"] + "; " + PANEL.format("ADVANCED"))
    names = ("Cut Open", "Tool Paths")
    before = [tall.wait_for(name)[1] for name in names]
    tall.click("Tool Paths")
    seen = []
    while tall.value("part('jobs.queue').queue.running is not None") or not seen:
        seen.append([tall.wait_for(name)[1] for name in names])
    assert all(np.allclose(places, before) for places in seen)
