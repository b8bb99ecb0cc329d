# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes of a wanted number of faces, and with fewer long loops."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import Cancelled, ContradictionError, SettingError, SynchError
from ..extract.lines.edge_crossings import TooManyLines
from ..extract.quads.finishing import lost_lines
from ..extract.quads.measure.faults import quad_faults
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields.target_one_form import TargetOneForm
from ..monitor import Monitor, portion
from ..solution import COARSE, FIRST
from .close_loops import close_loops

# Share by which the number of faces may miss without more tries and without a warning.
NEAR, FAR = 0.03, 0.05
# Spacings that are tried for a number of faces.
TRIES = 7
# Vertices from which on the search for directions is made on a coarse stage: its energies are as low there.
LARGE_MESH = 15_000
# What part of the quads that a spacing has room for there are in the end, about: on most meshes 0.94 to 1.01.
YIELD = 0.97
# Share of the work that directions are.
_DIRECTIONS = 0.4
# Share of the work on a pattern after which its loops are closed, and its quads smoothed.
_CLOSING, _SMOOTHING = 0.3, 0.9


def solve_quad_mesh(request, progress=None):
    """The SurfaceResult of a SurfaceRequest with its quads; errors as :meth:`SurfaceRequest.solve`."""
    wanted = request
    if _is_default_search(request) and request.given.mesh.vertex_count > LARGE_MESH:
        wanted = _with_options(request, rounding=COARSE)
    directions = wanted.directed(portion(progress, 0.0, _DIRECTIONS))
    found = _mesh_field(request, directions, progress)
    faults = [
        line for about in (_about_pieces, _about_lines, _about_others, _about_shape) for line in about(request, found)
    ]
    return replace(found, warnings=(*found.warnings, *request.refused_faults(faults)))


def draft_quad_mesh(request, progress=None):
    """A SurfaceResult with quads after a small part of the time of :func:`solve_quad_mesh`: of first fields, with the
    number of faces that the area has room for, and not smoothed. None where its quads are no mesh; Cancelled as there.
    """
    quick = replace(_with_options(request, method=FIRST), smoothing=0, start=None)

    def make():
        directions = quick.directed(portion(progress, 0.0, _DIRECTIONS))
        scaled = quick
        if quick.faces is not None:
            growth = TargetOneForm.of(quick.given.mesh, directions, quick.spacings)
            scaled = _scale_spacing(quick, _first_factor(quick, growth))
        return _finish(_draw(scaled, directions, portion(progress, _DIRECTIONS, 1 - _DIRECTIONS)))

    return _try_candidate(make)


def _first_factor(request, growth):
    """What the spacing is multiplied with for the wanted number of faces, by the area alone."""
    least = _least_factor(request.given.mesh, request.spacings, request.faces)
    return max(float(np.sqrt(YIELD * growth.quad_count / request.faces)), least)


def _mesh_field(request, directions, progress):
    """The mesh along a field; of the wanted number of faces as nearly as can be.

    The faces are counted on grid lines as they are traced; only meshes whose number is near are finished.
    """
    if _is_default_search(request) and request.branching == 0:
        # Patterns without dislocations are found on a coarse stage; variations are those of a whole solve.
        request = _with_options(request, method=COARSE)
    if request.faces is None:
        part = portion(progress, _DIRECTIONS, 1 - _DIRECTIONS)
        return _finish(_close(_settle(_draw(request, directions, part), part), part), part)
    growth = TargetOneForm.of(request.given.mesh, directions, request.spacings)
    spacing, drafts, found = _SpacingFactor(_first_factor(request, growth), request.faces), [], []
    for number in range(TRIES):
        share = (1 - _DIRECTIONS) / TRIES
        part = portion(progress, _DIRECTIONS + number * share, share)
        try:
            drafts.append(_draw(_scale_spacing(request, spacing.factor), directions, part))
            count = drafts[-1].face_count
            if abs(count / request.faces - 1) <= NEAR:
                found.append(_finish(_close(_settle(drafts.pop(), part), part), part))
                count = len(found[-1].quads.sizes)
        except ContradictionError:
            raise
        except TooManyLines as error:
            raise SettingError(f"{request.faces} faces are too many for this mesh ({error}): ask for fewer") from None
        except SettingError:
            spacing.be_smaller()
            continue
        if abs(count / request.faces - 1) <= NEAR:
            break
        spacing.correct(count)
    best = _nearest_count(request.faces, drafts, found)
    return replace(best, warnings=(*best.warnings, *_about_faces(request, len(best.quads.sizes))))


