"""The detector over a whole recording, without a filter: what `bematist steps` shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist import stance
from bematist.earth import STANDARD_GRAVITY
from bematist.errors import DataError
from bematist.frames import matrix_from_quaternion
from bematist.kernels import stance as stance_kernel
from bematist.kernels import steps as kernel
from bematist.kernels import steps_layout as at
from bematist.recording import Recording
from bematist.steps.parameters import StepParameters
from bematist.steps.setup import kernel_parameters, workspace
from bematist.updates import GapParameters

Array = NDArray[np.float64]
Codes = NDArray[np.uint8]

MOTIONS = ("static", "walking", "running", "stairs")
CARRYING = ("texting", "phoning", "swinging", "pocket", "bag")
FEATURES = (
    "force_rms",
    "rate_rms",
    "periodicity",
    "periodicity_asked",
    "period_frequency",
    "stride_rotation",
    "screen_up",
    "top_up",
    "climb_speed",
    "step_band",
    "acceleration",
)
"""Columns of `StepAnalysis.features`. rms acceleration (m/s²) and angular rate (rad/s); autocorrelation coefficient at the step period, how
large it must be where a walk begins, and that frequency (Hz); how much the rotation is the opposite of that a step ago; cosines between up
and the screen's normal and the upper end; speed of climbing (m/s); band-passed and whole acceleration (m/s²), of the last full cell."""


@dataclass(frozen=True, eq=False)
class StepAnalysis:
    """Steps and modes of a recording.

    Attributes
    ----------
    time : (N,) s, that of the recording.
    count : (N,) how many steps were counted at each sample: several where a walk was confirmed.
    frequency : (N,) step frequency, Hz; 0 where nobody walks.
    motion, carrying : (N,) index into MOTIONS, CARRYING.
    features : (N,11) what was decided on, FEATURES.
    event_time : (M,) instant of each step, s.
    event_confirmed : (M,) when it was counted, s.
    event_frequency : (M,) step frequency, Hz.
    event_size : (M,) height of the step's peak in the band-passed acceleration, m/s².
    event_motion, event_carrying : (M,) modes when it was counted.
    """

    time: Array
    count: Codes
    frequency: Array
    motion: Codes
    carrying: Codes
    features: Array
    event_time: Array
    event_confirmed: Array
    event_frequency: Array
    event_size: Array
    event_motion: Codes
    event_carrying: Codes
    parameters: StepParameters

    def feature(self, name: str) -> Array:
        """One of FEATURES (N,)."""
        return self.features[:, FEATURES.index(name)]


def analyse(
    recording: Recording,
    parameters: StepParameters | None = None,
    *,
    attitude: Array | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> StepAnalysis:
    """Steps and modes of a whole recording. attitude (N,4) wxyz, where it is known; gravity in m/s².

    Raises
    ------
    DataError
        There are no samples.
    """
    if not len(recording):
        raise DataError(f"{recording.source or 'The recording'} has no samples.")
    p = parameters or StepParameters()
    gap_s = GapParameters().seconds(recording.rate_hz if len(recording) > 1 else 100.0)
    up = None if attitude is None else matrix_from_quaternion(attitude)[:, 2]
    rows = recording.samples(pressure=True)
    out, events = detect(rows[:, :10], p, up=up, pressure=np.ascontiguousarray(rows[:, 10]), gravity=gravity, gap_s=gap_s)
    column = out.T
    return StepAnalysis(
        time=recording.time,
        count=column[at.OUT_COUNT].astype(np.uint8),
        frequency=column[at.OUT_FREQUENCY],
        motion=column[at.OUT_MOTION].astype(np.uint8),
        carrying=column[at.OUT_CARRYING].astype(np.uint8),
        features=out[:, at.OUT_FEATURES :],
        event_time=events[:, at.EVENT_TIME],
        event_confirmed=events[:, at.EVENT_CONFIRMED],
        event_frequency=events[:, at.EVENT_FREQUENCY],
        event_size=events[:, at.EVENT_SIZE],
        event_motion=events[:, at.EVENT_MOTION].astype(np.uint8),
        event_carrying=events[:, at.EVENT_CARRYING].astype(np.uint8),
        parameters=p,
    )


def detect(
    rows: Array,
    parameters: StepParameters,
    *,
    up: Array | None = None,
    pressure: Array | None = None,
    gravity: float = STANDARD_GRAVITY,
    gap_s: float = 0.02,
) -> tuple[Array, Array]:
    """The kernel over sample rows (N,10): its results (N, `steps_layout.OUT`) and its events (M, `steps_layout.EVENT_ROW`).

    up (N,3): the direction up in b, where an attitude is known. gap_s: missing values are held for so long.
    """
    memory = np.zeros(stance_kernel.HEAD_SIZE)
    memory[stance_kernel.HELD : stance_kernel.HELD + 2] = -np.inf
    columns, flags = stance.filled(memory, rows, gap_s)
    out, events = results(rows[:, 0], parameters)
    written = kernel.run(
        memory,
        workspace(),
        kernel_parameters(parameters, gravity=gravity),
        columns,
        flags,
        np.empty((3, 0)) if up is None else np.ascontiguousarray(up.T),
        np.empty(0) if pressure is None else pressure,
        out,
        events,
    )
    return out, events[:written].copy()


def results(time: Array, parameters: StepParameters) -> tuple[Array, Array]:
    """Room for the results of samples at times (N,), and for the steps that may be counted in them."""
    return np.empty((len(time), at.OUT)), np.empty((most(time, parameters), at.EVENT_ROW))


def most(time: Array, parameters: StepParameters) -> int:
    """The most steps that may be counted at times (N,)."""
    duration = float(time[-1] - time[0]) if len(time) else 0.0
    return int(parameters.detection.fastest_hz / 0.5 * duration) + 2 * at.MAX_NEW
