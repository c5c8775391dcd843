"""Which instant of a trajectory belongs to which row of its reference: by time, or by footfall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.attitudes import Attitude
from bematist.errors import DataError
from bematist.evaluate.alignment import align_path
from bematist.frames import conjugate, multiply, quaternion_from_rotation_vector, rotation_vector_from_quaternion
from bematist.recording import Reference
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]

MERGE_S = 0.1
"""Two stance phases less apart than this are one footfall, s."""
MERGE_M = 0.05
"""Two stance phases at places less apart than this are one footfall, m."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Pairs:
    """The trajectory at the rows of the reference that could be paired (K rows each)."""

    rows: NDArray[np.int64]
    """Rows of the reference."""
    time: Array
    """On the trajectory's clock, s."""
    position: Array
    velocity: Array
    attitude: Array
    packed_covariance: Array
    by_footfall: bool
    notes: tuple[str, ...] = ()


def pair(trajectory: Trajectory, reference: Reference) -> Pairs:
    """The trajectory at the reference's own instants, or at its footfalls.

    By time, the trajectory is interpolated (linearly; attitude along the shortest rotation), never the reference; rows
    outside the trajectory's time or without a plan position are left out and counted. By footfall, see
    `match_footfalls`.

    Raises
    ------
    DataError
        Nothing can be paired.
    """
    if not len(trajectory):
        raise DataError("The trajectory is empty: there is nothing to evaluate.")
    if np.isfinite(reference.time).any() or reference.footfall is None:
        return _by_time(trajectory, reference)
    return _by_footfall(trajectory, reference)


def _by_time(trajectory: Trajectory, reference: Reference) -> Pairs:
    t, notes = trajectory.time, []
    placed = np.isfinite(reference.position[:, :2]).all(1) & np.isfinite(reference.time)
    if reference.judged is not None:
        notes.append(f"errors are counted over {reference.judged.sum()} of {len(placed)} rows of the reference, as it asks")
        placed &= reference.judged
    # A tolerance of a µs: a time that was written with few digits must not lose the last row.
    inside = (reference.time >= t[0] - 1e-6) & (reference.time <= t[-1] + 1e-6)
    rows = np.flatnonzero(placed & inside)
    if not len(rows):
        span = reference.time[placed]
        where = f"from {span.min():.3f} s to {span.max():.3f} s" if len(span) else "with no row that has time, east and north"
        raise DataError(
            f"The trajectory (from {t[0]:.3f} s to {t[-1]:.3f} s) and the reference ({where}) do not overlap. Both "
            f"clocks must count "
            "seconds from the start of the recording: shift the reference's time column, or check that the two belong "
            "together."
        )
    if missing := int((~placed if reference.judged is None else reference.judged & ~placed).sum()):
        notes.append(f"{missing} rows of the reference have no time or no position and were left out")
    if outside := int((placed & ~inside).sum()):
        notes.append(f"{outside} rows of the reference lie outside the trajectory's time and were left out")
    at = np.clip(reference.time[rows], t[0], t[-1])
    return Pairs(rows=rows, time=at, **sample(trajectory, at), by_footfall=False, notes=tuple(notes))


def sample(trajectory: Trajectory, at: Array) -> dict[str, Array]:
    """Position, velocity, attitude and packed covariance of the trajectory at the times `at` (K,), s, inside its
    span.
    """
    t = trajectory.time
    if len(at) == len(t) and np.array_equal(at, t):
        names = ("position", "velocity", "attitude", "packed_covariance")
        return {name: getattr(trajectory, name) for name in names}
    k, after, u = _between(t, at)

    def between(values: Array) -> Array:
        return values[k] + u * (values[after] - values[k])

    return {
        "position": between(trajectory.position),
        "velocity": between(trajectory.velocity),
        "attitude": attitude_at(trajectory, at),
        "packed_covariance": between(trajectory.packed_covariance),
    }


def _between(t: Array, at: Array) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Samples before and after the times `at` (K,), and how far between them these are (K,1), 0 … 1."""
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, max(len(t) - 2, 0))
    after = np.minimum(k + 1, len(t) - 1)
    step = np.where(after > k, t[after] - t[k], 1.0)
    return k, after, ((at - t[k]) / step)[:, None]


def attitude_at(estimate: Trajectory | Attitude, at: Array) -> Array:
    """Attitudes (K,4) at the times `at` (K,), s, inside the estimate's span, along the shortest rotation between its samples."""
    t, q = estimate.time, estimate.attitude
    if len(at) == len(t) and np.array_equal(at, t):
        return q
    k, after, u = _between(t, at)
    turn = rotation_vector_from_quaternion(multiply(conjugate(q[k]), q[after]))
    return multiply(q[k], quaternion_from_rotation_vector(u * turn))


