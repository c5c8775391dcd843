"""What each measurement update assumes, its gate and its noise."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from bematist.parameters import Parameters


class ZeroVelocityParameters(Parameters):
    """In stance the velocity is zero (MAGINAV eqs 21-24)."""

    sd: float = Field(
        default=0.01,
        gt=0,
        description="Standard deviation of the velocity of a standing foot, m/s; with the relative stance rule, at its floor. Smaller: "
        "a rolling foot shortens the path; larger: the path drifts.",
    )


class MagneticParameters(Parameters):
    """What the magnetometer is used for, in stance only, once per sample, and the gates a sample must pass."""

    use: Literal["off", "reset", "heading"] = Field(
        default="off",
        description="off: not used. reset: the attitude is replaced by TRIAD's (MAGINAV Table 2, state 3). heading: a measurement of the "
        "heading in the Kalman filter.",
    )
    norm_tolerance: float = Field(
        default=0.05,
        gt=0,
        description="Gate: largest relative difference of the norm to the norm at the start (MAGINAV eqs 4-5). Larger: more samples "
        "pass, more disturbed ones too.",
    )
    inclination_tolerance: float = Field(
        default=math.radians(5),
        gt=0,
        description="Gate: largest difference, rad, of the inclination to the one at the start; a field that was turned keeps its norm.",
    )
    still_fraction: float = Field(
        default=0.1,
        gt=0,
        le=1,
        description="reset: only where the stance statistic is below this fraction of its threshold. TRIAD takes the specific force for "
        "up, and at the edges of a stance the foot already accelerates.",
    )
    tilt_sd: float = Field(
        default=math.radians(1.0),
        gt=0,
        description="reset: standard deviation of TRIAD's tilt, rad (specific force noise over g).",
    )
    direction_sd: float = Field(
        default=math.radians(2.0),
        gt=0,
        description="reset: standard deviation of the horizontal direction of the field, rad (field noise over its horizontal part).",
    )
    triad: Literal["corrected", "printed"] = Field(
        default="corrected",
        description="reset: printed is MAGINAV eq 11 as it stands, without the transposition; it turns the wrong way and ruins the path.",
    )
    covariance: Literal["replaced", "untouched"] = Field(
        default="replaced",
        description="reset: the attitude's part of the covariance becomes TRIAD's, or stays as it was (MAGINAV Table 2 is silent), "
        "so that position is moved by errors that are gone.",
    )
    heading_sd: float = Field(
        default=math.radians(40.0),
        gt=0,
        description="heading: standard deviation of one sample's magnetic heading, rad. Disturbances last for seconds, so it is far above "
        "white noise. Larger: heading follows the field more slowly.",
    )
    heading_tolerance: float = Field(
        default=math.radians(10.0),
        gt=0,
        description="heading: gate, rad; a sample is refused that differs by more than this and twice the filter's own doubt.",
    )


class StepParameters(Parameters):
    """Which steps of time are gaps, and how attitude is carried over them."""

    longest_step_s: float = Field(
        default=0.02, gt=0, description="A longer step, s (and longer than 3.5 sampling periods), is a gap and is bridged."
    )
    ballistic_s: float = Field(
        default=0.3,
        ge=0,
        description="Up to this long, s, velocity and angular rate are carried on; longer, the sensor is taken to have stopped.",
    )

    def seconds(self, rate_hz: float) -> float:
        """The step from which on time counts as a gap, s, at a sampling rate."""
        return max(self.longest_step_s, 3.5 / rate_hz)


class GapParameters(StepParameters):
    """How time without samples is bridged."""

    rate_sd: float = Field(default=1.0, ge=0, description="Angular rate in a gap, rad/s: attitude is in doubt by this times its length.")
    speed_sd: float = Field(default=1.5, ge=0, description="Speed in a gap, m/s: position is in doubt by this times its length.")
