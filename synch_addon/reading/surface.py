# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests of fields on surfaces: everything that is read from the scene before a solve."""

from dataclasses import replace

from ...core.tasks.surface_source import SurfaceSource
from ...core.tasks.surfaces import SurfaceRequest
from ..blender import attributes, meshes
from ..blender.attributes import read_factors, read_turns
from ..blender.objects import SURFACE_MARK
from ..settings.constraint_list import stored_constraints
from . import constraints
from .guides import read_guides


def settings_for(command, obj, settings):
    """The settings that count for a command on an object, with those that it stores; refuses what it cannot do."""
    if settings.constraints is None:
        settings = replace(settings, constraints=stored_constraints(obj))
    if settings.pins is None:
        settings = replace(settings, pins=obj.synch.pins if hasattr(obj, "synch") else "")
    return settings.for_command(command)


def gather(command, obj, settings, base=None, read=None, given=None):
    """The :class:`SurfaceRequest` of what settings ask for on an object in object mode; refuses what cannot be.

    Its surface is made of the same faces as a base, a MeshInput, where there is one. ``read`` and ``given`` are the
    MeshInput of the object as it is, where that has been read before, without and with the same cuts.
    """
    if given is None:
        read = meshes.read_mesh(obj, base, settings.strict) if read is None else read
        given = constraints.cut_mesh(obj, read, settings.constraints)
    name, exact = settings.angle_attribute, settings.exact_attribute
    has_features = command == "quad_mesh" and settings.features > 0
    source = SurfaceSource(
        given,
        rows=constraints.rows_of(obj, given, settings.all_constraints),
        guides=() if exact else read_guides(obj, given, settings.symmetry, settings.sources),
        directions=attributes.read_vectors(obj, exact, given) if exact else None,
        turns=read_turns(obj, given, name, settings.angle_range) if name else 0.0,
        factors=read_spacing_map(obj, given, settings),
        sharp=given.edges_of(attributes.read_marked_edges(obj, "sharp")) if has_features else (),
        is_fitted=SURFACE_MARK in obj,
    )
    return SurfaceRequest.of(command, source, settings)


def read_spacing_map(obj, given, settings):
    """Factors on the spacing, (n,), or 1 without a map."""
    name = settings.spacing_map
    return read_factors(obj, given, name, settings.spacing_range) if name else 1.0
