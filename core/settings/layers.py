# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of layers in a solid, and the texts in which guides and groups are written."""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..errors import SettingError
from ..spec_parser import items, quote_name
from .guidance import AXES, BOUNDARY
from .setting import LENGTH, SHARE, SMALLEST, Choice, setting
from .solver import SolverSettings
from .surface import SPACING_MAP, SPACING_RANGE

LAYERS = ("layers",)
_layer_setting = partial(setting, commands=LAYERS)


@dataclass(frozen=True)
class LayerGuideKind:
    """A kind of guide of layers.

    Attributes
    ----------
    label, tip : in the panel
    names : properties of the panel that hold its names
    asks : description of each name in messages
    optional : number of the last names that may be missing
    """

    label: str
    tip: str
    names: tuple[str, ...]
    asks: tuple[str, ...]
    optional: int = 0


_GROUP = "a vertex group"
_VECTOR_FILE: dict[str, Any] = {
    "names": ("file", "array"),
    "asks": ("a .vtu or .sol file", "one of its arrays"),
    "optional": 1,
}
LAYER_GUIDES = {
    "axis": LayerGuideKind("Axis", "An axis of the object: flat layers", ("axis",), ("X, Y or Z",)),
    "harmonic": LayerGuideKind(
        "Between Groups",
        "From one vertex group's faces to another's, along a harmonic function",
        ("low", "high"),
        (_GROUP, "another one"),
    ),
    "distance": LayerGuideKind(
        "Away From",
        "Away from a vertex group's faces, from the whole surface, or from another mesh",
        ("origin",),
        (f"{_GROUP}, a mesh object, or {BOUNDARY}",),
    ),
    "curve": LayerGuideKind("Along Curve", "Along a curve object: layers cross it", ("curve",), ("a curve object",)),
    "around": LayerGuideKind(
        "Around Curve", "Away from a curve object: layers lie around it like skins", ("curve",), ("a curve object",)
    ),
    "attribute": LayerGuideKind(
        "Attribute",
        "A vector attribute on the vertices, extended into the solid",
        ("vectors",),
        ("a vector attribute",),
    ),
    "file": LayerGuideKind("File", "Vectors in a solid, on points or cells of a .vtu or .sol file", **_VECTOR_FILE),
    "lines": LayerGuideKind(
        "File of Lines", "The same for vectors of either sign, such as principal stresses", **_VECTOR_FILE
    ),
}
# Wishes for a group of the boundary.
HELD, CONSTANT = "layer", "constant"
LAYER_WISHES = (
    Choice(HELD, "Layer on It", "A layer lies exactly on these faces"),
    Choice(CONSTANT, "Parallel", "Layers run parallel to each piece of these faces, at any distance from it"),
)
_NUMBERS = (
    Choice("pieces", "Of Pieces", "Each connected piece has its own number, counted from the bottom"),
    Choice(
        "levels",
        "Of Levels",
        "Pieces at the same height have the same number, counted in each body from its lowest layer",
    ),
)


@dataclass(frozen=True)
class LayerGuide:
    """A guide of layers: a key of :data:`LAYER_GUIDES`, and names of the axis, vertex groups, object or attribute."""

    kind: str
    names: tuple[str, ...]

    @classmethod
    def of_text(cls, text: str) -> "LayerGuide":
        """Read text such as ``axis:Z`` or ``harmonic:Bottom:Top`` (:mod:`core.spec_parser`)."""
        (kind, *given), *more = items(text, "guidance", "KIND:NAME:NAME")
        names = [name for name in given if name is not None]
        if kind not in LAYER_GUIDES:
            raise SettingError(f"the guidance {kind!r} is unknown: use one of {', '.join(LAYER_GUIDES)}")
        needed = LAYER_GUIDES[kind]
        fewest, most = len(needed.asks) - needed.optional, len(needed.asks)
        if more or not fewest <= len(names) <= most or not all(names):
            raise SettingError(f"the guidance {text!r} is incomplete: write {kind}:, {', :, '.join(needed.asks)}")
        if kind == "axis" and names[0] not in AXES:
            raise SettingError(f"the axis {names[0]!r} is unknown: use X, Y or Z")
        return cls(kind, tuple(names))

    def __str__(self) -> str:
        return ":".join([self.kind, *map(quote_name, self.names)])


@dataclass(frozen=True)
class Flush:
    """A condition on layers at a vertex group's faces, or at the whole boundary.

    Attributes
    ----------
    group : name of the vertex group, or "boundary"
    wish : "layer" (one lies exactly on it) or "constant" (any phase that is constant on each of its components)
    offset : height of the group above the last layer, as a part of a layer, from 0 to below 1
    """

    group: str
    wish: str
    offset: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.offset < 1 or (self.offset and self.wish != HELD):
            raise SettingError(
                f"the offset {self.offset:g} of the group {self.group!r} is not allowed: write {HELD}:0 to {HELD}:0.99"
            )
        wishes = [wish.name for wish in LAYER_WISHES]
        if self.wish not in wishes:
            raise SettingError(
                f"the wish {self.wish!r} of the group {self.group!r} is unknown: use {' or '.join(wishes)}"
            )

    def __str__(self) -> str:
        return f"{quote_name(self.group)}={self.wish}" + (f":{self.offset:g}" if self.offset else "")

    @property
    def phase(self) -> float | None:
        """The phase on the group in radians, None if the solver chooses it."""
        return math.tau * self.offset if self.wish == HELD else None


