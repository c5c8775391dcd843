"""One calibration, step by step: rests, accelerometer, axes, gyroscope, magnetometer, and gyroscope and magnetometer once more together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from bematist.calibrate.accelerometer import Gravity, check_unit, fit_gravity
from bematist.calibrate.axes import Blame, best_axes, blame
from bematist.calibrate.evidence import Evidence, Whole
from bematist.calibrate.gyroscope import Directions, calibrate_inertial, misfit, usable
from bematist.calibrate.known import KnownTurn, assigned, full_turns, measured_angle
from bematist.calibrate.magnetometer import Iron, calibrate_magnetometer, field_axes, fit_iron
from bematist.calibrate.rests import Rests, find_rests
from bematist.calibrate.result import QUANTITIES, Calibration, SensorCalibration
from bematist.calibrate.samples import FieldSamples, field_pairs, field_samples, stamp_delay
from bematist.calibrate.turning import Turn, turns_between
from bematist.calibrate.words import sensor_warnings
from bematist.errors import DataError
from bematist.recording import Recording

Array = NDArray[np.float64]
Found = TypeVar("Found")

SENSORS = tuple(QUANTITIES)
AXES_TURNS = 4
"""Turns between rests, at least, from which the axes are judged."""
ROUNDS = 2
"""Gyroscope and magnetometer, each with the other calibrated."""


@dataclass(frozen=True)
class Request:
    """Gravity, m/s², the field, µT or None, known turns (axis, rad), and the sensors that must be calibrated (none: what can be)."""

    gravity: float
    field: float | None
    turns: Sequence[tuple[int, float]]
    sensors: tuple[str, ...]

    def wants(self, sensor: str) -> bool:
        return not self.sensors or sensor in self.sensors


@dataclass(eq=False)
class _Prepared:
    """What is known before gyroscope and magnetometer are calibrated; `failures` says why something is not."""

    given: list[Recording]
    rests: Rests
    gravity: Gravity | None
    turns: list[Turn]
    samples: FieldSamples | None
    iron: Iron | None
    failures: list[str] = field(default_factory=list)

    @property
    def up(self) -> Directions | None:
        return None if self.gravity is None else Directions(self.gravity.up()[0], self.gravity.up_variance)


def run(given: Sequence[Recording], request: Request) -> Calibration:
    """Calibrate what the recordings can calibrate."""
    wrong: list[Blame] = []
    ready = _prepare(list(given), request)
    for _ in range(len(SENSORS) - 1):
        if (found := _wrong_axes(ready)) is None:
            break
        wrong.append(found)
        ready = _prepare([_turned(r, found) for r in ready.given], request)
    known = assigned(ready.turns, request.turns, _source(given)) if request.turns else []
    sensors, elevation = _calibrated(ready, request, known)
    if not sensors:
        raise DataError(" ".join(dict.fromkeys(ready.failures)) or f"{_source(given)}: there is nothing to calibrate.")
    sensors = {name: _in_own_axes(s, wrong) for name, s in sensors.items()}
    warnings = [w for r in given for w in r.warnings] + [f"Axes: {b.text()}; the calibration puts them right." for b in wrong]
    warnings += [w for s in sensors.values() for w in sensor_warnings(s)] + ready.failures
    return Calibration(
        sensors=sensors,
        sensing=given[0].sensing,
        source=given[0].source,
        rate_hz=given[0].rate_hz,
        warnings=tuple(dict.fromkeys(warnings)),
        evidence=_evidence(ready, sensors, known, elevation, wrong),
    )


def _source(given: Sequence[Recording]) -> str:
    return given[0].source or "The recording"


def _prepare(given: list[Recording], request: Request) -> _Prepared:
    """Rests, the accelerometer, turns, and hard and soft iron."""
    failures: list[str] = []

    def attempt(step: Callable[[], Found], *for_sensors: str) -> Found | None:
        # A sensor that was asked for must be calibrated; of the others it is said why they are not.
        try:
            return step()
        except DataError as error:
            if set(for_sensors) & set(request.sensors):
                raise
            if not request.sensors:
                failures.append(str(error))
            return None

    rests = find_rests(given)

    def accelerometer() -> Gravity:
        check_unit(given, request.gravity, _source(given))
        return fit_gravity(rests, request.gravity, _source(given))

    gravity = attempt(accelerometer, "accelerometer", "gyroscope")
    samples = field_samples(rests, given) if any(r.has_magnetometer for r in given) and request.wants("magnetometer") else None
    iron = attempt(lambda: fit_iron(samples, request.field, _source(given)), "magnetometer") if samples else None
    if "magnetometer" in request.sensors and samples is None:
        raise DataError(f"{_source(given)}: there is no magnetometer in it to calibrate.")
    return _Prepared(given, rests, gravity, turns_between(rests, given), samples, iron, failures)


def _gyro(ready: _Prepared, gyroscope: SensorCalibration | None) -> tuple[Array, Array]:
    """Offset and matrix of the gyroscope, as far as they are known."""
    if gyroscope is not None:
        return gyroscope.offset, gyroscope.matrix
    return (np.median(ready.rests.rate, axis=0) if len(ready.rests) else np.zeros(3)), np.eye(3)


def _wrong_axes(ready: _Prepared) -> Blame | None:
    """Whose axes do not fit the others', if there is one."""
    gyro, mag = np.eye(3), None
    if ready.up is not None:
        turns, up = usable(ready.turns, ready.up), ready.up
        if len(turns) >= AXES_TURNS:
            gyro = best_axes(lambda P: misfit(turns, up, P))
    if ready.iron is not None:
        mag = field_axes(ready.iron, field_pairs(ready.given, *_gyro(ready, None)))
    if (gyro != np.eye(3)).any():
        return blame(gyro, mag)
    return Blame("magnetometer", mag) if mag is not None and (mag != np.eye(3)).any() else None


