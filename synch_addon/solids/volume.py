# SPDX-License-Identifier: GPL-3.0-or-later
"""A volume of the layers' pattern: an OpenVDB file of cos(phase), and a volume object that shows it."""

from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.extract.voxels import points_inside
from ...core.interpolate_solid import evaluate_in_tets
from ..blender.files import check_output, check_written, unwritten
from ..blender.openvdb import openvdb_module
from ..nodes.canvas import surface_material
from .objects import placed

GRID, MATERIAL = "pattern", "Synch Volume"
# The node that has the density, and the custom property of the object with the spacing that it was made for.
_DENSITY, _SPACING = "Density", "synch_spacing"
# Outside of the solid; half way between layers inside.
_NOTHING, _LEAST = -1.0, np.nextafter(np.float32(-1), np.float32(0))
# A microsecond and four bytes each.
MOST_VOXELS = 50_000_000
# Values of the pattern at which a layer begins to show, and is opaque; how much light it takes on its thickness.
_THIN, _THICK, _OPACITY = 0.55, 0.9, 8.0
_COLOR = (0.32, 0.62, 0.82, 1.0)


def check_volume(path, resolution):
    """Refuse what needs no layers to be found wrong: the file, the resolution, or a Blender without OpenVDB."""
    check_output(path, [".vdb"])
    if resolution < 2:
        raise SettingError(f"a resolution of {resolution} voxels shows no layer: give 2 or more")
    openvdb_module()


def write_volume(obj, layering, path, resolution=128):
    """Write the pattern to a file and make a volume object of it; returns the object and the number of voxels inside.

    The grid holds cos(phase) at the middles of its voxels, which is 1 on the layers; outside, it is -1 and inactive.

    Parameters
    ----------
    obj : the object whose layers are shown
    layering : Layering
    path : .vdb
    resolution : voxels along the longest side
    """
    check_volume(path, resolution)
    solid, path = layering.solid, Path(path).absolute()
    low = solid.vertices.min(axis=0)
    extents = np.ptp(solid.vertices, axis=0)
    step, counts = _grid(extents, resolution)
    if counts.prod(dtype=float) > MOST_VOXELS:
        raise SettingError(
            f"a resolution of {resolution} makes {counts.prod(dtype=float):.1e} voxels, and {MOST_VOXELS:.0e} is the "
            f"most: reduce it to {_fitting(extents, resolution)}"
        )
    origin = low + (extents - step * (counts - 1)) / 2
    voxels = _write_grid(path, _pattern(layering, origin, step, counts), origin, step)
    data = bpy.data.volumes.new(f"{obj.name} Volume")
    data.filepath = str(path)
    made = placed(obj, "volume", data.name, data, layering.matrix)
    _show(made, layering.pattern.spacings.mean)
    return made, voxels


def _grid(extents, resolution):
    """Size of the voxels, and (3,) how many there are along each axis."""
    step = float(extents.max()) / resolution
    return step, np.ceil(extents / step).astype(int)


def _fitting(extents, resolution):
    """A resolution not much below the largest that makes no more voxels than the most."""
    while _grid(extents, resolution)[1].prod(dtype=float) > MOST_VOXELS:
        resolution = int(0.95 * resolution)
    return resolution


def _pattern(layering, origin, step, counts):
    """Float32 of a shape: cos(phase) inside the solid, which is above -1 there, and -1 outside."""
    values = np.full(counts, _NOTHING, np.float32)
    for places, tets, weights in points_inside(layering.solid, origin, step, counts):
        cosines = np.cos(evaluate_in_tets(layering.pattern.tet_phases, tets, weights))
        values[tuple(places.T)] = np.maximum(cosines.astype(np.float32), _LEAST)
    return values


def _write_grid(path, values, origin, step):
    """Write values to a file; returns how many are not nothing."""
    vdb = openvdb_module()
    grid = vdb.FloatGrid(_NOTHING)
    grid.name = GRID
    grid.copyFromArray(values)
    matrix = np.diag([step, step, step, 1.0])
    matrix[3, :3] = origin  # points are rows
    grid.transform = vdb.createLinearTransform(matrix.tolist())
    try:
        vdb.write(str(path), grids=[grid])
    except (OSError, RuntimeError) as error:
        raise unwritten(path, error) from None
    check_written(path)
    return grid.activeVoxelCount()


def _show(made, spacing):
    """Give a volume object a material, if it has none, or bring its density to another spacing."""
    if not any(slot.material for slot in made.material_slots):
        made.data.materials.clear()
        made.data.materials.append(_new_material(spacing))
    else:
        factor = made.get(_SPACING, spacing) / spacing
        for material in made.data.materials:
            node = material and material.node_tree and material.node_tree.nodes.get(_DENSITY)
            if node:
                node.inputs["To Max"].default_value *= factor
    made[_SPACING] = spacing


def _new_material(spacing):
    """Sheets where the pattern is near 1; the density goes with the spacing."""
    material = surface_material(MATERIAL)
    tree = material.node_tree
    output = tree.nodes["Material Output"]
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    pattern = tree.nodes.new("ShaderNodeAttribute")
    pattern.attribute_name, pattern.location = GRID, (-640, 0)
    density = tree.nodes.new("ShaderNodeMapRange")
    density.name = _DENSITY
    density.interpolation_type, density.location = "SMOOTHSTEP", (-420, 0)
    density.inputs["From Min"].default_value, density.inputs["From Max"].default_value = _THIN, _THICK
    density.inputs["To Max"].default_value = _OPACITY / spacing
    volume = tree.nodes.new("ShaderNodeVolumePrincipled")
    volume.location = (-180, 0)
    volume.inputs["Color"].default_value = _COLOR
    tree.links.new(pattern.outputs["Fac"], density.inputs["Value"])
    tree.links.new(density.outputs["Result"], volume.inputs["Density"])
    tree.links.new(volume.outputs["Volume"], output.inputs["Volume"])
    return material
