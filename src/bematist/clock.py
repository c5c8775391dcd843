"""From the stamps that a logger wrote to the times at which the samples were taken.

Two things are common. Stamps may be late reports of a sensor that samples evenly (packets, a busy phone): then the clock
behind them is fitted. Or they may be the true instants, with samples lost or unevenly taken: then they are kept. `repair`
decides by evidence and says why.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bematist.clockfit import period, signal_vote, uniform
from bematist.errors import DataError, UsageError

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mode = Literal["auto", "uniform", "stamps"]

REGULAR = 0.02
"""Stamps whose steps are whole multiples of the period within this part of it need no repair."""
DECISIVE = 4.0
"""Standard errors from which the signal decides between the hypotheses."""
FARTHEST_S = 1e12
"""A stamp beyond it (30,000 years) is a damaged number."""
CLOCK_SET_S = 86400.0
"""A leap by more than this is a clock that was set, not a pause."""


@dataclass(frozen=True)
class Clock:
    """A repaired time axis.

    Attributes
    ----------
    time : (M,) s, strictly increasing.
    rows : (M,) row of the raw stamps that each time belongs to.
    kind : "uniform" (the clock was fitted) or "stamps" (they were kept).
    note : which, and why.
    lost : (M−1,) samples missing at each step.
    warnings : what is suspicious.
    """

    time: Array
    rows: Rows
    kind: str
    note: str
    lost: Rows
    warnings: tuple[str, ...] = ()


def repair(
    stamps: Array,
    values: Array | Callable[[], Array] | None = None,
    mode: Mode = "auto",
    *,
    count: Rows | None = None,
    wrap_s: float | None = None,
    name: str = "time",
) -> Clock:
    """Repair the stamps (N,), in s, of samples `values` (N,C), or of what returns them: most clocks are told apart without.

    `count` (N,) is the sensor's own sample counter where the file has one: it tells which samples are lost.
    `wrap_s` is the span of the counter behind the stamps where it is known (2³² µs). `name` names the clock in messages.

    Raises
    ------
    DataError
        No stamp is finite, or the stamps never advance, or they run backwards.
    UsageError
        An unknown mode.
    """
    if mode not in ("auto", "uniform", "stamps"):
        raise UsageError(f'Clock "{mode}": choose "auto", "uniform" or "stamps".')
    rows = np.flatnonzero(np.abs(stamps) < FARTHEST_S)
    t = np.asarray(stamps, float)[rows]
    warnings: list[str] = []
    if len(rows) < len(stamps):
        warnings.append(f"{len(stamps) - len(rows)} rows without a {name} stamp were left out.")
    if not len(t):
        raise DataError(f"No {name} stamp is a number. Name the right column, or give the rate, with --columns map.toml.")

    def signal() -> Array | None:
        x = values() if callable(values) else values
        return None if x is None else np.asarray(x, float)[rows]

    # Most clocks only advance.
    if len(t) > 1 and not 0 < (step := np.diff(t)).min() <= step.max() < CLOCK_SET_S:
        t, rows, _ = _mend(t, rows, signal(), wrap_s, warnings, name)
    if len(t) < 3:
        order = np.argsort(t, kind="stable")
        return Clock(_spread(t[order]), rows[order], "stamps", "too few samples to judge", np.zeros(len(t) - 1, int))
    number = None if count is None else count[rows]
    if number is not None and np.any(np.diff(number) < 1):
        number = None
    time, lost, kind, note = _decide(t, signal, mode, number)
    _tell_gaps(time, lost, warnings, name)
    return Clock(time, rows, kind, note, lost, tuple(warnings))


def _mend(t: Array, rows: Rows, x: Array | None, wrap_s: float | None, warnings: list[str], name: str):
    """Stamps that repeat, go back or leap."""
    if np.ptp(t) == 0:
        raise DataError(
            f"The {name} stamps never advance (all are {t[0]:g}). Name another time column, or give the rate, with --columns map.toml."
        )
    if np.mean(np.diff(t) < 0) > 0.5:
        raise DataError(f"The {name} stamps run backwards. Sort the rows by time, or name another column with --columns map.toml.")
    t = _unwrap(t, wrap_s, warnings, name)
    t, rows, x = _drop_repeats(t, rows, x, warnings, name)
    t, rows, x = _drop_strays(t, rows, x, warnings, name)
    t, rows, x = _undo_swaps(t, rows, x, warnings, name)
    return _undo_resets(t, warnings, name), rows, x


def _unwrap(t: Array, wrap_s: float | None, warnings: list[str], name: str) -> Array:
    if wrap_s is None:
        return t
    d = np.diff(t)
    turn = (d < -0.5 * wrap_s) & (d + wrap_s < max(60.0, 0.01 * wrap_s))
    if turn.any():
        warnings.append(f"The counter behind the {name} stamps began anew {turn.sum()} times; unrolled.")
        t = t + wrap_s * np.concatenate([[0], np.cumsum(turn)])
    return t


def _take(keep: Rows, t: Array, rows: Rows, x: Array | None) -> tuple[Array, Rows, Array | None]:
    return t[keep], rows[keep], None if x is None else x[keep]


def _drop_repeats(t: Array, rows: Rows, x: Array | None, warnings: list[str], name: str):
    again = np.diff(t) == 0
    if not again.any() or x is None:
        return t, rows, x
    same = again.copy()
    k = np.flatnonzero(again)
    same[k] = ((x[k] == x[k + 1]) | (np.isnan(x[k]) & np.isnan(x[k + 1]))).all(1)
    # Where most repeated stamps carry new values, they are late reports, and equal values are chance.
    if same.sum() * 2 < again.sum():
        return t, rows, x
    warnings.append(f"{same.sum()} rows that repeat the row before them ({name} and values) were left out.")
    return _take(np.flatnonzero(~np.concatenate([[False], same])), t, rows, x)


def _drop_strays(t: Array, rows: Rows, x: Array | None, warnings: list[str], name: str):
    """Single stamps far from both neighbours, which agree with each other."""
    if len(t) < 4:
        return t, rows, x
    far = 20 * period(t)
    before, here, after = t[:-2], t[1:-1], t[2:]
    stray = (np.abs(here - before) > far) & (np.abs(here - after) > far) & (after > before) & (after - before < far)
    if not stray.any():
        return t, rows, x
    warnings.append(f"{stray.sum()} rows with a {name} stamp far from its neighbours were left out.")
    return _take(np.flatnonzero(~np.concatenate([[False], stray, [False]])), t, rows, x)


def _undo_swaps(t: Array, rows: Rows, x: Array | None, warnings: list[str], name: str):
    """Sort rows that came in the wrong order, where sorting leaves an even clock."""
    d = np.diff(t)
    T = period(t)
    swapped = (d < 0) & (d > -20 * T)
    if not swapped.any() or swapped.mean() > 0.05:
        return t, rows, x
    piece = np.concatenate([[0], np.cumsum(d <= -20 * T)])
    order = np.lexsort((t, piece))
    step = np.diff(t[order])
    near = np.flatnonzero(np.isin(order[:-1], np.flatnonzero(swapped) + 1))
    off = np.abs(step[near] / T - np.round(step[near] / T))
    if np.median(off) > 0.1 or np.any(step[near] == 0):
        return t, rows, x
    warnings.append(f"{swapped.sum()} rows came in the wrong order and were sorted by {name}.")
    t, rows, x = _take(order, t, rows, x)
    return _drop_repeats(t, rows, x, warnings, name)


def _undo_resets(t: Array, warnings: list[str], name: str) -> Array:
    d = np.diff(t)
    T = period(t)
    back = np.flatnonzero(d <= -max(20 * T, 1e-9))
    leap = np.flatnonzero(d > CLOCK_SET_S)
    if not len(back) and not len(leap):
        return t
    shift = np.zeros(len(t))
    for i in np.concatenate([back, leap]):
        shift[i + 1] += T - d[i]
    for what, which in (("went back", back), ("leapt ahead", leap)):
        if len(which):
            i = which[0]
            warnings.append(
                f"The {name} clock {what} {len(which)} times, first by {abs(d[i]):.6g} s at row {i + 2}; the recording "
                "goes on one step later, and how long the pause really was is unknown."
            )
    return t + np.cumsum(shift)


def _spread(t: Array) -> Array:
    """Strictly increasing times: sorted, and equal stamps spread evenly up to the next."""
    t = np.maximum.accumulate(t)
    value, first, count = np.unique(t, return_index=True, return_counts=True)
    if len(value) == len(t):
        return t
    ahead = np.append(np.diff(value), np.median(np.diff(value)) if len(value) > 1 else 1e-3)
    k = np.arange(len(t)) - np.repeat(first, count)
    return np.repeat(value, count) + np.repeat(ahead / count, count) * k


def _decide(t: Array, signal: Callable[[], Array | None], mode: str, count: Rows | None) -> tuple[Array, Rows, str, str]:
    d = np.diff(t)
    T = period(t)
    off = np.abs(d / T - np.round(d / T))
    regular = bool(d.min() > 0.5 * T and (off.max() < REGULAR or np.quantile(off, 0.99) < REGULAR))
    if mode != "uniform" and regular:
        lost = np.maximum(np.round(d / T).astype(np.int64) - 1, 0)
        why = f"steps are whole multiples of {1e3 * T:.4g} ms ({1 / T:.4g} Hz): the stamps are true and were kept"
        return t, lost, "stamps", why
    fitted, lost = uniform(t, count)
    kept = _spread(t)
    jitter = float(np.sqrt(np.mean((t - fitted) ** 2)))
    what = f"steps of {1e3 * d.min():.3g} to {1e3 * d.max():.4g} ms"
    if mode == "auto":
        mode, why = _weigh(kept, fitted, d, signal())
    else:
        why = "as asked"
    if mode == "uniform":
        rate = 1 / float(np.median(np.diff(fitted)))
        note = f"{what} report an even clock of {rate:.5g} Hz ({why}): it was fitted; stamps lie {1e3 * jitter:.2g} ms rms off"
        return fitted, lost, "uniform", note
    gaps = np.where(np.diff(kept) > 3 * T, np.round(np.diff(kept) / T).astype(np.int64) - 1, 0)
    return kept, gaps, "stamps", f"{what} are true sampling instants ({why}): they were kept"


def _weigh(kept: Array, fitted: Array, d: Array, x: Array | None) -> tuple[str, str]:
    """Which hypothesis, and why. The signal decides where it can; else the pattern of the steps does."""
    vote = 0.0 if x is None else signal_vote(kept, fitted, x)
    if abs(vote) > DECISIVE:
        return ("uniform" if vote > 0 else "stamps"), f"the signal is smoother on it, by {abs(vote):.0f} standard errors"
    repeated = float(np.mean(d <= 0))
    if repeated > 0.05:
        return "uniform", f"{100 * repeated:.0f} % of the stamps repeat or go back while the values go on"
    late = np.clip(d, *np.quantile(d, [0.01, 0.99]))
    spread = float(late.std())
    follow = float(np.mean((late[:-1] - late.mean()) * (late[1:] - late.mean()))) / spread**2 if spread > 0 else 0.0
    if follow < -0.2:
        return "uniform", f"a long step is followed by a short one, correlation {follow:.2f}"
    return "stamps", f"steps do not make up for one another, correlation {follow:.2f}"


def _tell_gaps(time: Array, lost: Rows, warnings: list[str], name: str) -> None:
    holes = np.flatnonzero(lost > 0)
    if len(holes):
        step = np.diff(time)[holes]
        k = int(np.argmax(step))
        warnings.append(
            f"{len(holes)} gaps in {name}, {int(lost.sum())} samples missing; the longest lasts {step[k]:.4g} s from "
            f"{time[holes[k]]:.6g} s."
        )
