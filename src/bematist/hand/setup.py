"""From parameters and alignment to what the kernels start from."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.align import Alignment, disagreement
from bematist.frames import matrix_from_quaternion
from bematist.hand.parameters import HandParameters, MagneticFieldParameters, QuasiStaticParameters, SpecificForceParameters
from bematist.hard_iron import begin, set_parameters
from bematist.kernels import hand_layout as at
from bematist.kernels import stance
from bematist.kernels.layout import LEAST_HORIZONTAL
from bematist.stance import sampling_rate

Array = NDArray[np.float64]

_CORRECTION = {"none": at.NOTHING, "kalman": at.KALMAN, "replace": at.REPLACE}
_REFERENCE = {"fixed": at.FIXED, "estimated": at.ESTIMATED}
_DETECTOR = {"variance": at.BY_VARIANCE, "likelihood": at.BY_LIKELIHOOD}


def rotation_to_quaternion(q: Array) -> Array:
    """−½ G (4,3): the additive error of a quaternion from the rotation vector psi in n, C_est = exp([psi×]) C_true."""
    w, x, y, z = q
    return -0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])


def initial_covariance(p: HandParameters, a: Alignment, period: float) -> Array:
    """P (16,16). The accelerometer's offset tilted the levelling: psi_x = e_north / g, psi_y = -e_east / g, with e = C b_a."""
    C = matrix_from_quaternion(a.attitude)
    T = np.zeros((16, 9))
    G = rotation_to_quaternion(a.attitude)
    T[at.E_Q : at.E_Q + 4, :3] = G
    T[at.E_Q : at.E_Q + 4, 6:9] = G @ np.stack([C[1], -C[0], np.zeros(3)]) / a.gravity
    T[at.E_BQ : at.E_BQ + 3, 3:6] = np.eye(3) * period / 2
    T[at.E_BA : at.E_BA + 3, 6:9] = np.eye(3)
    sds = [a.tilt_sd] * 2 + [p.heading_sd] + [a.gyro_bias_sd] * 3 + [p.initial.accel_bias_sd] * 3
    return T @ np.diag(np.square(sds)) @ T.T


def workspace(p: HandParameters, a: Alignment, prm: Array, start: float) -> Array:
    """The state before the first sample, at `start` s.

    The gyroscope-quaternion offset of a period T is T/2 times the gyroscope's (erratum of MAGYQ eq 20).
    """
    S, period = np.zeros(at.WORKSPACE_SIZE), prm[at.PERIOD]
    S[: at.WIDTH**2] = initial_covariance(p, a, period).ravel()
    S[at.Q : at.Q + 4] = a.attitude
    S[at.BQ : at.BQ + 3] = a.gyro_bias * period / 2
    S[at.EARTH_E : at.EARTH_U + 1] = field = prm[at.START_E : at.START_U + 1]
    horizontal = math.hypot(field[0], field[1])
    S[at.EARTH_NORM], S[at.EARTH_INCLINATION] = math.hypot(horizontal, field[2]), -math.atan2(field[2], horizontal)
    begin(S, at.IRON, p.attitude.magnetic.hard_iron, start)
    return S


def detectors(p: HandParameters, rate_hz: float, magnetic_rate_hz: float) -> tuple[NDArray[np.int64], Array]:
    """Empty detectors of the magnetic field and of the specific force, and what a missing value is held at."""
    index = np.zeros(2 * at.INDEX_EACH, np.int64)
    end = at.MEMORY_HEAD
    fields: tuple[tuple[QuasiStaticParameters, float], ...] = ((p.attitude.magnetic, magnetic_rate_hz), (p.attitude.force, rate_hz))
    for i, (field, rate) in enumerate(fields):
        length = max(2, round(field.window_s * rate) + 1)
        o = i * at.INDEX_EACH
        index[o + at.LENGTH], index[o + at.FIRST] = length, min(length, max(1, round(field.first_s * rate)))
        index[o + at.RING] = end
        end += at.DETECTOR_HEAD + at.ENTRY * length
    memory = np.zeros(end)
    memory[stance.HELD : stance.HELD + 2] = -np.inf
    return index, memory


