# SPDX-License-Identifier: GPL-3.0-or-later
"""All operators but those of the lists in panels."""

from ..blender.registration import register_all
from . import (
    animate,
    bake,
    clebsch,
    copy_settings,
    defects,
    directions,
    dots,
    end_jobs,
    favourites,
    field_io,
    isolines,
    layer_files,
    layers,
    loops,
    painting,
    pins,
    presets,
    quads,
    refine,
    samples,
    stripes,
    strokes,
    variations,
)

register, unregister = register_all(
    (
        directions.SYNCH_OT_directions,
        stripes.SYNCH_OT_stripes,
        quads.SYNCH_OT_quads,
        quads.SYNCH_OT_quad_mesh,
        quads.SYNCH_OT_quad_mesh_again,
        *end_jobs.CLASSES,
        *variations.CLASSES,
        *favourites.CLASSES,
        *defects.CLASSES,
        *dots.CLASSES,
        *loops.CLASSES,
        *strokes.CLASSES,
        *clebsch.CLASSES,
        *isolines.CLASSES,
        *presets.CLASSES,
        *pins.CLASSES,
        bake.SYNCH_OT_bake,
        copy_settings.SYNCH_OT_copy_settings,
        painting.SYNCH_OT_paint_map,
        refine.SYNCH_OT_refine,
        samples.SYNCH_OT_add_sample,
        layers.SYNCH_OT_layers,
        animate.SYNCH_OT_animate,
        *layer_files.CLASSES,
        *field_io.CLASSES,
    )
)
