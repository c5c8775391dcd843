"""From parameters and alignment to what the kernels start from."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bematist.align import Alignment, disagreement, undisturbed
from bematist.foot.parameters import AttitudeParameters, FootParameters
from bematist.frames import matrix_from_quaternion
from bematist.hard_iron import begin, set_parameters
from bematist.kernels import layout as kernel
from bematist.stance import StanceParameters

Array = NDArray[np.float64]

_MAGNETIC_USE = {
    "off": kernel.MAGNETIC_OFF,
    "reset": kernel.MAGNETIC_RESET,
    "heading": kernel.MAGNETIC_HEADING,
}
_PROPAGATION = {"common": kernel.COMMON, "mahony": kernel.MAHONY, "madgwick": kernel.MADGWICK}
_INTEGRATION = {"exact": kernel.EXACT, "first-order": kernel.FIRST_ORDER, "first-order-matrix": kernel.FIRST_ORDER_MATRIX}
_LISTEN = {"off": kernel.LISTEN_OFF, "gated": kernel.LISTEN_GATED, "all": kernel.LISTEN_ALL}


def initial_covariance(p: FootParameters, a: Alignment) -> Array:
    """P (15,15). The accelerometer's offset tilted the levelling: psi_x = e_north / g, psi_y = -e_east / g, with e = C b_a."""
    biases = p.states == 15
    sds = [a.tilt_sd] * 2 + [0.0] + [a.velocity_sd] * 3 + [0.0] * 3
    sds += [p.initial.accel_bias_sd * biases] * 3 + [a.gyro_bias_sd * biases] * 3
    C = matrix_from_quaternion(a.attitude)
    T = np.eye(15)
    T[0, 9:12], T[1, 9:12] = C[1] / a.gravity, -C[0] / a.gravity
    return T @ np.diag(np.square(sds)) @ T.T


def kernel_parameters(p: FootParameters, a: Alignment, rate_hz: float, *, seen: bool = True) -> tuple[Array, list[str]]:
    """The parameters that the kernels read (`kernels.layout`), and warnings about the field at the start.

    seen: whether there was a sample of the magnetometer at all.
    """
    biases = p.states == 15
    prm = np.zeros(kernel.PARAMETERS)
    prm[kernel.G] = a.gravity
    prm[kernel.EARTH_E : kernel.EARTH_U + 1] = a.earth_rate
    growth = rate_hz if p.noise.growth == "per-sample" else 1.0
    prm[kernel.PSD_ATTITUDE] = p.noise.angle_random_walk**2 * growth
    prm[kernel.PSD_VELOCITY] = p.noise.velocity_random_walk**2 * growth
    prm[kernel.PSD_ACCEL_BIAS] = p.noise.accel_bias_walk**2 * biases
    prm[kernel.PSD_GYRO_BIAS] = p.noise.gyro_bias_walk**2 * biases
    prm[kernel.WEIGHT_A], prm[kernel.WEIGHT_G] = p.stance.accel_sd**-2, p.stance.gyro_sd**-2
    prm[kernel.THRESHOLD], prm[kernel.FLOOR], prm[kernel.RATIO] = p.stance.limit, p.stance.least, p.stance.ratio
    prm[kernel.INVARIANT] = p.linearisation == "invariant"
    prm[kernel.ZERO_VELOCITY_SD] = p.zero_velocity.sd
    prm[kernel.GAP_S] = p.gap.seconds(rate_hz)
    prm[kernel.GAP_RATE], prm[kernel.GAP_SPEED] = p.gap.rate_sd, p.gap.speed_sd
    prm[kernel.GAP_BALLISTIC_S] = p.gap.ballistic_s
    _set_attitude(prm, p.attitude, a)
    _set_constraints(prm, p, a, rate_hz)
    _set_pace(prm, p.stance, rate_hz)
    return prm, _set_field(prm, p, a, seen)


def _set_attitude(prm: Array, p: AttitudeParameters, a: Alignment) -> None:
    prm[kernel.START : kernel.START + 4] = a.attitude
    prm[kernel.PROPAGATION] = _PROPAGATION[p.propagation]
    prm[kernel.INTEGRATION] = _INTEGRATION[p.integration]
    prm[kernel.AT_END] = p.force_at == "end"
    prm[kernel.KP], prm[kernel.KI], prm[kernel.BETA] = p.kp, p.ki, p.beta


