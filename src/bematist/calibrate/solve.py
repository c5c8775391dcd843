"""Weighted least squares with outliers, unknown disturbance and weak priors: what every calibration here is solved by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Model = Callable[[Array], tuple[Array, Array]]

ROUNDS = 6
OUTLIER = 4.5
"""A residual this many standard deviations large is left out."""
SPARE = 0.4
"""Degrees of freedom over residuals, below which nothing is called an outlier: too few residuals tell what is usual."""


@dataclass(frozen=True, eq=False)
class Block:
    """Residuals of one kind.

    model : parameters (P,) → residuals (n,d) and their derivatives (n,d,P).
    variance : (n,) of each residual, as far as the noise of the sensor explains it.
    name : for messages.
    smallest : standard deviation that is never gone below, in units of the residual.
    tolerated : a residual below this is never an outlier.
    """

    model: Model
    variance: Array
    name: str = ""
    smallest: float = 0.0
    tolerated: float = 0.0


@dataclass(frozen=True, eq=False)
class Fit:
    """Parameters (P,) with their covariance (P,P); for each block the residuals (n,d), which rows were kept (n,), and the standard
    deviation of what the noise of the sensor does not explain; determined (P,): how much of what is known of each comes from the data.
    """

    parameters: Array
    covariance: Array
    residuals: tuple[Array, ...]
    kept: tuple[NDArray[np.bool_], ...]
    floors: tuple[float, ...]
    determined: Array


@dataclass(frozen=True, eq=False)
class _Equations:
    """All residuals over their standard deviations, the prior's last, and their derivatives."""

    models: Sequence[Model]
    weights: Sequence[Array]
    kept: Sequence[NDArray[np.bool_]]
    prior: Array
    prior_sd: Array

    def residuals(self, p: Array) -> Array:
        parts = [(m(p)[0] * w[:, None])[k].ravel() for m, w, k in zip(self.models, self.weights, self.kept, strict=True)]
        return np.concatenate([*parts, (p - self.prior) / self.prior_sd])

    def jacobian(self, p: Array) -> Array:
        parts = [(m(p)[1] * w[:, None, None])[k].reshape(-1, len(p)) for m, w, k in zip(self.models, self.weights, self.kept, strict=True)]
        return np.concatenate([*parts, np.diag(1 / self.prior_sd)])


def fit(blocks: Sequence[Block], start: Array, prior: Array, prior_sd: Array, *, trim: bool = True) -> Fit:
    """Parameters that fit all blocks.

    The weights are those of the sensor's noise and of a further, equal variance in each block, the one with which the residuals are as
    large as they should be. The first round is robust (soft L1), then rows beyond `OUTLIER` are left out and the rest is fitted by plain
    least squares, so that without outliers nothing is lost. `prior` with `prior_sd` (P,) keeps what the data do not tell where it was.
    """
    from scipy.optimize import least_squares

    x = np.asarray(start, float)
    models = [_once(b.model) for b in blocks]
    kept = [np.ones(len(b.variance), bool) for b in blocks]
    floors = [b.smallest for b in blocks]
    found: list[Array] = []
    J = np.empty((0, len(x)))
    for turn in range(ROUNDS):
        equations = _Equations(models, [1 / np.sqrt(b.variance + f**2) for b, f in zip(blocks, floors, strict=True)], kept, prior, prior_sd)
        loss = "soft_l1" if turn == 0 and trim else "linear"
        jac: Any = equations.jacobian
        x = least_squares(equations.residuals, x, jac, x_scale=prior_sd, loss=loss, f_scale=3.0).x
        found = [m(x)[0] for m in models]
        J = equations.jacobian(x)
        freedom = _freedom(J, [int(k.sum()) * r.shape[1] for k, r in zip(kept, found, strict=True)])
        floors = [_floor(r[k], b.variance[k], f, b.smallest) for b, r, k, f in zip(blocks, found, kept, freedom, strict=True)]
        if trim and turn < ROUNDS - 2:
            kept = [
                _inliers(r, b, f) if free > SPARE * r.size else k
                for b, r, f, k, free in zip(blocks, found, floors, kept, freedom, strict=True)
            ]
    covariance: Array = np.asarray(np.linalg.inv(J.T @ J), float)
    return Fit(x, covariance, tuple(found), tuple(kept), tuple(floors), 1 - np.diag(covariance) / prior_sd**2)


def _once(model: Model) -> Model:
    """The model, which remembers its last answer: residuals and derivatives are asked for one after the other."""
    last: list[tuple[Array, tuple[Array, Array]]] = []

    def asked(p: Array) -> tuple[Array, Array]:
        if not last or not np.array_equal(last[0][0], p):
            last[:] = [(p.copy(), model(p))]
        return last[0][1]

    return asked


def _freedom(J: Array, rows: list[int]) -> list[float]:
    """Degrees of freedom of each block: its residuals less the share of the parameters that it determines (trace of its hat matrix)."""
    covariance = np.linalg.inv(J.T @ J)
    ends = np.cumsum(rows)
    return [n - float(np.einsum("ij,jk,ik->", J[e - n : e], covariance, J[e - n : e])) for n, e in zip(rows, ends, strict=True)]


def _floor(r: Array, variance: Array, freedom: float, smallest: float) -> float:
    """Standard deviation beside the known variances (n,) with which the squares of residuals (n,d) sum to the degrees of freedom."""
    if freedom < 1:
        return smallest
    square = (r**2).sum(1)

    def excess(floor: float) -> float:
        return float((square / (variance + floor**2)).sum()) - freedom

    if excess(smallest) <= 0:
        return smallest
    low, high = smallest, float(np.sqrt(square.sum() / freedom)) + smallest + 1e-12
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return high


def _inliers(r: Array, block: Block, floor: float) -> NDArray[np.bool_]:
    """Rows (n,) of residuals (n,d) within `OUTLIER` of a scale that outliers do not stretch."""
    size = np.sqrt((r**2).mean(1) / (block.variance + floor**2))
    # The median of a chi with d degrees of freedom, over the root of d, is near this for d of 1, 2, 3.
    middle = {1: 0.674, 2: 0.833, 3: 0.888}[r.shape[1]]
    scale = max(float(np.median(size)) / middle, 1e-300)
    return (size <= OUTLIER * scale) | ((r**2).mean(1) <= block.tolerated**2)


def placed(model: Model, start: int, stop: int) -> Model:
    """A model of the parameters from start to before stop, as one of all."""

    def of_all(p: Array) -> tuple[Array, Array]:
        r, J = model(p[start:stop])
        whole = np.zeros((*J.shape[:2], len(p)))
        whole[:, :, start:stop] = J
        return r, whole

    return of_all
