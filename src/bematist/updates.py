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


class HardIronParameters(Parameters):
    """The magnetometer's hard iron, followed while walking: a field that turns with the sensor, where the Earth's and a building's do not.

    It is told apart by the turning alone, with neither Earth's field nor attitude known; between measurements the field may change.
    """

    use: Literal["off", "watch", "correct"] = Field(
        default="off",
        description="off: not looked for. watch: found and told, and nothing else changed. correct: taken out of the readings, and of the "
        "field at the start, as long as `evidence` and `least` say so.",
    )
    prior_sd: float = Field(default=20.0, gt=0, description="Hard iron before the first measurement, µT on each axis.")
    walk: float = Field(default=0.01, ge=0, description="How it changes, µT/√s. Larger: it follows a sensor that is magnetised anew.")
    block_s: float = Field(
        default=0.1, gt=0, description="Samples of this time are one measurement, s (of a shoe, within one stance). Longer: fewer, surer."
    )
    sd: float = Field(
        default=0.5, gt=0, description="Noise of a measurement, µT on each axis, with soft iron and what else calibration left over."
    )
    delay_s: float = Field(
        default=0.01, ge=0, description="How far the clocks of magnetometer and gyroscope may be apart, s. Larger: fast turns count less."
    )
    turn_error: float = Field(
        default=0.01, ge=0, description="Error of the gyroscope over a turn of 1 rad, rad; it grows with the root of the turn."
    )
    drift: float = Field(
        default=0.1, ge=0, description="How the field drifts at any time, µT/√s, with the turning that the gyroscope's offset feigns."
    )
    field_walk: float = Field(
        default=1.0,
        ge=0,
        description="How the field changes as one moves, µT/√s, at least; from the innovations the filter learns by how much more. "
        "Smaller: surer in the open, and too sure in a building.",
    )
    memory_s: float = Field(default=10.0, gt=0, description="How long it remembers what it learned of that, s of motion.")
    jump: float = Field(
        default=16.3,
        gt=0,
        description="An innovation whose normalised square is larger (3 in expectation, 16.3 once in a thousand) is a field that has "
        "changed at once: the field is begun anew.",
    )
    evidence: float = Field(
        default=20.0,
        gt=0,
        description="ln of how much likelier the readings are with hard iron than without, from which on it counts as found. Larger: later "
        "and surer.",
    )
    least: float = Field(default=3.0, ge=0, description="Hard iron shorter than this, µT, is told and not taken out.")


class MagneticParameters(Parameters):
    """What the magnetometer is used for, in stance only, once per sample, and the gates a sample must pass."""

    use: Literal["off", "reset", "heading"] = Field(
        default="off",
        description="off: not used. reset: the attitude is replaced by TRIAD's (MAGINAV Table 2, state 3). heading: a measurement of the "
        "heading in the Kalman filter.",
    )
    hard_iron: HardIronParameters = HardIronParameters(block_s=0.5)
    reference: Literal["earth", "start"] = Field(
        default="earth",
        description="The undisturbed field that the gates compare with. earth: `initial.earth_field` where it is given. start: always the "
        "field at the start, for a magnetometer that was not calibrated.",
    )
    norm_tolerance: float = Field(
        default=0.05,
        gt=0,
        description="Gate: largest relative difference of the norm to that of the reference (MAGINAV eqs 4-5). Larger: more samples "
        "pass, more disturbed ones too.",
    )
    inclination_tolerance: float = Field(
        default=math.radians(5),
        gt=0,
        description="Gate: largest difference, rad, of the inclination to that of the reference; a field that was turned keeps its norm.",
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


class ZeroAngularRateParameters(Parameters):
    """ZARU: a foot at rest does not turn, so its gyroscope shows the gyroscope's offset (Jiménez et al. 2010; Li & Wang section 4.2)."""

    use: Literal["off", "rest", "stance"] = Field(
        default="off",
        description="off: not used. rest: in stance, after `after_s` of small angular rate. stance: at every sample in stance, as in the "
        "papers; a walking foot rocks while it stands, and its turning is taken for offset.",
    )
    sd: float = Field(
        default=0.01,
        gt=0,
        description="Standard deviation of the angular rate of a foot at rest, rad/s. Larger: the offset follows more slowly.",
    )
    correlation_s: float = Field(
        default=0.1,
        ge=0,
        description="How long one sway of a foot at rest lasts, s: the samples of this time count as one measurement. 0: each sample for "
        "itself, as in the papers. Larger: slower and safer.",
    )
    rate: float = Field(
        default=0.15,
        gt=0,
        description="rest: the angular rate, rad/s, freed of the offset, that a foot at rest does not exceed. Larger: a foot that turns "
        "slowly passes for one at rest.",
    )
    after_s: float = Field(
        default=1.0, ge=0, description="rest: how long the angular rate must have been small, s. Shorter: stances of a slow walk count."
    )


class HeadingReductionParameters(Parameters):
    """HDR: who walks straight puts his foot down as he did in the last two stances (Jiménez et al. 2010; Li & Wang section 4.2)."""

    use: Literal["off", "stance", "sample"] = Field(
        default="off",
        description="off: not used. stance: once a stance, with its mean yaw. sample: at every sample of a stance, as in the papers.",
    )
    sd: float = Field(
        default=math.radians(1.0),
        gt=0,
        description="Standard deviation of a stance's yaw against the mean of the two before, rad; of each sample for sample (the papers: "
        "0.1). Smaller: drift is held back more, and a slow turn is straightened more.",
    )
    tolerance: float = Field(
        default=math.radians(4.0),
        gt=0,
        description="A larger difference, rad, is a turn and is left alone. Larger: gentle curves are straightened.",
    )
    after_s: float = Field(
        default=0.05,
        ge=0,
        description="A stance counts from this length on, s; with stance, it is measured then. Longer: a steadier mean, and short stances "
        "of a run are left out.",
    )
    longest_s: float = Field(
        default=1.0, gt=0, description="sample: not later than this into a stance, s: who stands still does not walk straight."
    )
    apart_s: float = Field(
        default=0.2, ge=0, description="Stances nearer to each other, s, are one: a stride takes longer. Larger: fast steps are joined."
    )


class MagneticRateParameters(Parameters):
    """MARU: in a constant field the magnetometer tells how the sensor turned (Li & Wang's reference 22; MAGYQ eqs 40-43).

    Within one stance, where the sensor keeps its place: the field may be disturbed, but must not change.
    """

    use: bool = Field(default=False, description="Whether the turning of the field in stance measures the gyroscope's offset.")
    sd: float = Field(default=0.5, gt=0, description="Noise of one magnetometer sample, µT on each axis. Larger: the offset follows less.")
    interval_s: float = Field(
        default=0.5,
        ge=0,
        description="Time between the two samples that are compared, s; 0: successive ones, as in the paper, whose noise is much larger "
        "than their turn. Longer: each says more, and stances that are shorter say nothing.",
    )
    norm_tolerance: float = Field(
        default=0.02, gt=0, description="Gate: largest relative difference of the two norms. Larger: a changing field passes."
    )
    gate: float = Field(
        default=3.0, gt=0, description="Gate: a difference larger than this many times what is expected is refused. Larger: passes more."
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
