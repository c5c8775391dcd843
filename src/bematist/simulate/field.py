"""The magnetic field where the sensor is: the Earth's, and what stands around bends it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bematist.frames import quaternion_from_rotation_vector, rotate
from bematist.simulate.disturbances import FieldRegion, FieldTurn, IndoorField
from bematist.simulate.motion import Movement
from bematist.simulate.parameters import Scenario

Array = NDArray[np.float64]

REACH_M = 20.0
"""A dipole is not felt farther than this, m: a car's or pillar's is about 0.01 µT there."""


def earth_field(scenario: Scenario) -> Array:
    """The undisturbed flux density in ENU (3,), µT."""
    dip = np.radians(scenario.inclination_deg)
    return scenario.field_ut * np.array([0.0, np.cos(dip), -np.sin(dip)])


def dipole_field(position: Array, place: Array, moment: Array) -> Array:
    """Flux density (K,3), µT, at positions (K,3), m, of a dipole at `place` (3,) with `moment` (3,), A·m².

    B = µ0/4π (3 (m·r̂) r̂ − m) / r³, with µ0/4π = 0.1 µT·m³/(A·m²); J. D. Jackson, Classical Electrodynamics, eq 5.56.
    """
    r = position - place
    square = np.maximum((r**2).sum(1), 1e-4)
    return 0.1 * (3 * (r @ moment / square)[:, None] * r - moment) / square[:, None] ** 1.5


@dataclass(frozen=True, eq=False)
class Sources:
    """Iron that stands together: places (S,3), m, and moments (S,3), A·m²."""

    place: Array
    moment: Array


def sources(motion: Movement, rng: np.random.Generator) -> list[Sources]:
    """What stands along the walk, in groups: parked cars, facades, dipoles."""
    scenario, end = motion.scenario, motion.along[-1]
    earth = earth_field(scenario)
    north = earth / max(np.linalg.norm(earth), 1e-12)
    found = []
    for lot in scenario.parked_cars:
        along = np.arange(lot.from_m, min(lot.to_m, end), lot.spacing_m)
        # A row on each side of the path.
        places = np.concatenate([_beside(motion, along, side * lot.away_m, lot.height_m) for side in (1, -1)])
        found.append(Sources(places, _drawn(lot.moment, len(places), rng)))
    for wall in scenario.facades:
        along = np.arange(wall.from_m, min(wall.to_m, end), wall.spacing_m)
        moments = wall.induced * north + _drawn(wall.remanent, len(along), rng)
        found.append(Sources(_beside(motion, along, wall.away_m, wall.height_m), moments))
    for iron in scenario.dipoles:
        along = np.array([iron.at_m] if iron.at_m <= end else [])
        found.append(Sources(_beside(motion, along, iron.left_m, iron.height_m), _drawn(iron.moment, len(along), rng)))
    return [group for group in found if len(group.place)]


def _drawn(rms: float, n: int, rng: np.random.Generator) -> Array:
    return rms / np.sqrt(3) * rng.standard_normal((n, 3))


def _beside(motion: Movement, along: Array, left_m: float, height_m: float) -> Array:
    # Places (K,3) left of the path, and above the ground, at the distances (K,) along it.
    place, yaw = motion.places(along)
    return place + np.column_stack([-left_m * np.sin(yaw), left_m * np.cos(yaw), np.full(len(along), height_m)])


def _regions(indoor: IndoorField, rng: np.random.Generator) -> list[FieldRegion]:
    # Neighbours share a ramp: what one loses there, the other gains.
    lengths = indoor.region_m * rng.uniform(0.5, 1.5, int(2 * (indoor.to_m - indoor.from_m) / indoor.region_m) + 1)
    edges = indoor.from_m + np.concatenate([[0.0], lengths.cumsum()])
    edges = np.append(edges[edges < indoor.to_m - indoor.ramp_m], indoor.to_m)
    offsets = indoor.spread_ut * rng.standard_normal((len(lengths), 3)) * (rng.uniform(size=len(lengths)) < indoor.share)[:, None]
    half, ramp = indoor.ramp_m / 2, indoor.ramp_m
    return [
        FieldRegion(from_m=a - half, to_m=b + half, offset_ut=tuple(offset), ramp_m=ramp)
        for a, b, offset in zip(edges[:-1], edges[1:], offsets, strict=False)
        if offset.any()
    ]


def _there(stretch: FieldTurn | FieldRegion, travelled: Array) -> Array:
    # (K,) from 0 to 1 over the ramp, and back, with two continuous derivatives: 6u⁵ − 15u⁴ + 10u³.
    u = np.clip(np.minimum(travelled - stretch.from_m, stretch.to_m - travelled) / stretch.ramp_m, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def field_at(motion: Movement, position: Array, travelled: Array, rng: np.random.Generator) -> Array:
    """Flux density in ENU (K,3), µT, at positions (K,3), m, of the walk, (K,) m along it."""
    scenario = motion.scenario
    field = np.tile(earth_field(scenario), (len(position), 1))
    if not scenario.disturbed:
        return field
    for group in sources(motion, rng):
        around = (position > group.place.min(0) - REACH_M) & (position < group.place.max(0) + REACH_M)
        rows = np.flatnonzero(around.all(1))
        for place, moment in zip(group.place, group.moment, strict=True):
            near = rows[(np.abs(position[rows] - place) < REACH_M).all(1)]
            field[near] += dipole_field(position[near], place, moment)
    drawn = [region for indoor in scenario.indoor_fields for region in _regions(indoor, rng)]
    for region in (*scenario.field_regions, *drawn):
        share = _there(region, travelled)
        rows = np.flatnonzero(share)
        field[rows] += share[rows, None] * region.offset_ut
    for turn in scenario.field_turns:
        share = _there(turn, travelled)
        rows = np.flatnonzero(share)
        angle = np.radians(turn.angle_deg) * share[rows]
        axis = np.eye(3)[("east", "north", "up").index(turn.axis)]
        field[rows] = rotate(quaternion_from_rotation_vector(angle[:, None] * axis), field[rows])
    return field