def kernel_parameters(p: HandParameters, a: Alignment, rate_hz: float) -> tuple[Array, list[str]]:
    """The parameters that the kernels read (`kernels.hand_layout`), and warnings about the field at the start."""
    prm = np.zeros(at.PARAMETERS)
    own, noise, motion = p.attitude, p.attitude.noise, p.attitude.motion
    prm[at.G], prm[at.PERIOD] = a.gravity, 1 / rate_hz
    prm[at.PSD_ANGLE] = noise.angle_random_walk**2
    prm[at.BIAS_WALK] = (noise.gyro_bias_walk * prm[at.PERIOD] / 2) ** 2
    prm[at.BIAS_POWER] = 2.0 if noise.bias_scaling == "printed" else 1.0
    prm[at.ACCEL_DECAY] = 1 / noise.accel_bias_time_s
    prm[at.ACCEL_BIAS_WALK] = 2 * noise.accel_bias_sd**2 / noise.accel_bias_time_s
    prm[at.PROJECT] = own.normalise_covariance
    prm[at.CORRECTION], prm[at.REFERENCE] = _CORRECTION[own.correction], _REFERENCE[own.reference]
    prm[at.GAP_S], prm[at.GAP_RATE], prm[at.GAP_BALLISTIC_S] = p.gap.seconds(rate_hz), p.gap.rate_sd, p.gap.ballistic_s
    prm[at.RATE_E : at.RATE_U + 1] = a.earth_rate
    prm[at.LEVEL_PSD], prm[at.LEVEL_SPREAD] = motion.gravity_density**2, motion.gravity_spread
    prm[at.HEADING_PSD], prm[at.HEADING_SPREAD] = motion.heading_density**2, motion.heading_spread**2
    prm[at.HEADING_NORM], prm[at.HEADING_DIP] = motion.norm_tolerance, motion.inclination_tolerance
    prm[at.REST_VARIANCE] = 0.0 if own.magnetic.local else motion.rest_field_sd**2
    prm[at.HEADING_LONGEST_S] = motion.heading_spread**2 or math.inf
    _set_detector(prm, at.MAGNETIC, own.magnetic)
    _set_detector(prm, at.FORCE, own.force)
    return prm, _set_earth(prm, p, a)


def _set_detector(prm: Array, f: int, field: MagneticFieldParameters | SpecificForceParameters) -> None:
    prm[f + at.USE], prm[f + at.LOCAL], prm[f + at.EARTH], prm[f + at.GRADIENT] = field.use, field.local, field.earth, field.gradient
    prm[f + at.DETECTOR] = _DETECTOR[field.detector]
    prm[f + at.DEVIATION], prm[f + at.OUTLIER], prm[f + at.LIKELIHOOD] = field.deviation, field.outlier, field.likelihood
    prm[f + at.EARTH_TOLERANCE] = field.earth_tolerance
    prm[f + at.VARIANCE], prm[f + at.EARTH_VARIANCE] = field.sd**2, field.earth_sd**2
    prm[f + at.WALK] = field.walk**2
    prm[f + at.LIMIT], prm[f + at.PATIENCE] = field.innovation_limit, field.patience


def _set_earth(prm: Array, p: HandParameters, a: Alignment) -> list[str]:
    """The Earth's magnetic field in n: as given, else the mean over the rest at the start (MAGYQ section 4.2)."""
    field = p.initial.earth_field if p.initial.earth_field is not None else a.field
    horizontal = 0.0 if field is None else math.hypot(field[0], field[1])
    enters = a.field_from if p.initial.earth_field is None else np.zeros((3, 3))
    set_parameters(prm, at.IRON_USE, p.attitude.magnetic.hard_iron, enters)
    if field is None or not horizontal > LEAST_HORIZONTAL * math.hypot(horizontal, field[2]):
        prm[at.MAGNETIC + at.EARTH] = prm[at.HEADING_PSD] = 0.0
        if field is None:
            return []
        return ["The magnetic field at the start has no horizontal part that could give a heading: it serves only as a field that stays."]
    prm[at.START_E : at.START_U + 1] = field
    dip = p.attitude.magnetic.dip_tolerance
    prm[at.DIP_TOLERANCE] = math.inf if dip is None else dip
    if p.initial.earth_field is None or a.field is None:
        return []
    return disagreement(a.field, np.array(field), p.attitude.motion)


def initial_state(p: HandParameters, a: Alignment, head: Array) -> tuple[tuple[NDArray[Any], ...], list[str]]:
    """Detectors (index and memory), workspace and parameters of the kernels after an alignment on rows (K,10), and warnings."""
    known = np.isfinite(head[:, 7:10]).all(1)
    magnetic_rate = sampling_rate(head[known, 0], p.initial.longest_s) if known.sum() > 1 else a.rate_hz
    prm, warnings = kernel_parameters(p, a, a.rate_hz)
    return (*detectors(p, a.rate_hz, magnetic_rate), workspace(p, a, prm, head[0, 0]), prm), warnings
