# SPDX-License-Identifier: GPL-3.0-or-later
"""Other methods on the same matrices, written with SciPy alone.

Nothing here is taken from the project's solver, so that the peers stay what they are while it changes.
Every factorization but that of :func:`plain_spectral` is SciPy's fastest: ordered for symmetric matrices,
without row exchanges, in single precision. All columns of a set of fields are carried at once.

The functions know pieces whose nodes are complex numbers or pairs of real rows; :func:`linear_field` and
:func:`fixed_diffusion` also those with nodes that are fixed, which are one node of the piece, its ground.
"""

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu

# Shift of the spectral problems as a share of the stiffness; diffusion times end at its inverse.
SMALLEST_SHIFT = 1e-6
FALLING_TIMES = 0.5 ** np.arange(11)
FALLING_STEPS, FALLING_TOLERANCE = 30, 1e-2
FIXED_STEPS, FIXED_TOLERANCE = 500, 1e-4
# All starts are polished roughly, the best one then to the last digit that matters.
ROUGH = (40, 3e-5)
FINE = (200, 1e-9)
MEMORY = 5
LONGEST_BACKTRACK = 12


def plain_spectral(piece):
    """(N, 1) smallest eigenvector of (L, M), normalized: eigsh as a user of SciPy calls it."""
    mass = diags_array(piece.row_mass).tocsc()
    _, vectors = eigsh(piece.matrix, k=1, M=mass, sigma=-SMALLEST_SHIFT * piece.stiffness, which="LM")
    return normalize(piece, vectors)


def falling_diffusion(piece, starts, seed):
    """(N, 1) best of MBO from random starts with times halved ten times from 1 / lambda_1, polished."""
    rate, _ = lowest_mode(piece)
    angles = np.random.default_rng(seed).uniform(0, 2 * np.pi, (piece.node_count, starts))
    columns = diffuse(piece, _rows(piece, angles), FALLING_TIMES / rate, FALLING_STEPS, FALLING_TOLERANCE)
    columns = polish(piece, columns, *ROUGH)
    best = np.argmin(piece.energy(columns))
    return polish(piece, columns[:, [best]], *FINE)


def linear_field(piece):
    """(N, 1) the harmonic field with the values of the fixed nodes, normalized: L x = 0 at all others."""
    free, pull = _free(piece)
    columns = np.ones((piece.matrix.shape[0], 1), piece.matrix.dtype)
    columns[free] = splu(piece.matrix[free][:, free].tocsc()).solve(-pull)[:, None]
    return normalize(piece, columns)


def fixed_diffusion(piece, time=None, polished=True):
    """(N, 1) MBO at one time (by default 1 / lambda_1) until stationary, from the spectral field, or the linear one
    where nodes are fixed; these cannot be polished."""
    if piece.ground is not None:
        return diffuse(piece, linear_field(piece), [time], FIXED_STEPS, FIXED_TOLERANCE)
    rate, vector = lowest_mode(piece)
    columns = diffuse(piece, vector[:, None], [1 / rate if time is None else time], FIXED_STEPS, FIXED_TOLERANCE)
    return polish(piece, columns, *FINE) if polished else columns


def lowest_mode(piece):
    """Smallest eigenvalue of (L, M), as far as diffusion needs it, and its (N,) eigenvector."""
    size = piece.matrix.shape[0]
    mass = diags_array(piece.row_mass).tocsr()
    shift = SMALLEST_SHIFT * piece.stiffness
    inverse = Inverse(piece.matrix + shift * mass)
    operator = LinearOperator((size, size), matvec=inverse, dtype=piece.matrix.dtype)
    _, vectors = eigsh(piece.matrix, k=1, M=mass, sigma=-shift, OPinv=operator, tol=1e-3)
    vector = vectors[:, 0]
    value = piece.energy(vectors)[0] / np.vdot(vector, piece.row_mass * vector).real
    return max(value, shift), vector


