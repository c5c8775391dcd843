"""`HandAttitude`: attitude of a handheld sensor, in batch, in chunks and sample by sample."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist import stance
from bematist.align import Alignment
from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.hand.parameters import HandParameters
from bematist.hand.result import attitude, judge
from bematist.hand.setup import detectors, kernel_parameters, workspace
from bematist.hand.start import start
from bematist.intake import Intake, sample_rows
from bematist.kernels import hand as filter_kernel
from bematist.kernels import hand_layout as kernel
from bematist.recording import Recording

Array = NDArray[np.float64]


class HandAttitude:
    """The attitude filter MAGYQ for a sensor in the hand.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in pieces of
    any size and returns their attitudes, and `finish()` the rest of a recording that ended early; the pieces are, bit for bit, what `run`
    returns. The first `initial.longest_s` seconds are gathered before the first answer; from then on there is no delay.
    """

    def __init__(self, parameters: HandParameters | None = None, *, name: str = "") -> None:
        self.parameters = parameters or HandParameters()
        self.name = name
        self.alignment: Alignment | None = None
        self.north = "none"
        self._intake = Intake(self.parameters.initial.longest_s, "HandAttitude")
        self._state: tuple[NDArray[np.int64], Array, Array, Array] | None = None

    @property
    def warnings(self) -> list[str]:
        """What is suspicious so far."""
        return self._intake.warnings

    def run(self, recording: Recording, *, chunk: int | None = None, progress: Callable[[int, int], None] | None = None) -> Attitude:
        """The attitudes of a whole recording, fed in chunks of `chunk` samples.

        progress is called with the number of samples done and of all. Raises DataError where the recording cannot be processed.
        """
        if not self._intake.untouched:
            raise UsageError("This HandAttitude has been given samples already: make a new one for each recording.")
        if not len(recording):
            raise DataError(f"{recording.source or 'The recording'} has no samples.")
        started = time.perf_counter()
        n, size = len(recording), chunk or 50_000
        nav, diagnostics = np.empty((n, kernel.NAV)), np.empty((n, kernel.DIAG), np.float32)
        done = 0
        for first in range(0, n, size):
            last = first + size >= n
            done += self._advance(recording.samples(first, first + size), last, nav[done:], diagnostics[done:])
            if progress:
                progress(min(first + size, n), n)
        elapsed = time.perf_counter() - started
        warnings = (*recording.warnings, *self.warnings, *judge(nav, diagnostics, self.parameters, recording.has_magnetometer))
        return self._attitude(nav, diagnostics, warnings=warnings, processing_s=elapsed, source=recording.source)

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
            "parameters": self.parameters.model_dump(),
            "name": self.name,
            "intake": self._intake.save(),
            "alignment": self.alignment,
            "north": self.north,
            "state": None if self._state is None else [a.copy() for a in self._state],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> HandAttitude:
        """A filter in the state that `save` returned."""
        self = cls(HandParameters.model_validate(saved["parameters"]), name=saved["name"])
        self._intake = Intake.restore(saved["intake"])
        self.alignment, self.north = saved["alignment"], saved["north"]
        if saved["state"] is not None:
            index, memory, S, prm = (a.copy() for a in saved["state"])
            self._state = (index, memory, S, prm)
        return self

    def _piece(self, rows: Array, finish: bool) -> Attitude:
        n = self._intake.waiting + len(rows)
        nav, diagnostics = np.empty((n, kernel.NAV)), np.empty((n, kernel.DIAG), np.float32)
        done = self._advance(rows, finish, nav, diagnostics)
        return self._attitude(nav[:done], diagnostics[:done], warnings=tuple(self.warnings))

    def _advance(self, rows: Array, finish: bool, nav: Array, diagnostics: NDArray[np.float32]) -> int:
        """Feed rows; write what is decided into nav and diagnostics; return how many rows that is."""
        head, rows = self._intake.take(rows, finish)
        if head is not None:
            self._start(head)
        if self._state is None:
            return 0
        index, memory, S, prm = self._state
        columns, flags = stance.filled(memory, rows, prm[kernel.GAP_S])
        return filter_kernel.run(index, memory, S, prm, columns, flags, nav, diagnostics)

    def _start(self, head: Array) -> None:
        p = self.parameters
        rate = stance.sampling_rate(head[:, 0], p.initial.longest_s)
        known = np.isfinite(head[:, 7:10]).all(1)
        magnetic_rate = stance.sampling_rate(head[known, 0], p.initial.longest_s) if known.sum() > 1 else rate
        a, self.north = start(head, p, rate)
        self.alignment = a
        prm, warnings = kernel_parameters(p, a, rate)
        self.warnings.extend([*a.warnings, *warnings])
        self._state = (*detectors(p, rate, magnetic_rate), workspace(p, a, 1 / rate), prm)

    def _attitude(self, nav: Array, diagnostics: NDArray[np.float32], **fields: Any) -> Attitude:
        return attitude(nav, diagnostics, self.parameters, north=self.north, filter=self.name, **fields)
