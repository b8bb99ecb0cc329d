# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking: what an object with stripes or quads shows, as images over one of its UV maps."""

import os
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
from scipy.ndimage import distance_transform_edt

from ...core.errors import SettingError, SynchError
from ...core.extract.quads.trace.cells import cells
from ...core.files.leftovers import own_name, sweep
from ...core.settings.bake import MAPS, NEW_MAP
from ..blender import attributes, meshes
from ..blender import phases as blender_phases
from ..blender.new_geometry import new_mesh
from ..blender.objects import ObjectLink
from ..blender.pattern_surface import surface_of
from ..blender.transaction import keep_file, undone_by, whole_or_nothing
from ..jobs.report import versions
from ..patterns.numbers import numbers_of
from . import images as bake_images
from . import shaders
from .other_process import OtherProcess, can_be_stored
from .scene_copy import make_scene_copy, read_uv, write_uv

# Largest distance of the islands of a new map, in pixels, as a curved surface has hundreds of them. In images below
# the size _SMALL it is the same share of the map as at that size, so that islands do not vanish.
_APART, _SMALL = 4, 256
# Approximate seconds of one core for each pixel of a pass, and for each of its samples; a pass of normals takes several
# times as long, since the height is found at three places. And seconds that another process takes to start.
_PIXEL, _SAMPLE, _NORMAL, _START = 0.5e-6, 0.6e-6, 3, 2.0
# The largest number of a 16-bit PNG.
_MOST_NUMBER = 65535
# How many UV maps a mesh can have.
_MOST_MAPS = 8


class BakeJob:
    """A bake in steps, between which the window is drawn and the bake can be cancelled; see :mod:`..jobs.job`.

    Settings are checked before the first bake. Files and images are made after the last one, so that an error or a
    cancellation leaves none.

    Parameters
    ----------
    obj : bpy.types.Object with a pattern
    settings : BakeSettings
    elsewhere : whether Cycles runs in another process, so that a step does not hold the window
    """

    request = None
    at_once = 0.0

    def __init__(self, obj, settings, elsewhere=False):
        self.link, self.seconds = ObjectLink.to(obj), bake_seconds(settings.maps, settings.size, settings.samples)
        self._pieces, self._report = _baking(self.link, settings, elsewhere), None

    def advance(self):
        """Do the step that was named last; returns the next step's name and the share that is done, None at the end."""
        try:
            return next(self._pieces)
        except StopIteration as end:
            self._report = end.value
            return None
        except OSError as error:
            raise SynchError(f"{error.filename or 'a file'}: {error.strerror or error}") from error

    def close(self):
        """Leave no trace of a bake that has not come to its end."""
        self._pieces.close()

    def write(self, _):
        """Return the report: the bake has written everything itself."""
        return self._report


def bake_seconds(maps, size, samples):
    """About how long a bake with these settings takes."""
    maps = set(maps)
    passes = [samples] * (bool(maps & {"mask", "height"}) + ("colour" in maps) + _NORMAL * ("normal" in maps))
    passes += [1] * len(maps & {"phase", "index"})
    starts = len(maps) - ({"mask", "height"} <= maps)
    working = size**2 * sum(_PIXEL + _SAMPLE * count for count in passes)
    return _START * starts + working / bpy.context.scene.render.threads


