"""Stance detectors: when does the foot stand, and how much is a standing foot to be believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from bematist.arrays import median
from bematist.earth import STANDARD_GRAVITY
from bematist.kernels import stance as kernel
from bematist.parameters import Parameters
from bematist.recording import Recording
from bematist.updates import GapParameters

Array = NDArray[np.float64]

DETECTORS = {
    "shoe": kernel.SHOE,
    "ared": kernel.ARED,
    "amvd": kernel.AMVD,
    "amag": kernel.AMAG,
    "gyro": kernel.GYRO_NORM,
}
RULES = {"absolute": kernel.ABSOLUTE, "relative": kernel.RELATIVE, "adaptive": kernel.ABSOLUTE}
"""How a sample is judged; with the adaptive rule the filter moves the threshold."""


@dataclass(frozen=True)
class Defaults:
    """What suits one detector: window in s, threshold for walking, floor of the relative rule, thresholds for a slow and a running foot."""

    window_s: float
    threshold: float
    floor: float
    slow: float
    running: float


DEFAULTS = {
    "shoe": Defaults(0.035, 150.0, 5.0, 100.0, 1000.0),
    "ared": Defaults(0.035, 100.0, 3.0, 70.0, 700.0),
    "amvd": Defaults(0.1, 2.0, 0.07, 1.4, 14.0),
    "amag": Defaults(0.1, 1.0, 0.03, 0.7, 7.0),
    "gyro": Defaults(0.05, 0.6, 0.1, 0.5, 1.5),
}
"""The statistic of `gyro` is in rad/s, the others have no unit."""


class PaceParameters(Parameters):
    """Adaptive rule: slow, walking or running by the speed of the foot, its mean over a trailing window, and of it the largest in one."""

    window_s: float = Field(default=1.0, gt=0, le=10, description="Window of the mean and of the largest, s. Longer: a class lasts.")
    walk_speed: float = Field(default=0.9, gt=0, description="Walking from this speed on, m/s; slow below.")
    run_speed: float = Field(default=2.0, gt=0, description="Running from this speed on, m/s. Lower: a fast walk counts as a run.")
    hysteresis: float = Field(
        default=0.1, ge=0, lt=1, description="A class is left this much below the speed that leads to it, relative. Larger: fewer changes."
    )
    slow_threshold: float | None = Field(
        default=None, gt=0, description="Threshold of a slow foot; none: the detector's own. Larger: more stance, a shorter path."
    )
    run_threshold: float | None = Field(
        default=None, gt=0, description="Threshold of a running foot; none: the detector's own. Smaller: stances are missed."
    )


class StanceParameters(Parameters):
    """How the stance phase is found. Window and look-ahead are in seconds, so that they mean the same at every rate."""

    detector: Literal["shoe", "ared", "amvd", "amag", "gyro"] = Field(
        default="shoe",
        description="Test statistic: shoe (MAGINAV eqs 1-2), ared (angular rate energy), amvd (moving variance of the specific force), "
        "amag (magnitude of the specific force), gyro (rms angular rate in rad/s, Li & Wang eq 35).",
    )
    window_s: float | None = Field(
        default=None,
        gt=0,
        le=5,
        description="Window, s, about the judged sample (see `placement`); an odd number of samples; none: the detector's own. Longer is "
        "smoother and later, and cuts the edges of the stance.",
    )
    placement: Literal["centred", "forward", "causal"] = Field(
        default="centred",
        description="Where the window lies: centred on the judged sample; forward, from it on (as MAGINAV eqs 1-2 print it); causal, up to "
        "it, without delay. forward and causal call moving samples at one edge of the stance still.",
    )
    accel_sd: float = Field(
        default=0.3, gt=0, description="Specific force in stance, m/s² per sample. Larger: the accelerometer counts less."
    )
    gyro_sd: float = Field(
        default=0.05235987755982989,
        gt=0,
        description="Angular rate in stance, rad/s per sample (3 deg/s). Larger: the gyroscope counts less.",
    )
    rule: Literal["absolute", "relative", "adaptive"] = Field(
        default="absolute",
        description="absolute: stance where the statistic is below `threshold`. relative: below `ratio` times the least statistic "
        "within `lookaround_s` on either side, and the noise of the zero velocity grows with the statistic. adaptive: below `threshold` "
        "while walking, and below thresholds of `pace` when the foot is slow or runs (Li & Wang eq 36).",
    )
    threshold: float | None = Field(
        default=None,
        gt=0,
        description="Threshold of the absolute rule (MAGINAV eq 3), of the adaptive rule while walking; none: the detector's own. Larger: "
        "more stance, a shorter path when a rolling foot is taken for a standing one; smaller: stances are missed and the path drifts.",
    )
    floor: float | None = Field(
        default=None,
        gt=0,
        description="Relative rule: the least statistic that is told from stillness; none: the detector's own. Larger: more of a walking "
        "stance is taken.",
    )
    ratio: float = Field(default=2.0, gt=1, description="Relative rule: stance where the statistic is below ratio times the local least.")
    lookaround_s: float = Field(
        default=0.4,
        ge=0,
        le=5,
        description="Relative rule: half width, s, of the interval whose least statistic counts; about half a stride. It delays the "
        "result by as much.",
    )

    pace: PaceParameters = PaceParameters()

    @property
    def limit(self) -> float:
        """The threshold of the absolute rule, and of the adaptive one while walking."""
        return DEFAULTS[self.detector].threshold if self.threshold is None else self.threshold

    @property
    def limits(self) -> tuple[float, float, float]:
        """The thresholds of the adaptive rule: slow, walking, running."""
        own, pace = DEFAULTS[self.detector], self.pace
        slow = own.slow if pace.slow_threshold is None else pace.slow_threshold
        return slow, self.limit, own.running if pace.run_threshold is None else pace.run_threshold

    @property
    def least(self) -> float:
        """The floor of the relative rule."""
        return DEFAULTS[self.detector].floor if self.floor is None else self.floor

    @property
    def window(self) -> float:
        """The window, s."""
        return DEFAULTS[self.detector].window_s if self.window_s is None else self.window_s

    def window_samples(self, rate_hz: float) -> int:
        """Odd number of samples nearest to the window; with the detector's own window at least three."""
        return max(1 if self.window_s else 3, 2 * round((self.window * rate_hz - 1) / 2) + 1)

    def ahead_samples(self, rate_hz: float) -> int:
        """Samples of the window after the judged one."""
        others = self.window_samples(rate_hz) - 1
        return {"centred": others // 2, "forward": others, "causal": 0}[self.placement]

    def pace_samples(self, rate_hz: float) -> int:
        """Samples of the window whose mean speed tells the class."""
        return max(1, round(self.pace.window_s * rate_hz))

    def lookaround_samples(self, rate_hz: float) -> int:
        """Samples on either side whose least statistic counts."""
        return round(self.lookaround_s * rate_hz) if self.rule == "relative" else 0

    def latency_samples(self, rate_hz: float) -> int:
        """Delay between a sample and its verdict, samples."""
        return self.ahead_samples(rate_hz) + self.lookaround_samples(rate_hz)

    def latency_s(self, rate_hz: float) -> float:
        """Delay between a sample and its verdict, s."""
        return self.latency_samples(rate_hz) / rate_hz


def sampling_rate(time: Array, longest_s: float = 10.0) -> float:
    """Rate in Hz of the first `longest_s` of times (N,), which sets the windows; 100 where it cannot be told."""
    head = time[: int(np.searchsorted(time, time[0] + longest_s, side="right"))] if len(time) else time
    return 1 / median(np.diff(head)) if len(head) > 1 else 100.0


def memory(parameters: StanceParameters, rate_hz: float) -> tuple[NDArray[np.int64], Array]:
    """Empty state of the compiled detector: index (int64) and memory (float64)."""
    window, look = parameters.window_samples(rate_hz), parameters.lookaround_samples(rate_hz)
    capacity = 1 << (2 * window + 2 * look).bit_length()
    index = np.zeros(kernel.INDEX_SIZE, np.int64)
    index[[kernel.WINDOW, kernel.LOOKAHEAD, kernel.MASK]] = window, look, capacity - 1
    index[kernel.AHEAD] = parameters.ahead_samples(rate_hz)
    index[kernel.DETECTOR] = DETECTORS[parameters.detector]
    index[kernel.RULE] = RULES[parameters.rule]
    sizes = {
        kernel.TAIL: 2 * look,
        kernel.ROWS: kernel.ROW * capacity,
        kernel.QUEUE: capacity,
    }
    end = kernel.HEAD_SIZE
    for place, size in sizes.items():
        index[place] = end
        end += size
    state = np.zeros(end)
    state[kernel.HELD : kernel.HELD + 2] = -np.inf
    return index, state


def scratch(index: NDArray[np.int64], n: int) -> Array:
    """Room for the statistics of a call with n samples."""
    return np.empty(n + 2 * int(index[kernel.LOOKAHEAD]) + int(index[kernel.WINDOW]))


NO_FLAGS = np.empty(0)
"""Flags of rows in which no specific force and no angular rate is missing."""


def filled(state: Array, rows: Array, gap_s: float) -> tuple[Array, Array]:
    """Sample rows (n,10) as the kernels take them: columns (10,n), missing values held, and flags (n,) or `NO_FLAGS` where none is missing.

    Kernels read few columns of many rows, so that each column is in one piece.
    """
    columns = np.ascontiguousarray(rows.T)
    if np.isfinite(columns[1:7]).all():
        return columns, NO_FLAGS
    columns, flags = columns.copy(), np.empty(len(rows))
    kernel.fill(state, columns, flags, gap_s)
    return columns, flags


@dataclass(frozen=True, eq=False)
class StanceAnalysis:
    """Statistic, threshold and verdict of every sample of a recording."""

    time: Array
    statistic: Array
    threshold: Array
    stance: NDArray[np.bool_]
    parameters: StanceParameters

    @property
    def detector(self) -> str:
        return self.parameters.detector


def analyse(
    recording: Recording,
    parameters: StanceParameters | None = None,
    *,
    gravity: float = STANDARD_GRAVITY,
) -> StanceAnalysis:
    """The detector over a whole recording, without the filter but with its verdicts. gravity in m/s²."""
    parameters = parameters or StanceParameters()
    rate = sampling_rate(recording.time)
    out = detect(recording.samples(), parameters, rate, gravity=gravity, gap_s=GapParameters().seconds(rate))
    return StanceAnalysis(recording.time, out[:, 0], out[:, 1], out[:, 2] > 0, parameters)


def detect(
    rows: Array,
    parameters: StanceParameters,
    rate_hz: float,
    *,
    gravity: float = STANDARD_GRAVITY,
    gap_s: float = 0.02,
    zero_velocity_sd: float = 0.01,
) -> Array:
    """Statistic, threshold and zero-velocity standard deviation (m/s, 0 in swing) of sample rows (N,10): (N,3)."""
    index, state = memory(parameters, rate_hz)
    out = np.empty((len(rows) + parameters.latency_samples(rate_hz), 3))
    columns, flags = filled(state, rows, gap_s)
    written = kernel.detect(
        index,
        state,
        columns,
        flags,
        True,
        parameters.accel_sd**-2,
        parameters.gyro_sd**-2,
        gravity,
        parameters.limit,
        zero_velocity_sd,
        parameters.least,
        parameters.ratio,
        scratch(index, len(rows)),
        out,
    )
    return out[:written]
