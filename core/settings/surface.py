# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of directions, stripes, quads and quad meshes on a surface."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from ..errors import SettingError
from ..validation import MOST_ROUNDS
from .constraints import Constraint, from_plain
from .guidance import AUTOMATIC, GUIDES, SMOOTH, Source, parse_guidance
from .pins import parse_pins
from .setting import ANGLE, FACTOR, LENGTH, NUMBERS, SHARE, SMALLEST, Choice, Variant, default_of, records, setting
from .solver import SURFACES, SolverSettings

# Commands with a pattern, and commands with quads.
PATTERNS = tuple(command for command in SURFACES if command != "directions")
QUADS = ("quads", "quad_mesh")
# Number of directions at a point that count as the same.
SYMMETRY_ORDERS = {"vector": 1, "line": 2, "cross": 4}

_SYMMETRIES = (
    Choice("vector", "Vector", "One direction at each point"),
    Choice("line", "Line", "A direction and its opposite count as the same, as for stripes and hatching"),
    Choice("cross", "Cross", "Four directions at right angles, as for quads"),
)
_BOUNDARIES = (
    Choice("free", "Free", "No condition at the boundary"),
    Choice("along", "Along", "Directions run along the boundary"),
    Choice("across", "Across", "Directions meet the boundary at a right angle"),
    Choice("phase", "Line on It", "Directions run along the boundary and a stripe or grid line lies exactly on it"),
)
_SURFACES = (
    Choice(
        "automatic",
        "Automatic",
        "The object's own faces if they are fine enough, else a finer surface that follows them",
    ),
    Choice("faces", "Own Faces", "The object's own faces as they are, before its modifiers"),
    Choice("seen", "With Modifiers", "The result of the object's modifiers; the mesh itself is not changed"),
)
_TURN = {"unit": ANGLE, "usual": (-math.pi, math.pi)}
_ANY_FACTOR = {"unit": FACTOR, "least": 1e-3, "usual": (0.25, 4.0)}
_SHARE = {"unit": SHARE, "least": 0, "most": 1}
# Settings of the spacing that surfaces and solids share.
SPACING_MAP: dict[str, Any] = {"names": NUMBERS, "group": "pattern"}
SPACING_RANGE: dict[str, Any] = {**_ANY_FACTOR, "part_of": "spacing_map", "group": "pattern"}
_direction_setting = partial(setting, commands=SURFACES, group="directions")
_quad_mesh_setting = partial(setting, commands=("quad_mesh",), group="quad_mesh")


