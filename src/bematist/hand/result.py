"""From what the kernels wrote to an `Attitude`, and what is suspicious about it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.attitudes import Attitude
from bematist.hand.parameters import HandParameters
from bematist.kernels import hand_layout as kernel
from bematist.kernels.stance import HELD_SAMPLE, MISSING

Array = NDArray[np.float64]

VERDICTS = ("no sample", "changing", "local", "earth", "fault", "unused")
"""What became of a sample of a field, by its number in the diagnostics."""


def judge(nav: Array, diagnostics: NDArray[np.float32], p: HandParameters, has_magnetometer: bool) -> list[str]:
    """Warnings about the result."""
    found = []
    flag = diagnostics[:, kernel.BRIDGED]
    known = np.flatnonzero(flag != MISSING)
    gaps = np.diff(nav[known, 0])[flag[known][1:] == kernel.BRIDGED_OVER]
    if len(gaps):
        found.append(
            f"{len(gaps)} gap(s) of {gaps.sum():.2f} s in all were bridged, the longest {gaps.max():.2f} s: the heading is in doubt from "
            "there on."
        )
    for value, word in ((HELD_SAMPLE, "held over missing values"), (MISSING, "skipped, values missing for too long")):
        if n := int((flag == value).sum()):
            found.append(f"{n} of {len(nav)} samples were {word}.")
    if p.attitude.correction == "kalman" and p.attitude.magnetic.use:
        verdict = diagnostics[:, kernel.FIELD_M + kernel.VERDICT]
        faults = int((verdict == kernel.FAULT).sum())
        used = int(np.isin(verdict, (kernel.LOCAL_USED, kernel.EARTH_USED)).sum())
        if not has_magnetometer:
            found.append("There is no magnetometer: the heading is the gyroscope's alone, and drifts.")
        elif faults > used:
            found.append(
                f"The magnetic field contradicted the filter more often ({faults} samples) than it agreed ({used}): it is disturbed, or "
                "the magnetometer is not calibrated."
            )
    return found


def attitude(nav: Array, d: NDArray[np.float32], p: HandParameters, **fields: Any) -> Attitude:
    """Results (N,11) and diagnostics (N,32) of the kernels (`kernels.hand_layout`) by their names."""
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
    return Attitude(
        time=nav[:, 0],
        attitude=nav[:, 1:5],
        gyro_bias=d[:, kernel.GYRO_BIAS : kernel.GYRO_BIAS + 3].astype(float),
        packed_covariance=None if p.attitude.correction == "replace" else nav[:, 5:11],
        diagnostics=named,
        parameters=p.model_dump(),
        **fields,
    )
