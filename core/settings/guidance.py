# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides of directions on a surface, as text such as ``curvature-max=2,axis:Z``.

A guidance is "automatic", "smooth", or sources ``KIND:NAME=STRENGTH`` as :mod:`core.spec_parser` reads them.
"""

from dataclasses import dataclass

from ..errors import SettingError
from ..spec_parser import items, quote_name
from ..validation import check_size

BOUNDARY = "boundary"
# Without a guide: the choice is left to the command, or the field turns as little as it can.
AUTOMATIC, SMOOTH = "automatic", "smooth"
AXES = ("X", "Y", "Z")
# Factor of all weights but those of curvature, which depend on the surface's radii: the others are at most shares of
# the area. With it the field aligns with a guide over a distance of root(area / 300), and a blend with curvature, whose
# weights sum to 316 on spot, is balanced. There the field deviates from an axis by a median of 3 degrees (8 with a
# third of the factor, 1 with three times as much).
BOUNDED_STRENGTH = 300.0


@dataclass(frozen=True)
class GuideKind:
    """A kind of guide.

    Attributes
    ----------
    label, tip : in the panel
    names : kind of name that it needs, one of "numbers", "origin", "axis", "uv_map", "vectors", "path"; "" for none
    asks : description of that name in messages
    """

    label: str
    tip: str
    names: str = ""
    asks: str = ""


_NUMBERS = {"names": "numbers", "asks": "a float attribute or vertex group"}
_ORIGIN = {"names": "origin", "asks": "a vertex group, a curve object or boundary"}
_UV_MAP = {"names": "uv_map", "asks": "a UV map, or nothing for the active one"}
GUIDES = {
    "curvature-max": GuideKind("Largest Curvature", "Across ridges: where the surface bends most"),
    "curvature-min": GuideKind("Smallest Curvature", "Along ridges: where the surface bends least"),
    "gradient": GuideKind("Gradient", "Where a float attribute or vertex group grows", **_NUMBERS),
    "contour": GuideKind(
        "Contour", "Along the lines on which a float attribute or vertex group is constant", **_NUMBERS
    ),
    "distance": GuideKind(
        "Away From", "Away from a vertex group, a curve or the boundary, on the shortest way", **_ORIGIN
    ),
    "offset": GuideKind(
        "Around", "Along the lines of equal distance from a vertex group, a curve or the boundary", **_ORIGIN
    ),
    "axis": GuideKind("Axis", "An axis of the object, projected to the surface", "axis", "X, Y or Z"),
    "uv-u": GuideKind("UV U", "Where the first coordinate of a UV map grows", **_UV_MAP),
    "uv-v": GuideKind("UV V", "Where the second coordinate of a UV map grows", **_UV_MAP),
    "attribute": GuideKind(
        "Attribute", "A vector attribute on the vertices, projected to the surface", "vectors", "a vector attribute"
    ),
    "file": GuideKind(
        "File", "A field file of another program: .rawfield or .rosy", "path", "a .rawfield or .rosy file"
    ),
}


@dataclass(frozen=True)
class Source:
    """One source of guidance.

    Attributes
    ----------
    kind : a key of :data:`GUIDES`
    name : of the attribute, vertex group, curve object, axis, UV map or file
    strength : in a blend, and against the field's smoothness; None if it is not given: 1, or, for an attribute alone,
        directions that are used exactly
    """

    kind: str
    name: str = ""
    strength: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in GUIDES:
            raise SettingError(
                f"the guidance {self.kind!r} is unknown: use one of {AUTOMATIC}, {SMOOTH}, {', '.join(GUIDES)}"
            )
        needed = GUIDES[self.kind]
        if not needed.names and self.name:
            raise SettingError(f"the guidance {self.kind} takes no name: leave {self.name!r} out")
        if needed.names not in ("", "uv_map") and not self.name:
            raise SettingError(f"the guidance {self.kind} has no name: write {self.kind}: and {needed.asks}")
        if self.kind == "axis" and self.name not in AXES:
            raise SettingError(f"the axis {self.name!r} is unknown: use {needed.asks}")
        if self.strength is not None:
            check_size(self.strength, f"the strength of {self.label}")
            if self.strength < 0:
                raise SettingError(f"the strength of {self.label} is {self.strength}: give a number from 0 on")

    @property
    def label(self) -> str:
        """The text of the source without its strength."""
        return f"{self.kind}:{quote_name(self.name)}" if self.name else self.kind

    def __str__(self) -> str:
        return self.label if self.strength is None else f"{self.label}={self.strength:g}"

    @property
    def is_of_curvature(self) -> bool:
        """Whether the guide is a principal direction of the surface."""
        return self.kind.startswith("curvature")

    @property
    def share(self) -> float:
        """Factor of the guide's weights."""
        strength = 1.0 if self.strength is None else self.strength
        return strength if self.is_of_curvature else BOUNDED_STRENGTH * strength


def parse_guidance(text: str) -> tuple[Source, ...]:
    """The sources of a guidance, none for :data:`AUTOMATIC` and :data:`SMOOTH`; SettingError for a text that cannot be
    read."""
    found = items(text, "guidance", "KIND:NAME=STRENGTH")
    return () if found in [[(word, None, None)] for word in (AUTOMATIC, SMOOTH)] else tuple(_source(*i) for i in found)


def _source(kind: str, name: str | None, strength: str | None) -> Source:
    if kind in (AUTOMATIC, SMOOTH):
        raise SettingError(f"the guidance {kind} stands alone: leave it out of the blend")
    try:
        return Source(kind, name or "", None if strength is None else float(strength))
    except ValueError:
        raise SettingError(
            f"the strength {strength!r} of {kind} is not a number: write {kind}=1, or leave it out"
        ) from None
