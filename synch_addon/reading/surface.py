# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run is asked: everything that is read from the scene before anything is solved."""

from dataclasses import replace

import numpy as np

from ...core.errors import AsymmetryError, SettingError
from ...core.fields import quad_pattern
from ...core.fields.mirror import Mirror, Seam
from ...core.fields.patterns import check_lengths, check_spacing
from ...core.geometry.mirror import mirrored_vertices
from ...core.refinement import spacing as spacing_rules
from ...core.settings.pins import parse_pins
from ...core.settings.surface import SYMMETRY_ORDERS
from ...core.solve import Options
from ...core.tasks.quad_meshes import smallest_sides, spacing_factor
from ...core.tasks.surfaces import PATTERNS, SurfaceRequest
from ..blender import attributes, meshes
from ..blender.objects import SURFACE_MARK
from ..blender.vertex_maps import read_factors, read_turns
from ..settings.constraint_list import stored_constraints
from ..settings.fields import default_shares
from . import constraints
from .guides import read_guides


def settings_for(command, obj, settings):
    """The settings that count for a command on an object; refuses what it cannot do."""
    shares = {name: share for name, share in default_shares(command).items() if getattr(settings, name) is None}
    settings = replace(settings, **shares)
    if command == "directions":
        settings = replace(settings, spacing=None, spacing_map="", branching=None)
    elif PATTERNS[command] is quad_pattern:
        settings = replace(settings, symmetry="cross")
    elif settings.symmetry == "cross":
        raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
    if settings.constraints is None:
        settings = replace(settings, constraints=stored_constraints(obj))
    if settings.pins is None:
        settings = replace(settings, pins=obj.synch.pins if hasattr(obj, "synch") else "")
    return settings


def gather(command, obj, settings, base=None, given=None):
    """The :class:`SurfaceRequest` of what settings ask for on an object in object mode; refuses what cannot be.

    Its surface is made of the same faces as a base, a MeshInput, where there is one; ``given`` is the MeshInput of the
    object as it is, where that has been read before, with the same cuts.
    """
    if given is None:
        given = constraints.cut_mesh(obj, meshes.read_mesh(obj, base, settings.strict), settings.constraints)
    spacing = settings.spacing
    if spacing is None:
        # A surface of the pattern's own is as fine as the spacing needs.
        of_own = SURFACE_MARK in obj
        spacing = wished_spacing(command, given.mesh) if of_own else spacing_on_faces(command, given.mesh)
    spacing, spacings = asked_spacings(command, obj, given, settings, spacing)
    turn, directions, guides = settings.angle, None, ()
    if settings.angle_attribute:
        turn = turn + read_turns(obj, given, settings.angle_attribute, settings.angle_range)
    if settings.exact_attribute is None:
        guides = read_guides(obj, given, settings.symmetry, settings.sources)
    else:
        directions = attributes.read_vectors(obj, settings.exact_attribute, given)
    for row in settings.all_constraints:
        if PATTERNS.get(command) is quad_pattern and row.where == "attribute" and row.what == "phase":
            raise SettingError(f"{row.label} gives one phase a vertex, and quads have two: remove the row")
    rows = constraints.rows_of(obj, given, settings.all_constraints)
    if command == "quad_mesh" and settings.features > 0:
        sides = smallest_sides(given.mesh, spacings)
        rows += constraints.feature_rows(obj, given, settings.features, sides)
    mirrors = read_mirrors(given, settings.mirror)
    if given.seam is not None:
        mirrors += (Seam.of(given.mesh, given.seam, rows),)
    return SurfaceRequest(
        command,
        given,
        settings.symmetry,
        Options.of(settings),
        directions,
        guides,
        turn,
        rows,
        mirrors,
        spacing,
        spacings,
        tuple(map("XYZ".index, settings.mirror)),
        settings.smoothing,
        settings.singularities,
        settings.branching,
        settings.faces or None,
        settings.loops,
        pinned_triangles(parse_pins(settings.pins), given.polygons, settings.symmetry),
        strict=settings.strict,
    )


def asked_spacings(command, obj, given, settings, spacing):
    """The spacing, and that times its map: for quads with an aspect (n, 2); both as the face count asks, if there is
    one. Errors as :func:`gather`."""
    spacings = spacing
    if settings.spacing_map:
        spacings = spacing * read_factors(obj, given, settings.spacing_map, settings.spacing_range)
    if settings.symmetry == "cross" and settings.aspect != 1:
        spacings = np.reshape(spacings, (-1, 1)) * [1.0, settings.aspect]
    if command == "quad_mesh" and settings.faces:
        check_lengths(spacings)
        factor = spacing_factor(given.mesh, spacings, settings.faces)
        return factor * spacing, factor * spacings
    check_spacing(given.mesh.vertices[np.unique(given.mesh.triangles)], spacings)
    return spacing, spacings


def pinned_triangles(pins, polygons, symmetry):
    """Pairs of a triangle and an index, as :class:`DirectionWishes` takes them.

    Parameters
    ----------
    pins : dict of turns by faces
    polygons : Polygons
    symmetry : "vector", "line" or "cross"

    Raises
    ------
    SettingError
        for a face that does not exist
    """
    for face in pins:
        if not (0 <= face < len(polygons.starts) and polygons.drawn[face]):
            raise SettingError(f"there is no face {face} to pin: clear the pins, or pin again")
    order = SYMMETRY_ORDERS[symmetry]
    return tuple((int(polygons.first_triangles[face]), turns / order) for face, turns in pins.items())


def read_mirrors(given, axes):
    """Mirrors in the object's axes, as letters, through its origin."""
    numbers = sorted("XYZ".index(letter) for letter in set(axes))
    try:
        return tuple(Mirror.of(given.mesh, mirrored_vertices(given.mesh, given.polygons, n), n) for n in numbers)
    except AsymmetryError as error:
        raise error.renumbered(given.source) from None


def automatic_spacing(command, mesh, across=spacing_rules.LINES_ACROSS):
    """The spacing that suits a command on a surface (see :mod:`core.refinement.spacing`)."""
    return spacing_rules.automatic_spacing(mesh, lines_in_period(command), across)


def spacing_on_faces(command, mesh):
    """The automatic spacing where faces stay as they are."""
    return spacing_rules.spacing_on_faces(mesh, lines_in_period(command))


def wished_spacing(command, mesh):
    """The automatic spacing where faces are made as fine as it needs."""
    return spacing_rules.wished_spacing(mesh.areas.sum(), lines_in_period(command))


def lines_in_period(command):
    """A period has one stripe, and two quads."""
    return 2 if PATTERNS.get(command) is quad_pattern else 1
