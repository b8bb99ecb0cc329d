# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes with a wanted number of faces, and with fewer long loops."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import Cancelled, ContradictionError, SettingError, SynchError
from ..extract.lines.edge_crossings import TooManyLines
from ..extract.quads.finishing import TooLargeQuads, lost_lines
from ..extract.quads.measure.faults import REMEDY, WORST_ANGLE, count_lost_handles, quad_faults
from ..extract.quads.mirror import plane_edges, without_image
from ..extract.quads.repair.strips import NEAR
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields import DirectionField
from ..fields.curl_removal import keep_factors
from ..fields.target_one_form import TargetOneForm
from ..monitor import Callback, portion
from ..refinement.spacing import least_factor
from ..solution import COARSE, FIRST
from .closed_tunnels import NARROWEST, WIDEST, on_surface, without_tunnels
from .face_counts import FAR, SPOILT, SpacingFactor, Trial, best_count, choose, face_count, mean_angle, misses
from .quad_drafts import (
    FEW,
    Draft,
    complete,
    draw,
    finish,
    may_close_tunnels,
    may_meet_count,
    settle,
    with_tunnels_closed,
)
from .surface_result import SurfaceResult

if TYPE_CHECKING:
    from .surfaces import SurfaceRequest

# Relative error of the number of faces up to which strips of quads are changed before another spacing is tried.
REACH = 0.1
# Spacings that are tried for a number of faces, and number after which one that is off by up to FAR is taken.
TRIES, ENOUGH = 7, 3
# Share of unsound faces beyond which other spacings with about as many faces are not tried.
HOPELESS = 0.02
# Expected number of quads, as a share of those for which the area has room: on most meshes 0.94 to 1.01.
YIELD = 0.97
# Share of the length of boundaries and sharp edges beyond whose loss a mesh is solved again, and that part of the work.
LOST, _AGAIN = 0.02, 0.1
# A mesh is not solved again for lines of at most so many sides of quads: on scans most of these are noise.
SHORT = 4.0
# Mean of |angle - 90| over the corners, in degrees, beyond which crowded sharp edges are left out.
BAD_ANGLE = 10.0
# Share of the work for directions.
_DIRECTIONS = 0.4


def solve_quad_mesh(request: "SurfaceRequest", progress: Callback | None = None) -> SurfaceResult:
    """The result of a request with its quad mesh; errors as :meth:`SurfaceRequest.solve`.

    A bad mesh, and one that does not follow its boundaries and sharp edges, is solved again (:func:`_solve_again`).
    Tunnels that are narrower than the quads are closed before, and wider ones where corners are far from right angles.
    """
    tried: dict[int, float] = {}
    faces = request.settings.faces
    solved, filled = without_tunnels(request, NARROWEST) or (request, None)
    found, lost = _solve(solved, progress, tried)
    part = portion(progress, 1 - _AGAIN, _AGAIN)
    faults: tuple[str, ...] = ()
    is_settled = False
    wider = without_tunnels(request, WIDEST, keeps_marks=False) if mean_angle(found) > WORST_ANGLE else None
    if wider is not None and (filled is None or len(filled.sources) < len(wider[1].sources)):
        again = _try(wider[0], part, tried)
        if again is not None and _brings_right_angles(again[0], found, faces):
            whole, left = lost.all_lengths.sum(), again[1].all_lengths.sum()
            faults = _left_out("are around narrow tunnels or only marked", whole - left, whole)
            (solved, filled), (found, lost) = wider, again
            is_settled = mean_angle(found) <= WORST_ANGLE
    if not is_settled and (lost.share > LOST or _is_bad(found, faces)):
        found, lost, more = _solve_again(solved, found, lost, part, tried)
        faults += more
    if filled is not None:
        found = on_surface(found, request, filled)
    assert found.quads is not None
    return replace(
        found,
        warnings=(*found.warnings, *request.accept_faults([*faults, *_faults(request, found.quads, lost, tried)])),
    )


