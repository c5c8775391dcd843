"""A vector whose length is known whichever way the sensor is turned: |C (y - b)| = 1, an ellipsoid in the readings y."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.solve import Model

Array = NDArray[np.float64]

UPPER = np.array([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)])
"""Entries of an upper triangular matrix, or of a symmetric one, in the order of the parameters."""


def upper(p: Array) -> Array:
    """Upper triangular matrix (3,3) of six parameters."""
    C = np.zeros((3, 3))
    C[UPPER[:, 0], UPPER[:, 1]] = p[:6]
    return C


def symmetric(p: Array) -> Array:
    """Symmetric matrix (3,3) of six parameters."""
    C = upper(p)
    return C + np.triu(C, 1).T


def norm_model(y: Array, length: float, *, symmetric_matrix: bool) -> Model:
    """Residual |C (y - b)| - length of readings (n,3): nine parameters, six of C and b.

    d|x|/dC_ij = x_i (y - b)_j / |x|, d|x|/db = -Cᵀ x / |x|, with x = C (y - b).
    """

    def model(p: Array) -> tuple[Array, Array]:
        C = symmetric(p) if symmetric_matrix else upper(p)
        d = y - p[6:9]
        x = d @ C.T
        size = np.sqrt((x**2).sum(1))
        u = x / size[:, None]
        outer = u[:, :, None] * d[:, None, :]
        J = np.empty((len(y), 1, len(p)))
        J[:, 0, :6] = outer[:, UPPER[:, 0], UPPER[:, 1]]
        if symmetric_matrix:
            below = outer[:, UPPER[:, 1], UPPER[:, 0]]
            J[:, 0, [1, 2, 4]] += below[:, [1, 2, 4]]
        J[:, 0, 6:9] = -u @ C
        return (size - length)[:, None], J

    return model


def widened(matrix_covariance: Array, *, symmetric_matrix: bool) -> Array:
    """Covariance (12,12) of the nine entries of C, row by row, and b, from that of six parameters and b (9,9)."""
    T = np.zeros((12, 9))
    for k, (i, j) in enumerate(UPPER):
        T[3 * i + j, k] = 1.0
        if symmetric_matrix:
            T[3 * j + i, k] = 1.0
    T[9:, 6:] = np.eye(3)
    return T @ matrix_covariance @ T.T


def ellipsoid(y: Array) -> tuple[Array, Array] | None:
    """Symmetric C (3,3) with |C (y - b)| near 1, and b (3,), of the quadric that fits readings (n,3) best; None where it is no ellipsoid.

    Readings that lie far off the quadric are left out, three times over.
    """
    centre, scale = y.mean(0), float(np.sqrt(((y - y.mean(0)) ** 2).sum(1).mean()))
    if len(y) < 10 or not scale > 0:
        return None
    z, good, found = (y - centre) / scale, np.ones(len(y), bool), None
    for _ in range(4):
        x = z[good]
        square = x**2
        # xᵀQx - 2 vᵀx = c with trace Q = 3, so that the equations are linear and no sphere is preferred to a plane.
        D = np.column_stack([square @ [1, 1, -2], square @ [1, -2, 1], *(2 * x[:, i] * x[:, j] for i, j in UPPER[[1, 2, 4]]), 2 * x])
        D = np.column_stack([D, np.ones(len(x))])
        p = np.linalg.lstsq(D, square.sum(1), rcond=None)[0]
        Q = symmetric(np.array([1 - p[0] - p[1], -p[2], -p[3], 1 - p[0] + 2 * p[1], -p[4], 1 + 2 * p[0] - p[1]]))
        values, axes = np.linalg.eigh(Q)
        if values[0] <= 0:
            return found
        b = np.linalg.solve(Q, p[5:8])
        size = float(b @ Q @ b + p[8])
        if size <= 0:
            return found
        C = axes @ np.diag(np.sqrt(values / size)) @ axes.T
        off = np.abs(np.linalg.norm((z - b) @ C.T, axis=1) - 1)
        good = off <= 3.5 * max(float(np.median(off)), 1e-9)
        if good.sum() < 10:
            return found
        found = C / scale, centre + scale * b
    return found
