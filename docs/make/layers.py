# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figure 3 again: two solids cut open, the guiding function beside the layers of bench/solids.py.

    python docs/make/figure3.py MESHES --folder docs

MESHES holds stanford-bunny.obj. Needs Blender as a module (bpy).
"""

import tempfile
from pathlib import Path

from synch_fields.bench.command import arguments
from synch_fields.bench.solids import compared, shape_of
from synch_fields.docs.make.solid_pictures import beside, picture_of_function, picture_of_layers


def main():
    """The guiding function and the three patterns of the ring above those of the stuffed bunny."""
    options = arguments(__doc__, "stanford-bunny.obj", "the picture goes").parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = []
        for name in ("ring", "bunny"):
            shape = shape_of(name, options.meshes)
            function, results = compared(name, shape)
            pictures = [picture_of_function(name, shape.mesh, function, Path(folder) / f"{name}.png")]
            for k, (_, pattern) in enumerate(results):
                pictures.append(picture_of_layers(name, pattern, k > 0, Path(folder) / f"{name} {k}.png"))
            rows.append(pictures)
        beside(rows, options.folder / "figure3.png")


if __name__ == "__main__":
    main()
