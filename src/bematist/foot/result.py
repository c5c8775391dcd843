"""From what the kernels wrote to a `Trajectory`, and what is suspicious about it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import hard_iron
from bematist.intake import bridging_warnings
from bematist.kernels import layout as kernel
from bematist.trajectory import Trajectory
from bematist.updates import HardIronParameters

Array = NDArray[np.float64]

PHONE = (
    "A phone recorded this, and the method is for a sensor on the shoe: unless the phone was strapped to the shoe, the path means nothing. "
    "For a phone in the hand take the method hand (-m hand)."
)


def judge(nav: Array, diagnostics: NDArray[np.float32], prm: Array, iron: HardIronParameters) -> list[str]:
    """Warnings about the result."""
    stood = np.isfinite(diagnostics[:, kernel.ZV_SD])
    found = bridging_warnings(nav[:, 0], diagnostics[:, kernel.BRIDGED], "path")
    if not stood.any():
        found.append(
            "No stance was found: the path is dead reckoning without any correction and means nothing after a few seconds. Look at "
            "`bematist stance` and choose a threshold; check the units."
        )
    speed = float(np.sqrt(np.einsum("ij,ij->i", nav[:, 4:7], nav[:, 4:7]).max()))
    if speed > 15:
        found.append(f"The speed of the foot reaches {speed:.0f} m/s: stances are missed or the units are wrong.")
    gate = diagnostics[:, kernel.GATE]
    if prm[kernel.MAGNETIC_USE] != kernel.MAGNETIC_OFF and (gate > 0).any():
        share = float((gate[stood & (gate > 0)] == kernel.USED).mean()) if (stood & (gate > 0)).any() else 0.0
        if share < 0.05:
            found.append(
                f"Only {100 * share:.1f} % of the magnetometer samples in stance passed the gates: the field is disturbed, or was "
                "at the start."
            )
    return [*found, *hard_iron.judge(nav[:, 0], diagnostics[:, kernel.IRON_DIAG :], iron)]


def trajectory(nav: Array, d: NDArray[np.float32], S: Array | None, **fields: Any) -> Trajectory:
    """Results (N,29) and diagnostics (N,DIAG or more) of the kernels (`kernels.layout`) by their names."""
    named: dict[str, NDArray[Any]] = {
        "stance_statistic": d[:, kernel.STATISTIC],
        "stance_threshold": d[:, kernel.LIMIT],
        "zero_velocity_sd": d[:, kernel.ZV_SD],
        "innovation": d[:, kernel.INNOVATION : kernel.INNOVATION + 3],
        "nis": d[:, kernel.NIS],
        "magnetic_norm": d[:, kernel.NORM],
        "magnetic_inclination": d[:, kernel.INCLINATION],
        "magnetic_gate": d[:, kernel.GATE].astype(np.uint8),
        "navigation_state": d[:, kernel.STATE].astype(np.uint8),
        "bridged": d[:, kernel.BRIDGED].astype(np.uint8),
        "gyro_bias": d[:, kernel.GYRO_BIAS : kernel.GYRO_BIAS + 3],
        "gyro_bias_sd": d[:, kernel.GYRO_BIAS_SD : kernel.GYRO_BIAS_SD + 3],
        "accel_bias": d[:, kernel.ACCEL_BIAS : kernel.ACCEL_BIAS + 3],
        "accel_bias_sd": d[:, kernel.ACCEL_BIAS_SD : kernel.ACCEL_BIAS_SD + 3],
        "zaru_nis": d[:, kernel.ZARU_NIS],
        "hdr_innovation": d[:, kernel.HDR_INNOVATION],
        "maru_nis": d[:, kernel.MARU_NIS],
        "pace": d[:, kernel.PACE],
        **hard_iron.diagnostics(d[:, kernel.IRON_DIAG :]),
    }
    if S is not None:
        named["magnetic_reference"] = np.array([S[kernel.FIELD_NORM], S[kernel.FIELD_INCLINATION]])
    return Trajectory(
        time=nav[:, 0],
        position=nav[:, 1:4],
        velocity=nav[:, 4:7],
        attitude=nav[:, 7:11],
        stance=np.isfinite(d[:, kernel.ZV_SD]).astype(np.uint8),
        packed_covariance=nav[:, 11:29],
        diagnostics=named,
        **fields,
    )
