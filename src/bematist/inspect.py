"""What is in a recording: what `bematist info` prints."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.earth import STANDARD_GRAVITY
from bematist.intervals import intervals
from bematist.io.guess import norms, saturated
from bematist.recording import Recording

Array = NDArray[np.float64]

REST_BLOCK_S = 0.1
REST_LEAST_S = 1.0
REST_FORCE = 0.4
"""m/s²: spread of the norm of specific force within a block at rest."""
REST_RATE = 0.15
"""rad/s: angular rate at rest, the bias taken off."""
MOST_BIAS = 0.2
"""rad/s: a larger steady rate is a turn, not a bias."""


def describe(recording: Recording) -> dict[str, Any]:
    """Everything that `bematist info` tells, as plain data (JSON): sensors, clock, units, gaps, rest, warnings."""
    r = recording
    sensors = {
        "accelerometer": _sensor(r.time, r.specific_force, "g", STANDARD_GRAVITY),
        "gyroscope": _sensor(r.time, r.angular_rate, "deg/s", math.radians(1)),
    }
    if r.has_magnetometer:
        sensors["magnetometer"] = _sensor(r.magnetic_time, r.magnetic_flux_density, "uT", 1.0)
        low, middle, high = np.nanquantile(norms(r.magnetic_flux_density), [0.01, 0.5, 0.99])
        sensors["magnetometer"]["norm_uT"] = {"low": float(low), "median": float(middle), "high": float(high)}
    if len(r.pressure_time):
        sensors["barometer"] = _sensor(r.pressure_time, r.pressure[:, None], "Pa", 1.0)
    rest = rest_periods(r)
    return {
        "source": r.source,
        "start": None if r.start_ns is None else datetime.fromtimestamp(r.start_ns / 1e9, UTC).isoformat(),
        "duration_s": r.duration_s,
        "samples": len(r),
        "sensors": sensors,
        "rest": {
            "seconds": float(sum(length for _, length in rest)),
            "norm_m_s2": _rest_norm(r, rest),
            "periods": [{"start_s": start, "length_s": length} for start, length in rest],
        },
        "reference": _reference(r),
        "clock": [n for n in r.notes if n.startswith("Clock")],
        "units": [n for n in r.notes if n.startswith("Units")],
        "notes": [n for n in r.notes if not n.startswith(("Clock", "Units"))],
        "warnings": list(r.warnings),
    }


def _sensor(time: Array, values: Array, unit: str, scale: float) -> dict[str, Any]:
    """One sensor on the instants at which it has a sample."""
    there = np.isfinite(values).all(1)
    t, x = time[there], values[there]
    out: dict[str, Any] = {"samples": len(t), "missing": int((~there).sum()), "unit": unit, "rate_hz": None}
    if len(t) > 1:
        d = np.diff(t)
        step = float(np.median(d))
        # On an even clock half a step late is a sample that is not there; uneven steps vary more than that.
        uneven = float(np.mean(np.abs(d / step - np.round(d / step)) > 0.1)) > 0.1
        gap = d > (3.0 if uneven else 1.5) * step
        regular = d[~gap]
        out |= {
            "rate_hz": 1 / step,
            "jitter_ms": 1e3 * float(np.std(regular)),
            "steps_ms": [1e3 * float(d.min()), 1e3 * float(d.max())],
            "gaps": int(gap.sum()),
            "lost": int(np.round(d[gap] / step - 1).sum()),
            "longest_gap_s": float(d.max()) if gap.any() else 0.0,
        }
    if len(t):
        out["peak"] = float(np.abs(x).max() / scale)
        out["saturated"] = [{"axis": "xyz"[axis], "at": extreme / scale, "samples": count} for axis, extreme, count in saturated(x)]
    return out


def rest_periods(recording: Recording, least_s: float = REST_LEAST_S) -> list[tuple[float, float]]:
    """Start and length (s) of the stretches without motion of at least `least_s`."""
    r = recording
    good = np.isfinite(r.specific_force).all(1) & np.isfinite(r.angular_rate).all(1)
    t = r.time[good]
    if len(t) < 3:
        return []
    n = max(2, round(REST_BLOCK_S / float(np.median(np.diff(t)))))
    blocks = len(t) // n
    if blocks < 1:
        return []
    force = norms(r.specific_force[good])[: blocks * n].reshape(blocks, n)
    rate = r.angular_rate[good][: blocks * n]
    bias = _bias(rate.reshape(blocks, n, 3))
    turning = norms(rate - bias).reshape(blocks, n)
    start, end = t[: blocks * n].reshape(blocks, n)[:, 0], t[: blocks * n].reshape(blocks, n)[:, -1]
    still = (force.std(1) < REST_FORCE) & (np.sqrt((turning**2).mean(1)) < REST_RATE) & (end - start < 3 * REST_BLOCK_S)
    edges = intervals(still)
    spans = [(float(start[a]), float(end[b - 1] - start[a])) for a, b in edges]
    return [(begin, length) for begin, length in spans if length >= least_s]


def _bias(blocks: Array) -> Array:
    """Gyroscope bias (3,), rad/s: the mean rate of the tenth of blocks (B,n,3) that vary least; 0 where that is a turn."""
    spread = blocks.std(1).sum(1)
    quiet = spread <= np.quantile(spread, 0.1)
    bias = np.median(blocks[quiet].mean(1), axis=0)
    return bias if np.linalg.norm(bias) < MOST_BIAS else np.zeros(3)


def _rest_norm(r: Recording, rest: list[tuple[float, float]]) -> float | None:
    inside = np.zeros(len(r), bool)
    for start, length in rest:
        inside |= (r.time >= start) & (r.time <= start + length)
    inside &= np.isfinite(r.specific_force).all(1)
    return float(np.median(norms(r.specific_force[inside]))) if inside.any() else None


def _reference(r: Recording) -> dict[str, Any] | None:
    if r.reference is None:
        return None
    return {"points": len(r.reference.position), "note": r.reference.note, "mirrored": r.reference.mirrored}


def lines(description: dict[str, Any]) -> list[tuple[str, str]]:
    """The description as (label, text) lines to print."""
    d = description
    out = [("file", str(d["source"]))]
    if d["start"]:
        out.append(("start", d["start"]))
    out.append(("duration", f"{d['duration_s']:.2f} s, {d['samples']} rows"))
    out += [(name, _sensor_line(s)) for name, s in d["sensors"].items()]
    if "magnetometer" in d["sensors"]:
        n = d["sensors"]["magnetometer"]["norm_uT"]
        out.append(("magnetic norm", f"{n['low']:.1f} to {n['high']:.1f} µT, median {n['median']:.1f} µT"))
    else:
        out.append(("magnetometer", "none"))
    out += [(label.lower(), text) for label, _, text in (n.partition(": ") for n in [*d["clock"], *d["units"], *d["notes"]])]
    out.append(("rest", _rest_line(d["rest"])))
    if d["reference"]:
        mirror = ", may be mirrored" if d["reference"]["mirrored"] else ""
        out.append(("reference", f"{d['reference']['points']} points, {d['reference']['note']}{mirror}"))
    return out + [("warning", w) for w in d["warnings"]]


def _sensor_line(s: dict[str, Any]) -> str:
    parts = [f"{s['samples']} samples"]
    if s["rate_hz"] is not None:
        parts.append(f"{s['rate_hz']:.5g} Hz")
        parts.append(f"jitter {s['jitter_ms']:.3f} ms")
        parts.append(f"{s['gaps']} gaps, {s['lost']} lost, longest {s['longest_gap_s']:.4g} s" if s["gaps"] else "no gap")
    if s["missing"]:
        parts.append(f"{s['missing']} rows without a sample")
    if s["samples"]:
        parts.append(f"peak {s['peak']:.4g} {s['unit'].replace('uT', 'µT').replace('deg/s', '°/s')}")
        at = [f"{x['axis']} at {x['at']:.4g} ({x['samples']} samples)" for x in s["saturated"]]
        parts.append("saturated: " + ", ".join(at) if at else "not saturated")
    return "; ".join(parts)


def _rest_line(rest: dict[str, Any]) -> str:
    if not rest["periods"]:
        return f"no stretch of {REST_LEAST_S:g} s without motion"
    shown = ", ".join(f"{p['length_s']:.1f} s from {p['start_s']:.1f} s" for p in rest["periods"][:6])
    more = f" and {len(rest['periods']) - 6} more" if len(rest["periods"]) > 6 else ""
    return f"{shown}{more}; norm {rest['norm_m_s2']:.3f} m/s²"
