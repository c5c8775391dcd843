"""A short walk with exact inertial readings, made here and not by the package: the ground on which broken files are built."""

import numpy as np

G = 9.80665
Columns = dict[str, np.ndarray]


def walk(rate_hz: float = 100.0, strides: int = 4, rest_s: float = 1.5) -> Columns:
    """Columns of a canonical recording: rest, strides of 1 s and 1.2 m along x, rest. The foot pitches in swing.

    The field is (0, 20, -40) µT in the world, every sample.
    """
    n = round((2 * rest_s + strides) * rate_hz)
    t = np.arange(n) / rate_hz
    phase = np.clip((t - rest_s) % 1.0 / 0.55, 0, 1) * ((t >= rest_s) & (t < rest_s + strides))
    swing = (phase > 0) & (phase < 1)
    tau, T = np.where(swing, phase, 0.0), 0.55
    ax = 1.2 * (60 * tau - 180 * tau**2 + 120 * tau**3) / T**2 * swing
    az = 0.08 * np.pi**2 * 2 / T**2 * np.cos(2 * np.pi * tau) * swing
    pitch = 0.5 * np.sin(np.pi * tau) ** 2 * np.sin(2 * np.pi * tau)
    wy = np.gradient(pitch, t)
    c, s = np.cos(pitch), np.sin(pitch)
    force = np.column_stack([c * ax - s * (az + G), 0 * t, s * ax + c * (az + G)])
    field = np.column_stack([s * 40, 20 + 0 * t, -c * 40])
    noise = np.random.default_rng(7)
    force += noise.normal(0, 0.02, force.shape)
    rate = np.column_stack([0 * t, wy, 0 * t]) + noise.normal(0, 0.002, force.shape)
    field += noise.normal(0, 0.1, force.shape)
    names = ("fx", "fy", "fz", "wx", "wy", "wz", "mx", "my", "mz")
    return {"time": t, **dict(zip(names, np.hstack([force, rate, field]).T, strict=True))}


def csv(columns: Columns, separator: str = ",", end: str = "\n") -> str:
    """Canonical CSV text; NaN is an empty cell."""
    rows = zip(*columns.values(), strict=True)
    lines = [separator.join("" if np.isnan(v) else repr(float(v)) for v in row) for row in rows]
    return end.join([separator.join(columns), *lines, ""])
