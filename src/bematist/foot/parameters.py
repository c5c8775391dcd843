"""Parameters of the foot-mounted filter."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from bematist.align import InitialParameters
from bematist.earth import STANDARD_GRAVITY
from bematist.parameters import Parameters
from bematist.stance import StanceParameters
from bematist.updates import GapParameters, MagneticParameters, ZeroVelocityParameters


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