@dataclass(frozen=True)
class _LostLines:
    """(k,) the length that a quad mesh does not follow of a boundary or sharp edge, and (l,) lengths of all of them.

    ``side``: the length of a quad's side.
    """

    lengths: np.ndarray
    all_lengths: np.ndarray
    side: float

    @property
    def share(self) -> float:
        """Share of the length that is lost in lengths of more than :data:`SHORT` sides."""
        lost = self.lengths[self.lengths > SHORT * self.side].sum()
        return float(lost / self.all_lengths.sum()) if lost > 0 else 0.0


def _solve(
    request: "SurfaceRequest", progress: Callback | None, tried: dict[int, float]
) -> tuple[SurfaceResult, _LostLines]:
    """The result of one solve, and the lines that it loses.

    ``tried`` gets the mean deviations of corners, in degrees, of all meshes that were tried, by their numbers of faces.
    """
    wanted = request
    if _is_default_search(request):  # directions are searched for on a coarse stage: their energies are as low
        wanted = replace(request, options=replace(request.options, rounding=COARSE))
    with keep_factors():
        directions = wanted.directed(portion(progress, 0.0, _DIRECTIONS))
        found = _mesh_field(request, directions, progress, tried)
    assert found.quads is not None
    mesh = request.given.mesh
    planes = () if request.mirror_side is None else plane_edges(mesh, request.mirror_planes)
    side = (found.settled["spacing"] or request.spacing) / 2
    return found, _LostLines(*lost_lines(found.quads, mesh, request.rows, planes), side)


def _solve_again(
    request: "SurfaceRequest",
    found: SurfaceResult,
    lost: _LostLines,
    progress: Callback | None,
    tried: dict[int, float],
) -> tuple[SurfaceResult, _LostLines, tuple[str, ...]]:
    """The best of a mesh and of others, the lines it loses, and faults.

    Where corners are far from right angles, or the number of faces from the wanted one, crowded sharp edges are left
    out if that helps. Else directions that all curvature turns, as small steps need them, are used if that loses less.
    """
    faces = request.settings.faces
    if _is_bad(found, faces):
        uncrowded = request.uncrowded(found.settled["spacing"] or request.spacing)
        again = _try(uncrowded, progress, tried) if _count_links(uncrowded) < _count_links(request) else None
        if again is not None and _is_better(again[0], found, faces) and _keeps_handles(request, again[0], found):
            whole, left = lost.all_lengths.sum(), again[1].all_lengths.sum()
            return *again, _left_out("run beside others without room for quads", whole - left, whole)
    is_detailed = lost.share > LOST and request.detail > 0
    again = _try(replace(request, detail=0.0), progress, tried) if is_detailed else None
    if again is not None and again[1].share < lost.share and _keeps_handles(request, again[0], found):
        found, lost = again
    return found, lost, ()


def _left_out(which: str, length: float, whole: float) -> tuple[str, ...]:
    """A line about sharp edges that are left out, if their length is not 0."""
    if length <= 1e-9 * whole:
        return ()
    return (f"sharp edges are left out that {which}, {length:.3g} of {whole:.3g} in length: {REMEDY}",)


def _keeps_handles(request: "SurfaceRequest", result: SurfaceResult, other: SurfaceResult) -> bool:
    """Whether a quad mesh has all handles of the surface, or the other one lacks some, too."""
    assert result.quads is not None and other.quads is not None
    mesh = request.given.mesh
    return count_lost_handles(result.quads, mesh)[0] <= 0 or count_lost_handles(other.quads, mesh)[0] > 0


def _try(
    request: "SurfaceRequest", progress: Callback | None, tried: dict[int, float]
) -> tuple[SurfaceResult, _LostLines] | None:
    """As :func:`_solve`; None if the settings cannot be met."""
    try:
        return _solve(request, progress, tried)
    except SettingError:
        return None


def _count_links(request: "SurfaceRequest") -> int:
    """Number of edges on which there are constraints."""
    return sum(len(row.line.links) for row in request.rows)


