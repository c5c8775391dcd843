"""The papers' tables of noises, simulated and identified: `python benchmarks/allan.py study`.

Each case is one rest of five hours of one row of a table, all three axes alike, with a turn-on bias and quanta as the sensor has them.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import binom

import bematist as bm
from bematist.earth import STANDARD_GRAVITY
from bematist.reproduce.page import Page
from bematist.reproduce.study import Found, Part, Results, Settings, Study
from bematist.simulate import SENSORS, Sensor, simulate

HOURS = 5.0
_MG, _DEG = 1e-3 * STANDARD_GRAVITY, math.radians(1.0)
FLOOR = math.sqrt(2 * math.log(2) / math.pi)


def magyq(n: float, b: float, s: float, t: float, arw: float, bi: float, rrw: float) -> Sensor:
    """A row of MAGYQ's Tables 1 and 2 with the errata's units: mg/√Hz, mg, mg, s; °/s/√Hz, °/s, °/s/√h. Its floor is 0.664 B."""
    return SENSORS["adis16488"].override(
        {
            "velocity_random_walk": n * _MG,
            "accel_bias_instability": b / FLOOR * _MG,
            "accel_correlated_sd": s * _MG,
            "accel_correlation_s": t,
            "angle_random_walk": arw * _DEG,
            "gyro_bias_instability": bi / FLOOR * _DEG,
            "gyro_rate_random_walk": rrw / 60 * _DEG,
        }
    )


PRESETS = (SENSORS["lsm9ds1"], SENSORS["adis16488"])
TABLES: Mapping[str, Sensor] = {
    "MAGINAV Table 3, `lsm9ds1`": PRESETS[0],
    "MAGYQ Tables 1-2, means, `adis16488`": PRESETS[1],
    "MAGYQ Tables 1-2, X": magyq(0.0650, 0.1223, 0.1484, 18.16, 0.00413, 0.00117, 0.00158),
    "MAGYQ Tables 1-2, Y": magyq(0.0717, 0.0326, 0.0373, 48.05, 0.00445, 0.00121, 0.00142),
    "MAGYQ Tables 1-2, Z": magyq(0.0639, 0.0626, 0.0881, 197.2, 0.00442, 0.00105, 0.00157),
}


def truths(s: Sensor) -> dict[tuple[str, str], float]:
    """What the simulated sensor has: coefficients in SI. Rounding to a quantum adds white noise."""

    def white(density: float, quantum: float, rate_hz: float) -> float:
        return math.sqrt(density**2 + quantum**2 / 12 / rate_hz)

    found = {
        ("accelerometer", "N"): white(s.velocity_random_walk, s.accel_lsb, s.rate_hz),
        ("accelerometer", "B"): s.accel_bias_instability,
        ("accelerometer", "s"): s.accel_correlated_sd,
        ("accelerometer", "T"): s.accel_correlation_s if s.accel_correlated_sd else 0.0,
        ("gyroscope", "N"): white(s.angle_random_walk, s.gyro_lsb, s.rate_hz),
        ("gyroscope", "B"): s.gyro_bias_instability,
        ("gyroscope", "K"): s.gyro_rate_random_walk,
        ("magnetometer", "N"): white(s.magnetic_noise_density, s.magnetic_lsb, s.magnetometer_rate_hz),
    }
    return {key: value for key, value in found.items() if value}


def cases(seeds: int) -> list[Settings]:
    """`seeds` rests of the presets; of a row of MAGYQ's tables, which is one axis there, a third, so that it has as many axes."""
    return [
        {"table": name, "seed": seed, "hours": HOURS}
        for seed in range(seeds)
        for name, sensor in TABLES.items()
        if sensor in PRESETS or 3 * seed < seeds
    ]


def compute(case: Settings) -> Found:
    """One rest, identified as a user does it: a row for each coefficient found, and for each that was simulated."""
    sensor = TABLES[case["table"]]
    found = bm.allan(simulate("still", sensor, case["seed"], rest_s=3600 * case["hours"], flicker_from_s=0.0))
    keys = ("sensor", "axis", "symbol", "found", "value", "low", "high", "unit", "sheet_value", "sheet_unit")
    rows = [{key: row[key] for key in keys} for row in found.coefficients() if row["symbol"] != "0.664 B"]
    known = truths(sensor)
    told = {(r["sensor"], r["axis"], r["symbol"]) for r in rows}
    rows += [
        {"sensor": s, "axis": a, "symbol": c, "found": False, "value": None, "low": None, "high": None, "unit": ""}
        for s, c in known
        for a in "xyz"
        if (s, a, c) not in told and c != "T"  # a correlation time is told only where there is a process
    ]
    return Found([{**r, "truth": known.get((r["sensor"], r["symbol"]))} for r in rows if r["found"] or (r["sensor"], r["symbol"]) in known])


def held(row: Mapping[str, Any]) -> bool:
    """Whether the interval of a coefficient, or the bound of one that was not found, holds the truth."""
    return row["high"] is not None and row["low"] <= row["truth"] <= row["high"]


def lines(results: Results) -> list[str]:
    """The table of docs/allan.md."""
    out = [
        "| table | | | truth | median found | half width of the 95 % interval, median | found | held | expected |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    invented: Counter[str] = Counter()
    for name in TABLES:
        rows = [r for c in results.where(table=name) for r in c.rows]
        invented.update(f"{r['sensor']} {r['symbol']}" for r in rows if r["truth"] is None)
        before = name
        for (sensor, symbol), truth in truths(TABLES[name]).items():
            own = [r for r in rows if (r["sensor"], r["symbol"]) == (sensor, symbol)]
            out.append(f"| {before} | {sensor} | {symbol} | {_numbers(own, truth)}")
            before = ""
    curves = 9 * len(results.cases)
    made_up = ", ".join(f"{what} {n}" for what, n in sorted(invented.items())) or "none"
    return [*out, "", f"Found in {curves} curves though not simulated: {made_up}."]


def _numbers(rows: list[dict[str, Any]], truth: float) -> str:
    low, high = (int(x) for x in binom.interval(0.95, len(rows), 0.95))
    seen = [r for r in rows if r["found"]]
    told = sum(map(held, rows))
    if not seen:
        bound = float(np.median([r["high"] for r in rows]))
        return f"{truth:.4g} {rows[0]['unit']} | not found; bound {bound:.3g} | | 0/{len(rows)} | {told}/{len(rows)} | {low}-{high} |"
    unit, factor = seen[0]["sheet_unit"], seen[0]["sheet_value"] / seen[0]["value"]
    middle = float(np.median([r["value"] for r in seen]))
    width = float(np.median([(r["high"] - r["low"]) / 2 / r["value"] for r in seen]))
    return (
        f"{truth * factor:.4g} {unit} | {middle * factor:.4g} ({100 * (middle / truth - 1):+.2f} %) | {100 * width:.2g} % "
        f"| {len(seen)}/{len(rows)} | {told}/{len(rows)} | {low}-{high} |"
    )


def show(results: Results, page: Page) -> None:
    page.text("\n".join(lines(results)))


STUDY = Study(
    name="allan",
    title="Noises of the papers' tables, simulated and identified",
    paper="MAGYQ Tables 1-2, MAGINAV Table 3",
    introduction=("Rests of five hours, identified by `bm.allan`.",),
    parts=(Part("tables", "Coefficients and their intervals", cases, compute, show, 12.0),),
    claims=lambda results: [],
)
