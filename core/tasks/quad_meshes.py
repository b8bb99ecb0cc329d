# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of a wanted number of faces, and with fewer long loops."""

from dataclasses import replace

import numpy as np

from ..errors import Cancelled, ContradictionError, SettingError, SynchError
from ..extract.lines.edge_crossings import TooManyLines
from ..extract.quads.finishing import lost_lines
from ..extract.quads.measure.faults import quad_faults
from ..extract.quads.measure.loops import quad_loops
from ..fields.target_one_form import TargetOneForm
from ..monitor import Monitor, portion

# Share by which the number of faces may miss without more tries and without a warning, and how often one is made.
NEAR, FAR, CORRECTIONS = 0.03, 0.05, 6
# What part of the quads that a spacing has room for there are in the end, about: on most meshes 0.94 to 1.01.
YIELD = 0.97
# How much the singularities are turned down where loops are to be straightened.
CALMER = 0.25
# Shares of the work: directions, and of the rest the pattern.
_DIRECTIONS, _PATTERN, _CORRECTION = 0.4, 0.3, 0.05


def solve_quad_mesh(request, progress=None):
    """The SurfaceResult of a SurfaceRequest with its quads; errors as :meth:`SurfaceRequest.solve`."""
    share = 0.5 if request.straighten else 1.0
    found = _mesh_field(
        request, request.directed(portion(progress, 0.0, share * _DIRECTIONS)), portion(progress, 0.0, share)
    )
    if request.straighten:
        found = _straighten_loops(request, found, portion(progress, share, 1.0 - share))
    faults = [
        line for about in (_about_pieces, _about_lines, _about_others, _about_shape) for line in about(request, found)
    ]
    return replace(found, warnings=(*found.warnings, *request.refused_faults(faults)))


def _mesh_field(request, directions, progress):
    """The mesh along a field; of the wanted number of faces as nearly as can be.

    The number falls in steps, by whole loops: the spacing is mended in proportion, and then halfway between those with
    too many and too few.
    """
    if request.faces is None:
        return _trace_pattern(request, directions, portion(progress, _DIRECTIONS, 1 - _DIRECTIONS))
    growth = TargetOneForm.of(request.given.mesh, directions, request.spacings)
    least = _least_factor(request.given.mesh, request.spacings, request.faces)
    factor, bounds, found = max(np.sqrt(YIELD * growth.quad_count / request.faces), least), [0.0, np.inf], []
    for number in range(1 + CORRECTIONS):
        start = _DIRECTIONS + number * _CORRECTION + (number > 0) * _PATTERN
        share = _CORRECTION if number else _PATTERN
        try:
            found.append(
                _trace_pattern(_scale_spacing(request, float(factor)), directions, portion(progress, start, share))
            )
        except ContradictionError:
            raise
        except TooManyLines as error:
            raise SettingError(f"{request.faces} faces are too many for this mesh ({error}): ask for fewer") from None
        except SettingError:  # quads as large as that are no mesh
            bounds[1] = factor
            factor = np.sqrt(np.prod(bounds)) if bounds[0] > 0 else factor / 2
            continue
        count = len(found[-1].quads.sizes)
        if abs(count / request.faces - 1) <= NEAR:
            break
        bounds[count < request.faces] = factor
        proportional = factor * np.sqrt(count / request.faces)
        factor = np.sqrt(np.prod(bounds)) if bounds[0] > 0 and np.isfinite(bounds[1]) else proportional
    if not found:
        raise SettingError(f"{request.faces} faces are too few for a quad mesh of this surface: ask for more")
    best = min(found, key=lambda result: abs(len(result.quads.sizes) - request.faces))
    return replace(best, warnings=(*best.warnings, *_about_faces(request, len(best.quads.sizes))))


def _trace_pattern(request, directions, progress):
    """The result of the pattern along a field with its quads, and the settings that they are made with."""
    found = request.along(directions, progress)
    settled = {"spacing": request.spacing, "singularities": request.singularities}
    return replace(found, **request.traced(found.pattern), settled=settled)


def _scale_spacing(request, factor):
    return replace(request, spacing=factor * request.spacing, spacings=factor * np.asarray(request.spacings))


def _about_faces(request, count):
    wanted, mesh = request.faces, request.given.mesh
    if abs(count / wanted - 1) <= FAR:
        return
    pieces = len(np.unique(mesh.pieces[mesh.triangles[:, 0]]))
    if count > wanted and pieces > wanted:
        yield (
            f"the quad mesh has {count} faces, not {wanted}: each of the {pieces} pieces of the surface has one of its "
            f"own: where they should hang together, use Mesh > Clean Up > Merge by Distance"
        )
    else:
        yield f"the quad mesh has {count} faces, not {wanted}: what it must keep to leaves no spacing nearer to that"


