"""`FootIns`: inertial navigation of a shoe-mounted sensor, in batch, in chunks and sample by sample."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from bematist import stance
from bematist.align import Alignment, InitialParameters, initial_alignment
from bematist.earth import STANDARD_GRAVITY
from bematist.errors import DataError, UsageError
from bematist.frames import matrix_from_quaternion
from bematist.kernels import foot as filter_kernel
from bematist.kernels import layout as kernel
from bematist.parameters import Parameters
from bematist.recording import Recording
from bematist.stance import StanceParameters
from bematist.trajectory import Trajectory
from bematist.updates import GapParameters, MagneticParameters, ZeroVelocityParameters

Array = NDArray[np.float64]

_MAGNETIC_USE = {
    "off": kernel.MAGNETIC_OFF,
    "reset": kernel.MAGNETIC_RESET,
    "heading": kernel.MAGNETIC_HEADING,
}


class NoiseParameters(Parameters):
    """Process noise of the filter: densities (the root of a PSD), not per-sample values (erratum of MAGINAV eq 23)."""

    angle_random_walk: float = Field(
        default=math.radians(0.1),
        ge=0,
        description="White noise of the gyroscope, rad/s/√Hz. Larger: attitude follows the updates more.",
    )
    velocity_random_walk: float = Field(
        default=0.01, ge=0, description="White noise of the accelerometer, m/s²/√Hz. Larger: velocity follows the updates more."
    )
    gyro_bias_walk: float = Field(default=5e-6, ge=0, description="Random walk of the gyroscope's offset, rad/s/√s.")
    accel_bias_walk: float = Field(default=5e-5, ge=0, description="Random walk of the accelerometer's offset, m/s²/√s.")


class FootParameters(Parameters):
    """Everything that the foot-mounted filter can be told."""

    states: Literal[9, 15] = Field(
        default=15, description="15: attitude, velocity, position and both offsets (MAGINAV eq 18). 9: without the offsets."
    )
    gravity: float = Field(default=STANDARD_GRAVITY, gt=0, description="Local gravity, m/s².")
    stance: StanceParameters = StanceParameters()
    zero_velocity: ZeroVelocityParameters = ZeroVelocityParameters()
    magnetic: MagneticParameters = MagneticParameters()
    initial: InitialParameters = InitialParameters()
    noise: NoiseParameters = NoiseParameters()
    gap: GapParameters = GapParameters()


class FootIns:
    """A shoe-mounted navigator.

    `run(recording)` answers for a whole recording. Live, `update(rows)` takes sample rows (n,10), `recording.SAMPLE_COLUMNS`, in
    pieces of any size and returns the part of the trajectory that is decided, and `finish()` the rest; the pieces are, bit for bit,
    what `run` returns. The first `initial.longest_s` seconds are gathered before the first answer; afterwards an answer is
    `latency_s` late. `step(row)` is `update` for one row with the least overhead.
    """

    def __init__(self, parameters: FootParameters | None = None, *, method: str = "") -> None:
        self.parameters = parameters or FootParameters()
        self.method = method
        self.alignment: Alignment | None = None
        self.warnings: list[str] = []
        self._gathered: list[Array] = []
        self._finished = False
        self._last_time = -math.inf
        self._rate_hz = math.nan
        self._state: tuple[NDArray[np.int64], Array, Array, Array] | None = None
        self._scratch = np.empty(0)
        self._row = np.empty((1, kernel.NAV))
        self._row_diagnostics = np.empty((1, kernel.DIAG), np.float32)

    # -- batch -----------------------------------------------------------------------------------------------------------

    def run(self, recording: Recording, *, chunk: int | None = None, progress: Callable[[int, int], None] | None = None) -> Trajectory:
        """The trajectory of a whole recording, fed in chunks of `chunk` samples (default: a few seconds' work at a time).

        progress is called with the number of samples done and of all. Raises DataError where the recording cannot be processed.
        """
        if self._state is not None or self._gathered:
            raise UsageError("This FootIns has been given samples already: make a new one for each recording.")
        if len(recording) < 2:
            raise DataError(f"{recording.source or 'The recording'}: {len(recording)} sample(s) make no path. Record for longer.")
        started = time.perf_counter()
        n = len(recording)
        nav = np.empty((n, kernel.NAV))
        diagnostics = np.empty((n, kernel.DIAG), np.float32)
        size = chunk or 50_000
        done = 0
        for start in range(0, n, size):
            done += self._advance(recording.samples(start, start + size), False, nav[done:], diagnostics[done:])
            if progress:
                progress(min(start + size, n), n)
        done += self._advance(np.empty((0, 10)), True, nav[done:], diagnostics[done:])
        nav, diagnostics = nav[:done], diagnostics[:done]
        elapsed = time.perf_counter() - started
        warnings = (*recording.warnings, *self.warnings, *self._judge(nav, diagnostics))
        return self._trajectory(nav, diagnostics, warnings=warnings, processing_s=elapsed, source=recording.source)

    # -- live ------------------------------------------------------------------------------------------------------------

    @property
    def ready(self) -> bool:
        """Whether the start is aligned, so that `step` may be called."""
        return self._state is not None

    @property
    def latency_s(self) -> float:
        """Delay of an answer after the start, s (NaN before the sampling rate is known)."""
        return self.parameters.stance.latency_s(self._rate_hz)

    def update(self, rows: Array) -> Trajectory:
        """Take in sample rows (n,10); returns the trajectory of the samples that are now decided (it may be empty).

        Rows whose time does not increase are dropped and counted in a warning.
        """
        return self._piece(np.ascontiguousarray(rows, float).reshape(-1, 10), False)

    def finish(self) -> Trajectory:
        """No more samples will come: the trajectory of those that were still waiting."""
        piece = self._piece(np.empty((0, 10)), True)
        self._finished = True
        return piece

    def step(self, row: Array) -> Array | None:
        """`update` for one row (1,10), C-contiguous float64: one result row (29,) valid until the next call, or None.

        The result holds time, position (3), velocity (3), attitude (4) and the packed covariances of `Trajectory`. For speed nothing is
        checked: the time must increase. UsageError before the start is aligned: until `ready`, give the samples to `update`.
        """
        if self._state is None:
            raise UsageError("step() was called before the start was aligned: give the first seconds to update(), until `ready`.")
        index, memory, S, prm = self._state
        self._last_time = row[0, 0]
        n = filter_kernel.run(index, memory, S, prm, row, stance.NO_FLAGS, False, self._scratch, self._row, self._row_diagnostics)
        if n < 0:
            n = self._run(row, False, self._row, self._row_diagnostics)
        return self._row[0] if n else None

    def save(self) -> dict[str, Any]:
        """The whole state as plain arrays: `restore` goes on from it as if nothing had happened."""
        return {
            "parameters": self.parameters.model_dump(),
            "method": self.method,
            "gathered": np.concatenate(self._gathered) if self._gathered else np.empty((0, 10)),
            "last_time": self._last_time,
            "rate_hz": self._rate_hz,
            "warnings": list(self.warnings),
            "finished": self._finished,
            "alignment": self.alignment,
            "state": None if self._state is None else [a.copy() for a in self._state],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> FootIns:
        """A navigator in the state that `save` returned."""
        self = cls(FootParameters.model_validate(saved["parameters"]), method=saved["method"])
        self._gathered = [saved["gathered"].copy()] if len(saved["gathered"]) else []
        self._last_time = saved["last_time"]
        self._rate_hz = saved["rate_hz"]
        self.warnings = list(saved["warnings"])
        self._finished, self.alignment = saved["finished"], saved["alignment"]
        if saved["state"] is not None:
            index, memory, S, prm = (a.copy() for a in saved["state"])
            self._state = (index, memory, S, prm)
            self._scratch = stance.scratch(index, 1)
        return self

    # -- inside ----------------------------------------------------------------------------------------------------------

    def _piece(self, rows: Array, finish: bool) -> Trajectory:
        waiting = sum(len(r) for r in self._gathered)
        if self._state is not None:
            waiting = round(self.latency_s * self._rate_hz)
        nav = np.empty((waiting + len(rows), kernel.NAV))
        diagnostics = np.empty((len(nav), kernel.DIAG), np.float32)
        n = self._advance(rows, finish, nav, diagnostics)
        return self._trajectory(nav[:n], diagnostics[:n], warnings=tuple(self.warnings))

    def _advance(self, rows: Array, finish: bool, nav: Array, diagnostics: NDArray[np.float32]) -> int:
        """Feed rows; write what is decided into nav and diagnostics; return how many rows that is."""
        if self._finished:
            raise UsageError("finish() was called: make a new FootIns for more samples.")
        rows = self._increasing(rows)
        if self._state is None:
            if len(rows):
                self._gathered.append(rows)
            gathered = self._align(finish)
            if gathered is None:
                return 0
            rows = gathered
        return self._run(rows, finish, nav, diagnostics)

    def _run(self, rows: Array, finish: bool, nav: Array, diagnostics: NDArray[np.float32]) -> int:
        assert self._state is not None
        index, memory, S, prm = self._state
        rows, flags = stance.filled(memory, rows, prm[kernel.GAP_S])
        return filter_kernel.run(index, memory, S, prm, rows, flags, finish, stance.scratch(index, len(rows)), nav, diagnostics)

    def _increasing(self, rows: Array) -> Array:
        t = np.concatenate([[self._last_time], rows[:, 0]])
        if not (np.diff(t) > 0).all():
            later = rows[:, 0] > np.maximum.accumulate(np.where(np.isfinite(t), t, -np.inf))[:-1]
            self.warnings.append(f"{(~later).sum()} sample(s) whose time did not increase were dropped.")
            rows = rows[later]
        if len(rows):
            self._last_time = float(rows[-1, 0])
        return np.ascontiguousarray(rows)

    def _align(self, finish: bool) -> Array | None:
        """Once the start is gathered: align, set up the state, and return all rows gathered so far; None before that."""
        if not self._gathered:
            if finish:
                raise DataError("There are no samples.")
            return None
        start, end = self._gathered[0][0, 0], self._gathered[-1][-1, 0]
        longest = self.parameters.initial.longest_s
        if end - start < longest and not finish:
            return None
        rows = np.concatenate(self._gathered) if len(self._gathered) > 1 else self._gathered[0]
        head = rows[: int(np.searchsorted(rows[:, 0], start + longest, side="right"))]
        self._gathered = []
        self._start(head)
        return rows

    def _start(self, head: Array) -> None:
        p = self.parameters
        self._rate_hz = stance.sampling_rate(head[:, 0], p.initial.longest_s)
        gap_s = p.gap.seconds(self._rate_hz)
        a = initial_alignment(head, p.initial, self._rate_hz, p.gravity, p.noise.angle_random_walk, gap_s)
        self.alignment = a
        self.warnings += a.warnings
        index, memory = stance.memory(p.stance, self._rate_hz)
        S = np.zeros(kernel.WORKSPACE_SIZE)
        S[kernel.Q : kernel.Q + 4] = a.attitude
        S[kernel.BG : kernel.BG + 3] = a.gyro_bias
        S[: 15 * 16].reshape(15, 16)[:, :15] = self._initial_covariance(a)
        self._state = (index, memory, S, self._kernel_parameters(a))
        self._scratch = stance.scratch(index, 1)

    def _initial_covariance(self, a: Alignment) -> Array:
        """P (15,15). The accelerometer's offset tilted the levelling: psi_x = e_north / g, psi_y = -e_east / g, with e = C b_a."""
        p = self.parameters
        biases = p.states == 15
        sds = [a.tilt_sd] * 2 + [0.0] + [a.velocity_sd] * 3 + [0.0] * 3
        sds += [p.initial.accel_bias_sd * biases] * 3 + [a.gyro_bias_sd * biases] * 3
        C = matrix_from_quaternion(a.attitude)
        T = np.eye(15)
        T[0, 9:12], T[1, 9:12] = C[1] / p.gravity, -C[0] / p.gravity
        return T @ np.diag(np.square(sds)) @ T.T

    def _kernel_parameters(self, a: Alignment) -> Array:
        p = self.parameters
        biases = p.states == 15
        prm = np.zeros(kernel.PARAMETERS)
        prm[kernel.G] = p.gravity
        prm[kernel.PSD_ATTITUDE] = p.noise.angle_random_walk**2
        prm[kernel.PSD_VELOCITY] = p.noise.velocity_random_walk**2
        prm[kernel.PSD_ACCEL_BIAS] = p.noise.accel_bias_walk**2 * biases
        prm[kernel.PSD_GYRO_BIAS] = p.noise.gyro_bias_walk**2 * biases
        prm[kernel.WEIGHT_A], prm[kernel.WEIGHT_G] = p.stance.accel_sd**-2, p.stance.gyro_sd**-2
        prm[kernel.THRESHOLD], prm[kernel.FLOOR], prm[kernel.RATIO] = p.stance.limit, p.stance.floor, p.stance.ratio
        prm[kernel.ZERO_VELOCITY_SD] = p.zero_velocity.sd
        prm[kernel.GAP_S] = p.gap.seconds(self._rate_hz)
        prm[kernel.GAP_RATE], prm[kernel.GAP_SPEED] = p.gap.rate_sd, p.gap.speed_sd
        prm[kernel.GAP_BALLISTIC_S] = p.gap.ballistic_s
        self._set_field(prm, a)
        return prm

    def _set_field(self, prm: Array, a: Alignment) -> None:
        """The undisturbed field, MAGINAV eq 4 (erratum: averaged over the rest, not one sample)."""
        m = self.parameters.magnetic
        prm[kernel.NORM_TOLERANCE], prm[kernel.INCLINATION_TOLERANCE] = m.norm_tolerance, m.inclination_tolerance
        prm[kernel.TILT_SD], prm[kernel.DIRECTION_SD] = m.tilt_sd, m.direction_sd
        prm[kernel.STILL_FRACTION] = m.still_fraction
        prm[kernel.HEADING_SD], prm[kernel.HEADING_TOLERANCE] = m.heading_sd, m.heading_tolerance
        prm[kernel.FIELD_NORM] = prm[kernel.FIELD_INCLINATION] = math.nan
        prm[kernel.FIELD_E] = 1.0
        if a.field is None:
            if m.use == "reset":
                self.warnings.append(
                    "The method uses the magnetometer, but there is no sample of it in the rest at the start: it is not used."
                )
            return
        norm = float(np.linalg.norm(a.field))
        horizontal = math.hypot(a.field[0], a.field[1])
        if norm == 0 or horizontal < 0.05 * norm:
            if m.use != "off":
                self.warnings.append(
                    "The magnetic field at the start has no horizontal part that could give a heading: the magnetometer is not used."
                )
            return
        prm[kernel.MAGNETIC_USE] = _MAGNETIC_USE[m.use]
        prm[kernel.FIELD_NORM] = norm
        prm[kernel.FIELD_INCLINATION] = -math.asin(a.field[2] / norm)
        prm[kernel.FIELD_E : kernel.FIELD_U + 1] = a.field

    def _judge(self, nav: Array, diagnostics: NDArray[np.float32]) -> list[str]:
        """Warnings about the result."""
        found = []
        stood = np.isfinite(diagnostics[:, kernel.ZV_SD])
        known = np.flatnonzero(diagnostics[:, kernel.BRIDGED] != stance.kernel.MISSING)
        bridged = diagnostics[known, kernel.BRIDGED] == kernel.BRIDGED_OVER
        if bridged.any():
            gaps = np.diff(nav[known, 0])[bridged[1:]]
            found.append(
                f"{len(gaps)} gap(s) of {gaps.sum():.2f} s in all were bridged, the longest {gaps.max():.2f} s: the path is in doubt "
                "from there on."
            )
        for value, word in ((1, "held over missing values"), (2, "skipped, values missing for too long")):
            n = int((diagnostics[:, kernel.BRIDGED] == value).sum())
            if n:
                found.append(f"{n} of {len(nav)} samples were {word}.")
        if not stood.any():
            found.append(
                "No stance was found: the path is dead reckoning without any correction and means nothing after a few seconds. Look at "
                "`bematist stance` and choose a threshold; check the units."
            )
        speed = float(np.sqrt(np.square(nav[:, 4:7]).sum(1)).max())
        if speed > 15:
            found.append(f"The speed of the foot reaches {speed:.0f} m/s: stances are missed or the units are wrong.")
        gate = diagnostics[:, kernel.GATE]
        if self._state is not None and self._state[3][kernel.MAGNETIC_USE] != kernel.MAGNETIC_OFF and (gate > 0).any():
            share = float((gate[stood & (gate > 0)] == kernel.USED).mean()) if (stood & (gate > 0)).any() else 0.0
            if share < 0.05:
                found.append(
                    f"Only {100 * share:.1f} % of the magnetometer samples in stance passed the gates: the field is disturbed, or was "
                    "at the start."
                )
        return found

    def _trajectory(self, nav: Array, diagnostics: NDArray[np.float32], **fields: Any) -> Trajectory:
        d = diagnostics
        named: dict[str, NDArray[Any]] = {
            "stance_statistic": d[:, kernel.STATISTIC],
            "stance_threshold": d[:, kernel.LIMIT],
            "zero_velocity_sd": d[:, kernel.ZV_SD],
            "innovation": d[:, kernel.INNOVATION : kernel.INNOVATION + 3],
            "nis": d[:, kernel.NIS],
            "magnetic_norm": d[:, kernel.NORM],
            "magnetic_inclination": d[:, kernel.INCLINATION],
            "magnetic_gate": d[:, kernel.GATE].astype(np.uint8),
            "navigation_state": d[:, kernel.STATE].astype(np.uint8),
            "bridged": d[:, kernel.BRIDGED].astype(np.uint8),
            "gyro_bias": d[:, kernel.GYRO_BIAS : kernel.GYRO_BIAS + 3],
            "gyro_bias_sd": d[:, kernel.GYRO_BIAS_SD : kernel.GYRO_BIAS_SD + 3],
            "accel_bias": d[:, kernel.ACCEL_BIAS : kernel.ACCEL_BIAS + 3],
            "accel_bias_sd": d[:, kernel.ACCEL_BIAS_SD : kernel.ACCEL_BIAS_SD + 3],
        }
        if self._state is not None:
            prm = self._state[3]
            named["magnetic_reference"] = np.array([prm[kernel.FIELD_NORM], prm[kernel.FIELD_INCLINATION]])
        return Trajectory(
            time=nav[:, 0],
            position=nav[:, 1:4],
            velocity=nav[:, 4:7],
            attitude=nav[:, 7:11],
            stance=np.isfinite(d[:, kernel.ZV_SD]).astype(np.uint8),
            packed_covariance=nav[:, 11:29],
            diagnostics=named,
            method=self.method,
            parameters=self.parameters.model_dump(),
            **fields,
        )
