# SPDX-License-Identifier: GPL-3.0-or-later
"""What directions follow, as text such as ``curvature-max=2,axis:Z``, and as what the core asks of the field.

A guidance is "smooth", or sources ``KIND:NAME=STRENGTH`` as :mod:`core.texts` reads them.
"""

from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.fields.directions import SYMMETRIES
from ...core.fields.guidance.guides import (
    axis_guide,
    curvature_guide,
    distance_guide,
    gradient_guide,
    vectors_guide,
)
from ...core.tasks.surfaces import PendingGuide
from ...core.keywords import check_size
from ...core.texts import items, quoted
from ..blender import attributes
from ..blender import groups as blender_groups
from ..blender.field_files import read_guide
from ..blender.strokes import read_strokes

_NUMBERS = "a float attribute or vertex group"
_ORIGIN = "a vertex group, a curve object or boundary"
_UV_MAP = "a UV map, or nothing for the active one"
# What each kind of source needs a name of; None: it has none.
KINDS = {
    "curvature-max": None,
    "curvature-min": None,
    "gradient": _NUMBERS,
    "contour": _NUMBERS,
    "distance": _ORIGIN,
    "offset": _ORIGIN,
    "axis": "X, Y or Z",
    "uv-u": _UV_MAP,
    "uv-v": _UV_MAP,
    "attribute": "a vector attribute",
    "file": "a .rawfield or .rosy file",
}
BOUNDARY = "boundary"
AXES = ("X", "Y", "Z")
# Weights are at most shares of the area, except for curvature, whose scale is the surface's own radii. Times this,
# the field finds to a guide within root(area / 300), and a blend is even with curvature, whose weights sum to
# 316 on spot. There an axis is missed by a median of 3 degrees (8 with a third of it, 1 with three times as much).
BOUNDED_STRENGTH = 300.0


@dataclass(frozen=True)
class Source:
    """One source of guidance.

    Attributes
    ----------
    kind : one of ``KINDS``
    name : of the attribute, vertex group, curve object, axis, UV map or file
    strength : in a blend, and against the field's smoothness; None where it is not given: 1, or, for an attribute
        alone, directions that are taken exactly as they are
    """

    kind: str
    name: str = ""
    strength: float | None = None

    def __post_init__(self):
        if self.kind not in KINDS:
            raise SettingError(f"the guidance {self.kind!r} is unknown: use one of smooth, {', '.join(KINDS)}")
        needed = KINDS[self.kind]
        if needed is None and self.name:
            raise SettingError(f"the guidance {self.kind} takes no name: leave {self.name!r} out")
        if needed not in (None, _UV_MAP) and not self.name:
            raise SettingError(f"the guidance {self.kind} has no name: write {self.kind}: and {needed}")
        if self.kind == "axis" and self.name not in AXES:
            raise SettingError(f"the axis {self.name!r} is unknown: use {needed}")
        if self.strength is not None:
            check_size(self.strength, f"the strength of {self.label}")
            if self.strength < 0:
                raise SettingError(f"the strength of {self.label} is {self.strength}: give a number from 0 on")

    @property
    def label(self):
        """The source without its strength, as it is written."""
        return f"{self.kind}:{quoted(self.name)}" if self.name else self.kind

    def __str__(self):
        return self.label if self.strength is None else f"{self.label}={self.strength:g}"

    @property
    def share(self):
        """How much of the guide's weights counts."""
        strength = 1.0 if self.strength is None else self.strength
        return strength if self.kind.startswith("curvature") else BOUNDED_STRENGTH * strength


def parse(text):
    """The sources that a guidance consists of.

    Parameters
    ----------
    text : str

    Returns
    -------
    tuple of Source, empty for "smooth"

    Raises
    ------
    SettingError
        naming the source, or the place that cannot be read
    """
    found = items(text, "guidance", "KIND:NAME=STRENGTH")
    return () if found == [("smooth", None, None)] else tuple(_source(*item) for item in found)


def _source(kind, name, strength):
    if kind == "smooth":
        raise SettingError("the guidance smooth stands alone: leave it out of the blend")
    try:
        return Source(kind, name or "", None if strength is None else float(strength))
    except ValueError:
        raise SettingError(
            f"the strength {strength!r} of {kind} is no number: write {kind}=1, or leave it out"
        ) from None


def read_guides(obj, given, symmetry, sources):
    """Read what sources need of the object.

    Parameters
    ----------
    obj : bpy.types.Object, in object mode
    given : MeshInput
    symmetry : "vector", "line" or "cross"
    sources : tuple of Source

    Returns
    -------
    tuple of PendingGuide

    Raises
    ------
    SettingError
        for names that do not exist, files that do not fit, and lines or crosses as guides of another symmetry
    """
    return tuple(PendingGuide(s.label, _pending(obj, given, symmetry, s), s.share) for s in sources)


def _pending(obj, given, symmetry, source):
    mesh, kind, name = given.mesh, source.kind, source.name
    if kind.startswith("curvature"):
        _refuse_unequal(source, 2, symmetry)
        return partial(curvature_guide, mesh, largest=kind == "curvature-max")
    if kind in ("gradient", "contour"):
        return partial(gradient_guide, mesh, attributes.read_numbers(obj, name, given), contour=kind == "contour")
    if kind in ("distance", "offset"):
        return partial(distance_guide, mesh, _read_origin(obj, name, given), contour=kind == "offset")
    if kind == "axis":
        return partial(axis_guide, mesh, given.stretch[:, AXES.index(name)])
    if kind in ("uv-u", "uv-v"):
        coordinates = attributes.read_uv_map(obj, name)[given.polygons.triangle_corners]
        return partial(gradient_guide, mesh, coordinates[..., "uv".index(kind[-1])])
    if kind == "attribute":
        return partial(vectors_guide, mesh, attributes.read_vectors(obj, name, given))
    file_symmetry, compute = read_guide(given, name)
    _refuse_unequal(source, file_symmetry, symmetry)
    return compute


def _refuse_unequal(source, own, symmetry):
    """One of several directions that count as the same guides only fields in which they count as the same."""
    if SYMMETRIES[symmetry] % own:
        fitting = [name for name, number in SYMMETRIES.items() if number % own == 0]
        remedy = f"set the symmetry to {' or '.join(fitting)}" if fitting else "leave it out"
        raise SettingError(
            f"{source.label} gives {own} directions at a point, which cannot guide a {symmetry} field: {remedy}"
        )


def _read_origin(obj, name, given):
    """(n,) bool: the vertices from which distances are measured."""
    if name in obj.vertex_groups:
        return blender_groups.read_group(obj, name)[given.source]
    if name == BOUNDARY:
        edges = given.boundary_edges
        if len(edges) == 0:
            raise SettingError(
                f"the mesh {obj.data.name} has no boundary: measure from a vertex group or a curve object"
            )
        on_boundary = np.zeros(given.uncut.vertex_count, bool)
        on_boundary[given.uncut.edges[edges]] = True
        return given.of_uncut(on_boundary)
    if name not in bpy.data.objects:
        groups = ", ".join(g.name for g in obj.vertex_groups) or "none yet"
        raise SettingError(
            f"{name!r} is neither a vertex group nor an object: choose a vertex group ({groups}), "
            "a curve object, or boundary"
        )
    passed = np.zeros(given.mesh.vertex_count, bool)
    for faces, _ in read_strokes(obj, name, given):
        passed[given.mesh.triangles[faces]] = True
    return passed
