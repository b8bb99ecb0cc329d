# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes with a wanted number of faces, and with fewer long loops."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import Cancelled, ContradictionError, SettingError, SynchError
from ..extract.lines.edge_crossings import TooManyLines
from ..extract.quads.finishing import TooLargeQuads, lost_lines
from ..extract.quads.measure.faults import REMEDY, WORST_ANGLE, count_lost_handles, quad_faults
from ..extract.quads.measure.quality import quality
from ..extract.quads.mirror import plane_edges, without_image
from ..extract.quads.repair.strips import NEAR
from ..extract.quads.trace.quad_mesh import QuadMesh
from ..fields import DirectionField
from ..fields.curl_removal import keep_factors
from ..fields.target_one_form import TargetOneForm
from ..monitor import Callback, portion
from ..refinement.spacing import least_factor
from ..solution import COARSE, FIRST
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

# Largest relative error of the number of faces without a warning, and up to which strips of quads are changed before
# another spacing is tried.
FAR, REACH = 0.05, 0.1
# Spacings that are tried for a number of faces, and number after which one that is off by up to FAR is taken.
TRIES, ENOUGH = 7, 3
# Ratio of spacings, one with too many faces and one with too few, below which no others between them are tried.
NARROW = 1.008
# Share of unsound faces beyond which other spacings with about as many faces are not tried.
HOPELESS = 0.02
# Largest ratio of the wanted to the found number of faces that a correction of the spacing relies on.
MOST_CHANGE = 16.0
# A traced mesh with more than this many times FEW faces, where fewer than FEW were expected, is not finished.
SPOILT = 2
# Expected number of quads, as a share of those for which the area has room: on most meshes 0.94 to 1.01.
YIELD = 0.97
# Share of the length of boundaries and sharp edges beyond whose loss a mesh is solved again, and that part of the work.
LOST, _AGAIN = 0.02, 0.1
# A mesh is not solved again for lines of at most so many sides of quads: on scans most of these are noise.
SHORT = 4.0
# Mean of |angle - 90| over the corners, in degrees, beyond which crowded sharp edges are left out.
BAD_ANGLE = 10.0
# The same, up to which a mesh without narrow tunnels is preferred to one with another number of faces; beyond, only if
# its corners are better than that one's.
GOOD_ANGLE = 8.0
# Share of the work for directions.
_DIRECTIONS = 0.4