def _turned(r: Recording, wrong: Blame) -> Recording:
    quantity = QUANTITIES[wrong.sensor]
    return r.replace(**{quantity: getattr(r, quantity) @ wrong.axes.T})


def _in_own_axes(s: SensorCalibration, wrong: Sequence[Blame]) -> SensorCalibration:
    """A calibration of readings in axes that were put right, as one of the readings as they are: M (P y - b) = M P (y - Pᵀ b)."""
    P = _product(wrong, s.sensor)
    T = np.zeros((12, 12))
    T[:9, :9], T[9:, 9:] = np.kron(np.eye(3), P.T), P.T
    return replace(s, matrix=s.matrix @ P, offset=P.T @ s.offset, covariance=T @ s.covariance @ T.T)


def _calibrated(ready: _Prepared, request: Request, known: Sequence[KnownTurn]) -> tuple[dict[str, SensorCalibration], float]:
    """The sensors, and the elevation of the field, rad."""
    accelerometer = gyroscope = magnetometer = field = None
    elevation, delay = float("nan"), 0.0
    for _ in range(ROUNDS):
        if ready.gravity is not None:
            accelerometer, gyroscope = calibrate_inertial(ready.gravity, ready.turns, field, known, _source(ready.given))
        if ready.iron is not None and ready.samples is not None:
            up = np.full((len(ready.samples.values), 3), np.nan)
            if accelerometer is not None:
                at = ready.samples.rest >= 0
                x = accelerometer.apply(ready.rests.force[ready.samples.rest[at]])
                up[at] = _units(x)
            if magnetometer is not None:
                delay = stamp_delay(ready.given, *_gyro(ready, gyroscope), magnetometer.matrix, magnetometer.offset)
            pairs = field_pairs(ready.given, *_gyro(ready, gyroscope), delay)
            magnetometer, elevation = calibrate_magnetometer(ready.samples, ready.iron, pairs, up)
            if ready.gravity is not None and np.isfinite(elevation):
                field = _field_directions(ready.rests, magnetometer)
    if magnetometer is not None and delay:
        late = f"The magnetometer's stamps are {1e3 * delay:.0f} ms later than the gyroscope's"
        magnetometer = replace(magnetometer, note=f"{late}. The calibration allows for that and leaves them as they are.")
    found = {"accelerometer": accelerometer, "gyroscope": gyroscope, "magnetometer": magnetometer}
    return {name: s for name, s in found.items() if s is not None and request.wants(name)}, elevation


def _field_directions(rests: Rests, magnetometer: SensorCalibration) -> Directions:
    """The field's direction at each rest; how sure it is follows from how far its length is off over all of them."""
    x = magnetometer.apply(rests.field)
    size = np.linalg.norm(x, axis=1)
    scatter = np.nanmedian(np.abs(size / magnetometer.length - 1)) / 0.674
    far = np.abs(size / magnetometer.length - 1) > 4 * scatter
    units = np.where(far[:, None], np.nan, x / size[:, None])
    return Directions(units, rests.field_variance / magnetometer.length**2 + scatter**2)


def _product(wrong: Sequence[Blame], sensor: str) -> Array:
    """The axes (3,3) by which a sensor's readings were put right."""
    P = np.eye(3)
    for found in (b for b in wrong if b.sensor == sensor):
        P = found.axes @ P
    return P


def _units(x: Array) -> Array:
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def _evidence(
    ready: _Prepared, sensors: dict[str, SensorCalibration], known: Sequence[KnownTurn], elevation: float, wrong: Sequence[Blame]
) -> Evidence:
    S = np.eye(3)
    if "gyroscope" in sensors:
        S = sensors["gyroscope"].matrix @ _product(wrong, "gyroscope").T
    rows = []
    if ready.gravity is not None and ready.up is not None:
        accelerometer, up = sensors.get("accelerometer"), ready.up
        if accelerometer is not None:
            up = Directions(_units(accelerometer.apply(ready.rests.force @ _product(wrong, "accelerometer"))), up.variance)
        rows = [np.degrees([t.way(), *(misfit([t], up, M) for M in (np.eye(3), S))]) for t in usable(ready.turns, up)]
    whole = known or full_turns(ready.turns)
    told = [[float(np.degrees(a)) for a in (k.angle, measured_angle(k, np.eye(3)), measured_angle(k, S))] for k in whole]
    samples, iron = ready.samples, ready.iron
    kept = iron.fit.kept[0] if iron else np.zeros(0, bool)
    rests = ready.rests
    return Evidence(
        rests=rests,
        rests_kept=ready.gravity.kept if ready.gravity else np.zeros(len(rests), bool),
        field=samples.values if samples and iron else None,
        field_kept=kept,
        turns=np.array(rows).reshape(-1, 3),
        known_turns=tuple(Whole("xyz"[k.axis], *angles) for k, angles in zip(whole, told, strict=True)),
        turns_told=bool(known),
        elevation_deg=float(np.degrees(elevation)),
    )
