"""What the attitude filters have in common: batch, pieces, and a state that can be saved. A filter adds its start and its kernel."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from bematist.align import Alignment
from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.intake import Intake, sample_rows
from bematist.parameters import Parameters
from bematist.recording import Recording

Array = NDArray[np.float64]
Model = TypeVar("Model", bound=Parameters)


class AttitudeEstimator(ABC, Generic[Model]):
    """An attitude filter.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in pieces of
    any size and returns their attitudes, and `finish()` the rest of a recording that ended early; the pieces are, bit for bit, what `run`
    returns. The first `initial.longest_s` seconds are gathered before the first answer; from then on there is no delay.
    """

    def __init__(self, parameters: Model, longest_s: float, name: str) -> None:
        self.parameters = parameters
        self.name = name
        self.alignment: Alignment | None = None
        self.north = "none"
        self._intake = Intake(longest_s, type(self).__name__)
        self._state: tuple[NDArray[Any], ...] | None = None

    # -- what a filter adds ----------------------------------------------------------------------------------------------

    @abstractmethod
    def _results(self, n: int) -> tuple[NDArray[Any], ...]:
        """Room for the results of n samples, each array with a row a sample."""

    @abstractmethod
    def _start(self, head: Array) -> None:
        """Align on the rows of the first seconds: set `alignment`, `north` and `_state`."""

    @abstractmethod
    def _feed(self, rows: Array, *results: NDArray[Any]) -> None:
        """Run the kernel over rows, into the first rows of the results."""

    @abstractmethod
    def _judge(self, recording: Recording, *results: NDArray[Any]) -> list[str]:
        """Warnings about the results of a recording."""

    @abstractmethod
    def _attitude(self, *results: NDArray[Any], **fields: Any) -> Attitude:
        """Results by their names."""

    # -- batch -----------------------------------------------------------------------------------------------------------

    @property
    def warnings(self) -> list[str]:
        """What is suspicious so far."""
        return self._intake.warnings

    def run(self, recording: Recording, *, chunk: int | None = None, progress: Callable[[int, int], None] | None = None) -> Attitude:
        """The attitudes of a whole recording, fed in chunks of `chunk` samples.

        progress is called with the number of samples done and of all. Raises DataError where the recording cannot be processed.
        """
        if not self._intake.untouched:
            raise UsageError(f"This {self._intake.owner} has been given samples already: make a new one for each recording.")
        if not len(recording):
            raise DataError(f"{recording.source or 'The recording'} has no samples.")
        started = time.perf_counter()
        n, size = len(recording), chunk or 50_000
        results = self._results(n)
        done = 0
        for first in range(0, n, size):
            last = first + size >= n
            done += self._advance(recording.samples(first, first + size), last, *(r[done:] for r in results))
            if progress:
                progress(min(first + size, n), n)
        elapsed = time.perf_counter() - started
        warnings = (*recording.warnings, *self.warnings, *self._judge(recording, *results))
        return self._attitude(*results, warnings=warnings, processing_s=elapsed, source=recording.source)

    # -- live ------------------------------------------------------------------------------------------------------------

    def update(self, rows: Array) -> Attitude:
        """Take in sample rows (n,10); their attitudes, once the start is aligned (before that, none).

        Rows whose time does not increase are dropped and counted in a warning.
        """
        return self._piece(sample_rows(rows), False)

    def finish(self) -> Attitude:
        """No more samples will come: the attitudes of those that are still gathered, of a recording shorter than `initial.longest_s`."""
        return self._piece(np.empty((0, 10)), True)

    def save(self) -> dict[str, Any]:
        """The whole state: `restore` goes on from it as if nothing had happened."""
        return {
            "parameters": self.parameters,
            "name": self.name,
            "north": self.north,
            "intake": self._intake.save(),
            "alignment": self.alignment,
            "state": None if self._state is None else [a.copy() for a in self._state],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Self:
        """A filter in the state that `save` returned."""
        self = cls(saved["parameters"], name=saved["name"])  # pyright: ignore[reportCallIssue]
        self._intake = Intake.restore(saved["intake"])
        self.alignment, self.north = saved["alignment"], saved["north"]
        if saved["state"] is not None:
            self._state = tuple(a.copy() for a in saved["state"])
        return self

    def _piece(self, rows: Array, finish: bool) -> Attitude:
        results = self._results(self._intake.waiting + len(rows))
        done = self._advance(rows, finish, *results)
        return self._attitude(*(r[:done] for r in results), warnings=tuple(self.warnings))

    def _advance(self, rows: Array, finish: bool, *results: NDArray[Any]) -> int:
        """Feed rows; write the results of those that are answered, and return how many these are."""
        head, rows = self._intake.take(rows, finish)
        if head is not None:
            self._start(head)
        if self._state is None or not len(rows):
            return 0
        self._feed(rows, *results)
        return len(rows)