def _baking(link, settings, elsewhere):
    """Bake; yields the name of each step before it, and the share of the work done so far; returns the report."""
    obj = link.found  # from here on users can only turn the view, so that the object stays
    with meshes.object_mode(obj):
        start = time.perf_counter()
        kind, folder = _kind(obj), _folder(obj, settings)
        report = {"status": "baked", "command": "bake", "object": obj.name, "pattern": kind, "size": settings.size}
        report |= {"margin": settings.margin, "samples": settings.samples, "maps": {}, "warnings": []}
        report["uv_map"], coordinates = _layer(obj, settings, report["warnings"])
        is_new = coordinates is None
        with tempfile.TemporaryDirectory(prefix=own_name(), dir=folder or bpy.app.tempdir) as temporary:
            if is_new:
                yield "unwrap", 0.0
                with make_scene_copy(obj, modifiers=False) as copy:
                    coordinates = copy.unwrapped(min(max(settings.margin, 1), _APART) / max(settings.size, _SMALL))
            begin = _beginning(elsewhere, Path(temporary))
            yield from _bake_all(obj, kind, settings, coordinates, Path(temporary), report, begin)
            with whole_or_nothing():
                images = _put_files(obj, settings, Path(temporary), folder, report)
                if is_new:
                    _add_layer(obj, report["uv_map"], coordinates)
                if settings.material:
                    given = images, report["uv_map"], settings.displacement, f"{obj.name} Baked"
                    shown = bake_images.show_images(surface_of(obj), kind, *given)
                    report["materials"] = [material.name for material in shown]
    return report | {"seconds": time.perf_counter() - start, "versions": versions()}


def _kind(obj):
    """The kind of the object's pattern, refusing what cannot be baked at all."""
    if not hasattr(bpy.context.scene, "cycles"):
        raise SettingError("Cycles is switched off: enable Cycles Render Engine in Preferences > Add-ons")
    kind = blender_phases.pattern_kind(obj)
    if kind is None:
        raise SynchError(f"{obj.name} has no pattern: solve stripes or quads on it first")
    return kind


def _folder(obj, settings):
    """Where the files go, None where images are packed."""
    given = settings.folder
    if not given:
        return None
    if given.startswith("//") and not bpy.data.filepath:
        raise SettingError(f"{given}: this folder lies beside the .blend: save that first, or choose another folder")
    folder = Path(bpy.path.abspath(given)).resolve()
    if not folder.is_dir():
        raise SettingError(f"{given}: this folder does not exist, create it first")
    if not os.access(folder, os.W_OK):
        raise SettingError(f"{given}: nothing can be written to this folder, choose another")
    sweep(folder)
    for name in settings.maps:
        path = folder / bake_images.file_name(settings, obj.name, name)
        if path.is_dir():
            raise SettingError(f"{path}: this is a folder, choose another name")
    return folder


def _layer(obj, settings, warnings):
    """Name of the UV map, and (c, 2) its coordinates: None where it has to be made."""
    obj = surface_of(obj)
    layers = obj.data.uv_layers
    name = settings.uv_map or (NEW_MAP if settings.unwrap else "")
    layer = layers.get(name) if name else layers.active
    if layer is not None:
        coordinates = read_uv(layer)
        _judge(obj, layer.name, coordinates, warnings)
        return layer.name, coordinates
    if not settings.unwrap:
        which = f"UV map {name!r}" if name else "UV map"
        present = ", ".join(found.name for found in layers) or "none yet"
        raise SettingError(
            f"the mesh {obj.data.name} has no {which}: choose one of its maps ({present}), or ask for Smart UV Project"
        )
    if name in obj.data.attributes:
        raise SettingError(f"the mesh {obj.data.name} has another attribute {name!r}: give the UV map another name")
    if len(layers) >= _MOST_MAPS:
        raise SettingError(f"the mesh {obj.data.name} has {_MOST_MAPS} UV maps, which is the most: remove one")
    return name, None


def _judge(obj, name, coordinates, warnings):
    """Refuse a map that shows nothing, and warn of one that shows something twice or not at all."""
    places = coordinates[meshes.read_polygons(surface_of(obj)).triangle_corners].astype(float)
    sides = places[:, 1:] - places[:, :1]
    area = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]).sum() / 2
    if not area > 0:
        raise SettingError(f"the UV map {name!r} of {obj.data.name} is empty: unwrap the mesh, or ask for a new map")
    outside = np.any((coordinates < -1e-6) | (coordinates > 1 + 1e-6), axis=1).mean()
    if outside > 0:
        warnings.append(f"{outside:.1%} of the corners lie outside the image in the UV map {name!r}")
    if area * (1 - outside) > 1:
        warnings.append(f"faces overlap in the UV map {name!r}: one image cannot show them all")


