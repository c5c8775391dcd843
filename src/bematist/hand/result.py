"""From what the kernels wrote to an `Attitude`, and what is suspicious about it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import hard_iron
from bematist.attitudes import Attitude
from bematist.hand.parameters import HandParameters
from bematist.intake import bridging_warnings
from bematist.kernels import hand_layout as kernel

Array = NDArray[np.float64]


def room(n: int, p: HandParameters) -> NDArray[np.float32]:
    """Room for the diagnostics of n samples."""
    return np.empty((n, kernel.DIAG + hard_iron.extra_columns(p.attitude.magnetic.hard_iron)), np.float32)


def judge(nav: Array, d: NDArray[np.float32], p: HandParameters, has_magnetometer: bool, doubtful: str = "heading") -> list[str]:
    """Warnings about the result; `doubtful` is what a gap puts in doubt."""
    found = bridging_warnings(nav[:, 0], d[:, kernel.BRIDGED], doubtful)
    if p.attitude.correction != "none" and p.attitude.magnetic.use:
        verdict = d[:, kernel.FIELD_M + kernel.VERDICT]
        faults = int((verdict == kernel.FAULT).sum())
        used = int(np.isin(verdict, (kernel.LOCAL_USED, kernel.EARTH_USED)).sum())
        if not has_magnetometer:
            found.append("There is no magnetometer: the heading is the gyroscope's alone, and drifts.")
        elif faults > used:
            found.append(
                f"The magnetic field contradicted the filter more often ({faults} samples) than it agreed ({used}): it is disturbed, or "
                "the magnetometer is not calibrated."
            )
    return [*found, *hard_iron.judge(nav[:, 0], d[:, kernel.IRON_DIAG :], p.attitude.magnetic.hard_iron)]


def diagnostics(d: NDArray[np.float32]) -> dict[str, NDArray[Any]]:
    """Diagnostics (N,32 or more) of the kernels (`kernels.hand_layout`) by their names."""
    named: dict[str, NDArray[Any]] = {
        "gyro_bias_sd": d[:, kernel.GYRO_BIAS_SD : kernel.GYRO_BIAS_SD + 3],
        "accel_bias": d[:, kernel.ACCEL_BIAS : kernel.ACCEL_BIAS + 3],
        "accel_bias_sd": d[:, kernel.ACCEL_BIAS_SD : kernel.ACCEL_BIAS_SD + 3],
        "bridged": d[:, kernel.BRIDGED].astype(np.uint8),
        "heading_innovation": d[:, kernel.HEADING_NU],
    }
    for word, o in (("magnetic", kernel.FIELD_M), ("force", kernel.FIELD_F)):
        named |= {
            f"{word}_statistic": d[:, o + kernel.STATISTIC],
            f"{word}_innovation": d[:, o + kernel.NU : o + kernel.NU + 3],
            f"{word}_nis": d[:, o + kernel.NIS],
            f"{word}_gradient_nis": d[:, o + kernel.GRADIENT_NIS],
            f"{word}_verdict": d[:, o + kernel.VERDICT].astype(np.uint8),
        }
    return named | hard_iron.diagnostics(d[:, kernel.IRON_DIAG :])


def attitude(nav: Array, d: NDArray[np.float32], p: HandParameters, **fields: Any) -> Attitude:
    """Results (N,11) and diagnostics (N,32) of the kernels (`kernels.hand_layout`) by their names."""
    return Attitude(
        time=nav[:, 0],
        attitude=nav[:, 1:5],
        gyro_bias=d[:, kernel.GYRO_BIAS : kernel.GYRO_BIAS + 3].astype(float),
        packed_covariance=None if p.attitude.correction == "replace" else nav[:, 5:11],
        diagnostics=diagnostics(d),
        parameters=p.model_dump(),
        **fields,
    )
