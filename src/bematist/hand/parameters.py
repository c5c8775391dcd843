"""Parameters of the handheld filter."""

from __future__ import annotations

import math
from typing import Any, Literal

from pydantic import Field

from bematist.align import InitialParameters
from bematist.earth import STANDARD_GRAVITY
from bematist.parameters import Parameters
from bematist.updates import GapParameters, HardIronParameters


class HandNoiseParameters(Parameters):
    """Process noise of the attitude filter: densities (the root of a PSD), not per-sample values (erratum of MAGYQ eq 28)."""

    angle_random_walk: float = Field(
        default=math.radians(0.05),
        gt=0,
        description="White noise of the gyroscope, rad/s/√Hz. Larger: the attitude follows the fields more.",
    )
    gyro_bias_walk: float = Field(
        default=2e-5,
        ge=0,
        description="Random walk of the gyroscope's offset, rad/s/√s. Larger: the offset follows sooner, and takes up other errors too.",
    )
    bias_scaling: Literal["corrected", "printed"] = Field(
        default="corrected",
        description="How far the offset walks in a sampling period T. corrected: √T times `gyro_bias_walk`. printed: T times (MAGYQ eq "
        "28), at 100 Hz a tenth of it; with the fixed reference that is often the better tuning.",
    )
    accel_bias_sd: float = Field(
        default=0.05, ge=0, description="Standard deviation of the accelerometer's offset, m/s², a Gauss-Markov process (MAGYQ eq 13)."
    )
    accel_bias_time_s: float = Field(default=300.0, ge=1, description="Its correlation time, s. Larger: a steadier offset.")


class QuasiStaticParameters(Parameters):
    """When a field counts as constant in the navigation frame (MAGYQ eqs 33-34), and how much it is then believed."""

    use: bool = Field(default=True, description="Whether this field is looked at.")
    local: bool = Field(
        default=True,
        description="Whether a static field that is not the Earth's corrects, by its direction at the beginning of its period (QSF, MAGYQ "
        "eqs 35-38).",
    )
    earth: bool = Field(default=True, description="Whether a static field that looks like the Earth's corrects by the Earth's direction.")
    gradient: bool = Field(
        default=True,
        description="Whether a static field also corrects by its turning from sample to sample (MARU and AGU, MAGYQ eqs 39-46).",
    )
    window_s: float = Field(default=1.0, gt=0, le=20, description="Window of the detector, s (N T of eq 33). Longer: later and stricter.")
    first_s: float = Field(default=0.5, gt=0, le=20, description="Part of the window whose mean is the reference, s (N_first T).")
    detector: Literal["variance", "likelihood"] = Field(
        default="variance",
        description="Test statistic: variance (eq 33), or likelihood, the ratio test on the change of the norm from sample to sample.",
    )
    likelihood: float = Field(
        default=2.0, gt=0, description="Limit of the likelihood ratio; 1 is what noise alone gives. Larger: more periods, worse ones too."
    )
    innovation_limit: float = Field(
        default=25.0,
        gt=0,
        description="Fault detection: an innovation whose normalised square (3 in expectation) is larger is refused. Infinite: never.",
    )
    patience: int = Field(default=10, ge=0, description="After more refusals in a row than this the period ends, and a new one may begin.")


class MagneticFieldParameters(QuasiStaticParameters):
    """The magnetic field."""

    sd: float = Field(default=0.5, gt=0, description="Noise of a sample, µT, with what calibration left over. Larger: believed less.")
    deviation: float = Field(
        default=1.2, gt=0, description="gamma_1: largest rms difference of the norm to its reference over the window, µT."
    )
    outlier: float = Field(default=3.0, gt=0, description="gamma_2: largest difference of the last norm to the reference, µT (eq 34).")
    earth_tolerance: float = Field(
        default=1.5, ge=0, description="The field is the Earth's where the reference norm differs less than this from the Earth's, µT."
    )
    dip_tolerance: float | None = Field(
        default=None,
        gt=0,
        description="And where its inclination differs less than this, rad (2.5 degrees does well); none: only the norm counts (MAGYQ).",
    )
    earth_sd: float = Field(
        default=0.5,
        gt=0,
        description="Noise of a sample against the Earth's field, µT. Larger: what looks like the Earth's is believed less.",
    )
    hard_iron: HardIronParameters = HardIronParameters()
    walk: float = Field(
        default=0.0, ge=0, description="Estimated reference: how it changes as one moves on, µT/√s. Larger: an older reference binds less."
    )


class SpecificForceParameters(QuasiStaticParameters):
    """The specific force, whose static value is gravity where the hand does not accelerate."""

    sd: float = Field(default=0.1, gt=0, description="Noise of a sample, m/s², with the tremor of the hand. Larger: believed less.")
    deviation: float = Field(default=0.15, gt=0, description="gamma_1: largest rms difference of the norm to its reference, m/s².")
    outlier: float = Field(default=0.4, gt=0, description="gamma_2: largest difference of the last norm to the reference, m/s² (eq 34).")
    earth_tolerance: float = Field(
        default=0.2, ge=0, description="The force is gravity where the reference norm differs less than this from `gravity`, m/s²."
    )
    earth_sd: float = Field(default=0.1, gt=0, description="Noise of a sample against gravity, m/s².")
    walk: float = Field(default=0.0, ge=0, description="Estimated reference: how it changes, m/s²/√s.")


