# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pattern rebuilt from the attributes alone, and its largest jump across the edges of a mesh."""

import numpy as np

from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import FacePhases, evaluate

from .scenes import attribute


def polygons_of(obj):
    """Faces and loop triangles of an object, without the extension's own reader."""
    mesh = obj.data
    mesh.calc_loop_triangles()

    def read(elements, name, width=1):
        values = np.empty(len(elements) * width, np.int32)
        elements.foreach_get(name, values)
        return values.astype(int).reshape(-1, width) if width > 1 else values.astype(int)

    return Polygons(
        read(mesh.loops, "vertex_index"),
        read(mesh.polygons, "loop_start"),
        read(mesh.polygons, "loop_total"),
        read(mesh.loop_triangles, "loops", 3),
        read(mesh.loop_triangles, "polygon_index"),
    )


def phases_of(obj, suffix=""):
    """:class:`FacePhases` from nothing but the attributes: of stripes, or of a phase of quads ("_x", "_y")."""

    def read(name, absent):
        return attribute(obj, name).astype(float) if name in obj.data.attributes else absent

    count = len(obj.data.polygons)
    rim = read("synch_disclination" + suffix, np.zeros((count, 4)))
    return FacePhases(
        corner_phase=attribute(obj, "synch_phase" + suffix).astype(float),
        corner_place=attribute(obj, "synch_barycentric").astype(float),
        index=attribute(obj, "synch_index" + suffix),
        index_2=read(f"synch_index{suffix}_2", np.zeros(count)),
        disclination=rim,
        closing=attribute(obj, "synch_closing")[:, "_x_y".index(suffix) // 2].astype(float) if suffix else -rim[:, 0],
        unfit=np.empty(0, int),
    )


def largest_jump(obj, samples=10):
    """Largest jump of the product of cosines over the edges of the loop triangles, and how many were compared."""
    polygons = polygons_of(obj)
    suffixes = ("_x", "_y") if "synch_phase_x" in obj.data.attributes else ("",)
    phases = [phases_of(obj, suffix) for suffix in suffixes]
    triangles = polygons.triangles
    keys, waves = [], []
    for k in range(3):
        tails, heads = triangles[:, k], triangles[:, (k + 1) % 3]
        keys.append(np.minimum(tails, heads) * len(obj.data.vertices) + np.maximum(tails, heads))
        wave = np.empty((len(triangles), samples))
        for s, x in enumerate(np.linspace(0, 1, samples)):
            weights = np.zeros((len(triangles), 3))
            weights[:, k] = np.where(tails < heads, 1 - x, x)
            weights[:, (k + 1) % 3] = 1 - weights[:, k]
            here = [evaluate(phase, polygons, np.arange(len(triangles)), weights) for phase in phases]
            wave[:, s] = np.cos(here).prod(axis=0)
        waves.append(wave)
    keys, waves = np.concatenate(keys), np.concatenate(waves)
    order = np.argsort(keys, kind="stable")
    keys, waves = keys[order], waves[order]
    shared = np.flatnonzero(keys[1:] == keys[:-1])
    return np.abs(waves[shared] - waves[shared + 1]).max(), len(shared)
