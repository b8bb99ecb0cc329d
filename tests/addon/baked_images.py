# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked patterns and what the core says of them at every texel."""

import bpy
import numpy as np

from synch_fields.core.interpolate import evaluate
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.patterns import memory

from .scenes import attribute, quad_sphere, sphere

SIZE = 192
WIDTH, SOFTNESS = 0.5, 0.02
PATTERNS = {"stripes": (lambda: sphere(3), 0.5), "quads": (lambda: quad_sphere(7), 0.7)}


def patterned(kind="stripes", **settings):
    """An object with a pattern that has defects of both kinds, and no UV map yet."""
    build, spacing = PATTERNS[kind]
    obj = build()
    for layer in list(obj.data.uv_layers):
        obj.data.uv_layers.remove(layer)
    getattr(api, kind)(obj, **{"spacing": spacing} | settings)
    if kind == "quads":
        assert api.place_defects(obj, [40])["dislocations"]  # the solution has none
    return obj


def bake(obj, folder, **settings):
    """Bake into files that are called as their maps."""
    standard = dict(size=SIZE, margin=2, samples=1, unwrap=True, folder=str(folder), naming="{map}")
    return api.bake(obj, **standard | settings)


def rasterised(obj, size=SIZE, layer="Synch Bake"):
    """Pixels (row, column) whose middle lies in a face, the triangles there, and (k, 3) weights of their corners."""
    polygons = meshes.read_polygons(obj)
    uv = attribute(obj, layer).astype(float)[polygons.triangle_corners] * size
    pixels, triangles, weights = [], [], []
    for triangle, corners in enumerate(uv):
        low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
        x, y = np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high, strict=True)))
        matrix = np.vstack([corners.T, np.ones(3)])
        inside = np.linalg.solve(matrix, np.vstack([x.ravel() + 0.5, y.ravel() + 0.5, np.ones(x.size)])).T
        kept = inside.min(axis=1) > 1e-3
        pixels.append(np.column_stack([y.ravel(), x.ravel()])[kept].astype(int))
        triangles.append(np.full(kept.sum(), triangle))
        weights.append(inside[kept])
    return np.concatenate(pixels), np.concatenate(triangles), np.concatenate(weights)


def phases_at(obj, size=SIZE, layer="Synch Bake"):
    """Pixels, and the (k, p) phases of the solved pattern there: what the core says, without any attribute."""
    pixels, triangles, weights = rasterised(obj, size, layer)
    polygons = meshes.read_polygons(obj)
    solved = memory.recall(obj)
    assert {d["kind"] for d in solved.plain["disclinations"] + solved.plain["dislocations"]} == {
        "disclination",
        "dislocation",
    }
    phases = [evaluate(phase, polygons, triangles, weights) for phase in solved.pattern.on_faces(polygons)]
    return pixels, np.column_stack(phases)


def inside_of(phases):
    """Distance to the edge of a stripe or grid line, in periods or cells, and the largest one."""
    if phases.shape[1] == 1:
        away = np.abs((phases[:, 0] + np.pi) % (2 * np.pi) - np.pi)
        return (WIDTH - away / np.pi) / 2, WIDTH / 2
    line = 1 - np.sqrt(1 - WIDTH)
    away = np.abs((phases + np.pi / 2) % np.pi - np.pi / 2).min(axis=1) / np.pi
    return line / 2 - away, line / 2


def picture(path, size=SIZE, space="Non-Color"):
    """(size, size, 4) values of an image file or image as they are stored, the lowest row first."""
    image = path if isinstance(path, bpy.types.Image) else bpy.data.images.load(str(path))
    values = np.empty(size * size * 4, np.float32)
    kept, image.colorspace_settings.name = image.colorspace_settings.name, space
    image.pixels.foreach_get(values)
    image.colorspace_settings.name = kept
    return values.reshape(size, size, 4)
