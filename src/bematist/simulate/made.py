"""What a simulation gives: the recording, and everything that is true of it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from bematist.frames import conjugate, rotate
from bematist.recording import Recording, Reference
from bematist.simulate.carry import POINTING, Walker
from bematist.simulate.field import field_at
from bematist.simulate.hand import HandMotion
from bematist.simulate.motion import Movement
from bematist.simulate.paces import Steps
from bematist.simulate.parameters import Scenario, Sensor
from bematist.simulate.sensors import (
    Errors,
    drawn_errors,
    inertial_truth,
    jittered,
    measure,
    measure_field,
    measure_pressure,
    pressure_at,
)
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]
Moved = TypeVar("Moved", bound=Movement)


@dataclass(frozen=True, eq=False, kw_only=True)
class Simulation(Generic[Moved]):
    """A simulated walk with everything that is true of it.

    Attributes
    ----------
    recording : what the sensor said; its reference is the truth at every sample.
    truth : the path of the sensor as a `Trajectory` at the samples: position, velocity, attitude, stance, a covariance of zero, and
        the biases as diagnostics "gyro_bias" (N,3) rad/s and "accel_bias" (N,3) m/s².
    errors : all that the sensor got wrong, but white noise, rounding and clipping.
    field : (M,3) µT, the flux density in ENU where the magnetometer was at its samples.
    motion : the walk as a function of time, for the truth at any instant.
    scenario, sensor, seed : what it was made of.
    """

    recording: Recording
    truth: Trajectory
    errors: Errors
    field: Array
    motion: Moved
    scenario: Scenario
    sensor: Sensor
    seed: int


@dataclass(frozen=True, eq=False, kw_only=True)
class HandSimulation(Simulation[HandMotion]):
    """A walk with a sensor in the hand. `truth` is where the sensor was; the reference of `recording` is where the pedestrian was, with the
    attitude of the sensor.
    """

    pointing = POINTING
    """The axis of the sensor that points forward when one reads from it."""

    @property
    def walker(self) -> Walker:
        """Who walked."""
        return self.motion.walker

    @property
    def steps(self) -> Steps:
        """The steps that were made."""
        return self.motion.route.steps

    def modes_at(self, time: Array) -> tuple[NDArray[np.str_], NDArray[np.str_]]:
        """How one moved (standing, walking, running, upstairs, downstairs) and how the sensor was carried (K,) at the times (K,), s."""
        motion = np.append(self.steps.motion, "standing")[self.steps.number_at(time)]
        changes = [at for at, _ in self.walker.carries]
        carry = np.searchsorted(changes, self.motion.travelled(time), side="right") - 1
        return motion, np.array([c.name for _, c in self.walker.carries])[carry]

    def spans(self) -> list[tuple[float, float, str, str]]:
        """Time in pieces of one motion and one way of carrying: (begin s, end s, motion, carry), to a sample of the sensor."""
        time = self.recording.time
        motion, carry = self.modes_at(time)
        cuts = 1 + np.flatnonzero((motion[1:] != motion[:-1]) | (carry[1:] != carry[:-1]))
        edges = [0, *cuts.tolist(), len(time) - 1]
        return [(float(time[a]), float(time[b]), str(motion[a]), str(carry[a])) for a, b in pairwise(edges)]

    def direction_at(self, time: Array) -> Array:
        """Direction of walking (K,), rad, counter-clockwise from East, unwrapped, at the times (K,), s."""
        return self.motion.body(time)[1]


Generators = tuple[np.random.Generator, ...]
"""One generator for each part: the same walk under another sensor, the same noise on another walk."""


def generators(seed: int) -> Generators:
    """For walk, field, errors, noise, clock, hand and barometer."""
    return tuple(np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(7))


def recorded(motion: Movement, sensor: Sensor, random: Generators, source: str) -> dict[str, Any]:
    """What the sensor says of a walk, and the truth: fields of a `Simulation`. The reference of the recording is left out."""
    _, for_field, for_errors, for_noise, for_clock, _, for_barometer = random
    time = _times(motion, sensor.rate_hz)
    errors = drawn_errors(sensor, time, for_errors)
    f, w = measure(*inertial_truth(motion, time, sensor), errors, sensor, for_noise)
    magnetic, field, said = np.empty(0), np.empty((0, 3)), np.empty((0, 3))
    if sensor.magnetometer_rate_hz:
        magnetic = _times(motion, sensor.magnetometer_rate_hz)
        state = motion.at(magnetic)
        field = field_at(motion, state.position, motion.travelled(magnetic), for_field)
        said = measure_field(rotate(conjugate(state.attitude), field), errors, sensor, for_noise)
    barometer = pressure = np.empty(0)
    if sensor.pressure_rate_hz:
        barometer = _times(motion, sensor.pressure_rate_hz)
        pressure = measure_pressure(pressure_at(motion.at(barometer).position[:, 2]), sensor, for_barometer)
    recording = Recording(
        time=jittered(time, sensor, for_clock),
        specific_force=f,
        angular_rate=w,
        magnetic_time=magnetic,
        magnetic_flux_density=said,
        pressure_time=barometer,
        pressure=pressure,
        source=source,
        notes=(f"a sample is the {'mean over the interval that ends at' if sensor.sampling == 'average' else 'value at'} its time",),
    )
    return {"recording": recording, "errors": errors, "field": field, "motion": motion, "scenario": motion.scenario, "sensor": sensor}


def _times(motion: Movement, rate_hz: float) -> Array:
    return np.arange(int(motion.duration_s * rate_hz) + 1) / rate_hz


def truth_of(motion: Movement, errors: Errors, time: Array, stance: NDArray[np.bool_]) -> Trajectory:
    """The path of the sensor at the times (N,), s; `stance` (N,) says where it stands still."""
    state = motion.at(time)
    return Trajectory(
        time=time,
        position=state.position,
        velocity=state.velocity,
        attitude=state.attitude,
        stance=stance.astype(np.uint8),
        packed_covariance=np.broadcast_to(0.0, (len(time), 18)),
        diagnostics={"gyro_bias": errors.gyro_bias, "accel_bias": errors.accel_bias},
        method="truth",
    )


def exact(time: Array, position: Array, attitude: Array) -> Reference:
    """The truth as a reference."""
    return Reference(time=time, position=position, attitude=attitude, note="exact truth of the simulation, ENU")
