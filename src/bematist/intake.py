"""How samples come in: in order of time, and the first seconds gathered until the start can be aligned."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.kernels.layout import BRIDGED_OVER
from bematist.kernels.stance import HELD_SAMPLE, MISSING
from bematist.recording import SAMPLE_COLUMNS

Array = NDArray[np.float64]


class Intake:
    """Sample rows of `width` columns on their way into an estimator, whose class is `owner`; `warnings` grows."""

    def __init__(self, longest_s: float, owner: str, width: int = len(SAMPLE_COLUMNS)) -> None:
        self.longest_s, self.owner, self.width = longest_s, owner, width
        self.warnings: list[str] = []
        self.last_time = -math.inf
        self.started = False
        self.finished = False
        self._gathered: list[Array] = []

    @property
    def waiting(self) -> int:
        """Rows that are gathered."""
        return sum(len(r) for r in self._gathered)

    @property
    def untouched(self) -> bool:
        return not self.started and not self._gathered

    def take(self, rows: Array, finish: bool) -> tuple[Array | None, Array]:
        """The rows to run on now, and before them, once, those of the first `longest_s` to align the start with.

        Rows whose time does not increase are dropped and counted in a warning. Until the start is there no row is given.

        Raises
        ------
        DataError
            The last row has come, and there was none.
        UsageError
            The last row had come already.
        """
        if self.finished:
            raise UsageError(f"finish() was called: make a new {self.owner} for more samples.")
        self.finished = finish
        rows = self._increasing(rows)
        if self.started:
            return None, rows
        if len(rows):
            self._gathered.append(rows.copy())
        if not self._gathered:
            if finish:
                raise DataError("There are no samples.")
            return None, rows
        start = self._gathered[0][0, 0]
        if self._gathered[-1][-1, 0] - start < self.longest_s and not finish:
            return None, rows[:0]
        rows = np.concatenate(self._gathered) if len(self._gathered) > 1 else self._gathered[0]
        self._gathered, self.started = [], True
        return rows[: int(np.searchsorted(rows[:, 0], start + self.longest_s, side="right"))], rows

    def _increasing(self, rows: Array) -> Array:
        t = np.concatenate([[self.last_time], rows[:, 0]])
        if not (np.diff(t) > 0).all():
            later = rows[:, 0] > np.maximum.accumulate(np.where(np.isfinite(t), t, -np.inf))[:-1]
            self.warnings.append(f"{(~later).sum()} sample(s) whose time did not increase were dropped.")
            rows = rows[later]
        if len(rows):
            self.last_time = float(rows[-1, 0])
        return rows

    def save(self) -> dict[str, Any]:
        """The state as plain values."""
        return {
            "longest_s": self.longest_s,
            "owner": self.owner,
            "width": self.width,
            "warnings": list(self.warnings),
            "last_time": self.last_time,
            "started": self.started,
            "finished": self.finished,
            "gathered": np.concatenate(self._gathered) if self._gathered else np.empty((0, self.width)),
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Self:
        """An intake in the state that `save` returned."""
        self = cls(saved["longest_s"], saved["owner"], saved["width"])
        self.warnings, self.last_time = list(saved["warnings"]), saved["last_time"]
        self.started, self.finished = saved["started"], saved["finished"]
        self._gathered = [saved["gathered"].copy()] if len(saved["gathered"]) else []
        return self


def sample_rows(rows: Array, width: int = len(SAMPLE_COLUMNS)) -> Array:
    """Sample rows (n,10) as given by a caller, checked; with `width` 11, an eleventh column, pressure, may follow, and is NaN otherwise.

    Raises
    ------
    UsageError
        The shape is another.
    """
    rows = np.asarray(rows, float)
    own = len(SAMPLE_COLUMNS)
    if rows.ndim == 2 and rows.shape[1] == own < width:
        return np.concatenate([rows, np.full((len(rows), width - own), np.nan)], 1)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise UsageError(
            f"update() takes rows of ten numbers (n,10): time, specific force, angular rate, magnetic flux density; this has shape "
            f"{rows.shape}. Write NaN where there is no magnetometer."
        )
    return rows


def gap_warnings(gaps: Array, doubtful: str) -> list[str]:
    """What a result says of gaps (G,), s, that were bridged, and what is in doubt because of them; nothing without one."""
    if not len(gaps):
        return []
    return [
        f"{len(gaps)} gap(s) of {gaps.sum():.2f} s in all were bridged, the longest {gaps.max():.2f} s: the {doubtful} is in doubt from "
        "there on."
    ]


def bridging_warnings(time: Array, flags: NDArray[np.float32], doubtful: str) -> list[str]:
    """What a result says of gaps and missing values: times (N,), s, and what became of each sample (flags of `kernels.stance`)."""
    flags = np.ascontiguousarray(flags)
    if not flags.any():
        return []
    known = np.flatnonzero(flags != MISSING)
    found = gap_warnings(np.diff(time[known])[flags[known][1:] == BRIDGED_OVER], doubtful)
    for value, words in ((HELD_SAMPLE, "held over missing values"), (MISSING, "skipped, values missing for too long")):
        if n := int((flags == value).sum()):
            found.append(f"{n} of {len(time)} samples were {words}.")
    return found
