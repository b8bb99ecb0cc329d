# SPDX-License-Identifier: GPL-3.0-or-later
"""The library of assets that ships with the extension: presets as materials, and the node groups.

`tools/assets.py` makes it from the code that builds materials and groups in every file.
It is listed in the preferences only when the user asks for it.
"""

import shutil
import uuid
from pathlib import Path

import bpy
import numpy as np

from ..nodes.quads import quads_group
from ..nodes.stripes import stripes_group
from ..patterns.relief import relief_group
from .presets import PRESETS, preset_material

NAME, AUTHOR = "Synch Fields", "Synch Fields contributors"
FILE, CATALOGS = "synch_fields.blend", "blender_assets.cats.txt"
FOLDER = Path(__file__).parent / "library"
THUMBNAILS = Path(__file__).parent / "thumbnails"

_NOTICE = "LICENSE.txt"
# Name of a group: what it is, and its thumbnail.
GROUPS = {
    "Synch Stripes": ("Stripes on a mesh with their attributes: colors, profile, place across and along", "stripes"),
    "Synch Quads": ("Grid lines, checker, weave or dots on a mesh with the attributes of quads", "quads"),
    "Synch Relief": ("Raises a mesh by the profile of its stripes", "relief"),
    "Synch Quad Relief": ("Raises a mesh by the profile of its quads", "quad-relief"),
}


def write_library(folder):
    """Write the .blend, its catalogs and its licence to a folder, from an empty file; returns the .blend's path."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    assets = set()
    for name, preset in PRESETS.items():
        material = preset_material(name)
        _mark(material, "Materials", preset.description, THUMBNAILS / f"{name}.png", preset.kind)
        assets.add(material)
    for group in (stripes_group(), quads_group(), relief_group("stripes"), relief_group("quads")):
        text, thumbnail = GROUPS[group.name]
        _mark(group, "Node Groups", text, THUMBNAILS / f"{thumbnail}.png", "node group")
        assets.add(group)
    path = folder / FILE
    bpy.data.libraries.write(str(path), assets, fake_user=True, compress=True)
    lines = [f"{_catalog(name)}:{NAME}/{name}:{NAME}-{name}" for name in ("Materials", "Node Groups")]
    (folder / CATALOGS).write_text("\n".join(["VERSION 1", "", *lines, ""]), encoding="utf-8")
    shutil.copy(THUMBNAILS / _NOTICE, folder / _NOTICE)
    return path


def _catalog(name):
    """The catalog's identifier, the same in every version of the library."""
    return str(uuid.uuid5(uuid.NAMESPACE_DNS, f"{NAME} {name}"))


def _mark(block, catalog, text, picture, *tags):
    """Mark a datablock as an asset with a picture."""
    block.asset_mark()
    data = block.asset_data
    data.catalog_id, data.description, data.author = _catalog(catalog), text, AUTHOR
    data.license, data.copyright = "CC0-1.0", f"2026 {AUTHOR}"
    for tag in ("Synch Fields", *tags):
        data.tags.new(tag)
    image = bpy.data.images.load(str(picture))
    pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(pixels)
    preview = block.preview_ensure()
    preview.image_size = image.size
    preview.image_pixels_float.foreach_set(pixels)
    bpy.data.images.remove(image)


def is_registered(preferences):
    """Whether the library is among those of the preferences."""
    return any(Path(library.path) == FOLDER for library in preferences.filepaths.asset_libraries)


def register_library(preferences):
    """List the library in the preferences; returns its entry."""
    libraries = preferences.filepaths.asset_libraries
    for library in libraries:
        if Path(library.path) == FOLDER:
            return library
    return libraries.new(name=NAME, directory=str(FOLDER))
