"""A made-up walk with every diagnostic a filter may give, for the tests of the report."""

from typing import Any

import numpy as np

from bematist.frames import quaternion_from_euler
from bematist.recording import Reference
from bematist.trajectory import Trajectory

RATE_HZ = 238.0
STRIDE_S = 1.1


def walk(n: int = 5000, *, magnetometer: bool = True, **changes: Any) -> Trajectory:
    """A walk round an oval of n samples: a stride every 1.1 s, the foot standing for the first 40 % of it."""
    rng = np.random.default_rng(1)
    t = np.arange(n) / RATE_HZ
    phase = (t / STRIDE_S) % 1
    stance = (phase < 0.4).astype(np.uint8)
    swing = np.clip((phase - 0.4) / 0.6, 0, 1)
    strides = np.floor(t / STRIDE_S) + swing - np.sin(2 * np.pi * swing) / (2 * np.pi)
    angle = strides / 40 * 2 * np.pi
    position = np.stack([20 * np.cos(angle) - 20, 8 * np.sin(angle), 0.15 * np.sin(np.pi * swing) ** 2], -1)
    velocity = np.gradient(position, t, axis=0) * (stance == 0)[:, None]
    attitude = quaternion_from_euler(0.1 * np.sin(t), -0.6 * np.sin(np.pi * swing), angle + np.pi / 2)
    packed = np.zeros((n, 18))
    packed[:, [0, 3, 5]] = (0.001 * t[:, None] + 0.01) ** 2 * [1.0, 4.0, 0.5]
    packed[:, 1] = 0.5 * packed[:, 0]
    packed[:, [6, 9, 11, 12, 15, 17]] = 1e-4
    return Trajectory(
        **{
            "time": t,
            "position": position,
            "velocity": velocity,
            "attitude": attitude,
            "stance": stance,
            "packed_covariance": packed,
            "diagnostics": _diagnostics(rng, t, stance, magnetometer),
            "method": "maginav",
            "parameters": {
                "zero_velocity": {"sd": 0.02},
                "hdr": {"tolerance": 0.07},
                "magnetic": {"norm_tolerance": 0.05, "inclination_tolerance": 0.087},
            },
            "processing_s": 0.2,
            "source": "walk.csv",
            **changes,
        }
    )


def _diagnostics(rng: np.random.Generator, t: np.ndarray, stance: np.ndarray, magnetometer: bool) -> dict[str, np.ndarray]:
    n = len(t)
    standing = np.where(stance[:, None] == 1, 1.0, np.nan)
    found = {
        "stance_statistic": np.where(stance == 1, 10.0, 5000.0) * rng.lognormal(0, 0.4, n),
        "stance_threshold": np.full(n, 150.0),
        "zero_velocity_sd": np.where(stance == 1, 0.02, np.nan),
        "innovation": 0.02 * rng.standard_normal((n, 3)) * standing,
        "nis": rng.chisquare(3, n) * standing[:, 0],
        "gyro_bias": np.full((n, 3), 2e-3) * [1, -1, 0.5],
        "gyro_bias_sd": np.full((n, 3), 1e-4),
        "accel_bias": np.full((n, 3), 0.05) * [1, -1, 0.5],
        "accel_bias_sd": np.full((n, 3), 0.01),
        "bridged": np.zeros(n, np.uint8),
        "navigation_state": stance + 1,
        "pace": np.where(t < 5, 0.0, np.where(t < 15, 1.0, 2.0)),
        "zaru_nis": rng.chisquare(3, n) * np.where(t < 3, 1.0, np.nan),
        "hdr_innovation": np.where(np.arange(n) % 262 == 30, 0.05 * rng.standard_normal(n), np.nan),
    }
    if magnetometer:
        sampled = np.arange(n) % 3 == 0
        norm = np.where(sampled, 48 + rng.standard_normal(n), np.nan)
        found["magnetic_norm"] = norm
        found["magnetic_inclination"] = np.where(sampled, 1.1 + 0.05 * rng.standard_normal(n), np.nan)
        found["magnetic_gate"] = np.where(sampled, rng.integers(0, 5, n), 0).astype(np.uint8)
        found["maru_nis"] = np.where(np.arange(n) % 262 == 90, rng.chisquare(3, n), np.nan)
        found["magnetic_reference"] = np.array([48.0, 1.1])
    return {k: v if v.dtype == np.uint8 else v.astype(np.float32) for k, v in found.items()}


def turned(trajectory: Trajectory, angle: float) -> Trajectory:
    """The same walk from another start and in another direction, under another name."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    position = trajectory.position @ R.T + [3.0, -2.0, 0.5]
    return Trajectory(**{**vars(trajectory), "position": position, "velocity": trajectory.velocity @ R.T, "method": "zupt"})


def reference(trajectory: Trajectory) -> Reference:
    """The truth of a made-up walk: the walk itself."""
    return Reference(time=trajectory.time[::10], position=trajectory.position[::10], note="itself")
