"""Walks whose truth is known exactly: path → footprints or steps → motion of the shoe or the hand → sensor.

>>> made = simulate_walk("short", "ideal")
>>> made.recording.rate_hz
238.0
"""

from __future__ import annotations

import sys
import types
from dataclasses import replace
from typing import Any

import numpy as np

from bematist.recording import Recording
from bematist.simulate.carry import CARRIES, POINTING, Carry, Walker
from bematist.simulate.disturbances import Dipole, Facade, FieldRegion, FieldTurn, IndoorField, ParkedCars
from bematist.simulate.footprints import walk
from bematist.simulate.gaits import GAITS, Gait
from bematist.simulate.hand import HandMotion, carried
from bematist.simulate.made import HandSimulation, Simulation, exact, generators, recorded, truth_of
from bematist.simulate.motion import Motion
from bematist.simulate.paces import Steps, route
from bematist.simulate.parameters import SENSORS, Scenario, Sensor, resolve, resolve_hand
from bematist.simulate.scenarios import SCENARIOS
from bematist.simulate.sensors import Errors
from bematist.simulate.tumble import tumble

__all__ = [
    "CARRIES",
    "GAITS",
    "POINTING",
    "SCENARIOS",
    "SENSORS",
    "Carry",
    "Dipole",
    "Errors",
    "Facade",
    "FieldRegion",
    "FieldTurn",
    "Gait",
    "HandMotion",
    "HandSimulation",
    "IndoorField",
    "Motion",
    "ParkedCars",
    "Scenario",
    "Sensor",
    "Simulation",
    "Steps",
    "Walker",
    "simulate",
    "simulate_hand",
    "simulate_walk",
]


def simulate_walk(
    scenario: str | Scenario = "campus", sensor: str | Sensor = "lsm9ds1", seed: int = 0, **changes: Any
) -> Simulation[Motion]:
    """Simulate a walk with a sensor on the shoe, and keep its truth. Arguments as for `simulate`."""
    what, device = resolve(scenario, sensor, changes)
    random = generators(seed)
    motion = (tumble if what.tumble_rests else walk)(what, random[0])
    said = recorded(motion, device, random, _source("walk", what, device, seed))
    time = np.arange(len(said["recording"])) / device.rate_hz
    truth = truth_of(motion, said["errors"], time, motion.standing(time))
    said["recording"] = replace(said["recording"], reference=exact(time, truth.position, truth.attitude))
    return Simulation(truth=truth, seed=seed, **said)


def simulate_hand(
    scenario: str | Scenario = "building",
    carry: str | Carry = "texting",
    sensor: str | Sensor = "phone",
    seed: int = 0,
    **changes: Any,
) -> HandSimulation:
    """Simulate a walk with a sensor in the hand, in a pocket or in a bag, and keep its truth.

    Arguments as for `simulate`, with the fields of `Walker` and `Carry` among the `changes`; `carries=((0, "texting"), (200, "swinging"))`
    instead of `carry` changes over on the way, m along the path.
    """
    what, device, walker = resolve_hand(scenario, carry, sensor, changes)
    random = generators(seed)
    motion = carried(route(what, walker, random[0]), walker, random[5])
    said = recorded(motion, device, random, _source(f"walk ({walker.carries[0][1].name})", what, device, seed))
    time = np.arange(len(said["recording"])) / device.rate_hz
    truth = truth_of(motion, said["errors"], time, np.zeros(len(time), bool))
    said["recording"] = replace(said["recording"], reference=exact(time, motion.body(time)[0], truth.attitude))
    return HandSimulation(truth=truth, seed=seed, **said)


def _source(what: str, scenario: Scenario, sensor: Sensor, seed: int) -> str:
    return f"simulated {what} {scenario.name or 'of its own'}, sensor {sensor.name or 'of its own'}, seed {seed}"


def simulate(
    scenario: str | Scenario = "campus",
    sensor: str | Sensor = "lsm9ds1",
    seed: int = 0,
    *,
    carry: str | Carry | None = None,
    **changes: Any,
) -> Recording:
    """Simulate what a sensor on a shoe, or one that is carried, records on a walk.

    Parameters
    ----------
    scenario : a name of `SCENARIOS` (campus, short, straight, still, stairs, …) or a `Scenario`.
    sensor : a name of `SENSORS` (lsm9ds1, adis16488, phone, ideal) or a `Sensor`.
    seed : of the random numbers; the same seed makes the same recording.
    carry : how it is carried, a name of `CARRIES` (texting, phoning, swinging, …) or a `Carry`; None is on the shoe.
    changes : fields of scenario, sensor or gait to change, such as `length_m=400`, `rate_hz=1000`, `disturbed=False`, `rocking_deg=3`;
        `gait="run"` is one gait for the whole way.

    Returns
    -------
    A `Recording` whose reference is the exact truth at every sample: of the sensor on the shoe; of a carried one the attitude, and
    where the pedestrian is.

    Raises
    ------
    UsageError
        An unknown name, or a value that does not fit.
    """
    if carry is not None:
        return simulate_hand(scenario, carry, sensor, seed, **changes).recording
    return simulate_walk(scenario, sensor, seed, **changes).recording


class _Callable(types.ModuleType):
    # `bematist.simulate` is this package once it is imported, and the function `simulate` to whoever calls it.
    def __call__(self, *args: Any, **kwargs: Any) -> Recording:
        return simulate(*args, **kwargs)


sys.modules[__name__].__class__ = _Callable
