"""The magnetic field where the shoe is: the Earth's, and what stands around bends it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bematist.simulate.motion import Motion
from bematist.simulate.parameters import Scenario

Array = NDArray[np.float64]

REACH_M = 20.0
"""A dipole is not felt farther than this, m: a car's is less than 0.01 µT there."""


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


def parked_cars(motion: Motion, rng: np.random.Generator) -> list[list[tuple[Array, Array]]]:
    """Places (3,) and moments (3,) of the cars along the walk, lot by lot."""
    along = np.concatenate([[0.0], np.linalg.norm(np.diff(motion.footprint, axis=0), axis=1).cumsum()])
    lots = []
    for lot in motion.scenario.parked_cars:
        cars = []
        for s in np.arange(lot.from_m, min(lot.to_m, along[-1]), lot.spacing_m):
            centre = np.array([np.interp(s, along, axis) for axis in motion.footprint.T])
            yaw = np.interp(s, along, motion.yaw)
            left = np.array([-np.sin(yaw), np.cos(yaw), 0.0]) * lot.away_m
            for side in (left, -left):
                moment = lot.moment / np.sqrt(3) * rng.standard_normal(3)
                cars.append((centre + side + [0.0, 0.0, lot.height_m], moment))
        lots.append(cars)
    return lots


def field_at(motion: Motion, position: Array, rng: np.random.Generator) -> Array:
    """Flux density in ENU (K,3), µT, at positions (K,3), m, of the walk."""
    field = np.tile(earth_field(motion.scenario), (len(position), 1))
    for cars in parked_cars(motion, rng):
        places = np.array([place for place, _ in cars]).reshape(-1, 3)
        if not len(places):
            continue
        around = (position > places.min(0) - REACH_M) & (position < places.max(0) + REACH_M)
        rows = np.flatnonzero(around.all(1))
        for place, moment in cars:
            near = rows[(np.abs(position[rows] - place) < REACH_M).all(1)]
            field[near] += dipole_field(position[near], place, moment)
    return field
