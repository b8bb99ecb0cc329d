# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks for meshes that cannot carry a field; errors name the element and the remedy."""

from weakref import WeakKeyDictionary

import numpy as np

from ..errors import MeshError, name_elements
from ..gauge import balance
from .triangle_mesh import TriangleMesh

# A face whose area is below this share of its longest edge squared has no usable plane.
FLAT_FACE = 1e-12
# Single precision is too coarse where its steps are a larger share of the median edge than this.
COARSE_STEP = 0.02
# Vertices too far out for single precision are named if they are at most this share of all, and this many times as far
# out as the median of the others.
FEW_FAR, ALONE = 0.1, 100.0
# Warnings of :func:`coarse_mesh`.
_warnings: WeakKeyDictionary[TriangleMesh, str] = WeakKeyDictionary()


def check_mesh(mesh: TriangleMesh, faces: np.ndarray | None = None) -> None:
    """Raise :class:`MeshError` with one line for the first defect found.

    Loose vertices are harmless: they carry no field (see :attr:`TriangleMesh.loose_vertices`). ``faces``: (m,) int, the
    user's face of each triangle (a polygon of a Blender mesh), which messages name.
    """
    faces = np.arange(mesh.triangle_count) if faces is None else np.asarray(faces)
    if mesh.vertex_count == 0:
        raise MeshError("the mesh is empty: add some geometry first")
    if mesh.triangle_count == 0:
        raise MeshError("the mesh has no faces: a field lives on faces, so fill the outline (F) first")
    is_lost = ~np.isfinite(mesh.vertices).all(axis=1)
    _refuse_vertices(mesh, is_lost, "no finite position", "delete it or set its coordinates")
    _refuse_faces(mesh, faces)
    _refuse_edges(mesh, faces)
    corners = np.bincount(mesh.triangles.ravel(), minlength=mesh.vertex_count)
    _refuse_vertices(
        mesh,
        mesh.fan_corner_counts != corners,
        "faces that touch only at this point",
        "separate them with Mesh > Split > Faces & Edges by Vertices, or rip the vertex (V)",
    )


def coarse_places(places: np.ndarray, edges: np.ndarray) -> str:
    """Write a warning if single precision, in which Blender stores (n, 3) places, is too coarse for (e, 2) edges;
    otherwise return ""."""
    used, reach, steps, median = _measure_steps(places, edges)
    if steps.max(initial=0.0) <= COARSE_STEP * median:
        return ""
    far = far_vertices(places, edges)
    if len(far):
        others = reach[~np.isin(used, far)].max()
        verb, them, place = ("lies", "it", "its place") if len(far) == 1 else ("lie", "them", "their places")
        return (
            f"{name_elements('vertex', far)} {verb} {reach.max():.2g} from the origin, the others within {others:.2g}: "
            f"delete {them}, or correct {place}"
        )
    return (
        f"coordinates of {reach.max():.2g} leave steps of {steps.max():.2g} between neighbours in single precision: "
        "move the object's vertices to its origin before export"
    )


def coarse_mesh(mesh: TriangleMesh) -> str:
    """The warning of :func:`coarse_places` about a mesh, computed once: each step of Live reports it."""
    if mesh not in _warnings:
        largest = np.minimum(np.abs(mesh.vertices).max(), np.finfo(np.float32).max).astype(np.float32)
        lengths = mesh.edge_lengths
        is_fine = lengths.all() and np.spacing(largest) <= COARSE_STEP * np.median(lengths)
        _warnings[mesh] = "" if is_fine else coarse_places(mesh.vertices, mesh.edges)
    return _warnings[mesh]


