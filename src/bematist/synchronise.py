"""The offset and drift between two clocks, from the same motion seen by both: norms of rates, which know no frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from bematist.attitudes import Attitude
from bematist.earth import STANDARD_GRAVITY
from bematist.errors import DataError
from bematist.frames import conjugate, multiply, rotation_vector_from_quaternion
from bematist.recording import Recording, Reference
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]
Source = Recording | Reference | Trajectory | Attitude
Quantity = Literal["angular rate", "specific force"]
Dated = TypeVar("Dated", Recording, Reference)

STEP_S = 0.01
"""Both are averaged over steps of this length, s."""
GAP_S = 0.25
"""Over a longer pause between samples nothing is known, s."""
LEAST_S = 5.0
"""Shortest overlap that is looked at, s; and a quarter of the shorter one."""
APART_S = 0.25
"""A peak this far from the highest one is another one, s."""
CLEAR, HIGHER, NEARER = 0.3, 1.15, 2.0
"""A clear peak has at least this correlation, and is this many times as high as the next, or this many times nearer to 1."""
GLITCH = 1.5
"""Norms are cut at this many times their 99 % quantile: a camera that takes one marker for another turns by radians at once."""
PIECE_S, PIECES, NEAR_S = 20.0, 4, 0.5
"""For the drift: length of a piece, s, how many there must be, and how far its offset may be from that of the whole, s."""
SECOND_S = 0.1
"""Distance of the second differences of positions, s; the specific force is averaged alike."""


@dataclass(frozen=True, kw_only=True)
class Shift:
    """How the clock of B runs against A's: what is at t on B's is at `offset_s + (1 + drift) t` on A's.

    Attributes
    ----------
    offset_s : s. sd_s : its standard deviation, s, from the scatter of the pieces; NaN where they are too few.
    drift : s per s; 0 where it is not known. drift_sd : s per s, NaN where it is not known.
    correlation, second : of the highest peak, and of the next.
    quantity : what was correlated: "angular rate" or "specific force".
    overlap_s : how long both see the motion, s.
    """

    offset_s: float
    sd_s: float
    drift: float
    drift_sd: float
    correlation: float
    second: float
    quantity: Quantity
    overlap_s: float

    def times(self, time: Array) -> Array:
        """Times of B's clock on A's."""
        return self.offset_s + (1 + self.drift) * time

    def apply(self, b: Dated) -> Dated:
        """B on A's clock."""
        if isinstance(b, Reference):
            return replace(b, time=self.times(b.time))
        own = None if b.reference is None else self.apply(b.reference)
        fields = ("time", "magnetic_time", "pressure_time")
        return replace(b, reference=own, start_ns=None, **{name: self.times(getattr(b, name)) for name in fields})


def sync(a: Source, b: Source) -> Shift:
    """The clock of b against that of a, two views of one motion: recordings, references, trajectories or attitudes.

    The norms of both angular rates are correlated; of a reference without attitudes the norm of its acceleration and gravity, with that
    of the specific force. A parabola finds the peak to a fraction of a step. From two minutes on the
    offsets of pieces give the drift.

    Raises
    ------
    DataError
        There is no clear peak, or nothing to compare.
    """
    known: list[dict[Quantity, tuple[Array, Array] | None]] = [{"angular rate": _rates(x), "specific force": _forces(x)} for x in (a, b)]
    quantities: tuple[Quantity, ...] = ("angular rate", "specific force")
    shared: list[tuple[Quantity, tuple[Array, Array], tuple[Array, Array]]] = [
        (q, first, other) for q in quantities if (first := known[0][q]) is not None and (other := known[1][q]) is not None
    ]
    if not shared:
        raise DataError(
            "The clocks cannot be compared: one knows only attitudes and the other only positions. Give a recording for one of them."
        )
    quantity, first, other = shared[0]
    zero_a, ya = _even(*first)
    zero_b, yb = _even(*other)
    least = max(LEAST_S, 0.25 * STEP_S * min(np.isfinite(ya).sum(), np.isfinite(yb).sum()))
    lags, found, overlap = _correlation(ya, yb, int(least / STEP_S))
    best = int(np.argmax(found))
    apart = np.abs(lags - lags[best]) > APART_S / STEP_S
    second = float(found[apart].max(initial=0.0))
    peak = float(found[best])
    distinct = peak >= HIGHER * second or 1 - second >= NEARER * (1 - peak)
    if not (peak >= CLEAR and distinct):
        raise DataError(
            f"The clocks cannot be compared: the norms of the {quantity} have no clear peak. The highest correlation is {peak:.2f} at "
            f"{zero_a - zero_b + lags[best] * STEP_S:+.2f} s, the next {second:.2f}. Both must see the same motion for some seconds, and "
            "one that does not repeat itself: turn the sensors together at the start."
        )
    shift = Shift(
        offset_s=zero_a - zero_b + (lags[best] + _vertex(found, best)) * STEP_S,
        sd_s=math.nan,
        drift=0.0,
        drift_sd=math.nan,
        correlation=peak,
        second=second,
        quantity=quantity,
        overlap_s=float(overlap[best] * STEP_S),
    )
    return _drifting(shift, (zero_a, ya), (zero_b, yb))


