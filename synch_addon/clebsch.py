# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of a flow as objects: filaments as a curve, tubes as a mesh coloured by the sphere (paper, Section 3.6)."""

import math
import time
from dataclasses import asdict, dataclass

import bpy
import numpy as np

from ..core.errors import SettingError
from ..core.extract.filaments import filaments
from ..core.extract.isosurface import isosurface
from ..core.fields.clebsch import circulations, clebsch_map, quantum_for, spherical_map
from ..core.solve import METHODS, Options
from .flows import STRENGTH, read_flow
from .report import peak_memory, quality, versions

SHOWN = ("filaments", "tubes")
# Radius of a filament's tube in cells of the grid.
_THICKNESS = 0.25


@dataclass(frozen=True)
class ClebschSettings:
    """Settings of the operator, the command line and the API alike.

    Attributes
    ----------
    show : "filaments" or "tubes"
    resolution : nodes along the longest side that files and curves are resampled to
    count : filaments through the plane of the grid with most vorticity, unless a quantum is given
    quantum : circulation of one filament, None for one that makes ``count`` of them
    point : of the sphere, from which tubes are seen: they are around where the map shows its antipode; for filaments
        None shows the best map, a point the projection along it
    opening : degrees around the antipode that are inside a tube
    smoothing : how often points of filaments move to the middle of their neighbours
    method, seed, target_gap, time_limit : as for fields
    """

    show: str = "filaments"
    resolution: int = 48
    count: float = 4.0
    quantum: float | None = None
    point: tuple[float, float, float] | None = None
    opening: float = 60.0
    smoothing: int = 2
    method: str = "sdp"
    seed: int = 0
    target_gap: float = 1e-2
    time_limit: float | None = None

    def __post_init__(self):
        for name, choices in (("show", SHOWN), ("method", METHODS)):
            if getattr(self, name) not in choices:
                raise SettingError(f"{name} {getattr(self, name)!r} is unknown: use one of {', '.join(choices)}")
        for name in ("count", "opening"):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and math.isfinite(value) and value > 0):
                raise SettingError(f"the {name} is {value!r}: give a positive number")
        if self.opening >= 180:
            raise SettingError(f"the opening is {self.opening:g} degrees: the whole sphere has 180, give less")
        if self.point is not None and (len(self.point) != 3 or not np.linalg.norm(self.point) > 0):
            raise SettingError(f"the point of the sphere is {self.point!r}: give three numbers that are not all 0")
        if self.show == "tubes" and self.method != "sdp":
            raise SettingError("tubes come from the relaxation: use the method sdp")

    @property
    def options(self):
        return Options(method=self.method, seed=self.seed, target_gap=self.target_gap, time_limit=self.time_limit)


class ClebschJob:
    """One run in three steps: reading when it is made, :meth:`solve` on arrays alone, :meth:`write` into the scene."""

    def __init__(self, source, settings):
        self._start = time.perf_counter()
        self.settings = settings
        self._flow = read_flow(source, settings.resolution)
        if self._flow.grid.dimension != 3:
            raise SettingError(f"{self._flow.name}: a flow in a plane has no filaments to show: give one in space")

    def solve(self, callback=None):
        """Solve for the map, and the sphere where it is asked for."""
        settings, flow = self.settings, self._flow
        quantum = settings.quantum
        if quantum is None:
            quantum = quantum_for(flow.grid, flow.integrals, settings.count)
        self._found = clebsch_map(flow.grid, flow.integrals, quantum, settings.options, callback)
        self._sphere = None
        if settings.show == "tubes" or settings.point is not None:
            self._sphere = spherical_map(self._found, callback)

    def write(self, _obj=None):
        """Make the object; returns the report."""
        settings, shown = self.settings, self._found
        facts = {}
        if settings.show == "tubes":
            made, facts["tubes"] = _write_tubes(self._flow, self._sphere, settings)
        else:
            if settings.point is not None:
                shown = self._sphere.seen_from(settings.point)
            made, facts["filaments"] = _write_filaments(self._flow, shown, settings)
        vorticity = np.abs(circulations(shown.grid, shown.integrals)).sum()
        caught = shown.quantum * np.abs(shown.face_numbers).sum()
        return {
            "status": shown.solution.status.value,
            "command": "clebsch",
            "source": self._flow.name,
            "object": made.name,
            "nodes": shown.grid.node_count,
            "edges": len(shown.grid.edges),
            "shape": list(shown.grid.shape),
            "quantum": shown.quantum,
            **quality(shown.solution),
            "energy": shown.energy,
            "sphere_energy": self._sphere.energy if self._sphere else None,
            "vorticity_share": float(caught / vorticity) if vorticity else None,
            **facts,
            "times": shown.solution.times | {"total": time.perf_counter() - self._start},
            "peak_memory_mb": peak_memory(),
            "settings": asdict(settings),
            "warnings": [],
            "versions": versions(),
        }


