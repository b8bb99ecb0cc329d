# SPDX-License-Identifier: GPL-3.0-or-later
"""Start and result of a solve in the rows of one piece or of several, and the solution that the results make up."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from operator import attrgetter

import numpy as np

from ...piece import Piece
from ...problem import SynchronizationProblem
from ...solution import Certificate, Options, Solution, Status


@dataclass(frozen=True)
class PartResult:
    """The result of a piece, or of several.

    Attributes
    ----------
    rows : (m,) in the coordinates of the problem
    node_count : of its largest piece
    fields : (m, k) unit coordinates, best first; of frames (m * width, k)
    lifted : (m, r), or None
    singular_values : of the lifted field on the largest piece
    bound, sdp_value, spectral_bound : sums over the pieces
    certificate, status : the weakest, and the most severe one
    iterations, products : as in :class:`Solution`
    """

    rows: np.ndarray
    node_count: int
    fields: np.ndarray
    bound: float = 0.0
    sdp_value: float = 0.0
    certificate: Certificate = Certificate.NONE
    status: Status = Status.UNCERTIFIED
    lifted: np.ndarray | None = None
    singular_values: np.ndarray | None = None
    spectral_bound: float = 0.0
    iterations: int = 0
    products: int = 0


@dataclass(frozen=True)
class Start:
    """Coordinates (N, width) and lifted field to start from, in the rows of the problem; on a piece they are flat."""

    column: np.ndarray | None = None
    lifted: np.ndarray | None = None

    @classmethod
    def of(cls, problem: SynchronizationProblem, start: Solution | np.ndarray | None) -> "Start":
        """Convert phases, or a solution of a nearby problem, to the problem's coordinates."""
        if start is None:
            return cls()
        as_phases = partial(np.asarray, dtype=complex if problem.is_circle else float)
        if not isinstance(start, Solution):
            return cls(_as_columns(problem.coordinates(as_phases(start))))
        column, lifted = _as_columns(problem.coordinates(as_phases(start.phases))), start.lifted
        return cls(column, None if lifted is None or len(lifted) != len(column) else lifted)

    def on(self, piece: Piece) -> "Start":
        """The part of one piece."""
        column, lifted = (None if array is None else array[piece.rows] for array in (self.column, self.lifted))
        if lifted is not None and lifted.dtype != piece.matrix.dtype:
            lifted = None
        if lifted is not None:
            lifted[piece.unused_rows] = 0
        return Start(None if column is None else column.reshape(-1, 1), lifted)


def _as_columns(coordinates: np.ndarray) -> np.ndarray:
    """(N, width) of (N,) or (N, width) coordinates."""
    return coordinates.reshape(len(coordinates), -1)


def combine(
    problem: SynchronizationProblem, results: Sequence[PartResult], options: Options, times: dict[str, float]
) -> Solution:
    """The :class:`Solution` made up of the results; energies and bounds add up."""
    coordinates = problem.unit_coordinates()
    rank = max([r.lifted.shape[1] for r in results if r.lifted is not None], default=0)
    lifted = np.zeros((len(coordinates), rank), coordinates.dtype)
    if rank:
        lifted[:, : problem.width] = _as_columns(coordinates)
    for result in results:
        if result.lifted is not None:
            lifted[result.rows] = 0
            lifted[result.rows, : result.lifted.shape[1]] = result.lifted
    variations = []
    for number in range(max([r.fields.shape[1] for r in results], default=1)):
        for result in results:
            field = result.fields[:, min(number, result.fields.shape[1] - 1)]
            coordinates[result.rows] = field.reshape(len(result.rows), *coordinates.shape[1:])
        variations.append(problem.expand(coordinates))
    # A part that is shown before the end may have no relaxation yet.
    is_sdp = options.method == "sdp" and all(r.lifted is not None for r in results)
    largest = max(results, key=attrgetter("node_count"), default=None)
    bound, sdp_value = sum(r.bound for r in results), sum(r.sdp_value for r in results)
    return Solution(
        phases=variations[0],
        energy=problem.energy(variations[0]),
        lower_bound=min(bound, sdp_value) if is_sdp else bound,
        sdp_value=sdp_value if is_sdp else None,
        noise=float(problem.layout.noise.sum()),
        certificate=min((r.certificate for r in results), key=attrgetter("strength"), default=Certificate.PROVED),
        status=max(
            (r.status for r in results),
            key=attrgetter("severity"),
            default=Status.CERTIFIED if is_sdp else Status.UNCERTIFIED,
        ),
        rank=rank,
        singular_values=np.empty(0) if largest is None or largest.singular_values is None else largest.singular_values,
        lifted=lifted if rank else None,
        variations=np.array(variations),
        spectral_bound=None if is_sdp else sum(r.spectral_bound for r in results),
        iterations=sum(r.iterations for r in results),
        products=sum(r.products for r in results),
        times=times,
    )