def footfalls(trajectory: Trajectory) -> tuple[NDArray[np.int64], Array]:
    """Footfalls of the shoe: their middle samples (M,) and their mean positions (M,3), m.

    Stance phases less than 0.1 s apart, or at places less than 5 cm apart, are one footfall: detectors break a stance,
    and a foot that is lifted and put back has not walked.
    """
    spans = [(int(a), int(b)) for a, b in trajectory.stance_intervals()]
    merged: list[list[tuple[int, int]]] = []
    for first, end in spans:
        if merged and _same_place(trajectory, merged[-1], (first, end)):
            merged[-1].append((first, end))
        else:
            merged.append([(first, end)])
    middle = np.array([(m[0][0] + m[-1][1]) // 2 for m in merged], np.int64)
    return middle, np.array([_mean(trajectory, m) for m in merged]).reshape(-1, 3)


def _mean(trajectory: Trajectory, spans: list[tuple[int, int]]) -> Array:
    return np.concatenate([trajectory.position[a:b] for a, b in spans]).mean(0)


def _same_place(trajectory: Trajectory, group: list[tuple[int, int]], span: tuple[int, int]) -> bool:
    apart = trajectory.time[span[0]] - trajectory.time[group[-1][1] - 1]
    return apart < MERGE_S or float(np.linalg.norm(_mean(trajectory, group[-1:]) - _mean(trajectory, [span]))) < MERGE_M


def _by_footfall(trajectory: Trajectory, reference: Reference) -> Pairs:
    middle, place = footfalls(trajectory)
    if not len(middle):
        raise DataError(
            "The reference counts footfalls, but the trajectory has no stance phase to match them with. Look at the "
            "stance "
            "detection with `bematist stance`."
        )
    known = np.flatnonzero(np.isfinite(reference.position[:, :2]).all(1))
    if not len(known):
        raise DataError("The reference has no row with a position: there is nothing to compare with.")
    assert reference.footfall is not None
    mine, theirs = match_footfalls(place, reference.position[known], reference.footfall[known], reference.mirrored)
    notes = []
    if len(mine) < len(place) or len(theirs) < len(known):
        notes.append(
            f"the trajectory has {len(place)} footfalls and the reference {len(known)}: matched in order with the "
            f"least error, leaving "
            f"out {len(place) - len(mine)} of the trajectory and {len(known) - len(theirs)} of the reference"
        )
    at = middle[mine]
    return Pairs(
        rows=known[theirs],
        time=trajectory.time[at],
        position=place[mine],
        velocity=trajectory.velocity[at],
        attitude=trajectory.attitude[at],
        packed_covariance=trajectory.packed_covariance[at],
        by_footfall=True,
        notes=tuple(notes),
    )


def match_footfalls(
    place: Array, reference: Array, footfall: NDArray[np.int64], mirrored: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which footfall of the trajectory is which of the reference: two index arrays of one length.

    Where the trajectory has exactly the footfalls that the reference counts, the counts decide. Otherwise every
    footfall of the side that has fewer is matched, in order, so that the sum of squared plan errors after yaw alignment
    is least: dynamic programming in turn with alignment, from several starts (and their mirror images where allowed).
    """
    if footfall.min() >= 0 and len(place) == footfall.max() + 1:
        return np.asarray(footfall, np.int64), np.arange(len(footfall))
    few, many = (place, reference) if len(place) < len(reference) else (reference, place)
    best, least = np.arange(len(few)), np.inf
    for handed in (1.0, -1.0) if mirrored else (1.0,):
        for start in _starts(len(few), len(many)):
            found, cost = _settle(_plan(few) * [1.0, handed, 1.0], _plan(many), start)
            if cost < least:
                best, least = found, cost
    every = np.arange(len(few))
    return (every, best) if few is place else (best, every)


def _plan(position: Array) -> Array:
    return np.column_stack([position[:, :2], np.zeros(len(position))])


def _starts(few: int, many: int) -> list[NDArray[np.int64]]:
    # Guesses to settle from: the surplus lies at the ends, or is spread, or the first footfalls match whatever follows.
    rows, surplus = np.arange(few), many - few
    lags = np.unique(np.clip(np.append(np.arange(6), surplus), 0, surplus))
    spread = np.round(rows * ((many - 1) / max(few - 1, 1))).astype(np.int64)
    return [spread, *(rows + lag for lag in lags), *(rows[:12] + lag for lag in lags)]


def _settle(few: Array, many: Array, start: NDArray[np.int64]) -> tuple[NDArray[np.int64], float]:
    # Align, assign, align again, until nothing changes: the cost falls with every turn.
    found, cost = start, np.inf
    for _ in range(10):
        moved = align_path(few[: len(found)], many[found]).path(few)
        new, cost = _assign(((moved[:, None, :2] - many[None, :, :2]) ** 2).sum(-1))
        if np.array_equal(new, found):
            break
        found = new
    return found, cost


def _assign(cost: Array) -> tuple[NDArray[np.int64], float]:
    """The increasing choice of one column (of M) for each row (of K ≤ M) with the least sum, and that sum."""
    K, M = cost.shape
    total, choice = np.zeros(M + 1), np.empty((K, M), np.int64)
    for k in range(K):
        # total[m] is the least cost of the rows so far within the first m columns.
        here = total[:-1] + cost[k]
        least = np.minimum.accumulate(here)
        first = np.concatenate([[True], here[1:] < least[:-1]])
        choice[k] = np.maximum.accumulate(np.where(first, np.arange(M), 0))
        total = np.concatenate([[np.inf], least])
    columns, end = np.empty(K, np.int64), M
    for k in range(K - 1, -1, -1):
        columns[k] = choice[k, end - 1]
        end = columns[k]
    return columns, float(total[-1])
