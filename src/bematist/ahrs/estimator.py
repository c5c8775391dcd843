"""`Ahrs`: attitude in batch, in chunks and sample by sample."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.ahrs.parameters import AhrsParameters, MadgwickParameters
from bematist.align import Alignment, InitialParameters, initial_alignment
from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.intake import Intake, sample_rows
from bematist.kernels import attitude as kernel
from bematist.recording import Recording
from bematist.stance import sampling_rate

Array = NDArray[np.float64]

MAGNETIC_NORTH = (0.0, 1.0, 0.0)
"""Earth's field where none is given: its horizontal part points North."""


class Ahrs:
    """An attitude filter.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in pieces of
    any size and returns their attitudes, and `finish()` the rest of a recording that ended early; the pieces are, bit for bit, what `run`
    returns. The first `initial.longest_s` seconds are gathered before the first answer; from then on there is no delay.
    """

    def __init__(self, parameters: AhrsParameters | None = None, *, name: str = "") -> None:
        self.parameters = parameters or MadgwickParameters()
        self.name = name
        self.alignment: Alignment | None = None
        self.north = "none"
        self._intake = Intake(self.parameters.initial.longest_s, "Ahrs")
        self._state: tuple[Array, Array] | None = None

    @property
    def warnings(self) -> list[str]:
        """What is suspicious so far."""
        return self._intake.warnings

    def run(self, recording: Recording, *, chunk: int | None = None, progress: Callable[[int, int], None] | None = None) -> Attitude:
        """The attitudes of a whole recording, fed in chunks of `chunk` samples.

        progress is called with the number of samples done and of all. Raises DataError where the recording cannot be processed.
        """
        if not self._intake.untouched:
            raise UsageError("This Ahrs has been given samples already: make a new one for each recording.")
        if not len(recording):
            raise DataError(f"{recording.source or 'The recording'} has no samples.")
        started = time.perf_counter()
        n, size = len(recording), chunk or 50_000
        times, out = np.empty(n), np.empty((n, kernel.OUT))
        done = 0
        for start in range(0, n, size):
            last = start + size >= n
            done += self._advance(recording.samples(start, start + size), last, times[done:], out[done:])
            if progress:
                progress(min(start + size, n), n)
        elapsed = time.perf_counter() - started
        warnings = (*recording.warnings, *self.warnings, *_judge(times, out, self.parameters, recording))
        return self._attitude(times, out, warnings=warnings, processing_s=elapsed, source=recording.source)

    def update(self, rows: Array) -> Attitude:
        """Take in sample rows (n,10); their attitudes, once the start is aligned (before that, none).

        Rows whose time does not increase are dropped and counted in a warning.
        """
        return self._piece(sample_rows(rows), False)

    def finish(self) -> Attitude:
        """No more samples will come: the attitudes of those that are still gathered, of a recording shorter than `initial.longest_s`."""
        return self._piece(np.empty((0, 10)), True)

    def save(self) -> dict[str, Any]:
        """The whole state as plain values and arrays: `restore` goes on from it as if nothing had happened."""
        return {
            "parameters": self.parameters,
            "name": self.name,
            "north": self.north,
            "intake": self._intake.save(),
            "alignment": self.alignment,
            "state": None if self._state is None else [a.copy() for a in self._state],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Ahrs:
        """A filter in the state that `save` returned."""
        self = cls(saved["parameters"], name=saved["name"])
        self._intake = Intake.restore(saved["intake"])
        self.alignment, self.north = saved["alignment"], saved["north"]
        if saved["state"] is not None:
            S, prm = (a.copy() for a in saved["state"])
            self._state = (S, prm)
        return self

    def _piece(self, rows: Array, finish: bool) -> Attitude:
        n = self._intake.waiting + len(rows)
        times, out = np.empty(n), np.empty((n, kernel.OUT))
        done = self._advance(rows, finish, times, out)
        return self._attitude(times[:done], out[:done], warnings=tuple(self.warnings))

    def _advance(self, rows: Array, finish: bool, times: Array, out: Array) -> int:
        """Feed rows; write the times and results of those that are answered, and return how many these are."""
        head, rows = self._intake.take(rows, finish)
        if head is not None:
            self._start(head)
        if self._state is None or not len(rows):
            return 0
        times[: len(rows)] = rows[:, 0]
        kernel.run(*self._state, np.ascontiguousarray(rows.T), out[: len(rows)])
        return len(rows)

    def _start(self, head: Array) -> None:
        """Levelled on the mean of a rest, and aimed by the mean field (Li & Wang eqs 16-23, errata: averages, and the levelled field)."""
        p = self.parameters
        rate_hz = sampling_rate(head[:, 0], p.initial.longest_s)
        gap_s = p.gap.seconds(rate_hz)
        initial = InitialParameters.model_validate(p.initial.model_dump())
        if not p.magnetometer:
            head = head.copy()
            head[:, 7:10] = np.nan
        by_field = initial.heading_deg is None and initial.earth_field is None and bool(np.isfinite(head[:, 7:10]).all(1).any())
        if by_field:
            initial = initial.override({"earth_field": MAGNETIC_NORTH})
        a = initial_alignment(head, initial, rate_hz, p.gravity, 0.0, gap_s)
        self.alignment = a
        self.warnings.extend(a.warnings)
        given = initial.heading_deg is not None or (initial.earth_field is not None and a.field is not None)
        self.north = "magnetic" if by_field else "given" if given else "none"
        S = np.zeros(kernel.STATE_SIZE)
        S[kernel.Q : kernel.Q + 4] = a.attitude
        S[kernel.BIAS : kernel.BIAS + 3] = a.gyro_bias
        prm = np.zeros(kernel.PARAMETERS)
        prm[kernel.FILTER], prm[kernel.EXACT] = p.kind, p.integration == "exact"
        prm[kernel.GAIN], prm[kernel.BIAS_GAIN] = p.gains
        prm[kernel.GAP_S], prm[kernel.GAP_BALLISTIC_S] = gap_s, p.gap.ballistic_s
        north = _horizontal(a.field if initial.heading_deg is not None else initial.earth_field)
        prm[kernel.MAGNETOMETER] = p.magnetometer and north is not None
        prm[kernel.NORTH_E], prm[kernel.NORTH_N] = north or (0.0, 1.0)
        self._state = (S, prm)

    def _attitude(self, times: Array, out: Array, **fields: Any) -> Attitude:
        return Attitude(
            time=times,
            attitude=out[:, :4],
            gyro_bias=out[:, kernel.BIAS_OUT : kernel.BIAS_OUT + 3],
            diagnostics={"bridged": out[:, kernel.FLAG].astype(np.uint8)},
            north=self.north,
            filter=self.name,
            parameters=self.parameters.model_dump(),
            **fields,
        )


def _horizontal(field: Any) -> tuple[float, float] | None:
    """Unit direction East, North of a field (3,) in ENU; None without a horizontal part."""
    if field is None:
        return None
    length = math.hypot(field[0], field[1])
    return (float(field[0] / length), float(field[1] / length)) if length > 0 else None


def _judge(times: Array, out: Array, p: AhrsParameters, recording: Recording) -> list[str]:
    """Warnings about the result."""
    found = []
    flag = out[:, kernel.FLAG]
    gaps = np.diff(times)[flag[1:] == kernel.BRIDGED]
    if len(gaps):
        found.append(
            f"{len(gaps)} gap(s) of {gaps.sum():.2f} s in all were bridged, the longest {gaps.max():.2f} s: the heading is in doubt from "
            "there on."
        )
    for value, words in (
        (kernel.HELD, "had no angular rate: the last one was held"),
        (kernel.MISSING, "had no angular rate for too long: nothing was turned"),
    ):
        if n := int((flag == value).sum()):
            found.append(f"{n} of {len(times)} samples {words}.")
    if p.magnetometer and not recording.has_magnetometer and p.kind != kernel.GYRO:
        found.append("There is no magnetometer: the heading is the gyroscope's alone, and drifts.")
    return found
