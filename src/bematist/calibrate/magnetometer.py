"""The magnetometer: hard and soft iron from the ellipsoid that the field draws, and its axes against those of the other sensors.

Without the others |A (m - h)| is the field's flux density whichever way the sensor points: nine parameters, A symmetric. With them A has
nine entries: at rests the field keeps its angle to gravity (K. Papafotis, P. P. Sotiriadis, MAG.I.C.AL., IEEE Sensors J. 19, 2019, and
"Accelerometer and magnetometer joint calibration and axes alignment", Technologies 8, 2020), and while the sensor turns the field moves in
its axes as the gyroscope says. Both resolve the rotation that the ellipsoid leaves open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.axes import best_axes, one_of_each_sign
from bematist.calibrate.correlated import correlation, influence, spread
from bematist.calibrate.coverage import missing_directions
from bematist.calibrate.norm import ellipsoid, norm_model, symmetric, widened
from bematist.calibrate.result import SensorCalibration
from bematist.calibrate.samples import FieldSamples, Pairs
from bematist.calibrate.solve import Block, Fit, Model, fit
from bematist.errors import DataError

Array = NDArray[np.float64]

SYMMETRIC_SD = np.array([0.3, 0.15, 0.15, 0.3, 0.15, 0.3])
"""What is known before of A, relative."""
MATRIX_SD = 0.3
CENTRE_SD = 10.0
"""What is known before of the hard iron, in flux densities of the field."""
OFFSET_LIMIT, SCALE_LIMIT = 0.03, 0.03
"""Standard deviations, relative to the field, beyond which a calibration would do more harm than good."""
LARGEST_MISFIT = 0.08
"""Of the field: samples that scatter more with every calibration were not taken in one field."""
SMALLEST = 0.002
"""Of the field: no place has a steadier one."""
TOLERATED = 0.01
"""Of the field: a sample that is off by less is no outlier."""
ENOUGH_PAIRS = 8
ENOUGH_RESTS = 6
DETERMINED = 0.75


@dataclass(frozen=True, eq=False)
class Iron:
    """Symmetric A (3,3), hard iron h (3,), µT, the field's flux density, and the fit they are from."""

    A: Array
    h: Array
    length: float
    fit: Fit


def fit_iron(samples: FieldSamples, length: float | None, source: str) -> Iron:
    """Hard and soft iron from the norm alone. `length` is the field's flux density, µT; without it the volume is kept (det A = 1).

    Raises
    ------
    DataError
        Too few samples or directions, or no one field.
    """
    values = samples.values
    if len(values) < 12:
        raise DataError(
            f"{source}: the magnetometer has {len(values)} samples that can be used, too few. Turn the sensor every way for a minute."
        )
    first = ellipsoid(values)
    if first is None:
        centre = values.mean(0)
        first = np.eye(3) / max(float(np.linalg.norm(values - centre, axis=1).mean()), 1e-9), centre
    A, h = first
    radius = float(np.linalg.det(A)) ** (-1 / 3) if length is None else length
    prior = np.concatenate([np.eye(3)[np.triu_indices(3)], h])
    prior_sd = np.concatenate([SYMMETRIC_SD, np.full(3, CENTRE_SD * radius)])
    start = np.concatenate([(A * radius)[np.triu_indices(3)], h])
    model = norm_model(values, radius, symmetric_matrix=True)
    blocks = [Block(model, samples.variance, "norm", SMALLEST * radius, TOLERATED * radius)]
    found = fit(blocks, start, prior, prior_sd)
    iron = Iron(symmetric(found.parameters), found.parameters[6:9], radius, found)
    _check(iron, samples, source)
    return replace(iron, fit=_honest(found, blocks, prior_sd, samples, None, np.zeros(len(values), bool)))


