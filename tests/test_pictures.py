# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the README and the manual are sharp, not mostly background, and in their captions' colours."""

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from synch_fields.docs.make import webp  # noqa: E402
from synch_fields.docs.make.sheets import LETTERS, beside, pixels_of, save_pixels  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
LINK = re.compile(r"!\[[^\]]*\]\(([^)]+\.(?:png|webp))\)")
LINKED = sorted({(page.parent / link).resolve() for page in PAGES for link in LINK.findall(page.read_text("utf-8"))})

# Colours as conditions on red, green and blue from 0 to 1.
COLOURS = {
    "ink": lambda r, g, b: (b - r > 0.03) & (b < 0.55),
    "ivory": lambda r, g, b: (r - b > 0.045) & (r - b < 0.4) & (r > 0.35) & (r - g < 0.12),
    "rose": lambda r, g, b: (r - g > 0.3) & (b - g > 0.03),
    "orange": lambda r, g, b: (r - b > 0.3) & (r - g > 0.08),
    "blue": lambda r, g, b: (b - r > 0.25) & (b > 0.5),
    "green": lambda r, g, b: (g - r > 0.06) & (g - b > 0.06),
    "teal": lambda r, g, b: (g - r > 0.15) & (b - r > 0.15),
    "violet": lambda r, g, b: (r - g > 0.15) & (b - g > 0.15),
}
# For each picture, the colours that its caption promises, each with the least share of the pixels that must have it.
STRIPED = {"ink": 0.03, "ivory": 0.1}
EXPECTED = {
    "docs/moving.webp": {"ink": 0.015, "ivory": 0.1},
    "docs/animation.png": STRIPED,
    "docs/bake.png": {"ink": 0.1, "ivory": 0.1, "blue": 0.1},
    "docs/bunny.png": STRIPED,
    "docs/click_2.png": {"blue": 0.02},
    "docs/click_3.png": {"blue": 0.02, "ink": 0.01, "ivory": 0.005},
    "docs/click_4.png": {"ink": 0.03, "ivory": 0.02},
    "docs/constraints.png": STRIPED | {"rose": 0.004},
    "docs/contact_sheet.png": {"ink": 0.02, "ivory": 0.02},
    "docs/flows.png": {"orange": 0.02, "green": 0.01, "violet": 0.01},
    "docs/gallery.png": STRIPED | {"orange": 0.03, "teal": 0.02},
    "docs/makes/directions.png": STRIPED,
    "docs/makes/layers.png": {"rose": 0.08, "ivory": 0.1},
    "docs/makes/quad_mesh.png": {"ink": 0.02, "ivory": 0.1},
    "docs/makes/quads.png": STRIPED,
    "docs/makes/stripes.png": STRIPED,
    "docs/makes/vortices.png": {"green": 0.05, "orange": 0.02, "rose": 0.01, "blue": 0.01},
    "docs/panel.png": {"blue": 0.015},
    "docs/dots.png": STRIPED | {"orange": 0.0005},
    "docs/panels.png": {"blue": 0.02, "ivory": 0.005},
    "docs/panels_de.png": {"blue": 0.02, "ivory": 0.005},
    "docs/paper/figure1.png": {"rose": 0.05, "ivory": 0.1},
    "docs/paper/figure2.png": {"rose": 0.05, "ink": 0.02},
    "docs/paper/figure3.png": {"rose": 0.03, "blue": 0.03},
    "docs/paper/figure4.png": STRIPED,
    "docs/paper/figure5.png": {"green": 0.02, "blue": 0.02, "orange": 0.02},
    "docs/paper/figure6.png": STRIPED,
    "docs/paper/figure7.png": {"ink": 0.1, "ivory": 0.1, "blue": 0.05},
    "docs/paper/figure8.png": STRIPED,
    "docs/paper/figure9.png": {"rose": 0.002, "blue": 0.003, "green": 0.003},
    "docs/printing.png": {"orange": 0.1},
    "docs/progress.png": {"blue": 0.05},
    "docs/quad_mesh.png": {"ink": 0.02, "ivory": 0.2},
    "docs/quads.png": STRIPED,
    "docs/simple.png": {"ink": 0.01, "ivory": 0.02},
    "docs/loops.png": {"ink": 0.02, "ivory": 0.1, "blue": 0.004},
    "docs/sliders.png": {"ink": 0.02, "ivory": 0.2},
    "docs/spot.png": STRIPED,
    "docs/strokes.png": {"ink": 0.1, "ivory": 0.1},
    "docs/suzanne.png": STRIPED,
    "docs/vortices.png": {"green": 0.05, "orange": 0.02, "rose": 0.01, "blue": 0.01},
}
# The largest share of pixels of about one colour; a diagram is mostly paper.
MOST_BACKGROUND, MOST_PAPER, DIAGRAMS = 0.8, 0.95, ("docs/paper/figure9.png",)
# Not dark: at most this share of the pixels is nearly black. Not cut off: neighbours in the last row, where a panel
# would go on, differ by less than this; in pictures of one object, on all sides. Around what is baked images are black.
DARK, MOST_DARK, LARGEST_STEP, LARGEST_AROUND, IMAGES = 0.1, 0.01, 0.2, 0.1, ("docs/bake.png",)
OF_ONE_OBJECT = ("docs/makes/", "docs/bunny.png", "docs/spot.png", "docs/suzanne.png", "docs/vortices.png")
# Sharp: the hundredth of the pixels that differ most from their neighbours differ by at least this.
LEAST_CONTRAST = 0.02


