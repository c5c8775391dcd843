"""What a sensor recorded: every reader returns a `Recording`, every estimator takes one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bematist.arrays import complete, median
from bematist.errors import DataError

Array = NDArray[np.float64]

SAMPLE_COLUMNS = ("time", "fx", "fy", "fz", "wx", "wy", "wz", "mx", "my", "mz")
"""Columns of a sample row, the form in which estimators take data (`Recording.samples`); an eleventh, pressure in Pa, may follow."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Reference:
    """What is known of the true path: at instants, or at the footfalls of one shoe.

    Attributes
    ----------
    time : (K,) s on the recording's clock; NaN where only the footfall is known.
    position : (K,3) m, up NaN where only the plan is known.
    attitude : (K,4) wxyz or None.
    footfall : (K,) index of the stance phase each row belongs to (0 the initial stance), or None.
    judged : (K,) the rows that errors are counted over, or None for all.
    mirrored : whether the reference axes may be left-handed, so that alignment may mirror them.
    note : where it comes from, and in what frame.
    source : the file it was read from; "" where the recording itself holds it.
    origin : where on Earth its position (0, 0, 0) is: latitude and longitude in degrees, height in m (NaN where unknown), WGS-84; or None.
    """

    time: Array
    position: Array
    attitude: Array | None = None
    footfall: NDArray[np.int64] | None = None
    judged: NDArray[np.bool_] | None = None
    mirrored: bool = False
    note: str = ""
    source: str = ""
    origin: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """Which readings a recording holds, as far as it is known: what a calibration is made for, and only fits again.

    device : the one sensor, such as its serial number. axes : the remap that was asked for when it was read, "" without one. uncalibrated :
    whether a phone's raw readings were taken, and not those it calibrates. calibration : what the readings were calibrated with already.
    """

    device: str = ""
    axes: str = ""
    uncalibrated: bool = False
    calibration: str = ""

    def replace(self, **changes: str | bool) -> Sensing:
        return replace(self, **changes)  # pyright: ignore[reportArgumentType]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Recording:
    """Samples of a body-worn sensor, each sensor on its own clock, in SI units and µT, in the sensor's own axes.

    A row of `specific_force` or `angular_rate` that is NaN means "no sample of that sensor at this time", so the two may
    run at different rates on one time axis. Nothing is resampled.

    Attributes
    ----------
    time : (N,) s from the start of the recording, strictly increasing.
    specific_force : (N,3) m/s²; a level sensor at rest reads +g up.
    angular_rate : (N,3) rad/s.
    magnetic_time : (M,) s on the same time base, strictly increasing; empty without a magnetometer.
    magnetic_flux_density : (M,3) µT.
    pressure_time, pressure : (L,) s, Pa.
    reference : the true path, where the recording came with it.
    start_ns : UNIX time of `time` 0 in ns, or None.
    phone : whether a phone recorded it, which is seldom worn on a shoe.
    source : where the recording came from, for messages.
    sensing : which device, axes and channel the readings are of.
    notes : facts that `info` shows: units and why, the clock and why.
    warnings : what is suspicious; travels into `summary.json` and the report.

    Raises
    ------
    DataError
        The arrays do not fit together, or a clock does not increase.
    """

    time: Array
    specific_force: Array
    angular_rate: Array
    magnetic_time: Array = field(default_factory=lambda: np.empty(0))
    magnetic_flux_density: Array = field(default_factory=lambda: np.empty((0, 3)))
    pressure_time: Array = field(default_factory=lambda: np.empty(0))
    pressure: Array = field(default_factory=lambda: np.empty(0))
    reference: Reference | None = None
    start_ns: int | None = None
    phone: bool = False
    source: str = ""
    sensing: Sensing = field(default_factory=Sensing)
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for times, values, width in (
            ("time", "specific_force", 3),
            ("time", "angular_rate", 3),
            ("magnetic_time", "magnetic_flux_density", 3),
            ("pressure_time", "pressure", 0),
        ):
            t = np.ascontiguousarray(getattr(self, times), float)
            v = np.ascontiguousarray(getattr(self, values), float)
            shape = (len(t), width) if width else (len(t),)
            if t.ndim != 1 or v.shape != shape:
                raise DataError(
                    f"{self.source or 'The recording'}: {values} has shape {v.shape} where {times} asks for {shape}. "
                    "Give one row for each instant and three columns for a vector."
                )
            bad = np.flatnonzero(~(np.diff(t) > 0)) if np.isfinite(t).all() else np.flatnonzero(~np.isfinite(t)) - 1
            if len(bad):
                raise DataError(
                    f"{self.source or 'The recording'}: {times} is not finite and increasing at row {bad[0] + 1}. "
                    "Sort the rows and drop the repeated ones, or read the file with bematist.read, which repairs clocks."
                )
            object.__setattr__(self, times, t)
            object.__setattr__(self, values, v)

    def __repr__(self) -> str:
        field = f", {len(self.magnetic_time)} of the field" if self.has_magnetometer else ""
        return f"Recording({self.source or 'arrays'}, {len(self)} samples{field}, {self.duration_s:.1f} s)"

    def __len__(self) -> int:
        return len(self.time)

    @property
    def duration_s(self) -> float:
        return float(self.time[-1] - self.time[0]) if len(self.time) else 0.0

    @property
    def rate_hz(self) -> float:
        """Rate of the inertial samples, from the median step (NaN with fewer than two samples)."""
        return 1 / median(np.diff(self.time)) if len(self.time) > 1 else float("nan")

    @property
    def has_magnetometer(self) -> bool:
        return len(self.magnetic_time) > 0

    def samples(self, start: int = 0, stop: int | None = None, *, pressure: bool = False) -> Array:
        """The recording, or its rows from start to before stop, as sample rows (N,10), `SAMPLE_COLUMNS`; with pressure (N,11).

        A sample of magnetometer or barometer stands once, in the first inertial row at or after its own time, and NaN elsewhere; where two
        fall into one step, the later stands.
        """
        part = slice(start, stop)
        time = self.time[part]
        before = self.time[start - 1] if start and len(time) else -np.inf
        rows = np.full((10 + pressure, len(time)), np.nan).T  # each column in one piece, as the kernels read them
        rows[:, 0] = time
        rows[:, 1:4] = self.specific_force[part]
        rows[:, 4:7] = self.angular_rate[part]
        _place(rows[:, 7:10], time, before, self.magnetic_time, self.magnetic_flux_density)
        if pressure:
            _place(rows[:, 10:], time, before, self.pressure_time, self.pressure[:, None])
        return rows

    def chunks(self, n: int, *, pressure: bool = False) -> Iterator[Array]:
        """Sample rows in consecutive chunks of n."""
        for start in range(0, len(self), n):
            yield self.samples(start, start + n, pressure=pressure)

    def replace(self, **changes: ArrayLike | object) -> Recording:
        """A copy with some fields changed."""
        return replace(self, **changes)  # pyright: ignore[reportArgumentType]


def _place(rows: Array, time: Array, before: float, own_time: Array, values: Array) -> None:
    """Write samples with a clock of their own, own_time (M,) and values (M,k), into the rows (N,k) of inertial samples at `time` (N,).

    before: instant of the inertial sample ahead of these.
    """
    if not len(own_time) or not len(time):
        return
    # A tolerance of a µs: clocks that were written with few digits must not slip by a row.
    near = slice(*np.searchsorted(own_time, [before, time[-1] + 1e-5]))
    shifted, values = own_time[near] - 1e-6, values[near]
    inside = (shifted > before) & (shifted <= time[-1]) & complete(values)
    rows[np.searchsorted(time, shifted[inside])] = values[inside]