def _bake_all(obj, kind, settings, coordinates, folder, report, begin):
    """Bake all maps to files in a folder and add them to the report; yields as :func:`_baking`, while another process
    bakes, too. ``begin`` as of :func:`_beginning`."""
    phases = blender_phases.read_phases(obj, kind)
    polygons = meshes.read_polygons(surface_of(obj))
    materials = shaders.sources(surface_of(obj)) or [None]
    if "index" in settings.maps:  # what cannot be numbered is refused before anything is baked
        numbering = cells(phases, polygons) if kind == "quads" else numbers_of(obj, phases[0], polygons)
    is_signed = kind == "stripes" and blender_phases.is_signed(obj, polygons, phases[0])
    if "phase" in settings.maps:
        report["phase"] = shaders.phase_channels(kind, is_signed)
    # Kind of bake, materials, samples, and for each map the channels of the image that it takes.
    passes = (
        ("EMIT", lambda: shaders.glowing_pattern(materials, kind), settings.samples, {"mask": [0], "height": [1]}),
        ("EMIT", lambda: shaders.glowing_colours(materials, kind), settings.samples, {"colour": [0, 1, 2]}),
        ("NORMAL", lambda: shaders.as_rendered(materials), settings.samples, {"normal": [0, 1, 2]}),
        ("EMIT", lambda: shaders.glowing_phase(materials, kind, is_signed), 1, {"phase": [0, 1, 2]}),
    )
    for bake_type, glowing, samples, channels in passes:
        wanted = [name for name in channels if name in settings.maps]
        if not wanted:
            continue
        step = wanted[0], len(report["maps"]) / len(settings.maps)
        yield step
        start = time.perf_counter()
        with make_scene_copy(obj) as copy:
            copy.use_map(report["uv_map"], coordinates)
            copy.prepare(glowing(), settings.size, samples)
            baking = begin(copy, bake_type, settings.margin)
        values = yield from _wait(baking, *step)
        for name in wanted:
            path = folder / bake_images.file_name(settings, obj.name, name)
            bake_images.save(values[:, :, channels[name]], path, settings, name)
        _describe(report, wanted, settings, start)
    if "index" in settings.maps:
        step = "index", len(report["maps"]) / len(settings.maps)
        yield step
        start = time.perf_counter()
        with make_scene_copy(obj, modifiers=False) as copy:
            _lay_flat(copy, polygons, coordinates, settings.size)
            baking = begin(copy, "EMIT", 0)
        seen = yield from _wait(baking, *step)
        numbers = _numbers_at(seen, numbering, settings.margin)
        values = _number_values(numbers, numbering.count, settings, report)
        path = folder / bake_images.file_name(settings, obj.name, "index")
        bake_images.save(values[:, :, None], path, settings, "index")
        _describe(report, ["index"], settings, start)
    yield "write", 1.0


def _beginning(elsewhere, folder):
    """A function (copy, kind, margin) that bakes a prepared :class:`SceneCopy` here, or begins it in another process if
    that can read all of the scene from a file; :func:`_wait` takes what it returns."""

    def begin(copy, kind, margin):
        if elsewhere and can_be_stored(copy.scene):
            return OtherProcess(copy.scene, kind, margin, folder)
        return copy.bake(kind, margin)

    return begin


def _wait(baking, *step):
    """The values of a bake; yields the step while it goes on elsewhere."""
    if not isinstance(baking, OtherProcess):
        return baking
    with baking:
        while baking.is_running:
            yield step
        return baking.values()


