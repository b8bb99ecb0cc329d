# SPDX-License-Identifier: GPL-3.0-or-later
"""A volume of the layers' pattern: an OpenVDB file of cos(phase), and a volume object that shows it."""

from contextlib import contextmanager
from functools import partial
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.files.whole import unwritten, write_whole
from ...core.tasks.layer_outputs import NOTHING
from ...core.validation import convert_value
from ..blender.files import check_output
from ..blender.openvdb import openvdb_module
from ..blender.transaction import store, undone_by
from ..nodes.canvas import surface_material
from ..nodes.materials import SPACING
from .objects import keep_made, place_object

GRID, MATERIAL = "pattern", "Synch Volume"
# The node that has the density, which was made for the spacing that the object keeps.
_DENSITY = "Density"
# Values of the pattern at which a layer begins to show, and is opaque; how much light it takes on its thickness.
_THIN, _THICK, _OPACITY = 0.55, 0.9, 8.0
_COLOR = (0.32, 0.62, 0.82, 1.0)


def check_volume(path, resolution):
    """Check what does not depend on layers: the file, the resolution, and whether Blender has OpenVDB."""
    check_output(path, [".vdb"])
    if convert_value("resolution", int, resolution) < 2:
        raise SettingError(f"a resolution of {resolution} voxels shows no layer: give 2 or more")
    openvdb_module()


def make_volume(obj, layering, path):
    """A volume object of a .vdb file."""
    keep_made(obj)
    data = bpy.data.volumes.new(f"{obj.name} Volume")
    data.filepath = str(Path(path).absolute())
    made = place_object(obj, "volume", data.name, data, layering.matrix)
    _show(made, layering.spacing)
    return made


@contextmanager
def grid_file(voxels, path):
    """Write :class:`Voxels` to a .vdb file, with empty voxels inactive; the file appears at its path at the end. Yields
    what the report has of it: `voxels`, the number of active ones, and `files`."""
    path = Path(path).absolute()
    vdb = openvdb_module()
    grid = vdb.FloatGrid(NOTHING)
    grid.name = GRID
    grid.copyFromArray(voxels.values)
    matrix = np.diag([voxels.step, voxels.step, voxels.step, 1.0])
    matrix[3, :3] = voxels.origin  # points are rows
    grid.transform = vdb.createLinearTransform(matrix.tolist())
    count = grid.activeVoxelCount()

    def is_whole(made):
        try:
            return vdb.read(str(made), GRID).activeVoxelCount() == count
        except Exception:  # the library's own kinds, one for each of its faults
            return False

    with write_whole(path, is_whole) as made:
        try:
            vdb.write(str(made), grids=[grid])
        except Exception as error:  # as above, where the disk is full for instance
            raise unwritten(path, error) from None
        yield {"voxels": count, "files": [str(path)]}


def _show(made, spacing):
    """Give a volume object a material, if it has none, or bring its density to another spacing."""
    if not any(slot.material for slot in made.material_slots):
        made.data.materials.clear()
        made.data.materials.append(_new_material(spacing))
    else:
        factor = made.get(SPACING, spacing) / spacing
        for material in made.data.materials:
            tree = material and material.node_tree
            for node in (node for node in (tree.nodes if tree else ()) if node.name == _DENSITY):
                socket = node.inputs["To Max"]
                before = socket.default_value
                undone_by(material, partial(setattr, socket, "default_value", before))
                socket.default_value = before * factor
    store(made, SPACING, spacing)


def _new_material(spacing):
    """Sheets where the pattern is near 1; the density goes with the spacing."""
    material, surface, output = surface_material(MATERIAL)
    tree = material.node_tree
    tree.nodes.remove(surface)
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
