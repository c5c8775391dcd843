"""Figure 3: five hours of a still object, its attitude by the gyroscope alone and with TRIAD every five seconds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.align import triad
from bematist.earth import STANDARD_GRAVITY
from bematist.frames import euler_from_quaternion, multiply, quaternion_from_matrix, quaternion_from_rotation_vector
from bematist.recording import Recording
from bematist.reproduce.study import Found, Row, Settings
from bematist.simulate import SENSORS, simulate

Array = NDArray[np.float64]

RATES = SENSORS["lsm9ds1"].rate_hz, SENSORS["lsm9ds1"].magnetometer_rate_hz

NOTHING_ELSE: dict[str, Any] = {f"{q}_{what}": 0.0 for q in ("accel", "gyro") for what in ("bias_sd", "bias_instability", "lsb")}
NOTHING_ELSE["magnetic_lsb"] = 0.0
"""White noise and constant offsets are all that the paper adds."""

BIASES = {
    "bias instability": (182e-6 * STANDARD_GRAVITY, math.radians(8.63 / 3600)),
    "uncalibrated": (3e-3 * STANDARD_GRAVITY, math.radians(0.2)),
}
"""Constant offsets of accelerometer (m/s²) and gyroscope (rad/s), the same on each axis. The paper says "small" and gives no number; the
first are its Table 3's instabilities, the second the turn-on offsets of the simulator's preset."""

AVERAGED_S = 10.0


def cases(seeds: int) -> list[Settings]:
    """Each bias, with at most three seeds: one run is five hours long."""
    return [{"seed": s, "bias": bias, "hours": 5.0, "every_s": 5.0} for bias in BIASES for s in range(min(seeds, 3))]


def compute(settings: Settings) -> Found:
    """Errors of roll, pitch and yaw, degrees, at the end of every interval between two corrections (its worst moment)."""
    bias, every = settings["bias"], settings["every_s"]
    before = _still(bias, [settings["seed"], 0], AVERAGED_S)
    start = before.specific_force.mean(0), before.magnetic_flux_density.mean(0)
    single = before.specific_force[0], before.magnetic_flux_density[0]
    per, per_field = round(every * RATES[0]), round(every * RATES[1])
    turns, forces, fields = [], [], []
    whole, rest = divmod(settings["hours"], 1.0)
    for hour, share in enumerate([1.0] * int(whole) + [rest] * (rest > 0)):
        # An hour at a time, for the memory: white noise and constant offsets go on as they were.
        r = _still(bias, [settings["seed"], hour + 1], 3600 * share)
        angles = r.angular_rate[1 : 1 + len(r) // per * per] / RATES[0]
        turns.append(_turned(angles.reshape(-1, per, 3)))
        forces.append(r.specific_force[per::per])
        fields.append(r.magnetic_flux_density[per_field::per_field])
    turn, f, m = map(np.concatenate, (turns, forces, fields))
    R = _triads(start, f, m)
    attitudes = {
        "gyroscope": _chained(turn),
        "TRIAD": _corrected(turn, R.transpose(0, 2, 1)),
        "TRIAD, transposed as printed": _corrected(turn, R),
        "TRIAD, start of one sample": _corrected(turn, _triads(single, f, m).transpose(0, 2, 1)),
    }
    # Roll, pitch and yaw may have gone round several times.
    errors = {name: np.degrees(np.unwrap(euler_from_quaternion(q), axis=0)) for name, q in attitudes.items()}
    return Found(
        [{"attitude": name, **_summary(error)} for name, error in errors.items()],
        {name: error.astype(np.float32) for name, error in errors.items()},
    )


def _still(bias: str, seed: list[int], seconds: float) -> Recording:
    # The object's axes point East, North and Up.
    f_bias, w_bias = BIASES[bias]
    number = int(np.random.SeedSequence(seed).generate_state(1)[0])
    changes = {"rest_s": seconds, "mounting_deg": (0.0, 0.0, 0.0), "accel_bias": (f_bias,) * 3, "gyro_bias": (w_bias,) * 3}
    return simulate("still", "lsm9ds1", number, **changes, **NOTHING_ELSE)


def _turned(angles: Array) -> Array:
    # The product of the turns (B,n,3), rad, of each of B intervals: (B,4).
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(angles), 1))
    for k in range(angles.shape[1]):
        q = multiply(q, quaternion_from_rotation_vector(angles[:, k]))
    return q


def _chained(turn: Array) -> Array:
    # MAGINAV eq 7 without any correction.
    q = np.empty_like(turn)
    at = np.array([1.0, 0.0, 0.0, 0.0])
    for k, one in enumerate(turn):
        at = q[k] = multiply(at, one)
    return q


def _triads(start: tuple[Array, Array], f: Array, m: Array) -> Array:
    # TRIAD of MAGINAV eq 11 (B,3,3); erratum: C_FM is its transpose, with C(0) = 1 here.
    return np.array([triad(*start, a, b) for a, b in zip(f, m, strict=True)])


def _corrected(turn: Array, C: Array) -> Array:
    # The attitude is set to C (B,3,3) at the end of each interval; from there the gyroscope goes on to the next end.
    first = np.array([[1.0, 0.0, 0.0, 0.0]])
    return multiply(np.concatenate([first, quaternion_from_matrix(C[:-1])]), turn)


def _summary(error: Array) -> Row:
    row: Row = {}
    for axis, values in zip(("roll", "pitch", "yaw"), error.T, strict=True):
        row |= {f"{axis}_rms_deg": float(np.sqrt(np.mean(values**2))), f"{axis}_largest_deg": float(np.abs(values).max())}
        row[f"{axis}_last_deg"] = float(values[-1])
    return row
