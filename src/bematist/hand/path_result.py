"""From what the kernels wrote to a `Trajectory` with its steps, and what is suspicious about it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.hand.result import diagnostics
from bematist.kernels import hand_layout
from bematist.kernels import pdr_layout as at
from bematist.recording import Recording
from bematist.steps import CARRYING, MOTIONS
from bematist.trajectory import Steps, Trajectory

Array = NDArray[np.float64]


STRIKE, SWING = 30.0, 6.0
"""m/s², rad/s: a shoe exceeds both in nearly every second of a walk (half to all of them in nine recordings), a hand that walks in none."""


def worn_on_shoe(recording: Recording) -> list[str]:
    """A warning where the signals are those of a shoe."""
    if not len(recording) or recording.phone:
        return []
    second = np.floor(recording.time - recording.time[0]).astype(int)
    peaks = [np.zeros(second[-1] + 1) for _ in range(2)]
    for peak, values in zip(peaks, (recording.specific_force, recording.angular_rate), strict=True):
        np.fmax.at(peak, second, np.sqrt(np.square(values).sum(1)))
    share = float(((peaks[0] > STRIKE) & (peaks[1] > SWING)).sum() / (1 + np.count_nonzero(np.diff(second))))
    if share < 0.25:
        return []
    return [
        f"In {100 * share:.0f} % of the seconds the sensor strikes and swings as a shoe does, of which the methods of the hand count no "
        "steps: for a sensor on the shoe take the method foot (-m foot)."
    ]


def judge(nav: Array, d: NDArray[np.float32], aimed: str | None) -> list[str]:
    """Warnings about the path. aimed: the way of carrying whose axis was turned to the heading of the start, if one was."""
    stepped = np.flatnonzero(d[:, at.STEPS])
    if not len(stepped):
        return [
            f"No step was found in {nav[-1, 0] - nav[0, 0]:.0f} s: the path stays where it began. Look at `bematist steps`; for a sensor "
            "on a shoe take the method foot, and check the unit of the accelerometer."
        ]
    first = CARRYING[int(d[stepped[0], at.CARRYING])]
    if aimed is not None and first != aimed:
        return [
            f'The heading of the start, or East, is that of the axis for "{aimed}", but the first steps were found with "{first}": the '
            f'path may be turned as a whole. Set direction.first = "{first}" if the device was carried so from the beginning.'
        ]
    return []


def steps(rows: Sequence[Array]) -> Steps:
    """Rows of the kernel's list of steps (`pdr_layout.STEP_ROW`), in pieces, by their names."""
    r = np.concatenate([np.empty((0, at.STEP_ROW)), *rows])
    return Steps(
        time=r[:, at.S_TIME],
        counted=r[:, at.S_COUNTED],
        length=r[:, at.S_LENGTH],
        length_sd=r[:, at.S_LENGTH_SD],
        frequency=r[:, at.S_FREQUENCY],
        direction=r[:, at.S_DIRECTION],
        direction_sd=r[:, at.S_DIRECTION_SD],
        motion=np.array(MOTIONS)[r[:, at.S_MOTION].astype(int)],
        carrying=np.array(CARRYING)[r[:, at.S_CARRYING].astype(int)],
    )


def trajectory(nav: Array, d: NDArray[np.float32], attitude: NDArray[np.float32], **fields: Any) -> Trajectory:
    """Results (N,29) and diagnostics (N,5) of the path's kernel, and diagnostics (N,32) of the attitude filter, by their names."""
    named: dict[str, NDArray[Any]] = {
        "steps_counted": d[:, at.STEPS].astype(np.uint8),
        "step_frequency": d[:, at.STEP_FREQUENCY],
        "motion": d[:, at.MOTION].astype(np.uint8),
        "carrying": d[:, at.CARRYING].astype(np.uint8),
        "pressure_height": d[:, at.PRESSURE_HEIGHT],
        "gyro_bias": attitude[:, hand_layout.GYRO_BIAS : hand_layout.GYRO_BIAS + 3],
    }
    return Trajectory(
        time=nav[:, 0],
        position=nav[:, 1:4],
        velocity=nav[:, 4:7],
        attitude=nav[:, 7:11],
        stance=(d[:, at.STEPS] > 0).astype(np.uint8),
        packed_covariance=nav[:, 11:29],
        diagnostics=named | diagnostics(attitude),
        **fields,
    )