@dataclass(frozen=True, kw_only=True)
class SurfaceSettings(SolverSettings):
    """Settings of a direction field and of a pattern along it, besides those of the solver."""

    symmetry: str = setting(
        "line",
        "Symmetry",
        "Directions that count as the same at a point: one, two opposite ones, or the four of a cross",
        choices=_SYMMETRIES,
        commands=tuple(command for command in SURFACES if command not in QUADS),
        group="directions",
    )
    guidance: str = _direction_setting(
        AUTOMATIC,
        "Guidance",
        "What the directions follow: automatic (curvature for quad meshes without constraints, else smooth), smooth, "
        f"or guides KIND:NAME=STRENGTH separated by commas; kinds: {', '.join(GUIDES)}",
        placeholder="SPEC",
    )
    angle: float = _direction_setting(
        0.0, "Angle", "Turn the directions by this angle, counterclockwise seen from outside", **_TURN
    )
    angle_attribute: str = _direction_setting(
        "",
        "Angle Map",
        "Float attribute, radians added to the angle, or vertex group, which adds from 0 to the range",
        names=NUMBERS,
    )
    angle_range: float = _direction_setting(
        1.0,
        "Angle Range",
        "Angle that is added where the vertex group's weight is 1",
        **_TURN,
        part_of="angle_attribute",
    )
    boundary: str = _direction_setting("free", "Boundary", "How directions meet open edges", choices=_BOUNDARIES)
    vertex_group: str = _direction_setting(
        "", "Vertex Group", "Restrict the boundary to open edges with both ends in this group"
    )
    mirror: str = _direction_setting(
        "",
        "Mirror",
        "Make the pattern its own mirror image in these axes of the object; where the mesh is not symmetric, its "
        "positive side is mirrored",
        placeholder="AXES",
    )
    singularities: float | None = _direction_setting(
        None,
        "Singularities",
        "Share of the singular points that the smoothest directions have: at 0 there are as few as the shape allows, "
        "and directions bend more and quads vary in size instead",
        **_SHARE,
        variants={
            "": Variant(1.0, "", ""),
            "quad_mesh": Variant(
                0.9,
                "Mesh Singularities",
                "Share of the singular points that the smoothest directions have; they become the irregular vertices "
                "of quad meshes. Less removes the least important ones; at 0 there are as few as the shape allows, "
                "and quads vary in size instead",
            ),
        },
    )
    constraints: tuple[Constraint, ...] | None = setting(
        None,
        "Constraints",
        "Conditions on the pattern along lines of the mesh, as a JSON file of rows",
        unset="the object's own list",
        commands=SURFACES,
        placeholder="ROWS.json",
    )
    pins: str | None = setting(
        None,
        "Pins",
        "How often directions turn around chosen faces, in halves for lines and quarters for crosses",
        unset="the object's own pins",
        commands=SURFACES,
        placeholder="FACE=TURNS,...",
    )
    spacing: float | None = setting(
        None,
        "Spacing",
        "Distance from one stripe to the next, or length of two quads; the object's scale counts",
        unit=LENGTH,
        least=SMALLEST,
        start=0.1,
        usual=(1e-4, None),
        unset="about forty lines across the object, or as many as the mesh can carry",
        commands=PATTERNS,
        group="pattern",
    )
    spacing_map: str = setting(
        "",
        "Spacing Map",
        "Float attribute, a factor on the spacing, or vertex group, which takes it from 1 to the range",
        **SPACING_MAP,
        commands=PATTERNS,
    )
    spacing_range: float = setting(
        2.0, "Range", "Factor on the spacing where the vertex group's weight is 1", **SPACING_RANGE, commands=PATTERNS
    )
    branching: float | None = setting(
        None,
        "Branching",
        "How much lines may branch to keep their distance: at 100 % as much as even spacing needs, at 0 hardly at "
        "all, and their distance varies instead",
        **_SHARE,
        variants={
            "": Variant(1.0, "", ""),
            "quad_mesh": Variant(
                0.0,
                "Mesh Branching",
                "How much the lines of quad meshes may branch to keep their distance: at 0 all faces are quads and "
                "vary in size; at 100 % their sizes are most even, with faces of five and six corners between them",
            ),
        },
        commands=PATTERNS,
        group="pattern",
    )
    aspect: float = setting(
        1.0,
        "Aspect",
        "Spacing of quads along their second direction over that along the first, the one nearer to X; not possible "
        "if a singular point exchanges the two",
        **_ANY_FACTOR,
        commands=QUADS,
        group="quads",
    )
    faces: int = _quad_mesh_setting(
        0,
        "Face Count",
        "Approximate number of faces of the quad mesh, in place of the spacing; 0 to use the spacing",
        least=0,
        zero="Auto",
        most=10_000_000,
        usual=(None, 100_000),
    )
    features: float = _quad_mesh_setting(
        math.radians(40),
        "Feature Angle",
        "Boundaries and edges at which faces bend by more than this angle, or that are marked sharp, stay edges of the "
        "quad mesh; 0 for none of them",
        unit=ANGLE,
        least=0,
        zero="None",
        most=math.pi,
    )
    smoothing: int = _quad_mesh_setting(
        10,
        "Smoothing",
        "Number of smoothing steps, in which the quad mesh's vertices move on the surface to make faces squarer",
        least=0,
        most=MOST_ROUNDS,
        usual=(None, 20),
    )
    loops: float = _quad_mesh_setting(
        0.0,
        "Loops",
        "How much smoothness the quad mesh may lose for short closed loops around limbs and handles: at 0 none, at "
        "100 % as much as closing them takes. Takes three to ten times as long, and requires a branching of 0",
        **_SHARE,
    )
    surface: str = setting(
        "automatic",
        "Surface",
        "The surface that the pattern is solved and shown on",
        choices=_SURFACES,
        commands=SURFACES,
        group="pattern",
    )
    assign_material: bool = setting(
        False,
        "Assign to All Faces",
        "Show the pattern on all faces, also on an object with several materials",
        group="faces",
    )
    strict: bool = setting(
        False,
        "Strict",
        "Refuse meshes that are not manifold, instead of solving on a repaired copy, and results with faults",
        commands=SURFACES,
    )

    def __post_init__(self) -> None:
        if self.constraints is not None:
            object.__setattr__(self, "constraints", from_plain(self.constraints))
        super().__post_init__()
        if set(self.mirror) - set("XYZ"):
            raise SettingError(f"the mirror is {self.mirror!r}: use axes of X, Y and Z, such as X or XY")
        parse_guidance(self.guidance)
        parse_pins(self.pins or "")

    def for_command(self, command: str) -> "SurfaceSettings":
        """The settings that count for a command, with its own defaults; SettingError for what it cannot do."""
        shares = {name: share for name, share in default_shares(command).items() if getattr(self, name) is None}
        settings = replace(self, **shares)
        if settings.guidance == AUTOMATIC:
            is_free = command == "quad_mesh" and not settings.all_constraints
            settings = replace(settings, guidance="curvature-max" if is_free else SMOOTH)
        if command == "directions":
            return replace(settings, spacing=None, spacing_map="", branching=None)
        if command not in QUADS:
            if settings.symmetry == "cross":
                raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
            return settings
        for row in settings.all_constraints:
            if row.where == "attribute" and row.what == "phase":
                raise SettingError(f"{row.label} gives one phase a vertex, and quads have two: remove the row")
        return replace(settings, symmetry="cross")

    def unheeded(self, command: str, is_turned: bool) -> Iterator[str]:
        """Lines about settings that have no effect, or not the expected one, beside the others.

        ``is_turned``: whether the angle or its map turns the directions.
        """
        rows, exact, taken = self.all_constraints, self.exact_attribute, "directions that an attribute gives are taken"
        strength = f"give it a strength (attribute:{exact}=1)"
        unheard = [row.label for row in rows if row.what in ("along", "across", "angle")]
        if exact and unheard:
            yield f"{taken} as they are, without {', '.join(unheard)}: {strength} where rows should turn them"
        given = [row.label for row in rows if row.what == "phase" and row.where == "attribute"]
        if given and self.symmetry == "line" and not exact:
            yield (
                f"phases of {', '.join(given)} are meant for the directions that they were written with: "
                "guide by attribute:synch_direction without a strength"
            )
        striped = [row.label for row in rows if row.what in ("phase", "constant") and row.where != "attribute"]
        if is_turned and striped:
            yield f"the angle turns directions away from lines with a stripe ({', '.join(striped)}): set it to 0"
        if exact and self.mirror:
            yield f"{taken} as they are, without the mirror: {strength} where they should be mirrored"
        if exact and (self.singularities or 0.0) < default_shares(command)["singularities"]:
            yield f"{taken} as they are, with all their singular points: {strength} where there should be fewer"
        if exact and self.pins:
            yield f"{taken} as they are, without the pins: give it a strength"
        if is_turned and self.mirror:
            yield "the angle turns directions the same way on both sides of the mirror: set it to 0"

    @property
    def all_constraints(self) -> tuple[Constraint, ...]:
        """The constraint list, with the constraint of the boundary."""
        listed = self.constraints or ()
        if self.boundary == "free":
            return listed
        return (Constraint("boundary", self.boundary, self.vertex_group), *listed)

    @property
    def sources(self) -> tuple[Source, ...]:
        """The sources of guidance, see :func:`parse_guidance`."""
        return parse_guidance(self.guidance)

    @property
    def exact_attribute(self) -> str | None:
        """Name of the vector attribute whose directions are used exactly, or None."""
        exact = [source.name for source in self.sources if source.kind == "attribute" and source.strength is None]
        return exact[0] if exact and len(self.sources) == 1 else None


def default_shares(command: str) -> dict[str, Any]:
    """The shares of branches and of singular points that a command takes where none are given, by their names."""
    variants = [name for name, record in records(SurfaceSettings) if record.variants]
    return {name: default_of(SurfaceSettings, name, command) for name in variants}
