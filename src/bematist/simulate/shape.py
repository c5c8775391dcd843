"""What a swing looks like: polynomials through the median stride of real walks and runs, and the jolt at heel strike.

All are polynomials in y = 2u − 1, u from 0 (heel-off) to 1 (foot flat): powers of u itself would lose six digits at the end of the
swing. At both ends the value and three derivatives vanish (of `forward` and `turn` the value ends at 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A swing at every twentieth of its time, ends left out. Pitch in rad (positive: toes down), forward and up in shares of the stride and
# of the clearance. The median stride of walks, and of two runners, in a motion capture room, sensor on the instep.
# fmt: off
_MEASURED = {
    "walk": (
        (0.04, 0.10, 0.21, 0.42, 0.78, 1.05, 1.12, 0.99, 0.81, 0.59,
         0.32, 0.06, -0.18, -0.36, -0.46, -0.43, -0.33, -0.15, -0.04),
        (0.003, 0.009, 0.019, 0.037, 0.067, 0.105, 0.161, 0.241, 0.333, 0.436,
         0.543, 0.654, 0.758, 0.845, 0.910, 0.944, 0.966, 0.986, 0.997),
        (0.00, 0.02, 0.04, 0.05, 0.00, 0.10, 0.56, 0.93, 0.92, 0.77,
         0.56, 0.43, 0.48, 0.73, 1.00, 0.87, 0.57, 0.26, 0.06),
    ),
    "run": (
        (0.10, 0.31, 0.59, 0.86, 1.05, 1.15, 1.15, 1.11, 0.99, 0.82,
         0.61, 0.36, 0.10, -0.16, -0.34, -0.42, -0.38, -0.16, -0.08),
        (0.006, 0.015, 0.030, 0.051, 0.079, 0.118, 0.169, 0.237, 0.316, 0.411,
         0.507, 0.604, 0.703, 0.802, 0.883, 0.935, 0.963, 0.985, 0.998),
        (0.03, 0.08, 0.10, 0.15, 0.34, 0.54, 0.77, 0.90, 0.98, 1.00,
         0.90, 0.75, 0.58, 0.51, 0.50, 0.56, 0.43, 0.17, 0.02),
    ),
}
# fmt: on

_STRIKE = {"walk": (0.80, 0.06), "run": (0.85, 0.07)}
"""When in the swing the heel strikes, and how long the jolt lasts at most, s."""

_BLAS_ALONE = 512
"""Columns of a product that is too small for a BLAS to start threads for, which would spin in vain."""


@dataclass(frozen=True, eq=False)
class Shape:
    """Coefficients (rows, degree + 1) of the powers of y, three rows for each polynomial: value, first and second derivative.

    Attributes
    ----------
    swing : forward, up, pitch, turn, bump (from 0 to 1 and back).
    climb : from 0 to 1 early, and late, in the swing.
    jolt : up, back.
    strike, jolt_s : when in the swing the jolt begins, and how long it lasts at most, s.
    """

    swing: Array
    climb: Array
    jolt: Array
    strike: float
    jolt_s: float


_U = Polynomial([0.5, 0.5])
_STEP = Polynomial([0, 0, 0, 0, 35.0, -84.0, 70.0, -20.0])(_U)
_BUMP = Polynomial([1.0, 0, -1.0]) ** 4


@cache
def shape_of(name: str) -> Shape:
    """The shape of a gait's swing."""
    pitch, forward, up = _MEASURED[name]
    zero = Polynomial([0.0])
    swing = [_through(forward, _STEP, 7), _through(up, zero, 9), _through(pitch, zero, 9), _STEP, _BUMP]
    climb = [_lifted(3, 7), _lifted(7, 3)]
    # A heel rings, up and down and back and forth. The jolt is short: more derivatives vanish at its ends, for it to be smooth.
    soft = Polynomial([1.0, 0, -1.0]) ** 6
    jolt = [soft * Polynomial([0, -3.0, 0, 8.0]), soft * Polynomial([1.0, 0, -6.0])]
    return Shape(_rows(swing), _rows(climb), _rows(jolt), *_STRIKE[name])


def _through(values: tuple[float, ...], base: Polynomial, order: int) -> Polynomial:
    y = np.linspace(-1, 1, len(values) + 2)[1:-1]
    c = np.linalg.lstsq(_BUMP(y)[:, None] * np.vander(y, order, increasing=True), values - base(y))[0]
    return base + _BUMP * Polynomial(c)


def _lifted(a: int, b: int) -> Polynomial:
    """From 0 to 1 by the integral of u^a (1 − u)^b, early where a < b; three derivatives vanish at the ends from a, b = 3 on."""
    rise = (_U**a * (1 - _U) ** b).integ()
    return (rise - rise(-1.0)) / (rise(1.0) - rise(-1.0))


def _rows(polynomials: list[Polynomial]) -> Array:
    all_of = [p.deriv(k) if k else p for p in polynomials for k in range(3)]
    rows = np.zeros((len(all_of), max(len(p.coef) for p in all_of)))
    for row, p in zip(rows, all_of, strict=True):
        row[: len(p.coef)] = p.coef
    return rows


def evaluated(coefficients: Array, y: Array) -> Array:
    """Values (rows, K) at y (K,)."""
    powers = np.empty((coefficients.shape[1], len(y)))
    powers[0] = 1.0
    for k in range(1, len(powers)):
        np.multiply(powers[k - 1], y, out=powers[k])
    values = np.empty((len(coefficients), len(y)))
    for start in range(0, len(y), _BLAS_ALONE):
        part = slice(start, start + _BLAS_ALONE)
        np.matmul(coefficients, powers[:, part], out=values[:, part])
    return values
