# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's input: everything that is read from the scene before anything is solved, and the solves themselves."""

from dataclasses import dataclass, replace

import numpy as np

from ...core.errors import AsymmetryError, SettingError
from ...core.fields import (
    DirectionWishes,
    Row,
    direction_field,
    given_directions,
    quad_pattern,
    stripe_pattern,
)
from ...core.fields.directions import SYMMETRIES
from ...core.fields.growth import Growth
from ...core.fields.mirror import Mirror
from ...core.fields.patterns import check_spacing
from ...core.geometry import mesh_input
from ...core.geometry.mirror import mirrored_vertices
from ...core.monitor import Monitor
from ..blender import attributes, meshes
from ..blender.vertex_maps import read_factors, read_turns
from ..settings import constraints
from ..settings.constraint_list import stored_constraints
from ..settings.fields import Settings
from ..settings.guidance import PendingGuide, read_guides

# What a command solves along its directions; "directions" stops before.
PATTERNS = {"stripes": stripe_pattern, "quads": quad_pattern, "quad_mesh": quad_pattern}
# Automatic spacing: this many stripes or quads across the object, and at least this many edges to a period;
# an object of few edges gets these lines all the same, with a warning.
LINES_ACROSS = 40
EDGES_PER_PERIOD = 4
FEWEST_LINES = 2
# Warn when more than this share of the edges turn the phase by more than half a period.
COARSE_SHARE = 0.05


@dataclass(frozen=True)
class Task:
    """All that is read from the scene before solving.

    Attributes
    ----------
    command : "directions", or one of :data:`PATTERNS`
    given, settings : what the rest belongs to
    directions : (n, 3) vectors that are taken exactly as they are, or None
    guides : what the directions follow
    turn : radians by which the directions are turned, one or (n,)
    rows : Rows of the constraint list
    mirrors : reflections that leave the field as it is
    spacing : the spacing, in scene units
    spacings : that times its map, (n,), and for quads with an aspect (n, 2), or the spacing alone
    """

    command: str
    given: mesh_input.MeshInput
    settings: Settings
    directions: np.ndarray | None
    guides: tuple[PendingGuide, ...]
    turn: float | np.ndarray
    rows: tuple[Row, ...]
    mirrors: tuple[Mirror, ...]
    spacing: float
    spacings: float | np.ndarray


def settings_for(command, obj, settings):
    """The settings that count for a command on an object; refuses what it cannot do."""
    if command == "directions":
        settings = replace(settings, spacing=None, spacing_map="")
    elif PATTERNS[command] is quad_pattern:
        settings = replace(settings, symmetry="cross")
    elif settings.symmetry == "cross":
        raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
    if settings.constraints is None:
        settings = replace(settings, constraints=stored_constraints(obj))
    return settings


def gather(command, obj, settings, polygons=None):
    """Read what the settings ask for; refuse what cannot be. The faces are read where they are not given."""
    given = constraints.cut_mesh(obj, meshes.read_mesh(obj, polygons), settings.constraints)
    spacing = automatic_spacing(command, given.mesh) if settings.spacing is None else settings.spacing
    spacings, turn, directions, guides = spacing, settings.angle, None, ()
    if settings.spacing_map:
        spacings = spacing * read_factors(obj, given, settings.spacing_map, settings.spacing_range)
    if settings.symmetry == "cross" and settings.aspect != 1:
        spacings = np.reshape(spacings, (-1, 1)) * [1.0, settings.aspect]
    check_spacing(given.mesh.vertices[np.unique(given.mesh.triangles)], spacings)
    if settings.angle_attribute:
        turn = turn + read_turns(obj, given, settings.angle_attribute)
    if settings.exact_attribute is None:
        guides = read_guides(obj, given, settings.symmetry, settings.sources)
    else:
        directions = attributes.read_vectors(obj, settings.exact_attribute, given)
    for row in settings.all_constraints:
        if PATTERNS.get(command) is quad_pattern and row.where == "attribute" and row.what == "phase":
            raise SettingError(f"{row.label} gives one phase a vertex, and quads have two: remove the row")
    rows = constraints.rows_of(obj, given, settings.all_constraints)
    mirrors = read_mirrors(given, settings.mirror)
    return Task(command, given, settings, directions, guides, turn, rows, mirrors, spacing, spacings)


def read_mirrors(given, axes):
    """Mirrors in the object's axes, as letters, through its origin."""
    numbers = sorted("XYZ".index(letter) for letter in set(axes))
    try:
        return tuple(Mirror.of(given.mesh, mirrored_vertices(given.mesh, given.polygons, n), n) for n in numbers)
    except AsymmetryError as error:
        raise error.renumbered(given.source) from None


def solve_directions(task, callback, before=None):
    """The :class:`DirectionField` of a task, turned by its angle; from the one of the frame before, if there is one."""
    mesh, settings = task.given.mesh, task.settings
    symmetry = SYMMETRIES[settings.symmetry]
    if task.directions is not None:
        return given_directions(mesh, symmetry, task.directions).turned(task.turn)
    wishes = DirectionWishes(tuple(guide.weighted for guide in task.guides), task.rows, task.mirrors)
    return direction_field(mesh, symmetry, wishes, settings.options, callback, before).turned(task.turn)


def solve_pattern(task, field, report, callback, before=None, hold=0.0):
    """The :class:`Pattern` of a task along a field; from the one of the frame before, if there is one.

    What the spacing asks for is told to the report, where there is one.
    """
    if report is not None:
        _judge_spacing(task, field, report, callback)
    solve = PATTERNS[task.command]
    settings = task.settings
    return solve(
        task.given.mesh,
        field,
        task.spacings,
        task.rows,
        task.mirrors,
        settings.options,
        callback,
        before=before,
        hold=hold,
    )


def _judge_spacing(task, field, report, callback):
    growth = Growth.of(task.given.mesh, field, task.spacings)
    share = growth.coarse_share
    if share > COARSE_SHARE:
        finest = np.min(task.spacings)
        report.warn(
            f"the spacing {finest:g} is finer than the mesh can carry on {share:.0%} of its edges: "
            f"it needs edges shorter than {finest / 2:.3g}, subdivide or remesh"
        )
    report.forced_dislocations = growth.forced_dislocations
    # What the map asks for is seen before the stripes are there.
    Monitor(callback).at(f"pattern, {report.forced_dislocations:.0f} dislocations asked for", 0.0)


def automatic_spacing(command, mesh, across=LINES_ACROSS):
    """About this many stripes or quads across the object, or as many as its edges can carry, but two at least.

    A period has one stripe, and two quads.
    """
    size = np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()
    per_period = 2 if PATTERNS.get(command) is quad_pattern else 1
    spacing = max(per_period * size / across, carried_spacing(mesh.edge_lengths))
    return float(min(spacing, per_period * size / FEWEST_LINES))


def carried_spacing(lengths):
    """The finest spacing for (e,) lengths of edges: four edges to it as a rule, and two where they are longest."""
    median, long = np.quantile(lengths, [0.5, 1 - COARSE_SHARE])
    return float(max(EDGES_PER_PERIOD * median, 2 * long))