def groups_of_text(text: str) -> tuple[Flush, ...]:
    """The groups of text such as ``Top=layer:0.5,Bottom=constant``, empty for none."""
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
                f"the offset {offset!r} of the group {group!r} is not a number: write {HELD}:0.5 for half a layer"
            ) from None
    return tuple(rows)


def text_of_groups(groups: "tuple[Flush, ...] | list[Flush]") -> str:
    """The text that :func:`groups_of_text` reads."""
    return ",".join(str(row) for row in groups)


@dataclass(frozen=True, kw_only=True)
class LayerSettings(SolverSettings):
    """Settings of layers in a solid, besides those of the solver."""

    guidance: str = _layer_setting(
        "axis:Z",
        "Guidance",
        f"What the layers follow, such as axis:Z or harmonic:Bottom:Top; kinds: {', '.join(LAYER_GUIDES)}",
        placeholder="KIND:NAME",
    )
    groups: str = _layer_setting(
        "",
        "Groups",
        "Conditions on the faces of vertex groups or on the boundary, such as Top=layer,Bottom=constant",
        placeholder="NAME=WISH,...",
    )
    spacing: float | None = _layer_setting(
        None,
        "Spacing",
        "Distance from one layer to the next; the object's scale counts",
        unit=LENGTH,
        least=SMALLEST,
        start=0.1,
        usual=(1e-4, None),
        unset="24 layers across the object, or up to forty where the resolution carries them",
        group="layers",
    )
    size: float | None = _layer_setting(
        None,
        "Resolution",
        "Longest edge of the tetrahedra that fill the object, at most half the spacing",
        unit=LENGTH,
        least=SMALLEST,
        start=0.05,
        usual=(1e-4, None),
        unset="about a hundred thousand tetrahedra, or more where the spacing needs them",
        group="layers",
    )
    divisions: int | None = _layer_setting(
        None,
        "Divisions",
        "Number of layers in a period of the phase; where layers end inside the solid, a whole period ends",
        least=1,
        most=1000,
        unset="one, or as many as the tetrahedra need",
    )
    spacing_map: str = _layer_setting(
        "",
        "Spacing Map",
        "Float attribute, a factor on the spacing, or vertex group, which takes it from 1 to the range",
        **SPACING_MAP | {"group": "layers"},
    )
    spacing_range: float = _layer_setting(
        2.0,
        "Range",
        "Factor on the spacing where the vertex group's weight is 1",
        **SPACING_RANGE | {"group": "layers"},
    )
    branching: float = _layer_setting(
        1.0,
        "Branching",
        "How much layers may branch to keep their distance: at 100 % as much as even distances need, at 0 hardly at "
        "all",
        unit=SHARE,
        least=0,
        most=1,
        group="layers",
    )
    smallest_height: float = _layer_setting(
        0.0,
        "Smallest Height",
        "Smallest height of a layer, 0 for no limit; layers branch only as much as the limits need",
        unit=LENGTH,
        least=0,
        zero="No limit",
        group="layers",
    )
    largest_height: float = _layer_setting(
        0.0,
        "Largest Height",
        "Largest height of a layer, 0 for no limit",
        unit=LENGTH,
        least=0,
        zero="No limit",
        group="layers",
    )
    numbers: str = _layer_setting(
        "pieces",
        "Numbers",
        "What counts as one layer in the attribute, in files and in the order of paths",
        choices=_NUMBERS,
        group="layers",
    )
    strict: bool = _layer_setting(
        False, "Strict", "Refuse meshes that are not manifold, instead of filling a repaired copy"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        LayerGuide.of_text(self.guidance)
        groups_of_text(self.groups)
        low, high = self.heights
        if not low < high:
            raise SettingError(
                f"no layer is between {low:g} and {high:g} high: give a smallest height from 0 on, and a largest one "
                "above it"
            )
        if self.spacing is not None and not low <= self.spacing <= high:
            raise SettingError(
                f"the spacing {self.spacing:g} is not between the heights {low:g} and {high:g}: give one that is, "
                "or none"
            )

    @property
    def heights(self) -> tuple[float, float]:
        """The smallest and the largest height of a layer, 0 and infinity without limits."""
        return self.smallest_height, self.largest_height or math.inf

    @property
    def guide(self) -> LayerGuide:
        """The guide that the layers follow."""
        return LayerGuide.of_text(self.guidance)

    @property
    def flush(self) -> tuple[Flush, ...]:
        """Conditions on parts of the boundary."""
        return groups_of_text(self.groups)
