# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings as keyword arguments of the Python functions; `python tools/settings.py` writes this file."""

from typing import TypedDict

from .constraints import Constraint


class SolverKeywords(TypedDict, total=False):
    """Keywords of :class:`core.settings.SolverSettings`."""

    method: str
    seed: int
    rounding: str
    target_gap: float
    time_limit: float | None


class SurfaceKeywords(SolverKeywords, total=False):
    """Keywords of :class:`core.settings.SurfaceSettings`."""

    symmetry: str
    guidance: str
    angle: float
    angle_attribute: str
    angle_range: float
    boundary: str
    vertex_group: str
    mirror: str
    singularities: float | None
    constraints: tuple[Constraint, ...] | None
    pins: str | None
    spacing: float | None
    spacing_map: str
    spacing_range: float
    branching: float | None
    aspect: float
    faces: int
    features: float
    smoothing: int
    loops: float
    surface: str
    assign_material: bool
    strict: bool


class LayerKeywords(SolverKeywords, total=False):
    """Keywords of :class:`core.settings.LayerSettings`."""

    guidance: str
    groups: str
    spacing: float | None
    size: float | None
    divisions: int | None
    spacing_map: str
    spacing_range: float
    branching: float
    smallest_height: float
    largest_height: float
    numbers: str
    strict: bool


class FlowKeywords(SolverKeywords, total=False):
    """Keywords of :class:`core.settings.FlowSettings`."""

    show: str
    resolution: int
    share: float
    count: float | None
    quantum: float | None
    core: float | None
    attribute: str
    point: tuple[float, float, float] | None
    opening: float
    smoothing: int
    unwrapped: bool
    frames: tuple[int, int] | None
    strict: bool


class LineKeywords(TypedDict, total=False):
    """Keywords of :class:`core.settings.LineSettings`."""

    width: float
    distance: float
    smoothing: int
    radius: float
    spline: str


class BakeKeywords(TypedDict, total=False):
    """Keywords of :class:`core.settings.BakeSettings`."""

    maps: tuple[str, ...]
    size: int
    margin: int
    samples: int
    uv_map: str
    unwrap: bool
    folder: str
    naming: str
    file_format: str
    material: bool
    displacement: bool
