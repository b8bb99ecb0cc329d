# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist can set: once as plain data for the Python API, once as Blender properties."""

import math
from dataclasses import dataclass

import bpy
from bpy.props import (
    BoolProperty,
    BoolVectorProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ...core.errors import SettingError
from ...core.fields.calming import check_share
from ...core.fields.directions import SYMMETRIES
from ...core.keywords import MOST_ROUNDS, check_choice, check_positive, check_whole
from ...core.tasks.settings import SolverSettings
from ..blender.registration import keeping
from ..blender.translations import OURS
from .constraint_list import SynchConstraint
from .constraints import Constraint, from_plain
from .favourite_list import SynchFavourite
from .guidance import parse
from .guide_list import GUIDE_ITEMS, SynchGuide, stored_guidance, suggest_numbers
from .pins import parsed
from .solver import (
    ANGLE,
    BRANCHING,
    FACTOR,
    METHOD,
    RANGE,
    ROUNDING,
    SEED,
    SHARE,
    SPACING_MAP,
    SPACING_RANGE,
    TARGET_GAP,
    settings_of,
)

BOUNDARIES = ("free", "along", "across", "phase")
# Angle between two faces beyond which the edges of quad meshes follow theirs.
FEATURES = math.radians(40)
# Shares of branches and of singular points where none are given.
SHARES = {"branching": 1.0, "singularities": 1.0}
MESH_SHARES = {"branching": 0.0, "singularities": 0.95}


def default_shares(command):
    """The shares that a command takes where none are given, by their names."""
    return MESH_SHARES if command == "quad_mesh" else SHARES


@dataclass(frozen=True)
class Settings(SolverSettings):
    """Settings of the operators, the command line and the API alike, besides those of the solver.

    Attributes
    ----------
    symmetry : "vector", "line" or "cross"
    guidance : "smooth", or sources that directions follow, as :mod:`.guidance` reads them
    angle : radians by which the directions are turned
    angle_attribute : name of a float attribute on the vertices, more radians, or of a vertex group; "" for none
    angle_range : radians by which directions are turned where the vertex group's weight is 1
    boundary : "free", "along", "across" or "phase" (a stripe or grid line lies on the boundary)
    vertex_group : restricts the boundary to the edges in a vertex group; "" for all of it
    mirror : axes "X", "Y", "Z", or several, in which the field is its own mirror image; "" for none
    singularities : share of the shape's unevenness that directions answer with singular points, from 0 (the fewest
        that its topology allows) to 1; None for that of :func:`default_shares`
    constraints : rows of the constraint list, :class:`Constraint` or dicts; None for the object's own list
    pins : faces and by how many of the smallest turns directions turn around them, as :mod:`.pins` reads them; "" for
        none, None for the object's own
    spacing : period in scene units, the distance between two stripes or two quads' length; None for about forty
        stripes or quads across the object
    spacing_map : name of a float attribute on the vertices, a factor on the spacing, or of a vertex group; "" for none
    spacing_range : factor on the spacing where the vertex group's weight is 1
    aspect : of quads, the spacing along the second direction over that along the first, which is the one nearer to X
    features : of quad meshes, the angle in radians between two faces beyond which their edge is sharp: chains of edges
        lie on the boundary and on sharp edges; 0 for neither
    smoothing : of quad meshes, how often vertices move to where faces are nearer to squares, on the surface
    faces : of quad meshes, about how many there should be, whatever the spacing; 0 for as many as that gives
    straighten : of quad meshes, look for shorter loops among variations and with fewer singularities
    branching : share of the branches that even spacing needs, from 0 to 1; None for that of :func:`default_shares`
    assign_material : show the pattern on all faces, whatever materials they have
    strict : refuse meshes that cannot carry a field as they are, instead of solving on the surface nearest to them
    """

    symmetry: str = "line"
    guidance: str = "smooth"
    angle: float = 0.0
    angle_attribute: str = ""
    angle_range: float = 1.0
    boundary: str = "free"
    vertex_group: str = ""
    mirror: str = ""
    singularities: float | None = None
    constraints: tuple[Constraint, ...] | None = None
    pins: str | None = None
    spacing: float | None = None
    spacing_map: str = ""
    spacing_range: float = RANGE
    aspect: float = 1.0
    features: float = FEATURES
    smoothing: int = 10
    faces: int = 0
    straighten: bool = False
    branching: float | None = None
    assign_material: bool = False
    strict: bool = False

    def __post_init__(self):
        if self.constraints is not None:
            object.__setattr__(self, "constraints", from_plain(self.constraints))
        super().__post_init__()
        check_choice(self, "symmetry", SYMMETRIES)
        check_choice(self, "boundary", BOUNDARIES)
        for name in SHARES:
            if getattr(self, name) is not None:
                check_share(getattr(self, name), name)
        for name in ("angle", "angle_range"):
            if not math.isfinite(getattr(self, name)):
                raise SettingError(f"the {name.replace('_', ' ')} is {getattr(self, name)}: give a finite one")
        if not 0 <= self.features <= math.pi:
            raise SettingError(f"the angle of features is {self.features!r}: give radians from 0 (none) to pi")
        check_positive(self, "spacing_range", "aspect")
        check_whole(self, "faces")
        check_whole(self, "smoothing", most=MOST_ROUNDS)
        if set(self.mirror) - set("XYZ"):
            raise SettingError(f"the mirror is {self.mirror!r}: use axes of X, Y and Z, such as X or XY")
        parse(self.guidance)
        parsed(self.pins or "")

    @property
    def all_constraints(self):
        """The constraint list with what is asked of the boundary."""
        if self.boundary == "free":
            return self.constraints
        return (Constraint("boundary", self.boundary, self.vertex_group), *self.constraints)

    @property
    def sources(self):
        """The sources of guidance, none for "smooth"."""
        return parse(self.guidance)

    @property
    def exact_attribute(self):
        """Name of the vector attribute whose directions are taken exactly as they are, or None."""
        exact = [s.name for s in self.sources if s.kind == "attribute" and s.strength is None]
        return exact[0] if exact and len(self.sources) == 1 else None


def _items(*entries):
    return [(name.upper().replace("-", "_"), label, tip) for name, label, tip in entries]


SYMMETRY = EnumProperty(
    name="Symmetry",
    description="What is the same at a point: one direction, a line or a cross",
    items=_items(
        ("vector", "Vector", "One direction at each point"),
        ("line", "Line", "A direction and its opposite count as the same, as for stripes and hatching"),
        ("cross", "Cross", "Four directions at right angles, as for quads"),
    ),
    default="LINE",
)
FEATURE_ANGLE = FloatProperty(
    name="Feature Angle",
    description="Boundaries and edges at which faces bend by more than this angle, or that are marked sharp, stay "
    "edges of the quad mesh; 0 for none of them",
    subtype="ANGLE",
    default=FEATURES,
    min=0,
    max=math.pi,
)
SMOOTHING = IntProperty(
    name="Smoothing",
    description="How often the quad mesh's vertices move to where faces are nearer to squares, on the surface",
    default=Settings.smoothing,
    min=0,
    soft_max=20,
)
FACES = IntProperty(
    name="Face Count",
    description="About how many faces the quad mesh is to have, whatever the spacing; 0 for as many as that gives",
    default=Settings.faces,
    min=0,
    soft_max=100_000,
)
STRAIGHTEN = BoolProperty(
    name="Straighten",
    description="Look for a quad mesh of shorter loops and fewer spirals among variations and with fewer "
    "singularities; takes two to three times as long",
)
# Of quad meshes alone.
MESH_BRANCHING = FloatProperty(
    name="Mesh Branching",
    description="How much the lines of quad meshes may branch to keep their distance: at 0 faces are quads all over "
    "and vary in size, at 100 their sizes are most even, but faces of five and six corners lie between",
    default=100 * MESH_SHARES["branching"],
    **SHARE,
)
MESH_SINGULARITIES = FloatProperty(
    name="Mesh Singularities",
    description="How many singular points the directions of quad meshes may have to stay smooth: below 100 those go "
    "that bend the least, and irregular vertices with them; at 0 there are the fewest that the shape allows, and quads "
    "vary in size instead",
    default=100 * MESH_SHARES["singularities"],
    **SHARE,
)


class SettingProperties:
    """The settings as Blender properties, shared by the panel's storage and the operators."""

    symmetry: SYMMETRY
    angle: FloatProperty(
        name="Angle", description="Turn the directions by this angle, counterclockwise seen from outside", **ANGLE
    )
    angle_attribute: StringProperty(
        name="Angle Map",
        description="Float attribute, radians added to the angle, or vertex group, which adds from 0 to the range",
        search=suggest_numbers,
    )
    angle_range: FloatProperty(
        name="Angle Range",
        description="Angle that is added where the vertex group's weight is 1",
        default=Settings.angle_range,
        **ANGLE,
    )
    boundary: EnumProperty(
        name="Boundary",
        description="What happens at open edges",
        translation_context=OURS,
        items=_items(
            ("free", "Free", "Nothing is asked of the boundary"),
            ("along", "Along", "Directions run along the boundary"),
            ("across", "Across", "Directions meet the boundary at a right angle"),
            ("phase", "Line on It", "Directions run along the boundary and a stripe or grid line lies exactly on it"),
        ),
        default="FREE",
    )
    vertex_group: StringProperty(
        name="Vertex Group", description="Restrict the boundary to open edges with both ends in this group"
    )
    mirror: BoolVectorProperty(
        name="Mirror",
        description="Make the pattern its own mirror image in these axes of the object, whose mesh has to be symmetric",
        size=3,
    )
    singularities: FloatProperty(
        name="Singularities",
        description="How many singular points directions may have to stay smooth: 100 for as many as the shape's bumps "
        "call for, 0 for the fewest that it allows, where directions bend more and quads vary in size instead",
        default=100 * SHARES["singularities"],
        **SHARE,
    )
    spacing: FloatProperty(
        name="Spacing",
        description="Distance from one stripe to the next; the object's scale counts",
        subtype="DISTANCE",
        default=0.1,
        soft_min=1e-4,
        precision=4,
    )
    spacing_map: SPACING_MAP
    spacing_range: SPACING_RANGE
    branching: BRANCHING
    aspect: FloatProperty(
        name="Aspect",
        description="Spacing of quads along their second direction over that along the first, the one nearer to X; "
        "only where the two never change places around a disclination",
        default=1.0,
        **FACTOR,
    )
    features: FEATURE_ANGLE
    smoothing: SMOOTHING
    faces: FACES
    straighten: STRAIGHTEN
    method: METHOD
    rounding: ROUNDING
    seed: SEED
    target_gap: TARGET_GAP
    assign_material: BoolProperty(
        name="Assign to All Faces",
        description="Show the pattern on all faces, also on an object with several materials",
    )


class SynchSettings(SettingProperties, bpy.types.PropertyGroup):
    """Settings of an object, kept in the file."""

    guidance: EnumProperty(
        name="Guidance",
        description="What the directions follow",
        items=[
            ("SMOOTH", "Smoothest", "The field that turns least over the surface"),
            *GUIDE_ITEMS,
            ("BLEND", "Blend", "Several guides, each with a strength"),
        ],
        default="SMOOTH",
    )
    guide: PointerProperty(name="Guide", description="The only guide", type=SynchGuide)
    guides: CollectionProperty(name="Guides", description="The guides of a blend", type=SynchGuide)
    automatic_spacing: BoolProperty(
        name="Automatic Spacing",
        description="About forty stripes across the object, or as many as the mesh can carry",
        default=True,
    )
    mesh_branching: MESH_BRANCHING
    mesh_singularities: MESH_SINGULARITIES
    constraints: CollectionProperty(
        name="Constraints", description="What is asked of the pattern along lines of the mesh", type=SynchConstraint
    )
    pins: StringProperty(
        name="Pins",
        description="Faces around which directions turn as often as is said here, in the smallest turns that there "
        "are: halves for lines, quarters for crosses",
    )
    active_constraint: IntProperty(name="Active Constraint", description="Row that the panel shows", min=0)
    favourites: CollectionProperty(name="Favourites", description="Variations that are kept", type=SynchFavourite)
    result: StringProperty(name="Result", description="What the panel shows of the last solve, as JSON")


PROPERTY_NAMES = tuple(SettingProperties.__annotations__)
# What an object has of its own besides.
STORED_NAMES = (*PROPERTY_NAMES, "automatic_spacing", *(f"mesh_{name}" for name in MESH_SHARES))


def stored_settings(obj):
    """The :class:`Settings` that the panel keeps for an object; errors as :func:`stored_guidance`."""
    stored = obj.synch
    return plain(stored, None if stored.automatic_spacing else stored.spacing, stored_guidance(stored))


def plain(properties, spacing, guidance=None):
    """:class:`Settings` from an operator's properties, with the spacing given apart (None: automatic), or from an
    object's, whose guidance is given as text."""
    mirror = "".join(axis for axis, chosen in zip("XYZ", properties.mirror, strict=True) if chosen)
    guidance = properties.guidance if guidance is None else guidance
    apart = {"guidance": guidance, "spacing": spacing, "mirror": mirror}
    return settings_of(Settings, properties, SettingProperties, **apart)


register, unregister = keeping((SynchSettings,), (bpy.types.Object, "synch", SynchSettings))
