# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be set for layers in a solid: as plain data, and as text for operators and the command line."""

import math
from dataclasses import dataclass

from ...core.errors import SettingError
from ...core.fields.calming import check_share
from ...core.fields.limits import Limits
from ...core.interpolate import TURN
from ...core.keywords import check_choice, check_positive
from ...core.tasks.settings import SolverSettings
from ...core.texts import items, quoted
from ..settings.guidance import AXES, BOUNDARY
from ..settings.solver import RANGE

_GROUP = "a vertex group"
# What each kind of guide needs names of.
KINDS = {
    "axis": ("X, Y or Z",),
    "harmonic": (_GROUP, "another one"),
    "distance": (f"a vertex group, a mesh object, or {BOUNDARY}",),
    "curve": ("a curve object",),
    "around": ("a curve object",),
    "attribute": ("a vector attribute",),
    "file": ("a .vtu or .sol file", "one of its arrays"),
    "lines": ("a .vtu or .sol file", "one of its arrays"),
}
# Kinds whose last name may be missing.
SHORT = ("file", "lines")
# What a boundary group may ask for.
HELD, CONSTANT = "layer", "constant"
WISHES = (HELD, CONSTANT)
# What has a number of its own.
NUMBERS = ("pieces", "levels")


@dataclass(frozen=True)
class LayerGuide:
    """What layers follow.

    Attributes
    ----------
    kind : one of ``KINDS``
    names : of the axis, vertex groups, object or attribute
    """

    kind: str
    names: tuple[str, ...]

    @classmethod
    def of_text(cls, text):
        """From text such as ``axis:Z`` or ``harmonic:Bottom:Top``, as :mod:`core.texts` reads it."""
        (kind, *names), *more = items(text, "guidance", "KIND:NAME:NAME")
        names = [name for name in names if name is not None]
        if kind not in KINDS:
            raise SettingError(f"the guidance {kind!r} is unknown: use one of {', '.join(KINDS)}")
        needed = KINDS[kind]
        allowed = (len(needed) - (kind in SHORT), len(needed))
        if more or len(names) not in allowed or not all(names):
            raise SettingError(f"the guidance {text!r} is incomplete: write {kind}:, {', :, '.join(needed)}")
        if kind == "axis" and names[0] not in AXES:
            raise SettingError(f"the axis {names[0]!r} is unknown: use X, Y or Z")
        return cls(kind, tuple(names))

    def __str__(self):
        return ":".join([self.kind, *map(quoted, self.names)])


@dataclass(frozen=True)
class Flush:
    """What is asked of the layers on a vertex group's faces, or on the whole boundary.

    Attributes
    ----------
    group : name of the vertex group, or "boundary"
    wish : "layer" (one lies exactly on it) or "constant" (the same phase on each piece of it, whichever)
    offset : from 0 to below 1, of a layer: how far the group lies above the last layer, 0 for on it
    """

    group: str
    wish: str
    offset: float = 0.0

    def __post_init__(self):
        if not 0 <= self.offset < 1 or (self.offset and self.wish != HELD):
            raise SettingError(
                f"the offset {self.offset:g} of the group {self.group!r} is none: write {HELD}:0 to {HELD}:0.99"
            )
        if self.wish not in WISHES:
            raise SettingError(
                f"the wish {self.wish!r} of the group {self.group!r} is unknown: use {' or '.join(WISHES)}"
            )

    def __str__(self):
        return f"{quoted(self.group)}={self.wish}" + (f":{self.offset:g}" if self.offset else "")

    @property
    def phase(self):
        """Radians, None for one that is left to the solver."""
        return TURN * self.offset if self.wish == HELD else None


def groups_of_text(text):
    """Tuple of :class:`Flush` from text such as ``Top=layer:0.5,Bottom=constant``, empty for none."""
    rows = []
    found = items(text, "groups", "NAME=WISH")
    for group, wish in found if found != [("", None)] else ():
        if not group or wish is None:
            named = group or f"={wish}"
            raise SettingError(f"the group {named!r} lacks its name or its wish: write NAME=layer or NAME=constant")
        wish, _, offset = wish.partition(":")
        try:
            rows.append(Flush(group, wish.strip(), float(offset or 0)))
        except ValueError:
            raise SettingError(
                f"the offset {offset!r} of the group {group!r} is no number: write {HELD}:0.5 for half a layer"
            ) from None
    return tuple(rows)


def text_of_groups(groups):
    """The text that :func:`groups_of_text` reads."""
    return ",".join(str(row) for row in groups)


@dataclass(frozen=True)
class LayerSettings(SolverSettings):
    """Settings of the operator, the command line and the API alike, besides those of the solver.

    Attributes
    ----------
    guidance : what the layers follow, as :meth:`LayerGuide.of_text` reads it
    groups : what is asked of parts of the boundary, as :func:`groups_of_text` reads it
    spacing : distance between layers in scene units; None for an automatic one
    spacing_map : name of a float attribute on the vertices, a factor on the spacing, or of a vertex group; "" for none
    spacing_range : factor on the spacing where the vertex group's weight is 1
    branching : share of the branches that even distances need, from 0 to 1
    smallest_height, largest_height : limits of the distance between layers in scene units, 0 for none
    numbers : of layers: "pieces", each connected piece its own, or "levels", what lies at one height the same
    size : of the tetrahedra, their longest edge in scene units; None for an automatic one
    strict : refuse meshes that are no surface as they are, instead of filling the surface nearest to them
    """

    guidance: str = "axis:Z"
    groups: str = ""
    spacing: float | None = None
    spacing_map: str = ""
    spacing_range: float = RANGE
    branching: float = 1.0
    smallest_height: float = 0.0
    largest_height: float = 0.0
    numbers: str = NUMBERS[0]
    size: float | None = None
    strict: bool = False

    def __post_init__(self):
        super().__post_init__()
        check_positive(self, "spacing_range", optional=("spacing", "size"))
        check_share(self.branching, "branching")
        check_choice(self, "numbers", NUMBERS)
        _ = self.guide, self.flush
        limits = self.limits
        if self.spacing is not None and limits.clipped(self.spacing) != self.spacing:
            raise SettingError(
                f"the spacing {self.spacing:g} is not between the heights {limits}: give one that is, or none"
            )

    @property
    def guide(self):
        """The :class:`LayerGuide`."""
        return LayerGuide.of_text(self.guidance)

    @property
    def limits(self):
        """The :class:`Limits`."""
        return Limits(self.smallest_height, self.largest_height or math.inf)

    @property
    def flush(self):
        """Tuple of :class:`Flush`."""
        return groups_of_text(self.groups)
