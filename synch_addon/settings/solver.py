# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that surfaces, solids and flows have in common: as Blender properties."""

import math
from dataclasses import fields

from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty

from ...core.tasks.settings import SolverSettings
from .guide_list import suggest_numbers


def settings_of(kind, properties, shared, **apart):
    """Settings of a dataclass ``kind`` from the properties with the names of its fields that ``shared`` declares.

    Choices become lower case and percentages shares; ``apart`` are values of fields that are given otherwise.
    """
    known = shared.__annotations__
    values = {field.name: getattr(properties, field.name) for field in fields(kind) if field.name in known}
    for name, value in values.items():
        if known[name].function is EnumProperty:
            values[name] = value.lower() if isinstance(value, str) else tuple(choice.lower() for choice in value)
        elif known[name].keywords.get("subtype") == "PERCENTAGE":
            values[name] = value / 100
    return kind(**values | apart)


METHOD = EnumProperty(
    name="Method",
    description="How the field is optimized",
    items=[
        (
            "SDP",
            "Semidefinite",
            "Best results, with a bound on what could still be gained: proved, or estimated for large ones",
        ),
        ("SPECTRAL", "Spectral", "Fast and rough: one eigenvector"),
        ("DIFFUSION", "Diffusion", "Repeated smoothing and normalizing, without a useful bound"),
    ],
)
ROUNDING = EnumProperty(
    name="Rounding",
    description="How a field comes of the relaxation",
    items=[
        ("CONTINUATION", "Continuation", "Search from many projections for the least energy"),
        ("POLISH", "Polished", "The best of many random projections, and the local optimum below it"),
        ("RANDOM", "Randomized", "The best of many random projections and the principal one, as it is"),
        ("SVD", "Singular Vector", "The principal projection, as it is"),
    ],
)
SEED = IntProperty(name="Seed", description="Another seed gives another result of about the same quality", min=0)
TARGET_GAP = FloatProperty(
    name="Target Gap",
    description="How closely the relaxation's optimum is bracketed, as a share of its energy",
    default=SolverSettings.target_gap,
    min=1e-6,
    max=0.5,
    precision=4,
)
# Factor on the spacing where the weight of a vertex group is 1; limits of such factors, of shares, and of angles.
RANGE = 2.0
FACTOR = {"min": 1e-3, "soft_min": 0.25, "soft_max": 4.0}
SHARE = {"subtype": "PERCENTAGE", "min": 0.0, "max": 100.0, "precision": 0}
ANGLE = {"subtype": "ANGLE", "soft_min": -math.pi, "soft_max": math.pi}
BRANCHING = FloatProperty(
    name="Branching",
    description="How much lines may branch to keep their distance: 100 for as much as even spacing needs, 0 for hardly "
    "any branches or none, where lines are nearer to and further from one another instead",
    default=100.0,
    **SHARE,
)
SPACING_MAP = StringProperty(
    name="Spacing Map",
    description="Float attribute, a factor on the spacing, or vertex group, which takes it from 1 to the range",
    search=suggest_numbers,
)
SPACING_RANGE = FloatProperty(
    name="Range", description="Factor on the spacing where the vertex group's weight is 1", default=RANGE, **FACTOR
)