def _about_pieces(request, found):
    mesh, quads = request.given.mesh, found.quads
    of_triangles = mesh.pieces[mesh.triangles[:, 0]]
    all_pieces, kept = np.unique(of_triangles), np.unique(of_triangles[quads.triangles])
    if len(kept) < len(all_pieces):
        yield (
            f"{len(all_pieces) - len(kept)} of {len(all_pieces)} pieces of the surface are too small for the quads and "
            f"left out: reduce the spacing"
        )


def _about_lines(request, found):
    lost, lengths = lost_lines(found.quads, request.given.mesh, request.rows)
    if len(lost):
        yield (
            f"{len(lost)} of {len(lengths)} lines of the boundary and of sharp edges are lost, {lost.sum():.3g} of "
            f"{lengths.sum():.3g} in length: reduce the spacing"
        )


def _about_others(request, found):
    others = int((found.quads.sizes != 4).sum())
    if others and request.branching == 0:
        faces = len(found.quads.sizes)
        yield f"{others} of {faces} faces are no quads though no branches are asked for: reduce the spacing"


def _about_shape(request, found):
    return quad_faults(found.quads, request.given.mesh, request.given.is_closed)


def spacing_factor(mesh, spacings, faces):
    """What spacings are to be multiplied with for about a number of quads on a flat surface; no less than it takes for
    the quads to reach from one end of each piece to the other.

    Parameters
    ----------
    mesh : TriangleMesh
    spacings : one, (n,), or (n, 2) or (1, 2) along two axes
    faces : number of quads
    """
    return max(_area_factor(mesh, spacings) / np.sqrt(faces), _least_factor(mesh, spacings, faces))


def faces_of_factor(mesh, spacings, factor):
    """The number of quads for which :func:`spacing_factor` gives a factor, rounded down."""
    return int(max((_area_factor(mesh, spacings) / factor) ** 2, _least_factor(mesh, spacings, 1) / factor))


def _area_factor(mesh, spacings):
    """The factor at which one quad is as large as the surface."""
    sides = np.broadcast_to(_along_axes(spacings), (mesh.vertex_count, 2)) / 2
    return float(np.sqrt((mesh.vertex_masses / sides.prod(axis=1)).sum()))


def _least_factor(mesh, spacings, faces):
    """The factor at which so many quads in a row, corner to corner, are as long as the longest piece of the mesh: a
    needle has too little area for a spacing to follow from it."""
    low, high = np.full((2, mesh.vertex_count, 3), np.inf)
    np.minimum.at(low, mesh.pieces, mesh.vertices)
    np.minimum.at(high, mesh.pieces, -mesh.vertices)
    present = np.unique(mesh.pieces[mesh.triangles])
    reach = (-high[present] - low[present]).max()
    return float(reach / (np.sqrt(0.5) * np.max(spacings) * faces))


def smallest_sides(mesh, spacings):
    """(n,) the shorter side of a quad at each vertex, for spacings as :func:`spacing_factor` has them."""
    return np.broadcast_to(_along_axes(spacings).min(axis=1) / 2, mesh.vertex_count)


def _along_axes(spacings):
    spacings = np.asarray(spacings, float)
    return spacings if spacings.ndim == 2 else np.repeat(spacings.reshape(-1, 1), 2, axis=1)


def _straighten_loops(request, found, progress):
    """The mesh of the fewest spirals, and then of the shortest longest loop, of about as many faces, among those of the
    pattern's variations and of a calmer field."""
    monitor = Monitor(progress)
    variations = found.pattern.solution.variations
    candidates = []
    for number, phases in enumerate(variations[1:], 1):
        monitor.at("straightening", 0.5 * number / len(variations))
        pattern = found.pattern.showing(phases)
        candidates.append(_try_candidate(lambda shown=pattern: replace(found, pattern=shown, **request.traced(shown))))
    if request.singularities > 0 and request.directions is None:
        calmer = replace(request, singularities=max(0.0, request.singularities - CALMER))
        directions = calmer.directed(portion(progress, 0.5, 0.2))
        candidates.append(_try_candidate(lambda: _mesh_field(calmer, directions, portion(progress, 0.7, 0.3))))
    share, count = _quad_share(found), len(found.quads.sizes)
    near = [c for c in candidates if c is not None and abs(len(c.quads.sizes) / count - 1) <= NEAR]
    best = min(
        [found, *(c for c in near if _quad_share(c) >= share)],
        key=lambda result: (quad_loops(result.quads).spirals.sum(), quad_loops(result.quads).lengths.max(initial=0)),
    )
    return replace(best, loops_before=quad_loops(found.quads).figures)


def _try_candidate(make):
    """A candidate; None where its quads would be no mesh."""
    try:
        return make()
    except Cancelled:
        raise
    except SynchError:
        return None


def _quad_share(result):
    return float((result.quads.sizes == 4).mean())
