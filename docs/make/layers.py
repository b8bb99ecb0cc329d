# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figures 1 and 3 again: layers in solids, while they are printed, and cut open."""

from synch_fields.bench.solids import check_order, compared, shape_of
from synch_fields.docs.make.solid_pictures import beside, picture_of_function, picture_of_layers, picture_of_print

# Shares of the height that are printed.
PRINTED = (0.3, 0.65, 1.0)


def figure1(place):
    """The stuffed bunny with layers flush with its base and the tips of its ears, while it is printed."""
    _, results = compared("bunny", shape_of("bunny", place.meshes))
    row, pattern = results[-1]
    pictures = [picture_of_print("bunny", pattern, share, place.folder / f"{share}.png") for share in PRINTED]
    beside([[*pictures, picture_of_layers("bunny", pattern, True, place.folder / "open.png")]], place.picture)
    return {"solids": [row]}


def figure3(place):
    """The guiding function and the three patterns of the ring above those of the stuffed bunny."""
    sheets, rows = [], []
    for name in ("ring", "bunny"):
        shape = shape_of(name, place.meshes)
        function, results = compared(name, shape)
        check_order([row for row, _ in results])
        pictures = [picture_of_function(name, shape.mesh, function, place.folder / f"{name}.png")]
        for k, (row, pattern) in enumerate(results):
            pictures.append(picture_of_layers(name, pattern, k > 0, place.folder / f"{name} {k}.png"))
            rows.append(row)
        sheets.append(pictures)
    beside(sheets, place.picture)
    return {"solids": rows}
