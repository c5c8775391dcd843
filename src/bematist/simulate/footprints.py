"""Where and when the foot stands: a walk along a path as footprints, each stride a little different from the last."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bematist.simulate.gaits import Gait
from bematist.simulate.motion import Motion, Strides
from bematist.simulate.parameters import Scenario
from bematist.simulate.path import Flight, Path, scaled, with_stairs
from bematist.simulate.shape import Array

SHORTEST_M = 1e-6


@dataclass(frozen=True)
class Stretch:
    """A part of the path in one gait: from `begin` to `end`, m along it, or up or down a flight of stairs."""

    begin: float
    end: float
    gait: Gait
    flight: Flight | None = None


def stretches(scenario: Scenario, path: Path, flights: list[Flight], stops: Iterable[float] = ()) -> list[Stretch]:
    """The path cut where the gait changes, where stairs begin and end, and at the stops, m along it, that are not on stairs."""
    changes = [min(at, path.length_m) for at, _ in scenario.gaits]
    everywhere = sorted({*changes, *stops})
    found = []
    place = 0.0
    for flight in [*flights, None]:
        until = path.length_m if flight is None else float(flight.treads[0])
        cuts = [place, *(c for c in everywhere if place < c < until), until]
        for begin, end in pairwise(cuts):
            if end - begin > SHORTEST_M:
                k = max(0, int(np.searchsorted(changes, (begin + end) / 2)) - 1)
                found.append(Stretch(begin, end, scenario.gaits[k][1]))
        if flight is not None:
            place = float(flight.treads[-1])
            found.append(Stretch(until, place, scenario.stairs_gait, flight))
    return found


def _places(stretch: Stretch, first: bool, last: bool, rng: np.random.Generator) -> Array:
    # Footprints (n,), m along the path, after the one at the beginning of the stretch.
    if stretch.flight is not None:
        treads = stretch.flight.treads[1:]  # every second one is this foot's; the upper floor in any case
        return treads[(len(treads) - 1) % 2 :: 2]
    gait = stretch.gait
    length = stretch.end - stretch.begin
    # From standing to walking, and back, is half a stride.
    n = max(1 + (first and last), round(length / gait.stride_m + (first + last) / 2))
    part = 1 + gait.variation * drawn(rng, n)
    part[0] *= 0.5 if first else 1.0
    part[-1] *= 0.5 if last else 1.0
    along = part.cumsum()
    return stretch.begin + along * (length / along[-1])


def drawn(rng: np.random.Generator, n: int) -> Array:
    return np.clip(rng.standard_normal(n), -2.5, 2.5)


def walk(scenario: Scenario, rng: np.random.Generator) -> Motion:
    """The walk of a scenario."""
    if len(scenario.waypoints) < 2:
        return _standing(scenario)
    path, flights = way(scenario)
    parts = stretches(scenario, path, flights)
    along, gaits = [np.zeros(1)], []
    for i, part in enumerate(parts):
        along.append(_places(part, i == 0, i == len(parts) - 1, rng))
        gaits += [part.gait] * len(along[-1])
    along = np.concatenate(along)
    along[-1] = path.length_m
    place, yaw = path.at(along)
    climbs = np.zeros(len(gaits), np.int64)
    for flight in flights:
        inside = (along[:-1] > flight.treads[0] - SHORTEST_M) & (along[1:] < flight.treads[-1] + SHORTEST_M)
        climbs[inside] = np.sign(np.diff(place[:, 2])[inside]).astype(np.int64)
    strides = _strides(gaits, np.diff(along), climbs, rng)
    edges = _edges(scenario, gaits, strides, along, rng)
    yaw = yaw + np.radians([0.0, *(g.direction_sd_deg for g in gaits)]) * np.append(0.0, drawn(rng, len(gaits)))
    place, yaw = placed(scenario, place, yaw)
    return Motion(edges, place, yaw, along, strides, scenario)


def way(scenario: Scenario) -> tuple[Path, list[Flight]]:
    """The path of a scenario as it is drawn, and its flights of stairs."""
    path = scaled(scenario.waypoints, scenario.corner_radius_m, scenario.length_m)
    return with_stairs(path, scenario.stairs, scenario.riser_m, scenario.tread_m)


def placed(scenario: Scenario, place: Array, yaw: Array) -> tuple[Array, Array]:
    """Places (K,3) and directions (K,) of a drawn path turned to the heading of its first leg, with the origin at the start."""
    first = np.radians(90.0 - scenario.heading_deg) - yaw[0]
    c, s = np.cos(first), np.sin(first)
    return (place - place[0]) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), yaw + first


def _strides(gaits: list[Gait], length: Array, climbs: NDArray[np.int64], rng: np.random.Generator) -> Strides:
    def of(name: str) -> Array:
        return np.array([getattr(g, name) for g in gaits], float)

    def varied() -> Array:
        return 1 + of("variation") * drawn(rng, len(gaits))

    # A short stride lifts and pitches the foot less.
    full = np.minimum(1.0, length / of("stride_m"))
    up = of("clearance_m") * np.where(climbs == 0, full, 1.0) * varied()
    strike = of("impact_m") * full * np.exp(0.4 * drawn(rng, len(gaits)))
    return Strides(
        shape=np.array([g.shape for g in gaits]),
        full=full,
        roll=np.radians(of("roll_deg")) * full * varied(),
        pitch=of("pitch") * full * varied(),
        sway=of("sway_m") * full * drawn(rng, len(gaits)),
        clearance=up,
        impact=strike,
        rocking=np.radians(of("rocking_deg")),
        climbs=climbs,
    )


def _edges(scenario: Scenario, gaits: list[Gait], strides: Strides, along: Array, rng: np.random.Generator) -> Array:
    n = len(gaits)
    variation = np.array([g.variation for g in gaits])
    # A shorter stride takes less time, but not in proportion.
    swing = np.array([g.swing_s for g in gaits]) * (0.7 + 0.3 * strides.full) * (1 + variation * drawn(rng, n))
    flat = np.empty(n + 1)
    flat[1:] = [g.stance_s for g in gaits]
    flat[1:] *= 1 + variation * drawn(rng, n)
    for where, seconds in scenario.pauses:
        flat[min(np.searchsorted(along, where), n)] += seconds
    flat[0], flat[-1] = scenario.rest_s, scenario.final_rest_s
    times = np.empty(2 * n + 1)
    times[0::2], times[1::2] = flat, swing
    return np.concatenate([[0.0], times.cumsum()])


def _standing(scenario: Scenario) -> Motion:
    strides = _strides([], np.empty(0), np.empty(0, np.int64), np.random.default_rng())
    yaw = np.array([np.radians(90.0 - scenario.heading_deg)])
    edges = np.array([0.0, scenario.rest_s + scenario.final_rest_s])
    return Motion(edges, np.zeros((1, 3)), yaw, np.zeros(1), strides, scenario)