def _nearest_count(faces, drafts, found):
    """Of finished meshes, and drafts where there are none that are near, the one with the number nearest to the wanted
    one.

    Raises
    ------
    SettingError
        where all drafts have quads too large for a mesh
    """
    found = found.copy()
    for draft in sorted(drafts, key=lambda draft: abs(draft.face_count - faces)):
        if found and abs(len(found[0].quads.sizes) - faces) <= abs(draft.face_count - faces):
            break
        try:
            found.append(_finish(draft))
            break
        except SettingError:
            continue
    if not found:
        raise SettingError(f"{faces} faces are too few for a quad mesh of this surface: ask for more")
    return min(found, key=lambda result: abs(len(result.quads.sizes) - faces))


class _SpacingFactor:
    """What the spacing is multiplied with for a number of faces.

    The number falls in steps, by whole loops: the factor is corrected in proportion, and then to the geometric mean of
    one with too many faces and one with too few.
    """

    def __init__(self, factor, faces):
        self.factor, self._faces, self._bounds = factor, faces, [0.0, np.inf]

    def correct(self, count):
        """The factor gave a number of faces."""
        self._bounds[count < self._faces] = self.factor
        proportional = self.factor * float(np.sqrt(count / self._faces))
        low, high = self._bounds
        self.factor = float(np.sqrt(low * high)) if low > 0 and np.isfinite(high) else proportional

    def be_smaller(self):
        """The factor gave quads too large for a mesh."""
        self._bounds[1] = self.factor
        self.factor = float(np.sqrt(np.prod(self._bounds))) if self._bounds[0] > 0 else self.factor / 2


@dataclass(frozen=True)
class _Draft:
    """A pattern's result and its faces as they were traced.

    Attributes
    ----------
    request : SurfaceRequest of the spacing
    result : SurfaceResult without quads
    quads : QuadMesh as it was traced
    seconds : that tracing took
    """

    request: Any
    result: Any
    quads: QuadMesh
    seconds: dict[str, float]

    @property
    def face_count(self):
        """About how many faces there are after finishing: a polygon of 2 k corners becomes k - 1 quads."""
        sizes = self.quads.sizes
        return float((sizes - 2).sum() / 2) if self.request.has_only_quads else len(sizes)


def _draw(request, directions, progress):
    """The :class:`_Draft` of the pattern along a field."""
    result = request.along(directions, portion(progress, 0.0, _CLOSING if request.loops else 1.0))
    return _Draft(request, result, *request.trace(result.pattern))


def _settle(draft, progress):
    """The :class:`_Draft` of a whole solve where the search on a coarse stage has left dislocations."""
    if draft.request.options.method != COARSE or not draft.result.pattern.dislocations:
        return draft
    whole = _draw(_with_options(draft.request, method="sdp"), draft.result.field, progress)
    return min(draft, whole, key=lambda draft: draft.result.pattern.energy)


def _close(draft, progress):
    """The draft with more of its quads in short loops, where that is asked for and lines do not branch."""
    request = draft.request
    if request.loops == 0 or request.branching > 0:
        return draft
    pattern, before = close_loops(request, draft.result.pattern, portion(progress, _CLOSING, _SMOOTHING - _CLOSING))
    result = replace(draft.result, pattern=pattern, loops_before=before)
    return _Draft(request, result, *request.trace(pattern))


def _finish(draft, progress=None):
    """The result with its quads, and the settings that they are made with."""
    Monitor(progress).at("smoothing", _SMOOTHING)
    request = draft.request
    settled = {"spacing": request.spacing, "singularities": request.singularities}
    return replace(draft.result, **request.finish(draft.quads, draft.seconds), settled=settled)


def _is_default_search(request):
    """Whether the search for phases may be made smaller: nothing is said of it, and there is no start."""
    options = request.options
    return options.method == "sdp" and options.rounding == "continuation" and request.start is None


def _with_options(request, **changes):
    return replace(request, options=replace(request.options, **changes))


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


def _try_candidate(make):
    """A candidate; None where its quads would be no mesh."""
    try:
        return make()
    except Cancelled:
        raise
    except SynchError:
        return None
