"""The numbers: errors over rows of a trajectory and its reference, already in one frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bematist.frames import conjugate, matrix_from_quaternion, multiply, rotation_vector_from_quaternion
from bematist.intervals import intervals

Array = NDArray[np.float64]


def rms(values: ArrayLike) -> float:
    """Root mean square of the finite values; NaN where there is none. Rows of a matrix count as vectors."""
    v = np.asarray(values, float)
    square = v**2 if v.ndim == 1 else (v**2).sum(1)
    square = square[np.isfinite(square)]
    return float(np.sqrt(square.mean())) if len(square) else float("nan")


def path_length(position: Array) -> float:
    """Length of the polygon through positions (K,3), m; in the plan where up is NaN."""
    step = np.diff(position, axis=0)
    return float(np.sqrt(np.nansum(step**2, axis=1)).sum())


@dataclass(frozen=True, kw_only=True)
class Relative:
    """Relative error (RTE) over one window.

    Attributes
    ----------
    window, unit : length of the window, in s or m of the reference's path.
    rms_m : root mean square of the error of the displacement over the window, m.
    percent : `rms_m` in % of the window, for windows in m.
    pairs : number of (overlapping) windows; 0 where the walk is shorter than the window.
    """

    window: float
    unit: str
    rms_m: float
    percent: float
    pairs: int


def relative_error(error: Array, along: Array, window: float, unit: str) -> Relative:
    """RTE: rms over all rows i of |error[j] − error[i]|, j the first row with along[j] ≥ along[i] + window.

    `error` (K,3) is the position error after the one global alignment (a window is not aligned anew), `along` (K,) the
    time in s or the distance gone in m. This is the RTE of H. Yan et al., "RoNIN", ICRA 2020, with the fixed window
    named.
    """
    j = np.searchsorted(along, along + window - 1e-9)
    i = np.flatnonzero(j < len(along))
    value = rms(error[j[i]] - error[i]) if len(i) else float("nan")
    return Relative(window=window, unit=unit, rms_m=value, percent=100 * value / window if unit == "m" else np.nan, pairs=len(i))


def polygon_rows(time: Array, position: Array) -> NDArray[np.int64]:
    """Rows of a reference through which its length is measured.

    Of a sparse reference (rows more than 0.1 s apart), every row. Of a shoe, the middles of its footfalls, where it moves
    less than 2 cm in 0.1 s. Of a body or a hand, which never rest so, every row that is 0.5 m from the last: that is
    taken where the way through the footfalls is shorter by more than a tenth.
    """
    every = np.arange(len(time))
    if len(time) < 3 or np.median(np.diff(time)) > 0.1:
        return every
    before, after = (np.searchsorted(time, time + s).clip(max=len(time) - 1) for s in (-0.05, 0.05))
    still = np.nansum((position[after] - position[before]) ** 2, axis=1) < 0.02**2
    edges = intervals(still)
    steps = np.unique(np.concatenate([[0], edges.sum(1) // 2, every[-1:]]).clip(max=len(time) - 1))
    apart = np.unique(np.append(_kept(position), every[-1]))
    return steps if path_length(position[steps]) > 0.9 * path_length(position[apart]) else apart


def distance_along(position: Array) -> Array:
    """Distance gone (K,), m, along positions (K,3): small wavering of a noisy reference does not count.

    A row counts once it is 0.5 m from the last one that counted; in between, the distance from that one stands for it.
    """
    p, kept = np.nan_to_num(position), _kept(position)
    total = np.concatenate([[0.0], np.linalg.norm(np.diff(p[kept], axis=0), axis=1).cumsum()])
    last = np.searchsorted(kept, np.arange(len(p)), side="right") - 1
    away = np.linalg.norm(p - p[kept][last], axis=1)
    return np.maximum.accumulate(np.minimum(total[last] + away, np.append(total[1:], np.inf)[last]))


def _kept(position: Array) -> list[int]:
    # Rows each 0.5 m from the last.
    p, kept = np.nan_to_num(position), [0]
    while (at := _leaves(p, kept[-1])) < len(p):
        kept.append(at)
    return kept


def _leaves(p: Array, at: int, distance: float = 0.5) -> int:
    # The first row after `at` that is `distance` away; len(p) if none. In growing blocks: half a metre may take one row
    # or, in a rest, thousands.
    start, block = at + 1, 64
    while start < len(p):
        far = np.flatnonzero(((p[start : start + block] - p[at]) ** 2).sum(1) >= distance**2)
        if len(far):
            return start + int(far[0])
        start, block = start + block, 2 * block
    return len(p)


@dataclass(frozen=True, kw_only=True)
class AttitudeError:
    """Root mean square attitude errors, rad: about the vertical, of the vertical, and the whole angle."""

    heading: float
    tilt: float
    total: float


def attitude_error_vectors(estimate: Array, truth: Array) -> Array:
    """Rotation vectors psi (K,3), rad, in the navigation frame, with C_est = exp([psi ×]) C_true."""
    return rotation_vector_from_quaternion(multiply(estimate, conjugate(truth)))


def heading_and_tilt(estimate: Array, truth: Array) -> tuple[Array, Array]:
    """Heading errors (K,), rad, signed, and errors of the vertical (K,), rad, of quaternions (K,4).

    The heading error is the angle about the vertical of the rotation between the two (its twist), not a difference of
    Euler yaws, which mean nothing when a foot points down.
    """
    q = multiply(estimate, conjugate(truth))
    heading = 2 * np.arctan2(q[:, 3], q[:, 0])
    heading = np.arctan2(np.sin(heading), np.cos(heading))
    return heading, np.arccos(np.clip(matrix_from_quaternion(q)[:, 2, 2], -1, 1))


def attitude_error(estimate: Array, truth: Array) -> AttitudeError:
    """Attitude error of quaternions (K,4); heading and tilt as `heading_and_tilt` says."""
    heading, tilt = heading_and_tilt(estimate, truth)
    total = rotation_vector_from_quaternion(multiply(estimate, conjugate(truth)))
    return AttitudeError(heading=rms(heading), tilt=rms(tilt), total=rms(total))


def course_error(position: Array, reference: Array, stretch_m: float = 1.0) -> float:
    """Root mean square error, rad, of the direction of travel in the plan, over stretches of at least `stretch_m` of
    the reference.
    """
    gone = distance_along(np.column_stack([reference[:, :2], np.zeros(len(reference))]))
    rows = np.unique(np.searchsorted(gone, np.arange(0.0, gone[-1] + stretch_m, stretch_m)).clip(max=len(gone) - 1))
    a, b = np.diff(position[rows, :2], axis=0), np.diff(reference[rows, :2], axis=0)
    far = (np.linalg.norm(b, axis=1) >= stretch_m / 2) & (np.linalg.norm(a, axis=1) > 0)
    a, b = a[far], b[far]
    return rms(np.arctan2(b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0], (a * b).sum(1)))


@dataclass(frozen=True, kw_only=True)
class Nees:
    """Normalised estimation error squared of one quantity over a walk.

    Attributes
    ----------
    dof : degrees of freedom, 3; 2 for a position in the plan.
    mean : mean of eᵀ P⁻¹ e over the rows; an honest covariance gives `dof` in expectation.
    lower, upper : 95 % bounds of one row. Rows of one walk follow each other closely, so their mean keeps nearly this
        spread; for the mean over independent walks see `nees_bounds`.
    inside : share of rows within these bounds.
    rows : number of rows with a usable covariance.
    """

    dof: int
    mean: float
    lower: float
    upper: float
    inside: float
    rows: int


def nees(error: Array, packed: Array) -> Array:
    """eᵀ P⁻¹ e (K,) of errors (K,3) and packed covariances (K,6: xx xy xz yy yz zz); NaN where P is not positive
    definite.
    """
    a, b, c, d, e, f = packed.T
    # The adjugate: six cofactors of a symmetric matrix.
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    D, E, F = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * A + b * B + c * C
    scale = (a + d + f) / 3
    usable = (a > 0) & (F > 0) & (det > 1e-12 * scale**3)
    x, y, z = error.T
    value = A * x * x + D * y * y + F * z * z + 2 * (B * x * y + C * x * z + E * y * z)
    return np.where(usable, value / np.where(usable, det, 1.0), np.nan)


def nees_bounds(runs: int = 1, dof: int = 3, probability: float = 0.95) -> tuple[float, float]:
    """Bounds within which the mean NEES of `runs` independent runs lies with this probability (χ² with runs·dof
    degrees).

    Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001,
    section 5.4.2.
    """
    from scipy.special import gammaincinv

    tail = (1 - probability) / 2
    low, high = (2 * gammaincinv(runs * dof / 2, p) / runs for p in (tail, 1 - tail))
    return float(low), float(high)


def nees_summary(error: Array, packed: Array, dof: int = 3, least_sd: float = 0.0) -> Nees | None:
    """NEES of a walk, or None where no row has a positive definite covariance.

    Rows whose largest standard deviation is below `least_sd` are left out: there the reference is no better.
    """
    value = nees(error, packed)
    value = value[np.isfinite(value) & (packed[:, [0, 3, 5]].max(1) >= least_sd**2)]
    if not len(value):
        return None
    low, high = nees_bounds(1, dof)
    inside = float(((value >= low) & (value <= high)).mean())
    return Nees(dof=dof, mean=float(value.mean()), lower=low, upper=high, inside=inside, rows=len(value))


def rotate_packed(R: Array, packed: Array) -> Array:
    """R P Rᵀ for packed covariances (K,6)."""
    P = R @ packed[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3) @ R.T
    return P.reshape(-1, 9)[:, [0, 1, 2, 4, 5, 8]]
