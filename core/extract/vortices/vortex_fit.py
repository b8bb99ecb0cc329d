# SPDX-License-Identifier: GPL-3.0-or-later
"""Where in a face of a grid a vortex of one quantum passes, from the flow along the edges around it."""

from itertools import product

import numpy as np

from ...geometry.grid import Grid

# Places tried along both sides of a face, and radii of the vortex's core, in sides.
_SHARES, _CORES = np.linspace(0.05, 0.95, 10), (0.05, 0.2, 0.4, 0.7, 1.0, 1.5)
# Width in radians of the Gaussian that weights places by their misfit, and the largest share of the squared flow that
# the best one may leave unexplained.
_ALIKE, _LEFT = 0.05, 0.2
# Faces per batch.
_CHUNK = 4096


def fitted_places(grid: Grid, asked: np.ndarray, faces: np.ndarray, signs: np.ndarray) -> np.ndarray:
    """(k, 2) shares along both axes of (k,) faces at which single vortices pass; NaN where nothing like one is there.

    The (e,) phase changes that the flow asks for along the 24 edges around a face are compared with those of a straight
    vortex of one quantum through the face at many places, with many cores, and a uniform flow. Places count by how well
    they fit. Signs are +1 for vortices that go around as the face does, else -1.
    """
    result = np.full((len(faces), 2), np.nan)
    tried = np.array([place for _, *place in product(_CORES, _SHARES, _SHARES)])
    planes = grid.face_planes[faces]
    for plane in grid.planes:
        flows = _flows_of_vortices(tried, *grid.spacing[list(plane)])
        sizes = (flows**2).sum(axis=1)
        chosen = np.flatnonzero((planes == plane).all(axis=1))
        for part in np.array_split(chosen, len(chosen) // _CHUNK + 1):
            around, inside = _edges_around(grid, faces[part], plane)
            inside &= (grid.weights[around] > 0).all(axis=1)
            given = _without_uniform(asked[around] * signs[part, None])
            total = (given**2).sum(axis=1)
            misfits = total[:, None] - 2 * given @ flows.T + sizes
            least = misfits.min(axis=1, initial=np.inf)
            shares = np.exp((least[:, None] - misfits) / (2 * _ALIKE**2))
            places = shares @ tried / shares.sum(axis=1, keepdims=True)
            result[part] = np.where((inside & (least < _LEFT * total))[:, None], places, np.nan)
    return result


def _steps() -> tuple[np.ndarray, np.ndarray]:
    """(24, 2) first nodes of the edges of 3 by 3 faces, from the first node of the middle one, and (24,) which of the
    two axes they go along."""
    along = [(*step, 0) for step in product((-1, 0, 1), (-1, 0, 1, 2))]
    upwards = [(*step, 1) for step in product((-1, 0, 1, 2), (-1, 0, 1))]
    table = np.array(along + upwards)
    return table[:, :2], table[:, 2]


def _edges_around(grid: Grid, faces: np.ndarray, plane: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """(k, 24) edges of the 3 by 3 faces that surround each of (k,) faces in a plane, and (k,) bool, whether all exist.

    ``plane`` has the numbers of the two axes that span the faces. Edges beyond the boundary are replaced by others.
    """
    steps, kinds = _steps()
    corners = np.column_stack(np.unravel_index(grid.faces[faces, 0], grid.shape))
    places = np.repeat(corners[:, None], len(steps), axis=1)
    places[:, :, list(plane)] += steps
    last = np.array(grid.shape) - 1 - (np.arange(grid.dimension) == np.array(plane)[kinds][:, None])
    inside = (((places >= 0) & (places <= last)) | np.array(grid.periodic)).all(axis=(1, 2))
    places = np.where(grid.periodic, places % grid.shape, np.clip(places, 0, last))
    nodes = np.ravel_multi_index(tuple(np.moveaxis(places, 2, 0)), grid.shape)
    edges = np.empty_like(nodes)
    for kind, axis in enumerate(plane):
        edges[:, kinds == kind] = grid.edges_at(nodes[:, kinds == kind], axis)
    return edges, inside


def _flows_of_vortices(tried: np.ndarray, width: float, height: float) -> np.ndarray:
    """(t, 24) flow of a quantum, 2 pi, along the edges around a face of that size, without its uniform part."""
    steps, kinds = _steps()
    size = np.array([width, height])
    starts = (steps - tried[:, None]) * size
    away = np.where(kinds == 0, -starts[..., 1], starts[..., 0])  # the vortex is that far to the left
    first = np.take_along_axis(starts, kinds[None, :, None], axis=2)[..., 0]
    cores = np.repeat(_CORES, len(tried) // len(_CORES))[:, None] * np.sqrt(width * height)
    radius = np.sqrt(away**2 + cores**2)
    flows = away / radius * (np.arctan((first + size[kinds]) / radius) - np.arctan(first / radius))
    return _without_uniform(flows)


def _without_uniform(flows: np.ndarray) -> np.ndarray:
    """(k, 24) flows along the edges without their mean along both axes."""
    _, kinds = _steps()
    means = np.stack([flows[:, kinds == kind].mean(axis=1) for kind in (0, 1)], axis=1)
    return flows - means[:, kinds]