def _check(iron: Iron, samples: FieldSamples, source: str) -> None:
    kept = iron.fit.kept[0]
    off = np.abs(iron.fit.residuals[0][:, 0]) / iron.length
    sd = np.sqrt(np.diag(iron.fit.covariance))
    if (sd[:6] > SCALE_LIMIT).any() or (sd[6:] > OFFSET_LIMIT * iron.length).any():
        u = (samples.values - iron.h) @ iron.A.T
        missing = missing_directions(u / np.linalg.norm(u, axis=1, keepdims=True), max(1, len(u) // 200))
        where = f" (the field never pointed along {', '.join(missing)})" if missing else ""
        raise DataError(
            f"{source}: the sensor was not turned through enough directions to tell hard iron from soft iron and the field{where}. Turn it "
            "slowly every way, each side up once, at one place away from iron."
        )
    if np.median(off) > LARGEST_MISFIT or kept.mean() < 0.6:
        raise DataError(
            f"{source}: the magnetic field was not the same all the time: with every calibration its flux density scatters by "
            f"{100 * np.median(off):.0f} % of the field. Something magnetic came near, or the sensor was carried about. Turn it at one "
            "place, outdoors, away from iron."
        )


def norm_full(values: Array, length: float) -> Model:
    """Residual |A (m - h)| - length of readings (n,3), with nine entries of A, h, and the sine of the dip (which it does not need)."""

    def model(p: Array) -> tuple[Array, Array]:
        A, d = p[:9].reshape(3, 3), values - p[9:12]
        x = d @ A.T
        size = np.linalg.norm(x, axis=1)
        u = x / size[:, None]
        J = np.zeros((len(values), 1, len(p)))
        J[:, 0, :9] = (u[:, :, None] * d[:, None, :]).reshape(-1, 9)
        J[:, 0, 9:12] = -u @ A
        return (size - length)[:, None], J

    return model


def dip_model(values: Array, up: Array, length: float) -> Model:
    """Residual u · A (m - h) - length · s, with up u (n,3) at rests and s the sine of the field's elevation, one unknown."""

    def model(p: Array) -> tuple[Array, Array]:
        A, d = p[:9].reshape(3, 3), values - p[9:12]
        J = np.zeros((len(values), 1, len(p)))
        J[:, 0, :9] = (up[:, :, None] * d[:, None, :]).reshape(-1, 9)
        J[:, 0, 9:12] = -up @ A
        J[:, 0, 12] = -length
        return ((d @ A.T * up).sum(1) - length * p[12])[:, None], J

    return model


def turn_model(pairs: Pairs) -> Model:
    """Residual A (m₂ - h) - Rᵀ A (m₁ - h) of pairs of samples between which the sensor turned by R (n,3,3)."""
    back = np.swapaxes(pairs.turn, 1, 2)

    def model(p: Array) -> tuple[Array, Array]:
        A, d1, d2 = p[:9].reshape(3, 3), pairs.first - p[9:12], pairs.second - p[9:12]
        J = np.zeros((len(d1), 3, len(p)))
        eye = np.eye(3)
        J[:, :, :9] = (eye[None, :, :, None] * d2[:, None, None, :] - back[:, :, :, None] * d1[:, None, None, :]).reshape(-1, 3, 9)
        J[:, :, 9:12] = (back - eye) @ A
        return d2 @ A.T - np.einsum("nij,nj->ni", back, d1 @ A.T), J

    return model


def field_axes(iron: Iron, pairs: Pairs) -> Array:
    """The magnetometer's axes (3,3) against the gyroscope's; the unit matrix where the turns do not tell."""
    if len(pairs.first) < ENOUGH_PAIRS:
        return np.eye(3)
    x1, x2 = ((m - iron.h) @ iron.A.T / iron.length for m in (pairs.first, pairs.second))

    def misfit(P: Array) -> float:
        found = np.einsum("nji,nj->ni", pairs.turn, x1 @ P.T) - x2 @ P.T
        return float(np.median(np.linalg.norm(found, axis=1)))

    return best_axes(misfit, one_of_each_sign())


def calibrate_magnetometer(samples: FieldSamples, iron: Iron, pairs: Pairs, up: Array) -> tuple[SensorCalibration, float]:
    """The magnetometer in the frame of the other sensors, and the field's elevation, rad (NaN where nothing tells).

    up : (n,3) for each sample, in the accelerometer's calibrated frame, NaN where the sensor was not at rest.
    """
    at_rest = np.asarray(np.isfinite(up).all(1))
    limits = (SMALLEST * iron.length, TOLERATED * iron.length)
    blocks = [Block(norm_full(samples.values, iron.length), samples.variance, "norm", *limits)]
    if at_rest.sum() >= ENOUGH_RESTS:
        blocks.append(Block(dip_model(samples.values[at_rest], up[at_rest], iron.length), samples.variance[at_rest], "dip", *limits))
    if len(pairs.first) >= ENOUGH_PAIRS:
        blocks.append(Block(turn_model(pairs), pairs.variance, "turn", *limits))
    if len(blocks) == 1:
        return _alone(samples, iron), float("nan")
    A = iron.A
    s = float(np.median((((samples.values - iron.h) @ A.T / iron.length) * up).sum(1)[at_rest])) if at_rest.any() else 0.0
    start = np.concatenate([A.ravel(), iron.h, [s]])
    prior_sd = np.concatenate([np.full(9, MATRIX_SD), np.full(3, CENTRE_SD * iron.length), [1.0]])
    found = fit(blocks, start, np.concatenate([np.eye(3).ravel(), iron.h, [0.0]]), prior_sd)
    found = _honest(found, blocks, prior_sd, samples, pairs, at_rest)
    A, h = found.parameters[:9].reshape(3, 3), found.parameters[9:12]
    weak = [f"soft iron {'xyz'[k // 3]}{'xyz'[k % 3]}" for k in np.flatnonzero(found.determined[:9] < DETERMINED)]
    calibration = _result(samples, A, h, iron.length, found.covariance[:12, :12], found, tuple(weak), "")
    return calibration, float(np.arcsin(np.clip(found.parameters[12], -1, 1))) if at_rest.any() else float("nan")


def _honest(
    found: Fit, blocks: Sequence[Block], prior_sd: Array, samples: FieldSamples, pairs: Pairs | None, at_rest: NDArray[np.bool_]
) -> Fit:
    """The fit with a covariance that knows that errors of the field may hang together in time, and that a sample is used more than once."""
    p, C = found.parameters, found.covariance
    full = len(p) > 9
    A, h = (p[:9].reshape(3, 3), p[9:12]) if full else (symmetric(p), p[6:9])
    x = (samples.values - h) @ A.T
    along = x / np.linalg.norm(x, axis=1, keepdims=True)
    sd = np.sqrt(samples.variance + found.floors[0] ** 2)
    parts = []
    for b, keep, floor in zip(blocks, found.kept, found.floors, strict=True):
        J, weight = b.model(p)[1][keep], 1 / (b.variance[keep] + floor**2)
        if b.name == "norm":
            parts.append(influence(C, J, weight, (along @ A)[keep, None, :], samples.time[keep], sd[keep]))
        elif b.name == "dip":
            up = J[:, 0, :9].reshape(-1, 3, 3)  # up ⊗ (m - h): its derivative by m is up · A
            towards = up.sum(2) / (samples.values[at_rest][keep] - h).sum(1)[:, None]
            parts.append(influence(C, J, weight, (towards @ A)[:, None, :], samples.time[at_rest][keep], sd[at_rest][keep]))
        elif pairs is not None:
            own = np.full(int(keep.sum()), np.sqrt(float(pairs.variance[0]) / 2 + found.floors[0] ** 2))
            back = np.swapaxes(pairs.turn[keep], 1, 2)
            for D, time in ((-back @ A, pairs.time[keep, 0]), (np.broadcast_to(A, back.shape), pairs.time[keep, 1])):
                parts.append(influence(C, J, weight, D, time, own))
    keep = found.kept[0]
    order = np.flatnonzero(keep)[np.argsort(samples.time[keep], kind="stable")]
    share, correlation_s = correlation(found.residuals[0][order, 0] / sd[order], along[order], samples.time[order])
    covariance = spread(parts, share, correlation_s) + (C / prior_sd**2) @ C
    return replace(found, covariance=covariance, determined=1 - np.diag(covariance) / prior_sd**2)


def _alone(samples: FieldSamples, iron: Iron) -> SensorCalibration:
    note = (
        "Nothing ties the magnetometer's axes to those of the other sensors, no rests and no turns that the gyroscope followed: its soft "
        "iron is taken as symmetric."
    )
    covariance = widened(iron.fit.covariance, symmetric_matrix=True)
    return _result(samples, iron.A, iron.h, iron.length, covariance, iron.fit, (), note)


def _result(
    samples: FieldSamples, A: Array, h: Array, length: float, covariance: Array, found: Fit, weak: Sequence[str], note: str
) -> SensorCalibration:
    x = (samples.values - h) @ A.T
    size = np.linalg.norm(x, axis=1)
    kept, used = found.kept[0], samples.count[found.kept[0]]
    raw = np.linalg.norm(samples.values[kept], axis=1)
    return SensorCalibration(
        sensor="magnetometer",
        offset=h,
        matrix=A,
        covariance=covariance,
        length=length,
        before=float(np.sqrt(np.average(((raw - raw.mean()) / length) ** 2, weights=used))),
        after=float(np.sqrt(np.average((size[kept] / length - 1) ** 2, weights=used))),
        samples=int(used.sum()),
        left_out=int(samples.count[~kept].sum()),
        missing=missing_directions(x / size[:, None], max(1, len(x) // 200)),
        undetermined=tuple(weak),
        note=note,
    )