def far_vertices(places: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Find the (k,) vertices so far out that single precision is too coarse there for the others' edges; none if many
    are. Arguments as for :func:`coarse_places`."""
    used, reach, steps, median = _measure_steps(places, edges)
    is_far = steps > COARSE_STEP * median
    if not 0 < is_far.sum() <= FEW_FAR * len(used) or reach[is_far].min() < ALONE * np.median(reach[~is_far]):
        return used[:0]
    return used[is_far]


def refuse_far_vertices(mesh: TriangleMesh) -> None:
    """Raise :class:`MeshError` if there are :func:`far_vertices`: finer surfaces and solids would be too large."""
    if len(far_vertices(mesh.vertices, mesh.edges)):
        raise MeshError(coarse_places(mesh.vertices, mesh.edges))


def _measure_steps(places: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Compute the vertices of edges between finite places, (k,), their largest coordinates, the steps of single
    precision there, and the median edge length, infinite without edges."""
    known = edges[np.isfinite(places).all(axis=1)[edges].all(axis=1)]
    lengths = np.linalg.norm(np.diff(places[known], axis=1)[:, 0], axis=1)
    lengths = lengths[lengths > 0]
    used = np.flatnonzero(np.bincount(known.ravel(), minlength=len(places)))
    reach = np.abs(places[used]).max(axis=1)
    steps = np.spacing(np.minimum(reach, np.finfo(np.float32).max).astype(np.float32)).astype(float)
    return used, reach, steps, np.median(lengths) if len(lengths) else np.inf


def _name_piece(mesh: TriangleMesh, vertex: int) -> str:
    count = len(np.unique(mesh.pieces[mesh.triangles[:, 0]]))
    first = np.flatnonzero(mesh.pieces == mesh.pieces[vertex])[0]
    return f" (in the piece of vertex {first}, one of {count})" if count > 1 else ""


def _refuse_vertices(mesh: TriangleMesh, is_bad: np.ndarray, what: str, remedy: str) -> None:
    bad = np.flatnonzero(is_bad)
    if len(bad):
        verb = "has" if len(bad) == 1 else "have"
        raise MeshError(f"{name_elements('vertex', bad)} {verb} {what}{_name_piece(mesh, bad[0])}: {remedy}")


def flat_faces(mesh: TriangleMesh, faces: np.ndarray) -> np.ndarray:
    """Find faces without area, or with a triangle that repeats a vertex: bool for each of the (m,) triangles' faces."""
    areas, reach = np.bincount(faces, mesh.areas), np.zeros(faces.max() + 1)
    with np.errstate(invalid="ignore"):  # ufunc.at also reports floating-point flags of earlier calls
        sides = mesh.edge_lengths[mesh.triangle_edges.T]  # three rows: their largest is found many times as fast
        np.maximum.at(reach, faces, sides.max(axis=0) ** 2)
    flat = areas <= FLAT_FACE * reach
    flat[faces[(mesh.triangles == np.roll(mesh.triangles, 1, axis=1)).any(axis=1)]] = True
    return flat


def _refuse_faces(mesh: TriangleMesh, faces: np.ndarray) -> None:
    flat = flat_faces(mesh, faces)[faces]
    first = _first_rows(np.sort(mesh.triangles, axis=1), mesh.vertex_count)
    duplicate = np.ones(len(faces), bool)
    duplicate[first] = False
    for bad, what, remedy in (
        (flat, "no area", "use Mesh > Clean Up > Degenerate Dissolve"),
        (duplicate, "the same corners as another face", "delete one of each pair with Mesh > Delete > Only Faces"),
    ):
        if bad.any():
            names = np.unique(faces[bad])
            verb = "has" if len(names) == 1 else "have"
            where = _name_piece(mesh, mesh.triangles[bad][0, 0])
            raise MeshError(f"{name_elements('face', names)} {verb} {what}{where}: {remedy}")


def _first_rows(rows: np.ndarray, count: int) -> np.ndarray:
    """Find where each row of three numbers below ``count`` comes first."""
    if count >= 2**21:
        return np.unique(rows, axis=0, return_index=True)[1]
    return np.unique((rows[:, 0] * count + rows[:, 1]) * count + rows[:, 2], return_index=True)[1]


def _refuse_edges(mesh: TriangleMesh, faces: np.ndarray) -> None:
    crowded = np.flatnonzero(mesh.edge_face_counts > 2)
    if len(crowded):
        i, j = mesh.edges[crowded[0]]
        more = f" and {len(crowded) - 1} more" if len(crowded) > 1 else ""
        raise MeshError(
            f"the edge between vertices {i} and {j}{more} has {mesh.edge_face_counts[crowded[0]]} faces"
            f"{_name_piece(mesh, i)}: keep two, see Select > All by Trait > Non Manifold"
        )
    inside = mesh.twins > np.arange(len(mesh.twins))
    here, there = np.flatnonzero(inside), mesh.twins[inside]
    signs = mesh.triangle_edge_signs.ravel()
    clash = signs[here] == signs[there]
    if not clash.any():
        return
    triangles = np.column_stack([here, there]) // 3
    _, balanced = balance(mesh.triangle_count, triangles, clash)
    i, j = mesh.edges[mesh.triangle_edges.ravel()[here[clash][0]]]
    first, second = faces[triangles[clash][0]]
    where = f"faces {first} and {second} at the edge between vertices {i} and {j}{_name_piece(mesh, i)}"
    if balanced.all():
        raise MeshError(f"{where} face opposite ways: use Mesh > Normals > Recalculate Outside")
    raise MeshError(f"the surface is one-sided at {where}: cut it open along a loop of edges (Mesh > Split)")
