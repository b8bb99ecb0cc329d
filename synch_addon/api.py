# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python API: ``directions`` and ``stripes`` on a mesh object, shared by operators and command line.

Each gathers arrays, calls the core, and only then writes; an error or a cancellation leaves the
scene as it was. Both return the report that the command line writes as JSON.
"""

from contextlib import contextmanager
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..core.errors import AsymmetryError, ContradictionError, SettingError, SynchError
from ..core.fields import DirectionWishes, Row, direction_field, given_directions, stripe_pattern
from ..core.fields.directions import SYMMETRIES
from ..core.fields.mirror import Mirror
from ..core.fields.stripes import check_spacing, coarse_edge_share, forced_dislocations
from ..core.geometry.mirror import mirrored_vertices
from . import constraints, field_io, scene_io, write
from .constraint_list import stored_constraints
from .guidance import PendingGuide, read_guides
from .report import Report
from .settings import Settings, from_names
from .vertex_maps import read_factors, read_turns

# Automatic spacing: this many stripes across the object, and at least this many edges to a stripe;
# an object of few edges gets these stripes all the same, with a warning.
STRIPES_ACROSS = 40
EDGES_PER_STRIPE = 4
FEWEST_STRIPES = 2
# Warn when more than this share of the edges turn the phase by more than half a period.
COARSE_SHARE = 0.05


def directions(obj, callback=None, **settings):
    """Solve a direction field on a mesh object and write it as attributes and empties.

    Parameters
    ----------
    obj : bpy.types.Object
    callback : callable(stage, fraction) -> bool, optional; False cancels
    settings : see :class:`Settings`; spacing does not count

    Returns
    -------
    dict, the report

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    return run("directions", obj, from_names(settings), callback)


def stripes(obj, callback=None, **settings):
    """Solve a stripe pattern along a direction field and write attributes, material and empties.

    Parameters, result and errors as :func:`directions`.
    """
    return run("stripes", obj, from_names(settings), callback)


def run(command, obj, settings, callback=None):
    """Run "directions" or "stripes" with ready :class:`Settings`."""
    job = FieldJob(command, obj, settings)
    job.solve(callback)
    return job.write(obj)


def refuse(obj):
    """Raise SynchError for an object that cannot be given a field."""
    reason = scene_io.refusal(obj)
    if reason:
        raise SynchError(reason)


def import_field(obj, path):
    """Write the directions of a .rawfield or .rosy file to a mesh object's ``synch_direction``.

    Returns
    -------
    "vector", "line" or "cross", what the file's directions are

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    refuse(obj)
    with _object_mode(obj):
        return field_io.import_directions(obj, path)


def export_field(obj, path, symmetry="line"):
    """Write a mesh object's ``synch_direction`` as a .rawfield or .rosy file, one set of directions a triangle.

    Parameters
    ----------
    obj : bpy.types.Object, all of whose faces are triangles
    path : where to
    symmetry : "vector", "line" or "cross", what the directions are

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    refuse(obj)
    if symmetry not in SYMMETRIES:
        raise SettingError(f"symmetry {symmetry!r} is unknown: use one of {', '.join(SYMMETRIES)}")
    with _object_mode(obj):
        field_io.export_directions(obj, path, symmetry)


def select(obj, vertices):
    """Select vertices and nothing else of an object's mesh, in object or edit mode."""
    with _object_mode(obj):
        scene_io.select_vertices(obj, vertices)


class FieldJob:
    """One run in three steps, of which only the middle one takes long and touches no Blender data.

    Making it reads the object and refuses what cannot be; :meth:`solve` may run in another thread;
    :meth:`write` puts the result into the scene. Before that nothing has changed.
    """

    def __init__(self, command, obj, settings):
        refuse(obj)
        if command == "directions":
            settings = replace(settings, spacing=None, spacing_map="")
        elif settings.symmetry == "cross":
            raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
        bpy.context.view_layer.update()  # a script may have scaled the object just now
        if settings.constraints is None:
            settings = replace(settings, constraints=stored_constraints(obj))
        self.command = command
        self._report = Report(command, obj, settings)
        with _object_mode(obj), self._report.clock("read"):
            self._task = gather(obj, settings)
            self._report.warn_about(obj, self._task)

    def solve(self, callback=None):
        """Solve on the arrays alone.

        Raises
        ------
        Cancelled
            when the callback returns False
        ContradictionError
            naming vertices of the object
        """
        try:
            self._solve(callback)
        except ContradictionError as error:
            raise error.renumbered(self._task.given.source) from None

    def _solve(self, callback):
        alone = self.command == "directions"
        self._field = solve_directions(self._task, callback if alone else _portion(callback, 0.0, 0.4))
        self._pattern = None
        if not alone:
            self._pattern = solve_stripes(self._task, self._field, self._report, _portion(callback, 0.4, 0.6))

    def write(self, obj):
        """Write the result to the object at once; returns the report."""
        with _object_mode(obj):
            if not scene_io.is_unchanged(obj, self._task.given):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            with self._report.clock("write"):
                defects = write.results(obj, self._task, self._field, self._pattern, self._report)
            return self._report.finish(self._field, self._pattern, defects)


