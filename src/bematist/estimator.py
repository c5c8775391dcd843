"""What all estimators have in common: batch, pieces, and a state that can be saved. An estimator adds its start and its kernel."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from bematist.align import Alignment
from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.intake import Intake, sample_rows
from bematist.kernels.jit import STAMP, stopwatch
from bematist.parameters import Parameters
from bematist.recording import SAMPLE_COLUMNS, Recording
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]
Model = TypeVar("Model", bound=Parameters)
Result = TypeVar("Result", Attitude, Trajectory)


class Estimator(ABC, Generic[Model, Result]):
    """A filter over the samples of a recording.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in pieces of
    any size and returns the part of the result that is decided, and `finish()` the rest; the pieces are, bit for bit, what `run` returns.
    The first `initial.longest_s` seconds are gathered before the first answer.
    """

    width: ClassVar[int] = len(SAMPLE_COLUMNS)
    """Columns of the sample rows that the kernel takes; those that a caller leaves out are NaN."""
    least: ClassVar[int] = 1
    """Fewest samples of a recording."""

    def __init__(self, parameters: Model, longest_s: float, name: str) -> None:
        self.parameters = parameters
        self.name = name
        self.alignment: Alignment | None = None
        self._intake = Intake(longest_s, type(self).__name__, self.width)
        self._state: tuple[NDArray[Any], ...] | None = None

    # -- what an estimator adds ------------------------------------------------------------------------------------------

    @abstractmethod
    def _results(self, n: int) -> tuple[NDArray[Any], ...]:
        """Room for the results of n samples, each array with a row a sample."""

    @abstractmethod
    def _start(self, head: Array) -> None:
        """Align on the rows of the first seconds: set `alignment` and `_state`."""

    @abstractmethod
    def _feed(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        """Run the kernel over rows, into the first rows of the results; how many rows were answered. `finish`: no more will come."""

    @abstractmethod
    def _judge(self, recording: Recording, *results: NDArray[Any]) -> list[str]:
        """Warnings about the results of a recording."""

    @abstractmethod
    def _result(self, *results: NDArray[Any], **fields: Any) -> Result:
        """Results by their names."""

    def _suits(self, recording: Recording) -> list[str]:
        """Warnings about a recording that is not of the kind that this estimator is for."""
        return []

    def _waiting(self) -> int:
        """Rows that were taken and are not answered yet, apart from those that are gathered for the start."""
        return 0

    def _restored(self) -> None:
        """Called when a saved state is in place."""

    # -- batch -----------------------------------------------------------------------------------------------------------

    @property
    def north(self) -> str:
        """What North is (`Attitude.north`)."""
        return self.alignment.north if self.alignment is not None else "none"

    @property
    def warnings(self) -> list[str]:
        """What is suspicious so far."""
        return self._intake.warnings

    def run(self, recording: Recording, *, chunk: int | None = None, progress: Callable[[int, int], None] | None = None) -> Result:
        """The result for a whole recording, fed in chunks of `chunk` samples (default: a few seconds' work at a time).

        progress is called with the number of samples done and of all. Raises DataError where the recording cannot be processed.
        """
        if not self._intake.untouched:
            raise UsageError(f"This {self._intake.owner} has been given samples already: make a new one for each recording.")
        n, size = len(recording), chunk or 50_000
        if n < self.least:
            raise DataError(f"{recording.source or 'The recording'}: {n} sample(s) are too few. Record for longer.")
        with stopwatch() as seconds:
            results = self._results(n)
            done = 0
            for first in range(0, n, size):
                rows = recording.samples(first, first + size, pressure=self.width > len(SAMPLE_COLUMNS))
                done += self._advance(rows, first + size >= n, *(r[done:] for r in results))
                if progress:
                    progress(min(first + size, n), n)
            results = tuple(r[:done] for r in results)
            elapsed = seconds()
        warnings = (*self._suits(recording), *recording.warnings, *self.warnings, *self._judge(recording, *results))
        return self._result(*results, warnings=warnings, processing_s=elapsed, source=recording.source)

    # -- live ------------------------------------------------------------------------------------------------------------

    @property
    def ready(self) -> bool:
        """Whether the start is aligned, so that there are answers."""
        return self._state is not None

    @property
    def latency_s(self) -> float:
        """Delay of an answer after the start, s (NaN before the sampling rate is known)."""
        return self._waiting() / self.alignment.rate_hz if self.alignment is not None else math.nan

    def _begun(self) -> tuple[NDArray[Any], ...]:
        """The state, for `step`. UsageError before the start is aligned."""
        if self._state is None:
            raise UsageError("step() was called before the start was aligned: give the first seconds to update(), until `ready`.")
        return self._state

    def update(self, rows: Array) -> Result:
        """Take in sample rows (n,10); returns the result for the samples that are now decided (it may be empty).

        Rows whose time does not increase are dropped and counted in a warning.
        """
        return self._piece(sample_rows(rows, self.width), False)

    def finish(self) -> Result:
        """No more samples will come: the result for those that were still waiting."""
        return self._piece(np.empty((0, self.width)), True)

    def save(self) -> dict[str, Any]:
        """The whole state, which can be pickled: `restore` goes on from it as if nothing had happened."""
        return {
            "parameters": self.parameters,
            "name": self.name,
            "version": STAMP,
            "intake": self._intake.save(),
            "alignment": self.alignment,
            "state": None if self._state is None else [a.copy() for a in self._state],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Self:
        """An estimator in the state that `save` returned. UsageError where another version of the kernels saved it."""
        if saved.get("version") != STAMP:
            raise UsageError(
                "The state was saved by another version of bematist, whose filters remember other things: it cannot be restored. "
                "Begin anew, or restore it with the version that saved it."
            )
        self = cls(saved["parameters"])  # pyright: ignore[reportCallIssue]
        self.name, self.alignment = saved["name"], saved["alignment"]
        self._intake = Intake.restore(saved["intake"])
        if saved["state"] is not None:
            self._state = tuple(a.copy() for a in saved["state"])
            self._restored()
        return self

    def _piece(self, rows: Array, finish: bool) -> Result:
        results = self._results(self._intake.waiting + self._waiting() + len(rows))
        done = self._advance(rows, finish, *results)
        return self._result(*(r[:done] for r in results), warnings=tuple(self.warnings))

    def _advance(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        """Feed rows; write the results of those that are answered, and return how many these are."""
        head, rows = self._intake.take(rows, finish)
        if head is not None:
            self._start(head)
        return self._feed(rows, finish, *results) if self._state is not None else 0