def solve_quad_mesh(request: "SurfaceRequest", progress: Callback | None = None) -> SurfaceResult:
    """The result of a request with its quad mesh; errors as :meth:`SurfaceRequest.solve`.

    A bad mesh, and one that does not follow its boundaries and sharp edges, is solved again (:func:`_solve_again`).
    """
    found, lost = _solve(request, progress)
    faults: tuple[str, ...] = ()
    if lost.share > LOST or _is_bad(found, request.settings.faces):
        found, lost, faults = _solve_again(request, found, lost, portion(progress, 1 - _AGAIN, _AGAIN))
    assert found.quads is not None
    return replace(
        found, warnings=(*found.warnings, *request.accept_faults([*faults, *_faults(request, found.quads, lost)]))
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


def _solve(request: "SurfaceRequest", progress: Callback | None) -> tuple[SurfaceResult, _LostLines]:
    """The result of one solve, and the lines that it loses."""
    wanted = request
    if _is_default_search(request):  # directions are searched for on a coarse stage: their energies are as low
        wanted = replace(request, options=replace(request.options, rounding=COARSE))
    with keep_factors():
        directions = wanted.directed(portion(progress, 0.0, _DIRECTIONS))
        found = _mesh_field(request, directions, progress)
    assert found.quads is not None
    mesh = request.given.mesh
    planes = () if request.mirror_side is None else plane_edges(mesh, request.mirror_planes)
    side = (found.settled["spacing"] or request.spacing) / 2
    return found, _LostLines(*lost_lines(found.quads, mesh, request.rows, planes), side)


def _solve_again(
    request: "SurfaceRequest", found: SurfaceResult, lost: _LostLines, progress: Callback | None
) -> tuple[SurfaceResult, _LostLines, tuple[str, ...]]:
    """The best of a mesh and of others, the lines it loses, and faults.

    Where corners are far from right angles, or the number of faces from the wanted one, crowded sharp edges are left
    out if that helps. Else directions that all curvature turns, as small steps need them, are used if that loses less.
    """
    faces = request.settings.faces
    if _is_bad(found, faces):
        uncrowded = request.uncrowded(found.settled["spacing"] or request.spacing)
        again = _try(uncrowded, progress) if _count_links(uncrowded) < _count_links(request) else None
        if again is not None and _is_better(again[0], found, faces) and _keeps_handles(request, again[0], found):
            whole, left = lost.all_lengths.sum(), again[1].all_lengths.sum()
            return *again, (
                f"sharp edges are left out that run beside others without room for quads, {whole - left:.3g} of "
                f"{whole:.3g} in length: {REMEDY}",
            )
    again = _try(replace(request, detail=0.0), progress) if lost.share > LOST and request.detail > 0 else None
    if again is not None and again[1].share < lost.share and _keeps_handles(request, again[0], found):
        found, lost = again
    return found, lost, ()


def _keeps_handles(request: "SurfaceRequest", result: SurfaceResult, other: SurfaceResult) -> bool:
    """Whether a quad mesh has all handles of the surface, or the other one lacks some, too."""
    assert result.quads is not None and other.quads is not None
    mesh = request.given.mesh
    return count_lost_handles(result.quads, mesh)[0] <= 0 or count_lost_handles(other.quads, mesh)[0] > 0


def _try(request: "SurfaceRequest", progress: Callback | None) -> tuple[SurfaceResult, _LostLines] | None:
    try:
        return _solve(request, progress)
    except SettingError:
        return None


def _count_links(request: "SurfaceRequest") -> int:
    """Number of edges on which there are constraints."""
    return sum(len(row.line.links) for row in request.rows)


def _is_bad(result: SurfaceResult, faces: int) -> bool:
    """Whether the corners of a quad mesh are far from right angles, or its number of faces from the wanted one."""
    return _mean_angle(result) > BAD_ANGLE or _misses(result, faces) > FAR


def _is_better(result: SurfaceResult, other: SurfaceResult, faces: int) -> bool:
    """Whether corners are nearer to right angles, and the number of faces is near the wanted one, or nearer.

    Where corners are beyond :data:`WORST_ANGLE`, it may be twice as far from it.
    """
    far = FAR if _mean_angle(other) <= WORST_ANGLE else 2 * FAR
    return _mean_angle(result) < _mean_angle(other) and _misses(result, faces) <= max(far, _misses(other, faces))


def _mean_angle(result: SurfaceResult) -> float:
    """Mean of |angle - 90| over all corners, in degrees."""
    assert result.quads is not None
    return quality(result.quads)["angle_deviation"]


def _misses(result: SurfaceResult, faces: int) -> float:
    """Relative error of the number of faces, 0 where none is wanted."""
    return abs(_face_count(result) / faces - 1) if faces else 0.0


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


def _mesh_field(request: "SurfaceRequest", directions: DirectionField, progress: Callback | None) -> SurfaceResult:
    """The mesh along a field, with a number of faces as near as possible to the wanted one.

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
    spacing = _SpacingFactor(_first_factor(request, directions), faces)
    drafts: list[Draft] = []
    refused: list[Draft] = []  # with quads that are too large for a mesh
    found: list[SurfaceResult] = []
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
                    found.append(complete(draft, part))
                    if _misses(found[-1], faces) <= NEAR:
                        return found[-1]
                    expected = _face_count(found[-1])
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
    best = _best_count(faces, wanted, drafts, refused, found)
    return replace(best, warnings=(*best.warnings, *_about_faces(request, faces, _face_count(best))))


def _best_count(
    faces: int, wanted: float, drafts: list[Draft], refused: list[Draft], found: list[SurfaceResult]
) -> SurfaceResult:
    """The finished mesh with the number of faces nearest to the wanted one.

    The nearest draft is finished if it is nearer, and others as long as the number of faces is far from the wanted one.
    If it stays far from that, narrow tunnels are closed in a draft whose quads are too large for them, unless that
    makes bad corners.
    """
    results, refused = found.copy(), refused.copy()
    for draft in sorted(drafts, key=lambda draft: draft.misses(wanted)):
        misses = min((_misses(result, faces) for result in results), default=np.inf)
        if misses <= draft.misses(wanted) or (len(results) > len(found) and misses <= FAR):
            break
        settled = settle(draft)
        try:
            # Corrections that make many small faces of a few large ones are not used.
            is_spoilt = settled.face_count < FEW and settled.traced_count > SPOILT * FEW
            results.append(complete(draft if is_spoilt else settled))
        except TooLargeQuads:
            refused += [settled] if may_close_tunnels(settled) else []
        except SettingError:
            continue
    best = min(results, key=lambda result: _misses(result, faces), default=None)
    nearest = min(refused, key=lambda draft: draft.misses(wanted), default=None)
    if nearest is not None and (best is None or _misses(best, faces) > FAR):
        with suppress(SettingError):
            closed = complete(with_tunnels_closed(nearest))
            is_nearer = best is None or _misses(closed, faces) < _misses(best, faces)
            if is_nearer and (best is None or _mean_angle(closed) <= max(GOOD_ANGLE, _mean_angle(best))):
                return closed
    if best is None:
        raise SettingError(f"{faces} faces are too few for a quad mesh of this surface: ask for more")
    return best


class _SpacingFactor:
    """The factor of the spacing that gives a number of faces.

    The number changes in steps, by whole loops. The factor is corrected proportionally, and then to the geometric mean
    of one that gives too many faces and one that gives too few.
    """

    def __init__(self, factor: float, faces: int) -> None:
        self.factor, self._faces, self._bounds = factor, faces, [0.0, np.inf]

    def correct(self, count: float) -> None:
        """Correct the factor, which has given a number of faces."""
        self._bounds[count < self._faces] = self.factor
        proportional = self.factor * float(np.sqrt(np.clip(count / self._faces, 1 / MOST_CHANGE, MOST_CHANGE)))
        low, high = self._bounds
        self.factor = float(np.sqrt(low * high)) if low > 0 and np.isfinite(high) else proportional

    @property
    def is_settled(self) -> bool:
        """Whether factors that give too many faces and too few are so near each other that the number jumps there."""
        return self._bounds[1] < NARROW * self._bounds[0]

    def be_smaller(self) -> None:
        """Reduce the factor, which has given quads that are too large for a mesh."""
        self._bounds[1] = self.factor
        self.factor = float(np.sqrt(np.prod(self._bounds))) if self._bounds[0] > 0 else self.factor / 2


def _is_default_search(request: "SurfaceRequest") -> bool:
    """Whether a smaller search may replace the default one: it has no other settings and no start."""
    options = request.options
    return options.method == "sdp" and options.rounding == "continuation" and request.start is None


def _scale_spacing(request: "SurfaceRequest", factor: float) -> "SurfaceRequest":
    return replace(request, spacing=factor * request.spacing, spacings=factor * np.asarray(request.spacings))


def _face_count(result: SurfaceResult) -> int:
    return 0 if result.quads is None else len(result.quads.sizes)


def _about_faces(request: "SurfaceRequest", wanted: int, count: int) -> Iterator[str]:
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


def _faults(request: "SurfaceRequest", quads: QuadMesh, lost: _LostLines) -> Iterator[str]:
    """Lines about a quad mesh that differs from its surface or has faulty faces."""
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
    yield from quad_faults(quads, mesh, request.given.is_closed)