def faults(pixels, expected, background=MOST_BACKGROUND):
    """What is wrong with (height, width, 3) pixels from 0 to 1, as lines."""
    red, green, blue = np.moveaxis(pixels, -1, 0)
    shares = {name: float(COLOURS[name](red, green, blue).mean()) for name in expected}
    found = [f"{name}: {shares[name]:.3f}" for name, least in expected.items() if shares[name] < least]
    steps = np.abs(np.diff(pixels.mean(axis=2), axis=1))
    if np.quantile(steps, 0.99) < LEAST_CONTRAST:
        found.append("not sharp")
    counts = np.unique(np.rint(pixels * 32).astype(int) @ [1, 64, 4096], return_counts=True)[1]
    if counts.max() > background * counts.sum():
        found.append(f"one colour on {counts.max() / counts.sum():.0%}")
    return found


def dark_or_cut(pixels, all_sides):
    """What is too dark in (height, width, 3) pixels or goes on beyond their edge, as lines."""
    found = []
    dark = float((pixels.max(axis=2) < DARK).mean())
    if dark > MOST_DARK:
        found.append(f"black on {dark:.0%}")
    sides = {"below": pixels[-1]}
    if all_sides:
        sides |= {"above": pixels[0], "left": pixels[:, 0], "right": pixels[:, -1]}
    for name, side in sides.items():
        step = np.abs(np.diff(side.mean(axis=1))).max()
        if step > (LARGEST_AROUND if all_sides else LARGEST_STEP):
            found.append(f"cut off {name}")
    return found


