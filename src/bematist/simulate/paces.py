"""Steps of a pedestrian along the path: how long each is, when its foot comes down, and when one stands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from bematist.simulate.carry import Walker
from bematist.simulate.footprints import SHORTEST_M, Stretch, drawn, placed, stretches, way
from bematist.simulate.parameters import Scenario
from bematist.simulate.path import Path

Array = NDArray[np.float64]
Names = NDArray[np.str_]

_MEMORY = 40.0
"""Steps over which the wander of the frequency is forgotten."""

_LEG = 0.53
"""Length of the legs, of the height of the walker."""

_STAIRS_BOUNCE = 0.2
"""How unevenly the body rises, of the height of a stair."""

_STAIRS_EFFORT = 0.8
"""Movement of the body on stairs, where 1 is that of a walk at `WALK_MS`."""

WALK_MS = 1.3
"""Speed for which the sizes of movements are given, m/s."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Steps:
    """Steps of a walk (K,), from one foot's contact to the other's. What lies between the end of one and the begin of the next is a pause.

    Attributes
    ----------
    begin, time : s, when it begins, and when it ends with the contact of the foot.
    along : (K+1,) m along the path, from the start to the end of the last step.
    length_m, frequency_hz : the length over the ground, in plan, and the inverse of its duration.
    motion, carry : "walking", "running", "upstairs" or "downstairs", and the name of how the sensor was carried at its end.
    """

    begin: Array
    time: Array
    along: Array
    motion: Names
    carry: Names

    @property
    def length_m(self) -> Array:
        return np.diff(self.along)

    @property
    def frequency_hz(self) -> Array:
        return 1 / (self.time - self.begin)

    def __len__(self) -> int:
        return len(self.time)

    def along_at(self, time: Array) -> Array:
        """Distance along the path (K,), m, if each step went on evenly."""
        return np.interp(time, self._edges, np.repeat(self.along, 2)[1:-1]) if len(self) else np.zeros(len(time))

    def phase_at(self, time: Array) -> Array:
        """Steps that were made (K,), with the part of the present one."""
        return np.interp(time, self._edges, np.repeat(np.arange(len(self) + 1.0), 2)[1:-1]) if len(self) else np.zeros(len(time))

    def number_at(self, time: Array) -> NDArray[np.int64]:
        """The step (K,) at the times, −1 where one stands."""
        if not len(self):
            return np.full(len(time), -1)
        k = np.searchsorted(self._edges, time, side="right") - 1
        return np.where((k % 2 == 0) & (k < 2 * len(self)), k // 2, -1)

    @property
    def _edges(self) -> Array:
        return np.column_stack([self.begin, self.time]).ravel()


@dataclass(frozen=True, eq=False)
class Route:
    """Where the steps lead: what `field_at` and the movement of the body need of a path.

    Attributes
    ----------
    path : as it is drawn.
    steps : along it.
    scenario : what it was made of.
    effort, bounce_m : (K,) of each step: the size of the body's movement, where 1 is a walk at `WALK_MS`, and its rise and fall, m.
    duration_s : from the rest at the start to that at the end.
    """

    path: Path | None
    steps: Steps
    scenario: Scenario
    effort: Array
    bounce_m: Array
    duration_s: float

    def at(self, along: Array) -> tuple[Array, Array]:
        """Places (K,3), m, and directions (K,), rad, in ENU at the distances (K,) along the path, m."""
        if self.path is None:
            return np.zeros((len(along), 3)), np.full(len(along), np.radians(90.0 - self.scenario.heading_deg))
        places, yaw = self.path.at(np.concatenate([[0.0], along]))
        places, yaw = placed(self.scenario, places, yaw)
        return places[1:], yaw[1:]


def route(scenario: Scenario, walker: Walker, rng: np.random.Generator) -> Route:
    """The steps of a walker along the path of a scenario."""
    if len(scenario.waypoints) < 2:
        none = np.empty(0)
        empty = Steps(begin=none, time=none, along=np.zeros(1), motion=np.empty(0, str), carry=np.empty(0, str))
        return Route(None, empty, scenario, none, none, scenario.rest_s + scenario.final_rest_s)
    path, flights = way(scenario)
    pauses = {min(at, path.length_m): seconds for at, seconds in scenario.pauses}
    parts = stretches(scenario, path, flights, pauses)
    stands = [part.begin for part in parts if part.begin in pauses]
    pacer = _Pacer(walker, scenario, path, rng)
    found = [pacer.steps(part, first=part.begin in (0.0, *stands), last=part.end in (path.length_m, *stands)) for part in parts]
    along, seconds, motion, effort, bounce = (np.concatenate(column) for column in zip(*found, strict=True))
    along[-1] = path.length_m
    # A pause on a stretch that cannot be cut, a flight of stairs, is made at the next foot.
    waits = np.zeros(len(along))
    for at, wait in pauses.items():
        waits[min(np.searchsorted(along, at - SHORTEST_M), len(waits) - 1)] += wait
    end = scenario.rest_s + np.cumsum(seconds) + np.concatenate([[0.0], np.cumsum(waits)[:-1]])
    changes = np.array([at for at, _ in walker.carries])
    names = np.array([carry.name for _, carry in walker.carries])
    steps = Steps(
        begin=end - seconds,
        time=end,
        along=np.concatenate([[0.0], along]),
        motion=motion,
        carry=names[np.searchsorted(changes, along, side="right") - 1],
    )
    return Route(path, steps, scenario, effort, bounce, float(end[-1] + waits[-1] + scenario.final_rest_s))


_Columns = tuple[Array, Array, NDArray[Any], Array, Array]
"""Of the steps of a stretch: where it ends along the path, seconds, motion, effort, bounce."""


class _Pacer:
    """Steps of one stretch after the other; the wander of the frequency goes on from one to the next."""

    def __init__(self, walker: Walker, scenario: Scenario, path: Path, rng: np.random.Generator) -> None:
        self._walker, self._scenario, self._path, self._rng = walker, scenario, path, rng
        self._wander = walker.frequency_wander * float(rng.standard_normal())

    def steps(self, stretch: Stretch, *, first: bool, last: bool) -> _Columns:
        if stretch.flight is not None:
            return self._on_stairs(stretch)
        walker, gait = self._walker, stretch.gait
        usual_hz, usual_m = walker.pace(gait)
        # More than enough steps, of which the number is kept that comes nearest to the length.
        most = 3 + first + last + int(1.5 * (stretch.end - stretch.begin) / usual_m)
        frequency = usual_hz * self._varied(most)
        length = walker.step_length_m(frequency) if gait.shape == "walk" else usual_m * frequency / usual_hz
        length *= 1 + walker.length_sd * drawn(self._rng, most)
        # From standing to walking, and back, is half a step.
        length[0] *= 0.5 if first else 1.0
        along = length.cumsum() - (0.5 * length if last else 0.0)
        least = 1 + (first and last)
        n = least + int(np.argmin(np.abs(along[least - 1 :] - (stretch.end - stretch.begin))))
        length, frequency = length[:n], frequency[:n]
        length[-1] *= 0.5 if last else 1.0
        length *= (stretch.end - stretch.begin) / length.sum()
        effort = length * frequency / WALK_MS
        run = gait.shape == "run"
        bounce = (0.5 if run else 1.0) * walker.bounce * length**2 / (8 * _LEG * walker.height_m)
        return stretch.begin + length.cumsum(), 1 / frequency, np.repeat("running" if run else "walking", n), effort, bounce

    def _on_stairs(self, stretch: Stretch) -> _Columns:
        assert stretch.flight is not None
        gait, treads = stretch.gait, stretch.flight.treads
        n = len(treads) - 1
        low, high = self._path.at(treads[[0, -1]])[0][:, 2]
        seconds = (gait.swing_s + gait.stance_s) / 2 / self._varied(n)
        bounce = np.full(n, _STAIRS_BOUNCE * self._scenario.riser_m)
        return treads[1:], seconds, np.repeat("upstairs" if high > low else "downstairs", n), np.full(n, _STAIRS_EFFORT), bounce

    def _varied(self, n: int) -> Array:
        """Frequencies (n,) relative to the usual one."""
        keep = np.exp(-1 / _MEMORY)
        drive = self._walker.frequency_wander * np.sqrt(1 - keep**2) * self._rng.standard_normal(n)
        wander = lfilter([1.0], [1.0, -keep], drive, zi=[keep * self._wander])[0]
        self._wander = float(wander[-1])
        return (1 + np.clip(wander, -0.2, 0.2)) * (1 + self._walker.frequency_sd * drawn(self._rng, n))