def _lay_flat(copy, polygons, coordinates, size):
    """Replace the copy's mesh by its triangles, laid out flat in the UV map, that glow with their indices and
    barycentric coordinates: an image of them gives the place on the surface that each pixel shows."""
    corners = polygons.triangle_corners
    flat = np.column_stack([coordinates[corners.ravel()], np.zeros(corners.size)])
    data = new_mesh("Synch Bake", flat, np.arange(corners.size).reshape(-1, 3))
    data.uv_layers.new(name="Synch Bake").uv.foreach_set("vector", flat[:, :2].astype(np.float32).ravel())
    copy.obj.modifiers.clear()
    copy.obj.data = data
    data.materials.append(None)
    attributes.write_attribute(copy.obj, "triangle", "FACE", "INT", 1 + np.arange(len(corners)))
    for corner in range(2):
        weights = np.tile(np.eye(3)[corner], len(corners))
        attributes.write_attribute(copy.obj, f"weight_{corner}", "CORNER", "FLOAT", weights)
    copy.prepare([shaders.glowing_attributes("triangle", "weight_0", "weight_1")], size, samples=1)


def _numbers_at(seen, numbering, margin):
    """(size, size) numbers of stripes or quads at the middle of each pixel of an image of :func:`_lay_flat`, 0 where
    there is no face."""
    inside = seen[:, :, 0] > 0.5
    triangles, weights = np.rint(seen[inside, 0]).astype(int) - 1, seen[inside, 1:3].astype(float)
    weights = np.column_stack([weights, 1 - weights.sum(axis=1)])
    numbers = np.zeros(inside.shape, int)
    numbers[inside] = numbering.at(triangles, weights)
    return _extend_numbers(numbers, inside, margin)


def _extend_numbers(numbers, inside, margin):
    """Fill pixels that are inside faces or within the margin, and have no number, with the nearest number."""
    if not numbers.any():
        return numbers
    distance, nearest = distance_transform_edt(numbers == 0, return_indices=True)
    return np.where(inside | (distance <= margin), numbers[tuple(nearest)], 0)


def _number_values(numbers, count, settings, report):
    """Numbers as an image's values."""
    report["count"] = count
    if settings.file_format != "PNG":
        return numbers
    if count > _MOST_NUMBER:
        report["warnings"].append(f"{count} numbers are more than a PNG holds: they start again after {_MOST_NUMBER}")
    return np.where(numbers > 0, (numbers - 1) % _MOST_NUMBER + 1, 0) / _MOST_NUMBER


def _describe(report, names, settings, start):
    """Add maps that have been saved to the report; those that were baked together share their time."""
    seconds = (time.perf_counter() - start) / len(names)
    for name in names:
        report["maps"][name] = {"meaning": MAPS[name].meaning, "bits": int(settings.depth(name)), "seconds": seconds}


def _put_files(obj, settings, temporary, folder, report):
    """Put all files in their places, or pack them; returns the images that the .blend holds, by their maps."""
    images = {}
    for name, entry in report["maps"].items():
        target = bake_images.file_name(settings, obj.name, name)
        entry["bytes"] = (temporary / target).stat().st_size
        if folder is None:
            images[name] = bake_images.pack_image(temporary / target, target, name)
            entry["image"] = images[name].name
            continue
        _replace(obj, temporary / target, folder / target)
        entry["file"] = str(folder / target)
        if settings.material:
            images[name] = bake_images.load_image(folder / target, name)
    return images


def _replace(obj, made, place):
    """Put a file in its place, and an older one back there where the work fails."""
    undone_by(obj, lambda: bake_images.reload(place))
    keep_file(obj, place)
    os.replace(made, place)
    bake_images.reload(place)


def _add_layer(obj, name, coordinates):
    """A new UV map; the active ones stay."""
    obj = surface_of(obj)
    layers = obj.data.uv_layers
    active = layers.active and layers.active.name
    rendered = next((layer.name for layer in layers if layer.active_render), None)
    undone_by(obj.data, lambda: name in layers and layers.remove(layers[name]))
    write_uv(layers.new(name=name, do_init=False), coordinates)
    if active:
        layers.active = layers[active]
        layers[rendered].active_render = True
    meshes.update(obj)
