"""The accelerometer, from rests in many positions: |C (f - b)| = g (multi-position calibration, no rig).

D. Tedaldi, A. Pretto, E. Menegatti, "A robust and easy to implement method for IMU calibration without external equipments", ICRA 2014,
eqs 8-10, with C upper triangular: the z axis of the calibrated frame is the accelerometer's own z axis, and its y axis lies in the plane of
the accelerometer's y and z axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.coverage import missing_directions
from bematist.calibrate.norm import UPPER, norm_model, upper, widened
from bematist.calibrate.rests import Rests
from bematist.calibrate.result import SensorCalibration
from bematist.calibrate.solve import Block, Fit, fit
from bematist.errors import DataError
from bematist.recording import Recording

Array = NDArray[np.float64]

PRIOR_SD = np.array([0.1, 0.05, 0.05, 0.1, 0.05, 0.1, 2.0, 2.0, 2.0])
"""What is known before: scale factors to 10 %, axes at right angles to 3 degrees, offsets to 2 m/s²."""
PRIOR = np.array([1.0, 0, 0, 1.0, 0, 1.0, 0, 0, 0])
SMALLEST = 0.0005
"""m/s²: no rest of a sensor in use is steadier than this (temperature, quantisation, the table)."""
TOLERATED = 0.02
"""m/s²: a rest that is off by less is no outlier."""
FEWEST = 4
WRONG_UNIT = (0.5, 1.6)
"""The middle reading over gravity, beyond which the unit must be wrong; scale errors and offsets stay far within."""
SCALE_LIMIT, OFFSET_LIMIT = 0.01, 0.1
"""Standard deviations, relative and m/s², beyond which a calibration would do more harm than good."""
LARGEST_MISFIT = 0.3
"""m/s²: rests that disagree by more with every calibration are no rests."""


@dataclass(frozen=True, eq=False)
class Gravity:
    """The fit of C and b (nine parameters), the rests (K) it is from, and gravity, m/s²."""

    fit: Fit
    rests: Rests
    gravity: float

    @property
    def kept(self) -> NDArray[np.bool_]:
        return self.fit.kept[0]

    def up(self, parameters: Array | None = None) -> tuple[Array, Array]:
        """Directions of gravity (K,3) at all rests, and their derivatives (K,3,9)."""
        return up_directions(self.rests.force, self.fit.parameters if parameters is None else parameters)

    @property
    def up_variance(self) -> Array:
        """Variance (K,) of each component of the directions, rad²."""
        return (self.rests.force_variance + self.fit.floors[0] ** 2) / self.gravity**2

    def block(self) -> Block:
        """The equations of the rests."""
        return gravity_block(self.rests, self.gravity)


def gravity_block(rests: Rests, gravity: float) -> Block:
    """|C (f - b)| = g over the rests."""
    return Block(norm_model(rests.force, gravity, symmetric_matrix=False), rests.force_variance, "gravity", SMALLEST, TOLERATED)


def up_directions(f: Array, p: Array) -> tuple[Array, Array]:
    """Unit vectors (n,3) along C (f - b) of readings (n,3), and their derivatives (n,3,9) by the parameters of C and b."""
    C, d = upper(p), f - p[6:9]
    x = d @ C.T
    size = np.linalg.norm(x, axis=1)
    u = x / size[:, None]
    J = np.zeros((len(f), 3, 9))
    for k, (i, j) in enumerate(UPPER):
        J[:, i, k] = d[:, j]
    J[:, :, 6:9] = -C
    return u, (J - u[:, :, None] * (u[:, None, :] @ J)) / size[:, None, None]


def check_unit(recordings: Sequence[Recording], gravity: float, source: str) -> None:
    """Raise DataError where the accelerometer's unit cannot be m/s²: half of a recording in the hand is near gravity, rests or not."""
    middle = float(np.nanmedian(np.linalg.norm(np.concatenate([r.specific_force for r in recordings]), axis=1)))
    if not WRONG_UNIT[0] < middle / gravity < WRONG_UNIT[1]:
        raise DataError(
            f"{source}: the accelerometer reads {middle:.4g} m/s² in the middle, where gravity is {gravity:.4g}: its unit is wrong, or "
            "gravity was taken out. Give the unit, such as --units specific_force=g, or record the raw accelerometer."
        )


def fit_gravity(rests: Rests, gravity: float, source: str) -> Gravity:
    """The accelerometer's scale factors, misalignments and offsets, from rests alone.

    Raises
    ------
    DataError
        Too few rests or directions, or rests that are none.
    """
    if len(rests) < FEWEST:
        swayed = f" ({rests.left_out} more turned or swayed)" if rests.left_out else ""
        raise DataError(
            f"{source}: there are {len(rests)} rests{swayed}, too few to calibrate the accelerometer. Hold or lay the sensor still for two "
            "to three seconds in at least nine positions, each side up once and some askew, and turn it by hand in between."
        )
    found = Gravity(fit([gravity_block(rests, gravity)], PRIOR, PRIOR, PRIOR_SD), rests, gravity)
    _check(found, source)
    return found


def accelerometer_calibration(found: Gravity, p: Array, covariance: Array) -> SensorCalibration:
    """The calibration with parameters p (9,) and their covariance (9,9)."""
    rests, gravity, kept = found.rests, found.gravity, found.kept
    determined = 1 - np.diag(covariance) / PRIOR_SD**2
    size = np.linalg.norm((rests.force - p[6:9]) @ upper(p).T, axis=1)
    return SensorCalibration(
        sensor="accelerometer",
        offset=p[6:9],
        matrix=upper(p),
        covariance=widened(covariance, symmetric_matrix=False),
        length=gravity,
        before=float(np.sqrt(np.mean((np.linalg.norm(rests.force[kept], axis=1) / gravity - 1) ** 2))),
        after=float(np.sqrt(np.mean((size[kept] / gravity - 1) ** 2))),
        samples=int(kept.sum()),
        left_out=int((~kept).sum()),
        missing=missing_directions(found.up(p)[0][kept]),
        undetermined=tuple(f"misalignment {name}" for name, d in zip(("xy", "xz", "yz"), determined[[1, 2, 4]], strict=True) if d < 0.75),
    )


def _check(gravity: Gravity, source: str) -> None:
    found, rests = gravity.fit, gravity.rests
    left_out = int((~gravity.kept).sum())
    if found.floors[0] > LARGEST_MISFIT or left_out > 0.34 * len(rests):
        raise DataError(
            f"{source}: no calibration of the accelerometer brings the {len(rests)} rests to one gravity (they differ by "
            f"{found.floors[0]:.2g} m/s², and {left_out} by far more): some are no rests, or the sensor saturates, or something moved in "
            "it. Record again, and put the sensor down in each position."
        )
    sd = np.sqrt(np.diag(found.covariance))
    if (sd[[0, 3, 5]] > SCALE_LIMIT).any() or (sd[6:9] > OFFSET_LIMIT).any():
        missing = missing_directions(gravity.up()[0])
        where = f": there is {', '.join(f'no rest with {m} up' for m in missing)}" if missing else ""
        raise DataError(
            f"{source}: the {len(rests)} rests do not cover enough directions to tell scale factors from offsets{where}. Add rests with "
            "each of the six sides up, and some askew."
        )
