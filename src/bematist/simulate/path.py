"""The way that is walked: legs between waypoints, joined by arcs; some of them stairs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bematist.errors import UsageError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Path:
    """A curve of straight pieces and arcs in the plan, with a height that changes evenly between waypoints.

    Attributes
    ----------
    begin : (S+1,) m, where each piece begins along the path; the last entry is the length.
    start : (S,2) m, its first point.
    yaw : (S,) rad, its first direction.
    curvature : (S,) 1/m, positive to the left.
    height_at, height : (W,) m, heights along the path.
    """

    begin: Array
    start: Array
    yaw: Array
    curvature: Array
    height_at: Array
    height: Array

    @property
    def length_m(self) -> float:
        return float(self.begin[-1])

    def at(self, s: ArrayLike) -> tuple[Array, Array]:
        """Positions (K,3), m, and directions (K,), rad, unwrapped along the path, at the distances s (K,), m."""
        s = np.asarray(s, float)
        k = np.clip(np.searchsorted(self.begin, s, side="right") - 1, 0, len(self.yaw) - 1)
        d = s - self.begin[k]
        turn = self.curvature[k] * d
        # The chord of an arc: d sinc(turn/2) in the direction half-way.
        chord, middle = d * np.sinc(turn / (2 * np.pi)), self.yaw[k] + turn / 2
        plan = self.start[k] + chord[:, None] * np.column_stack([np.cos(middle), np.sin(middle)])
        return np.column_stack([plan, np.interp(s, self.height_at, self.height)]), self.yaw[k] + turn


def rounded(waypoints: ArrayLike, radius_m: float) -> Path:
    """The path through waypoints (W,3) with corners rounded by `radius_m`, less where a leg is too short for it."""
    p = np.asarray(waypoints, float)
    leg = np.diff(p[:, :2], axis=0)
    length = np.linalg.norm(leg, axis=1)
    p, leg, length = p[np.append(True, length > 0)], leg[length > 0], length[length > 0]
    yaw = np.unwrap(np.arctan2(leg[:, 1], leg[:, 0]))
    turn = np.diff(yaw)
    # What a corner takes off its two legs: at most half the shorter one.
    off = np.minimum(radius_m * np.tan(np.abs(turn) / 2), 0.5 * np.minimum(length[:-1], length[1:]))
    off = np.where(np.abs(turn) > 1e-9, off, 0.0)
    arc = np.where(off > 0, np.abs(turn) * off / np.where(off > 0, np.tan(np.abs(turn) / 2), 1.0), 0.0)
    before, after = np.concatenate([[0.0], off]), np.concatenate([off, [0.0]])
    unit = leg / length[:, None]
    n = len(leg)
    pieces = np.empty(2 * n - 1)
    pieces[0::2], pieces[1::2] = length - before - after, arc
    start = np.empty((2 * n - 1, 2))
    start[0::2], start[1::2] = p[:-1, :2] + unit * before[:, None], p[1:-1, :2] - unit[:-1] * off[:, None]
    direction, curvature = np.repeat(yaw, 2)[:-1], np.zeros(2 * n - 1)
    curvature[1::2] = np.where(arc > 0, turn / np.where(arc > 0, arc, 1.0), 0.0)
    begin = np.concatenate([[0.0], pieces.cumsum()])
    corners = (begin[1::2][: n - 1] + begin[2::2][: n - 1]) / 2
    return Path(begin, start, direction, curvature, np.concatenate([[0.0], corners, begin[-1:]]), p[:, 2])


def scaled(waypoints: ArrayLike, radius_m: float, length_m: float | None) -> Path:
    """`rounded`, with the plan of the waypoints scaled so that the path has `length_m`; heights stay."""
    p = np.asarray(waypoints, float)
    path = rounded(p, radius_m)
    for _ in range(20):
        if length_m is None or abs(path.length_m - length_m) < 1e-9 * length_m:
            break
        p = p * [length_m / path.length_m, length_m / path.length_m, 1.0]
        path = rounded(p, radius_m)
    return path


@dataclass(frozen=True, eq=False)
class Flight:
    """A flight of stairs on the path: `treads` (n+1,), m along it, from the floor before the first riser to the floor above the last."""

    treads: Array


def with_stairs(path: Path, legs: tuple[int, ...], riser_m: float, tread_m: float) -> tuple[Path, list[Flight]]:
    """The path with stairs, all as high, in the middle of some legs (counted from 0), and the flights in order.

    The height is that of the treads at the places `Flight.treads` (between them, where no foot stands, a ramp).

    Raises
    ------
    UsageError
        There is no such leg, it does not climb, or it is too short for its steps.
    """
    there = len(path.height) - 1
    flights, at, height = [], list(path.height_at), list(path.height)
    for leg in sorted(legs):
        if not 0 <= leg < there:
            raise UsageError(f"There is no leg {leg} to be stairs: the path has {there}, counted from 0.")
        low, high = path.height[leg], path.height[leg + 1]
        n = max(1, round(abs(high - low) / riser_m))
        begin, end = path.begin[2 * leg], path.begin[2 * leg + 1]
        if low == high or (n + 1) * tread_m > end - begin:
            raise UsageError(
                f"Leg {leg} cannot be stairs: it climbs {high - low:.2f} m, in {n} steps of {tread_m} m, on {end - begin:.2f} m of "
                "straight path. Give its ends different heights, and more length or a smaller tread_m."
            )
        treads = (begin + end) / 2 + tread_m * (np.arange(n + 1) - n / 2)
        flights.append(Flight(treads))
        at += [treads[0], treads[-1]]
        height += [low, high]
    order = np.argsort(at, kind="stable")
    return replace(path, height_at=np.array(at)[order], height=np.array(height)[order]), flights