def _drifting(shift: Shift, a: tuple[float, Array], b: tuple[float, Array]) -> Shift:
    """The shift with drift and standard deviations, where there are enough pieces of b that are found near in a."""
    (zero_a, ya), (zero_b, yb) = a, b
    n, near = round(PIECE_S / STEP_S), round(NEAR_S / STEP_S)
    times, offsets = [], []
    for start in range(0, len(yb) - n + 1, n):
        middle = zero_b + (start + n / 2) * STEP_S
        first = round((zero_b + start * STEP_S + shift.offset_s - zero_a) / STEP_S)
        if first < near or first + n + near > len(ya):
            continue
        lags, found, _ = _correlation(ya[first - near : first + n + near], yb[start : start + n], n // 2)
        best = int(np.argmax(found))
        if found[best] >= CLEAR and 0 < best < len(found) - 1 and 0 <= lags[best] <= 2 * near:
            times.append(middle)
            offsets.append(zero_a + (first - near + lags[best] + _vertex(found, best) - start) * STEP_S - zero_b)
    if len(times) < PIECES:
        return shift
    t, d = np.array(times), np.array(offsets)
    good, off, line = np.ones(len(t), bool), np.zeros(len(t)), np.zeros(2)
    for _ in range(3):  # pieces whose peak is another one are left out
        line = np.polyfit(t[good] - t.mean(), d[good], 1)
        off = np.abs(d - np.polyval(line, t - t.mean()))
        good = off <= max(STEP_S, 4 * float(np.median(off)))
    if good.sum() < PIECES:
        return shift
    spread = t[good] - t[good].mean()
    sd = math.sqrt(float(np.square(off[good]).sum()) / (good.sum() - 2))
    drift, middle = float(line[0]), float(line[1])
    drift_sd = sd / math.sqrt(float(spread @ spread))
    if abs(drift) < 3 * drift_sd:
        return replace(shift, offset_s=float(np.median(d[good])), sd_s=sd / math.sqrt(good.sum()), drift_sd=drift_sd)
    # The offset is that at time 0 of b, which may lie far from the middle of the pieces.
    sd_s = math.hypot(sd / math.sqrt(good.sum()), float(t[good].mean()) * drift_sd)
    return replace(shift, offset_s=middle - drift * float(t.mean()), sd_s=sd_s, drift=drift, drift_sd=drift_sd)


def _rates(x: Source) -> tuple[Array, Array] | None:
    """Times (K,) and norms (K,), rad/s, of the angular rate."""
    if isinstance(x, Recording):
        return _finite(x.time, np.linalg.norm(x.angular_rate, axis=1))
    q: Any = x.attitude
    if q is None:
        return None
    good = np.isfinite(x.time) & np.isfinite(q).all(1)
    t, q = x.time[good], q[good]
    # Differences over a hundredth of a second at least: of closer attitudes only the digits differ.
    stride = max(1, round(STEP_S / float(np.median(np.diff(t))))) if len(t) > 1 else 1
    t, q = t[::stride], q[::stride]
    turned = np.linalg.norm(rotation_vector_from_quaternion(multiply(conjugate(q[:-1]), q[1:])), axis=1)
    dt = np.diff(t)
    fine = (dt > 0) & (dt <= GAP_S)
    return _finite((t[:-1] + t[1:])[fine] / 2, turned[fine] / dt[fine])


def _forces(x: Source) -> tuple[Array, Array] | None:
    """Times (K,) and norms (K,), m/s², of the specific force, averaged over `SECOND_S` as second differences of positions are."""
    if isinstance(x, Recording):
        found = _finite(x.time, np.linalg.norm(x.specific_force, axis=1))
        if found is None:
            return None
        zero, y = _even(*found)
        width = round(SECOND_S / STEP_S)
        weights = np.bartlett(2 * width + 1)
        smooth = np.asarray(np.convolve(y, weights / weights.sum(), "same"), float)
        return _finite(zero + np.arange(len(y), dtype=float) * STEP_S, smooth)
    if isinstance(x, Attitude):
        return None
    good = np.isfinite(x.time) & np.isfinite(x.position[:, :2]).all(1)
    p = np.where(np.isfinite(x.position), x.position, 0.0)[good]
    if good.sum() < 3:
        return None
    t = np.arange(x.time[good][0] + SECOND_S, x.time[good][-1] - SECOND_S, STEP_S)
    at = [np.column_stack([np.interp(t + d, x.time[good], axis) for axis in p.T]) for d in (-SECOND_S, 0.0, SECOND_S)]
    force = (at[0] - 2 * at[1] + at[2]) / SECOND_S**2 + [0, 0, STANDARD_GRAVITY]
    last = x.time[good][np.searchsorted(x.time[good], t, side="right") - 1]
    return _finite(t, np.where(t - last <= GAP_S, np.linalg.norm(force, axis=1), np.nan))


def _finite(t: Array, x: Array) -> tuple[Array, Array] | None:
    good = np.isfinite(t) & np.isfinite(x)
    return (t[good], x[good]) if good.sum() > 1 else None


def _even(t: Array, x: Array) -> tuple[float, Array]:
    """Means of x over steps of `STEP_S`, NaN where nothing is known, and the time of the middle of the first."""
    x = np.minimum(x, GLITCH * np.quantile(x, 0.99))
    total = np.concatenate([[0.0], np.cumsum(np.diff(t) * (x[1:] + x[:-1]) / 2)])
    edges = np.arange(t[0], t[-1], STEP_S)
    means = np.diff(np.interp(edges, t, total)) / STEP_S
    middle = edges[:-1] + STEP_S / 2
    after = np.searchsorted(t, middle).clip(1, len(t) - 1)
    return float(edges[0] + STEP_S / 2), np.where(t[after] - t[after - 1] <= GAP_S, means, np.nan)


def _correlation(a: Array, b: Array, least: int) -> tuple[NDArray[np.int64], Array, Array]:
    """Correlation of a (N,) with b (M,) by lag: a[k + lag] with b[k], where both are known; with the lags, and how many steps overlap.

    -1 where fewer than `least` steps overlap, or where one of them hardly moves.
    """
    size = 1 << (len(a) + len(b) - 1).bit_length()
    known = [np.isfinite(x).astype(float) for x in (a, b)]
    values = [np.where(k > 0, x - np.nanmean(x), 0.0) for x, k in zip((a, b), known, strict=True)]
    fa, fka, fsa, fb, fkb, fsb = (np.fft.rfft(x, size) for v, k in zip(values, known, strict=True) for x in (v, k, v**2))
    fb, fkb, fsb = fb.conj(), fkb.conj(), fsb.conj()
    lags = np.arange(-len(b) + 1, len(a))
    n, sa, sb, saa, sbb, sab = (np.fft.irfft(f, size)[lags] for f in (fka * fkb, fa * fkb, fka * fb, fsa * fkb, fka * fsb, fa * fb))
    n = np.round(n)
    many = np.maximum(n, 1)
    va, vb = saa / many - (sa / many) ** 2, sbb / many - (sb / many) ** 2
    moves = (va > 0.1 * np.nanvar(a)) & (vb > 0.1 * np.nanvar(b)) & (n >= max(least, 2))
    both = np.sqrt(np.where(moves, va * vb, 1.0))
    return lags, np.where(moves, (sab / many - sa * sb / many**2) / both, -1.0), n


def _vertex(x: Array, k: int) -> float:
    """Where the parabola through x[k - 1 .. k + 1] is highest, in steps from k."""
    if not 0 < k < len(x) - 1:
        return 0.0
    bend = x[k - 1] - 2 * x[k] + x[k + 1]
    return float(np.clip((x[k - 1] - x[k + 1]) / (2 * bend), -0.5, 0.5)) if bend < 0 else 0.0