def _set_constraints(prm: Array, p: FootParameters, a: Alignment, rate_hz: float) -> None:
    zaru, hdr, maru = p.zaru, p.hdr, p.maru
    prm[kernel.ZARU_USE] = zaru.use != "off"
    prm[kernel.ZARU_RATE], prm[kernel.ZARU_AFTER_S] = (zaru.rate, zaru.after_s) if zaru.use == "rest" else (math.inf, 0.0)
    prm[kernel.ZARU_VARIANCE] = zaru.sd**2 * max(1.0, zaru.correlation_s * rate_hz)
    prm[kernel.HDR_USE] = {"off": kernel.HDR_OFF, "sample": kernel.HDR_SAMPLE, "stance": kernel.HDR_STANCE}[hdr.use]
    prm[kernel.HDR_VARIANCE], prm[kernel.HDR_TOLERANCE] = hdr.sd**2, hdr.tolerance
    prm[kernel.HDR_AFTER_S], prm[kernel.HDR_APART_S] = hdr.after_s, hdr.apart_s
    prm[kernel.HDR_LONGEST_S] = hdr.longest_s if hdr.use == "sample" else math.inf
    # The yaw of the body axis, x or y, that lies flatter.
    up = matrix_from_quaternion(a.attitude)[2]
    prm[kernel.HDR_AXIS] = float(abs(up[1]) < abs(up[0]))
    prm[kernel.MARU_USE] = maru.use
    prm[kernel.MARU_VARIANCE], prm[kernel.MARU_INTERVAL_S] = 2 * maru.sd**2, maru.interval_s
    prm[kernel.MARU_NORM_TOLERANCE], prm[kernel.MARU_GATE] = maru.norm_tolerance, maru.gate
    prm[kernel.CONSTRAINED] = zaru.use != "off" or hdr.use != "off" or maru.use


def _set_pace(prm: Array, s: StanceParameters, rate_hz: float) -> None:
    prm[kernel.PACE_USE] = s.rule == "adaptive"
    prm[kernel.PACE_SAMPLES] = s.pace_samples(rate_hz)
    prm[kernel.PACE_WALK], prm[kernel.PACE_RUN], prm[kernel.PACE_HYSTERESIS] = s.pace.walk_speed, s.pace.run_speed, s.pace.hysteresis
    prm[kernel.PACE_LIMIT : kernel.PACE_LIMIT + 3] = s.limits


def workspace(p: FootParameters, a: Alignment, prm: Array, start: float) -> Array:
    """The workspace before the first sample, at `start` s (`kernels.layout`), with the rings of the adaptive rule behind it."""
    S = np.zeros(kernel.WORKSPACE_SIZE + 2 * int(prm[kernel.PACE_SAMPLES] * prm[kernel.PACE_USE]))
    S[kernel.Q : kernel.Q + 4] = a.attitude
    S[kernel.BG : kernel.BG + 3] = a.gyro_bias
    S[: 15 * 16].reshape(15, 16)[:, :15] = initial_covariance(p, a)
    S[kernel.FIELD_TIME] = start
    field = prm[kernel.START_E : kernel.START_U + 1]
    norm, horizontal = float(np.linalg.norm(field)), math.hypot(field[0], field[1])
    S[kernel.FIELD_NORM] = S[kernel.FIELD_INCLINATION] = math.nan
    S[kernel.FIELD_E] = S[kernel.NORTH_E] = 1.0
    if horizontal > 0:
        S[kernel.FIELD_NORM], S[kernel.FIELD_INCLINATION] = norm, -math.asin(field[2] / norm)
        S[kernel.FIELD_E : kernel.FIELD_U + 1] = field
        S[kernel.NORTH_E], S[kernel.NORTH_N] = field[:2] / horizontal
    begin(S, kernel.IRON, p.magnetic.hard_iron, start)
    S[kernel.LIMIT_NOW], S[kernel.CLASS] = prm[kernel.THRESHOLD], kernel.WALKING
    return S


def _set_field(prm: Array, p: FootParameters, a: Alignment, seen: bool) -> list[str]:
    m = p.magnetic
    listening = p.attitude.propagation != "common" and p.attitude.magnetometer != "off"
    prm[kernel.TRIAD_PRINTED], prm[kernel.KEEP_COVARIANCE] = m.triad == "printed", m.covariance == "untouched"
    prm[kernel.NORM_TOLERANCE], prm[kernel.INCLINATION_TOLERANCE] = m.norm_tolerance, m.inclination_tolerance
    prm[kernel.TILT_SD], prm[kernel.DIRECTION_SD] = m.tilt_sd, m.direction_sd
    prm[kernel.STILL_FRACTION] = m.still_fraction
    prm[kernel.HEADING_SD], prm[kernel.HEADING_TOLERANCE] = m.heading_sd, m.heading_tolerance
    own = m.reference == "start" or p.initial.earth_field is None
    set_parameters(prm, kernel.IRON_USE, m.hard_iron, a.field_from if own else np.zeros((3, 3)))
    if a.field is None:
        if m.use == "reset" or listening:
            where = " in the rest at the start" if seen else ""
            return [f"The method uses the magnetometer, but there is no sample of it{where}: it is not used."]
        return []
    field = a.field if m.reference == "start" else undisturbed(p.initial, a.field)
    assert field is not None
    norm = float(np.linalg.norm(field))
    horizontal = math.hypot(field[0], field[1])
    if norm == 0 or not horizontal > kernel.LEAST_HORIZONTAL * norm:
        if m.use != "off" or listening:
            return ["The magnetic field has no horizontal part that could give a heading: the magnetometer is not used."]
        return []
    prm[kernel.MAGNETIC_USE] = _MAGNETIC_USE[m.use]
    prm[kernel.LISTEN] = _LISTEN[p.attitude.magnetometer] if listening else kernel.LISTEN_OFF
    prm[kernel.START_E : kernel.START_U + 1] = field
    if p.initial.earth_field is None or (m.use == "off" and not listening):
        return []
    return [f"{w} With magnetic.reference=start those that look like the start are." for w in disagreement(a.field, field, m)]