class Inverse:
    """Solves with a positive definite sparse matrix in single precision."""

    def __init__(self, matrix):
        self._dtype = np.complex64 if np.iscomplexobj(matrix.data) else np.float32
        self._factorization = splu(
            matrix.astype(self._dtype).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def __call__(self, columns):
        return self._factorization.solve(np.asfortranarray(columns, dtype=self._dtype))


def diffuse(piece, columns, times, steps, tolerance):
    """MBO: solve (M + tau L) x' = M x for the nodes that are not fixed and normalize, over and over (Viertel and Osting
    2019).

    ``columns`` are (N, k) fields, ``times`` the values of tau, one factorization each, ``steps`` the most at each time;
    one is finished early where no unit vector moves by more than the tolerance.
    """
    free, pull = _free(piece)
    matrix = piece.matrix if piece.ground is None else piece.matrix[free][:, free]
    mass = piece.row_mass[free].astype(np.float32)[:, None]
    whole = normalize(piece, columns).astype(np.complex64 if piece.is_complex else np.float32, order="F")
    columns = whole[free]
    for time in np.minimum(times, 1 / (SMALLEST_SHIFT * piece.stiffness)):
        inverse = Inverse(diags_array(piece.row_mass[free]) + time * matrix)
        drift = (time * pull).astype(columns.dtype)[:, None]
        for _ in range(steps):
            moved = normalize(piece, inverse(mass * columns - drift))
            change = np.abs(moved - columns).max()
            columns = moved
            if change <= tolerance:
                break
    whole[free] = columns
    return whole


def _free(piece):
    """Rows that are not the ground's, and what L makes of the ground's value 1 there."""
    if piece.ground is None:
        return slice(None), np.zeros(piece.matrix.shape[0], piece.matrix.dtype)
    held = np.arange(piece.block) + piece.block * piece.ground
    free = np.delete(np.arange(piece.matrix.shape[0]), held)
    return free, piece.matrix[free][:, held[:1]].toarray().ravel()


def normalize(piece, columns):
    """Every unit vector of every column scaled to length one; zero vectors stay zero."""
    lengths = np.abs(columns) if piece.is_complex else np.hypot(columns[0::2], columns[1::2])
    lengths[lengths == 0] = 1
    return columns / (lengths if piece.is_complex else np.repeat(lengths, 2, axis=0))


def polish(piece, columns, steps, tolerance):
    """Descend in the angles of all nodes, every column of (N, k) fields for itself; returns the fields.

    L-BFGS (Nocedal and Wright, Algorithm 7.4) whose first guess of the inverse Hessian is that of L + shift M seen
    along the unit circles; full step first, halved where it fails. A column is finished where the predicted relative
    decrease is below the tolerance, or after so many steps.
    """
    angles = _angles(piece, columns)
    rows, energy, gradient = _evaluate(piece, angles)
    inverse = Inverse(piece.matrix + diags_array(0.1 * energy.min() / piece.mass.sum() * piece.row_mass))
    memory = []
    for step in range(1, steps + 1):
        direction = -_inverse_hessian(piece, rows, inverse, memory, gradient)
        slope = _inner(gradient, direction)
        # The first predictions, made without a memory of the curvature, are too small.
        active = (slope < 0) & (-slope > (tolerance if step > MEMORY else 0) * energy)
        moved = _search(piece, angles, direction, energy, slope, np.where(active, 1.0, 0.0))
        if moved is None:
            break
        new_angles, (rows, energy, new_gradient) = moved
        _remember(memory, new_angles - angles, new_gradient - gradient)
        angles, gradient = new_angles, new_gradient
    return rows


def _search(piece, angles, direction, energy, slope, lengths):
    """New angles with rows, energies and gradient there, or None where no column moves."""
    for _ in range(LONGEST_BACKTRACK):
        if not lengths.any():
            return None
        trial = angles + lengths * direction
        evaluated = _evaluate(piece, trial)
        failed = evaluated[1] > energy + 1e-4 * lengths * slope + piece.noise
        if not failed.any():
            return trial, evaluated
        lengths = np.where(failed, lengths / 2, lengths)
    return None


def _evaluate(piece, angles):
    """Rows, energies and their gradient by the angles."""
    rows = _rows(piece, angles)
    image = piece.matrix @ rows
    energy = _inner(rows.real, image.real) + (_inner(rows.imag, image.imag) if piece.is_complex else 0)
    return rows, energy, 2 * _along(piece, _tangents(piece, rows), image)


def _inverse_hessian(piece, rows, inverse, memory, gradient):
    vector, shares = gradient.copy(), []
    for move, change, curvature in reversed(memory):
        share = curvature * _inner(move, vector)
        vector -= share * change
        shares.append(share)
    tangents = _tangents(piece, rows)
    spread = vector if piece.is_complex else np.repeat(vector, 2, axis=0)
    vector = 0.5 * _along(piece, tangents, inverse(tangents * spread))
    for (move, change, curvature), share in zip(memory, reversed(shares), strict=True):
        vector += (share - curvature * _inner(change, vector)) * move
    return vector


def _remember(memory, move, change):
    curvature = _inner(move, change)
    good = curvature > 1e-10 * np.sqrt(_inner(move, move) * _inner(change, change))
    memory.append((move, change, np.where(good, 1 / np.where(good, curvature, 1), 0.0)))
    if len(memory) > MEMORY:
        memory.pop(0)


def _inner(first, second):
    """(k,) inner products of columns."""
    return np.einsum("nk,nk->k", first, second)


def _angles(piece, columns):
    return (
        np.angle(columns).astype(float) if piece.is_complex else np.arctan2(columns[1::2], columns[0::2], dtype=float)
    )


def _rows(piece, angles):
    """(N, k) unit rows at (nodes, k) angles."""
    if piece.is_complex:
        return np.exp(1j * angles)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1).reshape(-1, angles.shape[1])


def _tangents(piece, rows):
    """Derivative of the rows by the angles."""
    if piece.is_complex:
        return 1j * rows
    tangents = np.empty_like(rows)
    tangents[0::2], tangents[1::2] = -rows[1::2], rows[0::2]
    return tangents


def _along(piece, tangents, vectors):
    """(nodes, k) components of vectors along unit tangents."""
    if piece.is_complex:
        return tangents.real * vectors.real + tangents.imag * vectors.imag
    return tangents[0::2] * vectors[0::2] + tangents[1::2] * vectors[1::2]
