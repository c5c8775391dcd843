"""The Allan deviation: how fast, and whether its intervals hold the truth.

python benchmarks/allan.py speed          5 h at 238 Hz, 6 axes, beside allantools on the same averaging times
python benchmarks/allan.py study [SEEDS]  5 h of rest of the sensor presets, simulated, identified by `bm.allan`; 20 seeds without a number
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable

import allantools
import numpy as np
from scipy.signal import lfilter

import bematist as bm
from bematist.allan.deviation import Stretches, averaging_spans, overlapping_variance
from bematist.simulate import SENSORS, Sensor, simulate

HOURS, RATE_HZ, AXES, ROUNDS = 5.0, 238.0, 6, 5


def speed() -> dict[str, float]:
    """Seconds of one thread for all axes, least of five rounds, allantools' for as many, and their ratio."""
    n = int(HOURS * 3600 * RATE_HZ)
    values = np.random.default_rng(0).standard_normal((AXES, n))
    pieces, spans, room = Stretches((slice(0, n),), 1 / RATE_HZ), averaging_spans(n), np.empty(n + 1)

    def ours() -> None:
        for axis in range(AXES):
            overlapping_variance(values[axis], pieces, spans, room)

    def theirs() -> None:
        allantools.oadev(values[0], rate=RATE_HZ, data_type="freq", taus=spans / RATE_HZ)

    ours()
    pairs = [(_seconds(ours), AXES * _seconds(theirs)) for _ in range(ROUNDS)]  # one after the other: a busy machine slows both alike
    fast, slow = (min(p[k] for p in pairs) for k in (0, 1))
    return {"seconds": fast, "allantools_seconds": slow, "ratio": float(np.median([b / a for a, b in pairs]))}


def _seconds(call: Callable[[], None]) -> float:
    start = time.thread_time()
    call()
    return time.thread_time() - start


def truths(s: Sensor) -> dict[tuple[str, str], float]:
    """What the simulated sensor has: coefficients in SI. Rounding to a quantum adds white noise."""

    def white(density: float, quantum: float, rate_hz: float) -> float:
        return math.sqrt(density**2 + quantum**2 / 12 / rate_hz)

    return {
        ("accelerometer", "N"): white(s.velocity_random_walk, s.accel_lsb, s.rate_hz),
        ("accelerometer", "B"): s.accel_bias_instability,
        ("gyroscope", "N"): white(s.angle_random_walk, s.gyro_lsb, s.rate_hz),
        ("gyroscope", "B"): s.gyro_bias_instability,
        ("gyroscope", "K"): s.gyro_rate_random_walk,
        ("magnetometer", "N"): white(s.magnetic_noise_density, s.magnetic_lsb, s.magnetometer_rate_hz),
    }


FLICKER_PER_DECADE = 2


def flicker(n: int, rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Flicker noise of B = 1 at every averaging time from a few samples on: Gauss-Markov processes, two a decade, to a day."""
    decades = math.log10(86_400 * rate_hz)
    times = 10 ** np.arange(0, decades, 1 / FLICKER_PER_DECADE)
    sd = math.sqrt(math.log(10) / FLICKER_PER_DECADE / math.pi)
    values = np.zeros(n)
    for correlation in times:
        keep = math.exp(-1 / correlation)
        drive = sd * math.sqrt(1 - keep**2) * rng.standard_normal(n)
        drive[0] = sd * rng.standard_normal()
        values += lfilter([1.0], [1.0, -keep], drive)
    return values


def at_rest(name: str, seed: int, hours: float) -> bm.Recording:
    """A simulated rest whose flicker reaches down to single samples, with twice as many processes a decade as the simulator's own."""
    s, rng = SENSORS[name], np.random.default_rng([seed, 1])
    r = simulate("still", s.override({"accel_bias_instability": 0.0, "gyro_bias_instability": 0.0}), seed, rest_s=3600 * hours)
    force, rate = r.specific_force, r.angular_rate
    for axis in range(3):
        force[:, axis] += s.accel_bias_instability * flicker(len(r), s.rate_hz, rng)
        rate[:, axis] += s.gyro_bias_instability * flicker(len(r), s.rate_hz, rng)
    return r


def study(name: str, seeds: int, hours: float = HOURS) -> list[str]:
    """Lines of a table: how often a coefficient was found, held by its interval (not found: within its bound), and how far off it was."""
    told: dict[tuple[str, str], list[tuple[bool, bool, float]]] = {}
    others: dict[str, int] = {}
    for seed in range(seeds):
        found = bm.allan(at_rest(name, seed, hours))
        for row in found.coefficients():
            key = (row["sensor"], row["symbol"])
            truth = truths(SENSORS[name]).get(key, 0.0)
            if truth:
                held = row["low"] <= truth <= row["high"]
                told.setdefault(key, []).append((row["found"], held, row["value"] / truth))
            elif row["found"] and row["symbol"] in "QNBKRs":
                others[" ".join(key)] = others.get(" ".join(key), 0) + 1
    lines = [
        f"{name}, {hours:g} h, {seeds} seeds, three axes each",
        "| sensor | coefficient | found | held | median of found / true | spread |",
    ]
    for (sensor, symbol), rows in told.items():
        ratios = [r for was_found, _, r in rows if was_found] or [math.nan]
        lines.append(
            f"| {sensor} | {symbol} | {sum(r[0] for r in rows)}/{len(rows)} | {sum(r[1] for r in rows)}/{len(rows)} "
            f"| {np.median(ratios):.4f} | {np.std(ratios):.4f} |"
        )
    return [*lines, f"found though not simulated: {others or 'none'}"]


if __name__ == "__main__":
    if sys.argv[1:2] == ["study"]:
        for preset in ("lsm9ds1", "adis16488"):
            print("\n".join(study(preset, int(sys.argv[2]) if len(sys.argv) > 2 else 20)), flush=True)
    else:
        print({key: round(value, 4) for key, value in speed().items()})
