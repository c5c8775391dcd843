"""Walks whose truth is known exactly: path → footprints → motion → sensor.

>>> made = simulate_walk("short", "ideal")
>>> made.recording.rate_hz
238.0
"""

from __future__ import annotations

import sys
import types
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.frames import conjugate, rotate
from bematist.recording import Recording, Reference
from bematist.simulate.disturbances import Dipole, Facade, FieldTurn, ParkedCars
from bematist.simulate.field import field_at
from bematist.simulate.footprints import walk
from bematist.simulate.gaits import GAITS, Gait
from bematist.simulate.motion import Motion
from bematist.simulate.parameters import SENSORS, Scenario, Sensor, resolve
from bematist.simulate.scenarios import SCENARIOS
from bematist.simulate.sensors import Errors, drawn_errors, inertial_truth, jittered, measure, measure_field
from bematist.trajectory import Trajectory

__all__ = [
    "GAITS",
    "SCENARIOS",
    "SENSORS",
    "Dipole",
    "Errors",
    "Facade",
    "FieldTurn",
    "Gait",
    "Motion",
    "ParkedCars",
    "Scenario",
    "Sensor",
    "Simulation",
    "simulate",
    "simulate_walk",
]


@dataclass(frozen=True, eq=False, kw_only=True)
class Simulation:
    """A simulated walk with everything that is true of it.

    Attributes
    ----------
    recording : what the sensor said; its reference is the truth at every sample.
    truth : the path as a `Trajectory` at the samples: position, velocity, attitude, stance, a covariance of zero, and
        the biases as diagnostics "gyro_bias" (N,3) rad/s and "accel_bias" (N,3) m/s².
    errors : all that the sensor got wrong, but white noise, rounding and clipping.
    field : (M,3) µT, the flux density in ENU where the magnetometer was at its samples.
    motion : the walk as a function of time, for the truth at any instant.
    scenario, sensor, seed : what it was made of.
    """

    recording: Recording
    truth: Trajectory
    errors: Errors
    field: NDArray[np.float64]
    motion: Motion
    scenario: Scenario
    sensor: Sensor
    seed: int


def simulate_walk(scenario: str | Scenario = "campus", sensor: str | Sensor = "lsm9ds1", seed: int = 0, **changes: Any) -> Simulation:
    """Simulate a walk, and keep its truth. Arguments as for `simulate`."""
    what, device = resolve(scenario, sensor, changes)
    # One generator for each part: the same walk under another sensor, the same noise on another walk.
    for_walk, for_field, for_errors, for_noise, for_clock = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(5))
    motion = walk(what, for_walk)
    time = np.arange(int(motion.duration_s * device.rate_hz) + 1) / device.rate_hz
    errors = drawn_errors(device, time, for_errors)
    f, w = measure(*inertial_truth(motion, time, device), errors, device, for_noise)
    magnetic = np.empty(0)
    field = said = np.empty((0, 3))
    if device.magnetometer_rate_hz:
        magnetic = np.arange(int(motion.duration_s * device.magnetometer_rate_hz) + 1) / device.magnetometer_rate_hz
        state = motion.at(magnetic)
        field = field_at(motion, state.position, motion.travelled(magnetic), for_field)
        said = measure_field(rotate(conjugate(state.attitude), field), errors, device, for_noise)
    truth = _truth(motion, time, errors)
    recording = Recording(
        time=jittered(time, device, for_clock),
        specific_force=f,
        angular_rate=w,
        magnetic_time=magnetic,
        magnetic_flux_density=said,
        reference=Reference(time=time, position=truth.position, attitude=truth.attitude, note="exact truth of the simulation, ENU"),
        source=f"simulated walk {what.name or 'of its own'}, sensor {device.name or 'of its own'}, seed {seed}",
        notes=(f"a sample is the {'mean over the interval that ends at' if device.sampling == 'average' else 'value at'} its time",),
    )
    return Simulation(recording=recording, truth=truth, errors=errors, field=field, motion=motion, scenario=what, sensor=device, seed=seed)


def _truth(motion: Motion, time: NDArray[np.float64], errors: Errors) -> Trajectory:
    state = motion.at(time)
    return Trajectory(
        time=time,
        position=state.position,
        velocity=state.velocity,
        attitude=state.attitude,
        stance=motion.standing(time).astype(np.uint8),
        packed_covariance=np.broadcast_to(0.0, (len(time), 18)),
        diagnostics={"gyro_bias": errors.gyro_bias, "accel_bias": errors.accel_bias},
        method="truth",
    )


def simulate(scenario: str | Scenario = "campus", sensor: str | Sensor = "lsm9ds1", seed: int = 0, **changes: Any) -> Recording:
    """Simulate what a sensor on a shoe records on a walk.

    Parameters
    ----------
    scenario : a name of `SCENARIOS` (campus, short, straight, still, stairs, …) or a `Scenario`.
    sensor : a name of `SENSORS` (lsm9ds1, adis16488, ideal) or a `Sensor`.
    seed : of the random numbers; the same seed makes the same recording.
    changes : fields of scenario, sensor or gait to change, such as `length_m=400`, `rate_hz=1000`, `disturbed=False`, `rocking_deg=3`;
        `gait="run"` is one gait for the whole way.

    Returns
    -------
    A `Recording` whose reference is the exact truth at every sample.

    Raises
    ------
    UsageError
        An unknown name, or a value that does not fit.
    """
    return simulate_walk(scenario, sensor, seed, **changes).recording


class _Callable(types.ModuleType):
    # `bematist.simulate` is this package once it is imported, and the function `simulate` to whoever calls it.
    def __call__(self, *args: Any, **kwargs: Any) -> Recording:
        return simulate(*args, **kwargs)


sys.modules[__name__].__class__ = _Callable