@dataclass(frozen=True)
class Task:
    """All that is read from the scene before solving.

    Attributes
    ----------
    given, settings : what the rest belongs to
    directions : (n, 3) vectors that are taken exactly as they are, or None
    guides : what the directions follow
    turn : radians by which the directions are turned, one or (n,)
    rows : Rows of the constraint list
    mirrors : reflections that leave the field as it is
    spacing : the spacing, in scene units
    spacings : that times its map, (n,), or the spacing alone
    """

    given: scene_io.MeshInput
    settings: Settings
    directions: np.ndarray | None
    guides: tuple[PendingGuide, ...]
    turn: float | np.ndarray
    rows: tuple[Row, ...]
    mirrors: tuple[Mirror, ...]
    spacing: float
    spacings: float | np.ndarray


def gather(obj, settings):
    """Read what the settings ask for; refuse what cannot be."""
    given = constraints.cut_mesh(obj, scene_io.read_mesh(obj), settings.constraints)
    spacing = automatic_spacing(given.mesh) if settings.spacing is None else settings.spacing
    spacings, turn, directions, guides = spacing, settings.angle, None, ()
    if settings.spacing_map:
        spacings = spacing * read_factors(obj, given, settings.spacing_map, settings.spacing_range)
    check_spacing(given.mesh, spacings)
    if settings.angle_attribute:
        turn = turn + read_turns(obj, given, settings.angle_attribute)
    if settings.exact_attribute is None:
        guides = read_guides(obj, given, settings.symmetry, settings.sources)
    else:
        directions = scene_io.read_vectors(obj, settings.exact_attribute, given)
    rows = constraints.rows_of(obj, given, settings.all_constraints)
    mirrors = read_mirrors(given, settings.mirror)
    return Task(given, settings, directions, guides, turn, rows, mirrors, spacing, spacings)


def read_mirrors(given, axes):
    """Mirrors in the object's axes, as letters, through its origin."""
    numbers = sorted("XYZ".index(letter) for letter in set(axes))
    try:
        return tuple(Mirror.of(given.mesh, mirrored_vertices(given.mesh, given.polygons, n), n) for n in numbers)
    except AsymmetryError as error:
        raise error.renumbered(given.source) from None


def solve_directions(task, callback):
    """The :class:`DirectionField` of a task, turned by its angle."""
    mesh, settings = task.given.mesh, task.settings
    symmetry = SYMMETRIES[settings.symmetry]
    if task.directions is not None:
        return given_directions(mesh, symmetry, task.directions).turned(task.turn)
    wishes = DirectionWishes(tuple(guide.weighted for guide in task.guides), task.rows, task.mirrors)
    return direction_field(mesh, symmetry, wishes, settings.options, callback).turned(task.turn)


def solve_stripes(task, field, report, callback):
    """The :class:`StripePattern` of a task along a field."""
    mesh, settings = task.given.mesh, task.settings
    share = coarse_edge_share(mesh, field, task.spacings)
    if share > COARSE_SHARE:
        finest = np.min(task.spacings)
        report.warn(
            f"the spacing {finest:g} is finer than the mesh can carry on {share:.0%} of its edges: "
            f"it needs edges shorter than {finest / 2:.3g}, subdivide or remesh"
        )
    report.forced_dislocations = forced_dislocations(mesh, field, task.spacings)
    if callback is not None:  # what the map asks for is seen before the stripes are there; cancelling is the solver's
        callback(f"stripes, {report.forced_dislocations:.0f} dislocations asked for", 0.0)
    return stripe_pattern(mesh, field, task.spacings, task.rows, task.mirrors, settings.options, callback)


def automatic_spacing(mesh):
    """About forty stripes across the object, or as many as its edges can carry, but two at least."""
    size = np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()
    median, long = np.quantile(mesh.edge_lengths, [0.5, 1 - COARSE_SHARE])
    spacing = max(size / STRIPES_ACROSS, EDGES_PER_STRIPE * median, 2 * long)
    return float(min(spacing, size / FEWEST_STRIPES))


def _portion(callback, start, share):
    """A callback for a part of the whole work."""
    if callback is None:
        return None
    return lambda stage, fraction: callback(stage, start + share * fraction)


@contextmanager
def _object_mode(obj):
    """Leave edit mode while attributes are read and written, and come back to it."""
    editing = obj.mode == "EDIT"
    if editing:
        if bpy.context.view_layer.objects.active != obj:
            raise SynchError(
                f"{obj.name} is in edit mode and not active: make it the active object, or leave edit mode"
            )
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if editing:
            bpy.ops.object.mode_set(mode="EDIT")