def clebsch(source, callback=None, **settings):
    """Show the vortices of a flow.

    Parameters
    ----------
    source : path of a .vdb or .npz file, a volume object, a curve object, or a list of curve objects
    callback : callable(stage, fraction) -> bool, optional; False cancels
    settings : see :class:`ClebschSettings`

    Returns
    -------
    dict, the report

    Raises
    ------
    SynchError
        with one line that says what is wrong and the remedy; nothing is written
    """
    known = list(ClebschSettings.__annotations__)
    for name in settings:
        if name not in known:
            raise SettingError(f"the setting {name!r} is unknown: use one of {', '.join(known)}")
    job = ClebschJob(source, ClebschSettings(**settings))
    job.solve(callback)
    return job.write()


def _write_filaments(flow, shown, settings):
    """A curve object with a spline for every filament."""
    found = filaments(shown, settings.smoothing)
    data = bpy.data.curves.new("Vortex Filaments", "CURVE")
    data.dimensions = "3D"
    data.bevel_depth = _THICKNESS * float(shown.grid.spacing.min())
    data.bevel_resolution = 3
    for line in found:
        spline = data.splines.new("POLY")
        spline.points.add(len(line.points) - 1)
        spline.points.foreach_set("co", np.column_stack([line.points, np.ones(len(line.points))]).ravel())
        spline.use_cyclic_u = line.is_closed
        # Thicker where several lie on each other.
        spline.points.foreach_set("radius", np.full(len(line.points), np.sqrt(line.strength / shown.quantum)))
    made = _add(f"{flow.name} Filaments", data)
    made[STRENGTH] = shown.quantum
    return made, [
        {
            "strength": line.strength,
            "closed": line.is_closed,
            "points": len(line.points),
            "length": float(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum()),
        }
        for line in found
    ]


def _write_tubes(flow, sphere, settings):
    """A mesh around where the map to the sphere shows the antipode of the chosen point, with the sphere as colour."""
    point = np.array(settings.point if settings.point is not None else (0.0, 0.0, 1.0), float)
    facing = sphere.sphere @ (-point / np.linalg.norm(point))
    surface = isosurface(sphere.found.grid, facing, math.cos(math.radians(settings.opening)))
    data = bpy.data.meshes.new("Vortex Tubes")
    data.from_pydata(surface.mesh.vertices.tolist(), [], surface.mesh.triangles.tolist())
    data.shade_smooth()
    shown = surface.interpolated(sphere.sphere)
    shown = shown / np.maximum(np.linalg.norm(shown, axis=1, keepdims=True), 1e-12)
    colors = np.column_stack([0.5 + 0.5 * shown, np.ones(len(shown))])
    for name, data_type, field, values in (
        ("synch_sphere", "FLOAT_VECTOR", "vector", shown),
        ("synch_color", "FLOAT_COLOR", "color", colors),
    ):
        attribute = data.attributes.new(name, data_type, "POINT")
        attribute.data.foreach_set(field, values.astype(np.float32).ravel())
    made = _add(f"{flow.name} Tubes", data)
    made[STRENGTH] = sphere.found.quantum * 0.5 * (1 - math.cos(math.radians(settings.opening)))
    return made, {"faces": surface.mesh.triangle_count, "pieces": int(surface.mesh.pieces.max(initial=-1)) + 1}


def _add(name, data):
    """A new object of the scene's collection, active and selected."""
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    layer = bpy.context.view_layer
    for other in layer.objects:
        other.select_set(other == made)
    layer.objects.active = made
    return made
