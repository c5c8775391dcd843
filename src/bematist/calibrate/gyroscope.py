"""The gyroscope: its offset from the rests, scale factors and misalignment from the turns between them.

The turn that the gyroscope measures between two rests must carry the direction of gravity, and of the magnetic field where it is
calibrated, at the first to that at the second (Tedaldi et al. 2014, eqs 11-13; with the field: MAG.I.C.AL., K. Papafotis, P. P. Sotiriadis,
IEEE Sensors J. 19, 2019). A known turn adds what gravity cannot see: a turn about the vertical.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.accelerometer import PRIOR, Gravity, accelerometer_calibration
from bematist.calibrate.accelerometer import PRIOR_SD as ACCEL_PRIOR_SD
from bematist.calibrate.accelerometer import TOLERATED as TOLERATED_REST
from bematist.calibrate.known import KnownTurn, known_model
from bematist.calibrate.rests import Rests
from bematist.calibrate.result import SensorCalibration
from bematist.calibrate.solve import Block, Fit, Model, fit, placed
from bematist.calibrate.turning import Turn, propagated, turned
from bematist.errors import DataError
from bematist.frames import matrix_from_quaternion

Array = NDArray[np.float64]

PRIOR_SD = np.where(np.eye(3, dtype=bool), 0.1, 0.05).ravel()
"""What is known before: scale factors to 10 %, axes to 3 degrees."""
SMALLEST = 2e-4
"""rad: no turn by hand is known better."""
TOLERATED = np.radians(0.5)
"""rad: a turn that misses by less is no outlier."""
LEAST_TURN = 0.2
"""rad: a smaller turn between two rests tells nothing."""
DETERMINED = 0.75
LARGEST_MISFIT = np.radians(3.0)


@dataclass(frozen=True, eq=False)
class Directions:
    """A vector that stands still in the room, as seen from the sensor at each rest: unit vectors (K,3), NaN where unknown, with the
    variance (K,) of each component, rad². `model`: parameters of the accelerometer (9,) → the vectors and their derivatives (K,3,9); None
    where they are what they are.
    """

    units: Array
    variance: Array
    model: Model | None = None


def direction_model(turns: Sequence[Turn], seen: Directions) -> Model:
    """Residual (n,2): the direction at the first rest, turned by S w, less that at the second, in the plane across it.

    Parameters: nine of S, then nine of the accelerometer.
    """
    first, second = (np.array([getattr(t, name) for t in turns], int) for name in ("first", "second"))
    across = tangents(seen.units[second])

    def model(p: Array) -> tuple[Array, Array]:
        S = p[:9].reshape(3, 3)
        found = [propagated(S, t) for t in turns]
        R, G = np.array([f[0] for f in found]), np.array([f[1] for f in found])
        units, by_accel = (seen.units, None) if seen.model is None else seen.model(p[9:18])
        x = np.einsum("nba,nb->na", R, units[first])
        out = np.zeros((len(turns), 2, len(p)))
        # d(Rᵀu) = (Rᵀu) × dφ
        out[:, :, :9] = across @ np.cross(x[:, :, None], G, axis=1)
        if by_accel is not None:
            out[:, :, 9:18] = across @ (np.swapaxes(R, 1, 2) @ by_accel[first] - by_accel[second])
        return np.einsum("nij,nj->ni", across, x - units[second]), out

    return model


def tangents(v: Array) -> Array:
    """Two unit vectors (n,2,3) across each of the unit vectors (n,3), and across each other."""
    side = np.eye(3)[np.argmin(np.abs(v), axis=1)]
    a: Array = np.cross(v, side)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b: Array = np.cross(v, a)
    return np.stack([a, b], 1)


def usable(turns: Sequence[Turn], seen: Directions) -> list[Turn]:
    """The turns that are large enough, between rests at which the direction is known."""
    known = np.asarray(np.isfinite(seen.units).all(axis=1))
    return [t for t in turns if known[t.first] and known[t.second] and t.way() > LEAST_TURN]


def misfit(turns: Sequence[Turn], seen: Directions, S: Array) -> float:
    """Median angle, rad, by which the directions miss with rates S w; NaN without turns."""
    found = []
    for t in turns:
        R = matrix_from_quaternion(turned(t.rates, t.steps, S))
        found.append(np.arccos(np.clip(R.T @ seen.units[t.first] @ seen.units[t.second], -1, 1)))
    return float(np.median(found)) if found else float("nan")


def turn_blocks(rests: Rests, turns: Sequence[Turn], seen: Sequence[Directions], known: Sequence[KnownTurn]) -> list[Block]:
    """The equations of the turns: what was seen at their ends, and what is known of their angle."""
    blocks, white = [], rests_white(rests)
    for directions in seen:
        part = usable(turns, directions)
        if part:
            ends = directions.variance[[t.first for t in part]] + directions.variance[[t.second for t in part]]
            drift = np.array([white * t.seconds + offset_drift(rests, t) for t in part])
            blocks.append(Block(direction_model(part, directions), ends + drift, "direction", SMALLEST, TOLERATED))
    if known:
        blocks.append(Block(known_model(known), np.array([k.sd**2 for k in known]), "known turn", 0.0, TOLERATED))
    return blocks


def calibrate_inertial(
    gravity: Gravity, turns: Sequence[Turn], field: Directions | None, known: Sequence[KnownTurn], source: str
) -> tuple[SensorCalibration, SensorCalibration]:
    """Accelerometer and gyroscope, together: the turns also tell the accelerometer's misalignment, where its rests alone do not.

    field : the directions of the magnetic field at the rests, where the magnetometer is calibrated.

    Raises
    ------
    DataError
        The turns do not fit the directions with any calibration.
    """
    up = Directions(gravity.up()[0], gravity.up_variance, gravity.up)
    blocks = turn_blocks(gravity.rests, turns, [up] if field is None else [up, field], known)
    start = np.concatenate([np.eye(3).ravel(), gravity.fit.parameters])
    rest_block = gravity.block()
    rest_block = Block(placed(rest_block.model, 9, 18), rest_block.variance, "gravity", gravity.fit.floors[0], TOLERATED_REST)
    found = fit([rest_block, *blocks], start, np.concatenate([np.eye(3).ravel(), PRIOR]), np.concatenate([PRIOR_SD, ACCEL_PRIOR_SD]))
    directions = [f for b, f in zip(blocks, found.floors[1:], strict=True) if b.name == "direction"]
    if max(directions, default=0.0) > LARGEST_MISFIT:
        raise DataError(
            f"{source}: the turns that the gyroscope measures miss the directions at rest by {np.degrees(max(directions)):.1f} degrees "
            "with every calibration: its unit or its axes are wrong, it saturates, or its samples are not on the accelerometer's clock. "
            "See `bematist info`, and turn the sensor more slowly."
        )
    accelerometer = accelerometer_calibration(gravity, found.parameters[9:18], found.covariance[9:18, 9:18])
    return accelerometer, _gyroscope(gravity.rests, blocks, found)


def _gyroscope(rests: Rests, blocks: Sequence[Block], found: Fit) -> SensorCalibration:
    offset, offset_variance = gyro_offset(rests)
    covariance = np.zeros((12, 12))
    covariance[9:, 9:] = np.diag(offset_variance)
    if blocks:
        covariance[:9, :9] = found.covariance[:9, :9]
    raw = np.concatenate([np.eye(3).ravel(), found.parameters[9:18]])
    seen = [(b, k) for b, k in zip(blocks, found.kept[1:], strict=True) if b.name == "direction"]
    before, after = (_rms([b.model(p)[0][k] for b, k in seen]) for p in (raw, found.parameters))
    left_out = sum(int((~k).sum()) for k in found.kept[1:])
    return SensorCalibration(
        sensor="gyroscope",
        offset=offset,
        matrix=found.parameters[:9].reshape(3, 3) if blocks else np.eye(3),
        covariance=covariance,
        length=np.nan,
        before=before,
        after=after,
        samples=sum(len(b.variance) for b in blocks) - left_out,
        left_out=left_out,
        undetermined=tuple(_name(k) for k in np.flatnonzero(found.determined[:9] < DETERMINED).tolist()) if blocks else (),
        note="" if blocks else "The sensor was not turned between rests: of the gyroscope only the offset is calibrated.",
    )


def _rms(residuals: Sequence[Array]) -> float:
    r = np.concatenate([(x**2).sum(1) for x in residuals]) if residuals else np.empty(0)
    return float(np.sqrt(r.mean())) if len(r) else float("nan")


def _name(k: int) -> str:
    i, j = divmod(k, 3)
    return f"scale {'xyz'[i]}" if i == j else f"misalignment {'xyz'[i]}{'xyz'[j]}"


def rests_white(rests: Rests) -> float:
    """Density N² of the gyroscope's white noise, rad²/s: the middle over the rests."""
    return float(np.median(rests.rate_variance * rests.seconds))


def offset_drift(rests: Rests, turn: Turn) -> float:
    """Variance, rad², of the turn by the offset, which was taken as the mean over the two rests."""
    return float(rests.rate_variance[turn.first] + rests.rate_variance[turn.second]) / 4 * turn.seconds**2


def gyro_offset(rests: Rests) -> tuple[Array, Array]:
    """Offset (3,) and its variance (3,): the mean over the rests, by their length, and how much they scatter."""
    weight = rests.seconds / rests.seconds.sum()
    mean = weight @ rests.rate
    scatter = weight @ (rests.rate - mean) ** 2
    white = float(weight**2 @ rests.rate_variance)
    return mean, np.maximum(scatter * float(weight @ weight), white)