def pictures_of(path, folder):
    """The pixels of a picture, or of some frames of a moving one."""
    if path.suffix != ".webp":
        return [pixels_of(path)[..., :3]]
    stills = webp.frames(path.read_bytes())[0]
    pictures = []
    for still in stills[:: len(stills) // 6]:
        (folder / "still.webp").write_bytes(still)
        pictures.append(pixels_of(folder / "still.webp")[..., :3])
    return pictures


def name_of(path):
    return path.relative_to(ROOT).as_posix()


def test_every_picture_says_which_colours_it_shows():
    assert {name_of(path) for path in LINKED} == EXPECTED.keys()


@pytest.mark.parametrize("path", LINKED, ids=name_of)
def test_a_picture_shows_what_its_caption_says(path, tmp_path):
    background = MOST_PAPER if name_of(path) in DIAGRAMS else MOST_BACKGROUND
    for pixels in pictures_of(path, tmp_path):
        assert not faults(pixels, EXPECTED[name_of(path)], background)
        if name_of(path) not in IMAGES:
            assert not dark_or_cut(pixels, name_of(path).startswith(OF_ONE_OBJECT))


def test_a_view_whose_shaders_still_compile_is_found():
    """A grey viewport with an outline in orange, as Blender draws it until an object's material is ready."""
    view = np.full((460, 530, 3), 0.24)
    y, x = np.mgrid[:460, :530]
    view[np.abs(np.hypot(x - 265, y - 230) - 150) < 1.5] = (1.0, 0.6, 0.1)
    found = faults(view, EXPECTED["docs/click_4.png"])
    assert {"ink: 0.000", "ivory: 0.000", "one colour on 99%"} <= set(found)


@pytest.mark.parametrize(("rows", "found"), [(slice(375), ["cut off below"]), (slice(None), [])])
def test_a_panel_that_goes_on_is_found(rows, found):
    """The first rows of the simple panel, through its thumbnails, and all of it."""
    assert dark_or_cut(pixels_of(ROOT / "docs" / "simple.png")[rows.start : rows.stop, :, :3], False) == found


def test_a_dark_or_cropped_picture_is_found():
    whole = pixels_of(ROOT / "docs" / "spot.png")[..., :3]
    assert dark_or_cut(whole, True) == []
    assert dark_or_cut(whole[:, 500:], True) == ["cut off left"]
    assert dark_or_cut(0.1 * whole, True) == ["black on 100%"]


def test_stripes_of_the_moving_picture_lie_farther_apart_when_its_knob_spacing_goes_up(tmp_path):
    """The knob is turned in the first half of the frames with stripes, two thirds of all."""
    stills = webp.frames((ROOT / "docs" / "moving.webp").read_bytes())[0]
    counts = []
    for still in stills[0], stills[len(stills) // 3]:
        (tmp_path / "still.webp").write_bytes(still)
        ink = pixels_of(tmp_path / "still.webp")[:, :500, 2] < 0.45  # beside the knobs
        counts.append((np.diff(ink, axis=1)).sum())
    assert counts[1] < 0.7 * counts[0]


def test_the_moving_picture_is_small_and_moves():
    path = ROOT / "docs" / "moving.webp"
    stills, milliseconds = webp.frames(path.read_bytes())
    assert path.stat().st_size < 3_000_000
    assert 60 <= len(stills) <= 90 and len(set(stills)) > 50
    assert min(milliseconds) > 0 and sum(milliseconds) < 20_000
    assert webp.frames(webp.animated(stills, (640, 400), milliseconds)) == (stills, milliseconds)


@pytest.mark.parametrize("vertical", [False, True])
def test_labels_are_above_pictures_side_by_side_and_on_the_left_of_those_below_one_another(tmp_path, vertical):
    save_pixels(tmp_path / "one.png", np.ones((150, 180, 3)))
    beside([tmp_path / "one.png"] * 2, tmp_path / "sheet.png", vertical, labels=["first", "second"])
    sheet = pixels_of(tmp_path / "sheet.png")[..., :3]
    turned = np.rot90(sheet, -1) if vertical else sheet
    band, below = np.split(turned, [2 * LETTERS])
    assert below.shape == ((180, 300, 3) if vertical else (150, 360, 3)) and (below == 1).all()
    assert all((half < 0.5).any() for half in np.split(band, 2, axis=1))


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "make").glob("*.py")), ids=lambda path: path.stem)
def test_what_makes_the_pictures_can_be_imported(path):
    importlib.import_module(f"synch_fields.docs.make.{path.stem}")