class MotionParameters(Parameters):
    """Beyond the paper: what the two fields say while they are not static, and what the magnetic one says in a rest."""

    gravity_density: float = Field(
        default=0.0,
        ge=0,
        description="Gravity in motion: the specific force is up on the average, with accelerations of this density, m/s²/√Hz; 0: not "
        "used. Larger: tilt follows the gyroscope more.",
    )
    gravity_spread: float = Field(
        default=0.3,
        ge=0,
        description="Added to it for each m/s² by which the norm differs from gravity, 1/√Hz. Larger: strong strides count less.",
    )
    heading_density: float = Field(
        default=0.0,
        ge=0,
        description="Heading from every sample that looks like the Earth's field, with errors of this density, rad/√Hz; 0: not used. "
        "Larger: the heading follows the gyroscope more.",
    )
    heading_spread: float = Field(
        default=0.0,
        ge=0,
        description="Added to it for each rad by which a disturbance of the size that norm and inclination show would turn the heading, "
        "1/√Hz: √2τ for disturbances that last τ seconds. Larger: doubtful fields count less.",
    )
    rest_field_sd: float = Field(
        default=0.0,
        ge=0,
        description="Without `local` of the magnetic field: while the specific force is static, the sensor stays where it is, and a static "
        "field is compared with what it was when that began, with this noise of a sample, µT; 0: not used. Larger: believed less.",
    )
    norm_tolerance: float = Field(default=0.1, gt=0, description="Gate: largest relative difference of its norm to the Earth's.")
    inclination_tolerance: float = Field(default=math.radians(5), gt=0, description="Gate: largest difference of its inclination, rad.")


class AttitudeParameters(Parameters):
    """The attitude filter MAGYQ and what was added to it."""

    correction: Literal["kalman", "replace", "none"] = Field(
        default="kalman",
        description="kalman: the filter. replace: the baseline QUEST, the attitude is replaced where gravity or the Earth's field is "
        "detected. none: the baseline GyInt, the gyroscope integrated with the offset of the rest at the start.",
    )
    reference: Literal["fixed", "estimated"] = Field(
        default="fixed",
        description="The direction that a static field keeps. fixed: the mean at the beginning of the period, taken for the truth (MAGYQ). "
        "estimated: a part of the state that takes over the attitude's error, so that the covariance stays honest.",
    )
    normalise_covariance: bool = Field(
        default=True,
        description="Whether P loses what it says along the quaternion when that is normalised. MAGYQ does not; it costs much accuracy.",
    )
    earth_rate: tuple[float, float, float] | None = Field(
        default=None, description="Rotation of the Earth, rad/s, East, North, Up, taken out of the angular rate; none: left in the offset."
    )
    noise: HandNoiseParameters = HandNoiseParameters()
    magnetic: MagneticFieldParameters = MagneticFieldParameters()
    force: SpecificForceParameters = SpecificForceParameters()
    motion: MotionParameters = MotionParameters()


class HandParameters(Parameters):
    """Everything that the handheld attitude filter can be told."""

    gravity: float = Field(default=STANDARD_GRAVITY, gt=0, description="Local gravity, m/s².")
    initial: InitialParameters = InitialParameters(sway=math.radians(1.0), shortest_s=3.0)
    heading_sd: float = Field(
        default=0.0,
        ge=0,
        description="How far the heading at the start may be from the one that the Earth's field tells elsewhere, rad. 0: the start "
        "defines the frame. Larger: the heading follows the field sooner.",
    )
    moving_start_s: float = Field(
        default=4.0,
        gt=0,
        description="Without a rest at the start, the specific force is averaged over this long, s, to find up. Longer: less of the hand's "
        "own motion, more of the gyroscope's offset.",
    )
    attitude: AttitudeParameters = AttitudeParameters()
    gap: GapParameters = GapParameters()


def hand_parameters(**attitude: Any) -> HandParameters:
    """Parameters with some values of the attitude filter changed, nested."""
    return HandParameters().override({"attitude": attitude})


MAGYQ = HandParameters()
"""The filter of the paper, corrected."""

GYINT = hand_parameters(correction="none")
"""Its baseline: the gyroscope alone (section 8.2.1)."""

QUEST = hand_parameters(correction="replace")
"""Its baseline that knows the Earth's fields only (section 8.2.1)."""

MAGYQ_ESTIMATED = hand_parameters(
    reference="estimated",
    magnetic={"gradient": False, "dip_tolerance": math.radians(2.5), "earth_sd": 2.0},
    force={"gradient": False},
)
"""The paper's filter with its references in the state, and the dip gate."""

HAND = hand_parameters(
    reference="estimated",
    magnetic={"local": False, "gradient": False, "earth": False},
    force={"local": False, "gradient": False, "earth": False},
    motion={"gravity_density": 0.8, "gravity_spread": 0.0, "heading_density": 0.05, "heading_spread": 3.0, "rest_field_sd": 2.0},
).override({"heading_sd": math.radians(3)})
"""The default: gravity also in motion, heading from every sample that looks like the Earth's field, and any field that stays in a rest."""