def _is_bad(result: SurfaceResult, faces: int) -> bool:
    """Whether the corners of a quad mesh are far from right angles, or its number of faces from the wanted one."""
    return mean_angle(result) > BAD_ANGLE or misses(result, faces) > FAR


def _brings_right_angles(result: SurfaceResult, other: SurfaceResult, faces: int) -> bool:
    """Whether corners come near enough to right angles for any number of faces, or :func:`_is_better`."""
    return mean_angle(result) <= WORST_ANGLE or _is_better(result, other, faces)


def _is_better(result: SurfaceResult, other: SurfaceResult, faces: int) -> bool:
    """Whether corners are nearer to right angles, and the number of faces is near the wanted one, or nearer.

    Where corners are beyond :data:`WORST_ANGLE`, it may be twice as far from it.
    """
    far = FAR if mean_angle(other) <= WORST_ANGLE else 2 * FAR
    return mean_angle(result) < mean_angle(other) and misses(result, faces) <= max(far, misses(other, faces))


def draft_quad_mesh(request: "SurfaceRequest", progress: Callback | None = None) -> SurfaceResult | None:
    """A first result with quads, in a small part of the time of :func:`solve_quad_mesh`; None if they are not a mesh.

    It has first fields, the number of faces estimated from the area, and no smoothing.
    """
    quick = replace(request.smoothed(0), options=replace(request.options, method=FIRST), start=None)
    try:
        with keep_factors():
            directions = quick.directed(portion(progress, 0.0, _DIRECTIONS))
        if quick.settings.faces:
            quick = _scale_spacing(quick, _first_factor(quick, directions))
        return finish(draw(quick, directions, portion(progress, _DIRECTIONS, 1 - _DIRECTIONS)))
    except Cancelled:
        raise
    except SynchError:
        return None


def _first_factor(request: "SurfaceRequest", directions: DirectionField) -> float:
    """The factor of the spacing for the wanted number of faces, estimated from the area."""
    faces = request.settings.faces
    one_form = TargetOneForm.of(request.given.mesh, directions, request.spacings)
    least = least_factor(request.given.mesh, request.spacings, faces)
    return max(float(np.sqrt(YIELD * one_form.quad_count / faces)), least)


def _mesh_field(
    request: "SurfaceRequest", directions: DirectionField, progress: Callback | None, tried: dict[int, float]
) -> SurfaceResult:
    """The mesh along a field, with a number of faces as near as possible to the wanted one; ``tried`` as of
    :func:`_solve`.

    Faces are counted in the phases; only meshes with nearly the wanted number are traced and finished.
    """
    faces = request.settings.faces
    if _is_default_search(request) and request.settings.branching == 0:
        # Without curl, quad meshes of first fields are as good as those of whole solves.
        request = replace(request, options=replace(request.options, method=FIRST))
    if not faces:
        part = portion(progress, _DIRECTIONS, 1 - _DIRECTIONS)
        draft = settle(draw(request, directions, part))
        try:
            return complete(draft, part)
        except TooLargeQuads:
            if not may_close_tunnels(draft):
                raise
            return complete(with_tunnels_closed(draft), part)
    spacing = SpacingFactor(_first_factor(request, directions), faces)
    drafts: list[Draft] = []
    refused: list[Draft] = []  # with quads that are too large for a mesh
    found: list[Trial] = []
    reach = NEAR if request.settings.loops else REACH  # closing loops takes longer than another draft
    wanted = float(faces)  # of quads for which phases have room, as finished meshes may have more
    for number in range(TRIES):
        if number >= ENOUGH and min((draft.misses(wanted) for draft in drafts), default=np.inf) <= FAR:
            break
        if spacing.is_settled:
            break
        share = (1 - _DIRECTIONS) / TRIES
        part = portion(progress, _DIRECTIONS + number * share, share)
        try:
            draft = draw(_scale_spacing(request, spacing.factor), directions, part)
            count = draft.face_count
            drafts.append(draft)
            # Tracing raises SettingError if the quads are too large for a mesh, before more work goes into it.
            traced = draft.traced_count if count < FEW else 0
            if traced > SPOILT * FEW:
                drafts.pop()
                count = traced
            elif draft.misses(wanted) <= reach or (traced and abs(draft.finished_count / faces - 1) <= reach):
                draft = settle(drafts.pop())
                expected = faces if request.settings.loops else draft.finished_count
                if request.settings.loops or may_meet_count(draft):
                    found.append(Trial.of(draft, part))
                    if found[-1].misses(faces) <= NEAR:
                        return choose(found, faces, tried)
                    expected = found[-1].face_count
                else:
                    drafts.append(draft)
                wanted = faces * draft.face_count / expected
        except ContradictionError:
            raise
        except TooManyLines as error:
            raise SettingError(f"{faces} faces are too many for this mesh ({error}): ask for fewer") from None
        except TooLargeQuads as error:
            if may_close_tunnels(draft):
                refused.append(draft)
                if error.share > HOPELESS:
                    break
            spacing.be_smaller()
            continue
        except SettingError:
            spacing.be_smaller()
            continue
        spacing.correct(count * faces / wanted)
    best = best_count(faces, wanted, drafts, refused, found, tried)
    return replace(best, warnings=(*best.warnings, *_about_faces(request, faces, face_count(best))))


