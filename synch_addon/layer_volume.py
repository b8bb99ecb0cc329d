# SPDX-License-Identifier: GPL-3.0-or-later
"""A volume of the layers' pattern: an OpenVDB file of cos(phase), and a volume object that shows it."""

from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ..core.errors import SettingError
from ..core.extract.voxels import points_inside
from ..core.interpolate_solid import evaluate_in_tets
from .files import check_output, check_written, unwritten
from .flows import openvdb_module
from .layer_links import SOLID

GRID, MATERIAL = "pattern", "Synch Volume"
# Between layers, and outside of the solid.
_NOTHING = -1.0
_MOST_VOXELS = 100_000_000
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
    step = float(extents.max()) / resolution
    counts = np.ceil(extents / step).astype(int)
    if counts.prod() > _MOST_VOXELS:
        raise SettingError(f"a resolution of {resolution} makes {counts.prod():.1e} voxels: reduce it")
    origin = low + (extents - step * (counts - 1)) / 2
    places, tets, weights = points_inside(solid, origin, step, counts)
    values = np.cos(evaluate_in_tets(layering.pattern.tet_phases, tets, weights))
    _write_grid(path, places, values, counts, origin, step)
    data = bpy.data.volumes.new(f"{obj.name} Volume")
    data.filepath = str(path)
    data.materials.append(_material(layering.pattern.spacings.mean))
    made = bpy.data.objects.new(data.name, data)
    made[SOLID] = obj
    for collection in obj.users_collection:
        collection.objects.link(made)
    made.matrix_world = Matrix(layering.matrix)
    return made, len(values)


def _write_grid(path, places, values, counts, origin, step):
    vdb = openvdb_module()
    dense = np.full(counts, _NOTHING, np.float32)
    dense[tuple(places.T)] = values
    grid = vdb.FloatGrid(_NOTHING)
    grid.name = GRID
    grid.copyFromArray(dense)
    matrix = np.diag([step, step, step, 1.0])
    matrix[3, :3] = origin  # points are rows
    grid.transform = vdb.createLinearTransform(matrix.tolist())
    try:
        vdb.write(str(path), grids=[grid])
    except (OSError, RuntimeError) as error:
        raise unwritten(path, error) from None
    check_written(path)


def _material(spacing):
    """Sheets where the pattern is near 1; the density goes with the spacing."""
    material = bpy.data.materials.new(MATERIAL)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    output = tree.nodes["Material Output"]
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    pattern = tree.nodes.new("ShaderNodeAttribute")
    pattern.attribute_name, pattern.location = GRID, (-640, 0)
    density = tree.nodes.new("ShaderNodeMapRange")
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
