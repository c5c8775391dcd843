"""Parameters of the foot-mounted filter."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from bematist.align import InitialParameters
from bematist.earth import STANDARD_GRAVITY
from bematist.parameters import Parameters
from bematist.stance import StanceParameters
from bematist.updates import (
    GapParameters,
    HeadingReductionParameters,
    MagneticParameters,
    MagneticRateParameters,
    ZeroAngularRateParameters,
    ZeroVelocityParameters,
)


class AttitudeParameters(Parameters):
    """How the attitude goes from sample to sample, between the updates of the filter."""

    propagation: Literal["common", "mahony", "madgwick"] = Field(
        default="common",
        description="common: by the gyroscope alone. mahony, madgwick: also drawn towards gravity, and towards the magnetic field where "
        "`magnetometer` says so (Li & Wang eqs 24-34). The filter's covariance knows nothing of that.",
    )
    integration: Literal["exact", "first-order", "first-order-matrix"] = Field(
        default="exact",
        description="exact: exponential (MAGINAV eq 7). first-order: quaternion to first order, normalised (Li & Wang eqs 24, 29). "
        "first-order-matrix: I + [w x] dt, made orthogonal at every sample (MAGINAV eqs 8-9, Li & Wang eq 10); at 10 rad/s and 100 Hz it "
        "turns by 0.33 % too little.",
    )
    force_at: Literal["middle", "end"] = Field(
        default="middle",
        description="Attitude that turns the specific force of an interval: at its middle, or at its end as MAGINAV eq 14 prints it, which "
        "is half a sample late and costs height.",
    )
    magnetometer: Literal["off", "gated", "all"] = Field(
        default="off",
        description="Magnetometer samples that draw the attitude of mahony and madgwick: none; those that pass the gates of `magnetic`; "
        "all, as in the literature. Each counts once, when it arrives, in swing too.",
    )
    kp: float = Field(default=1.0, ge=0, description="mahony: proportional gain, 1/s. Larger: drawn faster, and astray by accelerations.")
    ki: float = Field(
        default=0.0,
        ge=0,
        description="mahony: integral gain, 1/s². Above 0 it estimates the gyroscope's offset, which the filter with 15 states does too.",
    )
    beta: float = Field(
        default=0.1, ge=0, description="madgwick: gain, 1/s; it turns by up to 2 beta rad/s, whatever the error. Larger: as with kp."
    )


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
    growth: Literal["density", "per-sample"] = Field(
        default="density",
        description="What white noise adds to the covariance at a sample: its density squared times the sampling period; or, as MAGINAV eq "
        "23 is worded, the variance of a sample times the period, which is the sampling rate in Hz times too much.",
    )


class FootParameters(Parameters):
    """Everything that the foot-mounted filter can be told."""

    states: Literal[9, 15] = Field(
        default=15, description="15: attitude, velocity, position and both offsets (MAGINAV eq 18). 9: without the offsets."
    )
    linearisation: Literal["printed", "invariant"] = Field(
        default="printed",
        description="printed: errors of velocity as MAGINAV eqs 20-22 have them; every stance then seems to tell a little of the heading, "
        "and its uncertainty becomes several times too small. invariant: errors of velocity in axes that turn with the attitude's error "
        "(invariant Kalman filter), so that zero velocity says nothing of heading, which it cannot.",
    )
    gravity: float = Field(default=STANDARD_GRAVITY, gt=0, description="Local gravity, m/s².")
    earth_rate: tuple[float, float, float] | None = Field(
        default=None,
        description="Rotation of the Earth, rad/s, East, North, Up, taken out of the angular rate; none: left in the gyroscope's offset.",
    )
    attitude: AttitudeParameters = AttitudeParameters()
    stance: StanceParameters = StanceParameters()
    zero_velocity: ZeroVelocityParameters = ZeroVelocityParameters()
    magnetic: MagneticParameters = MagneticParameters()
    zaru: ZeroAngularRateParameters = ZeroAngularRateParameters()
    hdr: HeadingReductionParameters = HeadingReductionParameters()
    maru: MagneticRateParameters = MagneticRateParameters()
    initial: InitialParameters = InitialParameters()
    noise: NoiseParameters = NoiseParameters()
    gap: GapParameters = GapParameters()