def _is_default_search(request: "SurfaceRequest") -> bool:
    """Whether a smaller search may replace the default one: it has no other settings and no start."""
    options = request.options
    return options.method == "sdp" and options.rounding == "continuation" and request.start is None


def _scale_spacing(request: "SurfaceRequest", factor: float) -> "SurfaceRequest":
    return replace(request, spacing=factor * request.spacing, spacings=factor * np.asarray(request.spacings))


def _about_faces(request: "SurfaceRequest", wanted: int, count: int) -> Iterator[str]:
    """A warning where the number of faces is far from the wanted one."""
    if abs(count / wanted - 1) <= FAR:
        return
    mesh = request.given.mesh
    pieces = len(np.unique(mesh.pieces[mesh.triangles[:, 0]]))
    if count > wanted and pieces > wanted:
        yield (
            f"the quad mesh has {count} faces, not {wanted}, because each of the {pieces} pieces of the surface needs "
            f"one: to join pieces, use Mesh > Clean Up > Merge by Distance"
        )
    else:
        yield f"the quad mesh has {count} faces, not {wanted}: its constraints allow no spacing that comes nearer"


def _faults(request: "SurfaceRequest", quads: QuadMesh, lost: _LostLines, tried: dict[int, float]) -> Iterator[str]:
    """Lines about a quad mesh that differs from its surface or has faulty faces; ``tried`` as of :func:`_solve`."""
    mesh = request.given.mesh
    of_triangles = mesh.pieces[mesh.triangles[:, 0]]
    all_pieces, kept = np.unique(of_triangles), np.unique(of_triangles[quads.triangles])
    if len(kept) < len(all_pieces):
        yield (
            f"{len(all_pieces) - len(kept)} of {len(all_pieces)} pieces of the surface are too small for the quads and "
            f"left out: {REMEDY}"
        )
    if len(lost.lengths):
        yield (
            f"{len(lost.lengths)} of {len(lost.all_lengths)} lines of the boundary and of sharp edges are lost as a "
            f"whole or in part, {lost.lengths.sum():.3g} of {lost.all_lengths.sum():.3g} in length: {REMEDY}"
        )
    for axis, normal in zip(request.settings.mirror, request.mirror_planes, strict=True):
        alone = without_image(quads, normal)
        if alone:
            yield (
                f"{alone} of {len(quads.vertices)} vertices of the quad mesh have no mirror image across {axis}, since "
                "faces lie across a mirror plane: cut them there (Mesh > Bisect)"
            )
    others = int((quads.sizes != 4).sum())
    if others and request.settings.branching == 0:
        yield f"{others} of {len(quads.sizes)} faces are not quads, although no branches are wanted: {REMEDY}"
    yield from quad_faults(quads, mesh, request.given.is_closed, tried)
