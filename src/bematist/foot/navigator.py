"""`FootIns`: inertial navigation of a shoe-mounted sensor, in batch, in chunks and sample by sample."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import stance
from bematist.align import Alignment, initial_alignment
from bematist.errors import DataError, UsageError
from bematist.foot.parameters import FootParameters
from bematist.foot.result import PHONE, judge, trajectory
from bematist.foot.setup import kernel_parameters, workspace
from bematist.intake import Intake, sample_rows
from bematist.kernels import foot as filter_kernel
from bematist.kernels import layout as kernel
from bematist.recording import Recording
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]


class FootIns:
    """A shoe-mounted navigator.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in
    pieces of any size and returns the part of the trajectory that is decided, and `finish()` the rest; the pieces are, bit for bit,
    what `run` returns. The first `initial.longest_s` seconds are gathered before the first answer; afterwards an answer is
    `latency_s` late. `step(row)` is `update` for one row with the least overhead.
    """

    def __init__(self, parameters: FootParameters | None = None, *, method: str = "") -> None:
        self.parameters = parameters or FootParameters()
        self.method = method
        self.alignment: Alignment | None = None
        self._intake = Intake(self.parameters.initial.longest_s, "FootIns")
        self.warnings = self._intake.warnings
        self._rate_hz = math.nan
        self._state: tuple[NDArray[np.int64], Array, Array, Array] | None = None
        self._scratch = np.empty(0)
        self._row = np.empty((1, kernel.NAV))
        self._row_diagnostics = np.empty((1, kernel.DIAG), np.float32)

    # -- batch -----------------------------------------------------------------------------------------------------------

    def run(self, recording: Recording, *, chunk: int | None = None, progress: Callable[[int, int], None] | None = None) -> Trajectory:
        """The trajectory of a whole recording, fed in chunks of `chunk` samples (default: a few seconds' work at a time).

        progress is called with the number of samples done and of all. Raises DataError where the recording cannot be processed.
        """
        if not self._intake.untouched:
            raise UsageError("This FootIns has been given samples already: make a new one for each recording.")
        if len(recording) < 2:
            raise DataError(f"{recording.source or 'The recording'}: {len(recording)} sample(s) make no path. Record for longer.")
        started = time.perf_counter()
        n = len(recording)
        nav = np.empty((n, kernel.NAV))
        diagnostics = np.empty((n, kernel.DIAG), np.float32)
        size = chunk or 50_000
        done = 0
        for start in range(0, n, size):
            done += self._advance(recording.samples(start, start + size), False, nav[done:], diagnostics[done:])
            if progress:
                progress(min(start + size, n), n)
        done += self._advance(np.empty((0, 10)), True, nav[done:], diagnostics[done:])
        nav, diagnostics = nav[:done], diagnostics[:done]
        assert self._state is not None
        elapsed = time.perf_counter() - started
        phone = (PHONE,) if recording.phone else ()
        warnings = (*phone, *recording.warnings, *self.warnings, *judge(nav, diagnostics, self._state[3]))
        return self._trajectory(nav, diagnostics, warnings=warnings, processing_s=elapsed, source=recording.source)

    # -- live ------------------------------------------------------------------------------------------------------------

    @property
    def ready(self) -> bool:
        """Whether the start is aligned, so that `step` may be called."""
        return self._state is not None

    @property
    def latency_s(self) -> float:
        """Delay of an answer after the start, s (NaN before the sampling rate is known)."""
        return self.parameters.stance.latency_s(self._rate_hz) if self._rate_hz > 0 else math.nan

    def update(self, rows: Array) -> Trajectory:
        """Take in sample rows (n,10); returns the trajectory of the samples that are now decided (it may be empty).

        Rows whose time does not increase are dropped and counted in a warning.
        """
        return self._piece(sample_rows(rows), False)

    def finish(self) -> Trajectory:
        """No more samples will come: the trajectory of those that were still waiting."""
        return self._piece(np.empty((0, 10)), True)

    def step(self, row: Array) -> Array | None:
        """`update` for one row (1,10), C-contiguous float64: one result row (29,) valid until the next call, or None.

        The result holds time, position (3), velocity (3), attitude (4) and the packed covariances of `Trajectory`. For speed nothing is
        checked: the time must increase. UsageError before the start is aligned: until `ready`, give the samples to `update`.
        """
        if self._state is None:
            raise UsageError("step() was called before the start was aligned: give the first seconds to update(), until `ready`.")
        index, memory, S, prm = self._state
        self._intake.last_time = row[0, 0]
        columns = row.T if row.flags.c_contiguous else np.ascontiguousarray(row.T)
        n = filter_kernel.run(index, memory, S, prm, columns, stance.NO_FLAGS, False, self._scratch, self._row, self._row_diagnostics)
        if n < 0:
            n = self._run(row, False, self._row, self._row_diagnostics)
        return self._row[0] if n else None

    def save(self) -> dict[str, Any]:
        """The whole state as plain arrays: `restore` goes on from it as if nothing had happened."""
        return {
            "parameters": self.parameters.model_dump(),
            "method": self.method,
            "intake": self._intake.save(),
            "rate_hz": self._rate_hz,
            "alignment": self.alignment,
            "state": None if self._state is None else [a.copy() for a in self._state],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> FootIns:
        """A navigator in the state that `save` returned."""
        self = cls(FootParameters.model_validate(saved["parameters"]), method=saved["method"])
        self._intake = Intake.restore(saved["intake"])
        self.warnings = self._intake.warnings
        self._rate_hz, self.alignment = saved["rate_hz"], saved["alignment"]
        if saved["state"] is not None:
            index, memory, S, prm = (a.copy() for a in saved["state"])
            self._state = (index, memory, S, prm)
            self._scratch = stance.scratch(index, 1)
        return self

    # -- inside ----------------------------------------------------------------------------------------------------------

    def _piece(self, rows: Array, finish: bool) -> Trajectory:
        waiting = self._intake.waiting
        if self._state is not None:
            waiting = self.parameters.stance.latency_samples(self._rate_hz)
        nav = np.empty((waiting + len(rows), kernel.NAV))
        diagnostics = np.empty((len(nav), kernel.DIAG), np.float32)
        n = self._advance(rows, finish, nav, diagnostics)
        return self._trajectory(nav[:n], diagnostics[:n], warnings=tuple(self.warnings))

    def _advance(self, rows: Array, finish: bool, nav: Array, diagnostics: NDArray[np.float32]) -> int:
        """Feed rows; write what is decided into nav and diagnostics; return how many rows that is."""
        head, rows = self._intake.take(rows, finish)
        if head is not None:
            self._start(head)
        return self._run(rows, finish, nav, diagnostics) if self._state is not None else 0

    def _run(self, rows: Array, finish: bool, nav: Array, diagnostics: NDArray[np.float32]) -> int:
        assert self._state is not None
        index, memory, S, prm = self._state
        columns, flags = stance.filled(memory, rows, prm[kernel.GAP_S])
        return filter_kernel.run(index, memory, S, prm, columns, flags, finish, stance.scratch(index, len(rows)), nav, diagnostics)

    def _start(self, head: Array) -> None:
        p = self.parameters
        self._rate_hz = stance.sampling_rate(head[:, 0], p.initial.longest_s)
        gap_s = p.gap.seconds(self._rate_hz)
        a = initial_alignment(head, p.initial, self._rate_hz, p.gravity, p.noise.angle_random_walk, gap_s)
        self.alignment = a
        self.warnings += a.warnings
        index, memory = stance.memory(p.stance, self._rate_hz)
        prm, warnings = kernel_parameters(p, a, self._rate_hz)
        self.warnings += warnings
        self._state = (index, memory, workspace(p, a, prm, head[0, 0]), prm)
        self._scratch = stance.scratch(index, 1)

    def _trajectory(self, nav: Array, diagnostics: NDArray[np.float32], **fields: Any) -> Trajectory:
        prm = None if self._state is None else self._state[3]
        return trajectory(nav, diagnostics, prm, method=self.method, parameters=self.parameters.model_dump(), **fields)
