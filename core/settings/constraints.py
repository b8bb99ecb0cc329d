# SPDX-License-Identifier: GPL-3.0-or-later
"""The constraint list: rows as plain data, and from JSON."""

from dataclasses import dataclass, fields

from ..errors import SettingError, quote_value
from ..validation import check_size, check_text
from .setting import Choice

PLACES = (
    Choice("boundary", "Boundary", "The open edges of the mesh, or those of a vertex group", "MESH_PLANE"),
    Choice("group", "Vertex Group", "The chains of edges, areas and points of a vertex group", "GROUP_VERTEX"),
    Choice("seams", "Seams", "Edges marked as seams", "UV_EDGESEL"),
    Choice("sharp", "Sharp Edges", "Edges marked as sharp", "MOD_EDGESPLIT"),
    Choice("creases", "Creases", "Edges with a crease", "MOD_SUBSURF"),
    Choice("curve", "Curve", "A curve or drawn strokes of another object, projected to the surface", "CURVE_DATA"),
    Choice("attribute", "Attribute", "Vertices, each with its own direction or phase", "SPREADSHEET"),
)
WISHES = (
    Choice("along", "Along", "Stripes run along the line, or along the attribute's vectors"),
    Choice("across", "Across", "Stripes meet the line at a right angle"),
    Choice("angle", "Angle", "Stripes meet the line at an angle"),
    Choice("phase", "Phase", "A stripe lies on the line: its middle at 0°, the middle of a gap at 180°"),
    Choice("constant", "Same Phase", "The line follows one stripe, at any distance from its middle"),
    Choice("cut", "Cut", "The pattern does not continue across: each side has its own"),
)
# Places that need a name; the boundary may have the name of a group that restricts it.
_NAMED = {"group": "a vertex group", "curve": "a curve object", "attribute": "an attribute"}


def wishes_at(where: str) -> list[str]:
    """The wishes that are possible at a place: only edges of the mesh can be cut, and an attribute has no line."""
    impossible = {"boundary": {"cut"}, "curve": {"cut"}, "attribute": {"cut", "constant"}}.get(where, set())
    return [wish.name for wish in WISHES if wish.name not in impossible]


@dataclass(frozen=True)
class Constraint:
    """One row of the list.

    Attributes
    ----------
    where : name of one of :data:`PLACES`
    what : name of one of :data:`WISHES`
    name : of the vertex group, the curve object or the attribute
    degrees : the angle from the line, or the phase
    weight : of a soft wish, None for a hard one
    """

    where: str
    what: str
    name: str = ""
    degrees: float = 0.0
    weight: float | None = None

    def __post_init__(self) -> None:
        for value, choices in ((self.where, PLACES), (self.what, WISHES)):
            names = [choice.name for choice in choices]
            if value not in names:
                raise SettingError(f"{self.label} has {value!r}: use one of {', '.join(names)}")
        if not isinstance(self.name, str):
            raise SettingError(f"the name {self.name!r} in {self.where} {self.what} is not text: give a name")
        check_text(self.name, f"the name in {self.where} {self.what}")
        if self.where in _NAMED and not self.name:
            raise SettingError(f"{self.label} has no name: choose {_NAMED[self.where]}")
        for key in ("degrees", "weight"):
            value = getattr(self, key)
            if key == "weight" and value is None:
                continue
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise SettingError(f"the {key} of {self.label} is {quote_value(value)}: give a number")
            check_size(value, f"the {key} of {self.label}")
        if self.what not in wishes_at(self.where):
            raise SettingError(f"{self.label} is impossible: use one of {', '.join(wishes_at(self.where))} there")
        if self.what == "cut" and self.weight is not None:
            raise SettingError(f"{self.label} has a weight: a cut can only be hard")

    @property
    def label(self) -> str:
        """The row's name in messages."""
        return f"the constraint {self.where}{' ' + self.name if self.name else ''} {self.what}"


def from_plain(rows: object) -> tuple[Constraint, ...]:
    """Constraints from a list of dicts with the attributes of :class:`Constraint` as keys, as in JSON."""
    if not isinstance(rows, list | tuple):
        raise SettingError(
            "the constraints are not a list: give a list of rows such as {'where': 'seams', 'what': 'cut'}"
        )
    known = [item.name for item in fields(Constraint)]
    constraints = []
    for number, row in enumerate(rows, start=1):
        if isinstance(row, Constraint):
            constraints.append(row)
            continue
        if not isinstance(row, dict) or not {"where", "what"} <= set(row):
            raise SettingError(f"row {number} is {quote_value(row)}: give it a 'where' and a 'what'")
        for key in row:
            if key not in known:
                raise SettingError(f"row {number} has the key {quote_value(key)}: use {', '.join(known)}")
        try:
            constraints.append(Constraint(**row))
        except SettingError as error:
            raise SettingError(f"row {number}: {error}") from None
    return tuple(constraints)
