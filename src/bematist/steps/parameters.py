"""Parameters of the step detector and of the decision trees for motion and carrying."""

from __future__ import annotations

import math

from pydantic import Field

from bematist.parameters import Parameters

Axis = tuple[float, float, float]


class DetectionParameters(Parameters):
    """When an acceleration is a step. Times are in seconds and counts in steps, so that they mean the same at every sampling rate."""

    level_s: float = Field(
        default=3.0,
        gt=0,
        le=60,
        description="Without an attitude, up is turned by the gyroscope and drawn to the specific force with this time constant, s. "
        "Longer: steadier in a swinging hand, but more of the gyroscope's offset.",
    )
    high_pass_hz: float = Field(
        default=0.6,
        gt=0,
        le=2,
        description="Acceleration below this frequency is no gait, Hz. Higher: gestures disturb less, but a stride's own part is lost.",
    )
    start_hz: float = Field(default=1.8, gt=0, le=5, description="Centre of the band pass as long as no pace is known, Hz.")
    slowest_hz: float = Field(
        default=0.85,
        gt=0.3,
        le=2,
        description="Slowest step frequency, Hz; a slower period is taken for a stride's. Lower: slow walks are seen, but a swinging arm's "
        "strides may be counted as steps.",
    )
    fastest_hz: float = Field(default=3.6, gt=1, le=6, description="Fastest step frequency, Hz. Higher: shaking counts as steps sooner.")
    selectivity: float = Field(
        default=0.8,
        gt=0.3,
        le=5,
        description="Quality factor of each of the two band passes. Larger: a purer step wave, but a walk's first steps are smaller in it "
        "and it rings after the last.",
    )
    stride_selectivity: float = Field(
        default=1.5,
        gt=0.3,
        le=5,
        description="The same where a device turns back and forth once a stride, as in a swinging hand: the wave of half the frequency "
        "must be kept out.",
    )
    correlation_s: float = Field(
        default=1.8,
        gt=0.2,
        le=10,
        description="Time constant of the autocorrelation that tells the period, s. Longer: surer, and later to follow a change of pace.",
    )
    follow_s: float = Field(default=0.4, gt=0, le=10, description="Time constant with which the band pass follows the pace, s.")
    periodic: float = Field(
        default=0.2,
        ge=0,
        lt=1,
        description="A walk begins where the autocorrelation coefficient of the acceleration at the step period is at least this, "
        "with a device that does not rotate. Smaller: irregular walks are seen sooner, gestures are taken for steps.",
    )
    periodic_rate: float = Field(
        default=0.3,
        ge=0,
        description="And more by this for each rad/s of rms angular rate. Larger: a device that is turned about makes fewer steps.",
    )
    periodic_most: float = Field(default=0.7, gt=0, lt=1, description="But never more than this.")
    stride_periodic: float = Field(
        default=0.4,
        ge=0,
        lt=1,
        description="The same where the rotation tells the stride, at the step's or the stride's period, whichever is better.",
    )
    least_force: float = Field(
        default=0.2,
        gt=0,
        description="Least height of a step's peak in the band-passed acceleration, m/s². Smaller: softer steps count, and handling too.",
    )
    first_steps: int = Field(
        default=4, ge=2, le=12, description="A walk begins with so many regular steps, which are then all counted. More: surer, later."
    )
    irregularity: float = Field(
        default=0.35, gt=0, lt=1, description="How far the time between two steps may be from the step period, relative."
    )
    refractory: float = Field(
        default=0.6, gt=0, lt=1, description="No step follows another within this part of the step period. Larger: fewer double counts."
    )
    pause: float = Field(
        default=2.3,
        gt=1,
        le=5,
        description="A walk ends when no step has come for this many step periods. Larger: it outlasts a missed step, which then counts.",
    )
    peak_share: float = Field(
        default=0.3,
        ge=0,
        lt=1,
        description="Least height of a peak against the recent ones. Larger: fewer false steps, soft ones are lost.",
    )
    ringing: float = Field(
        default=0.6,
        ge=0,
        lt=2,
        description="Least amplitude of the unfiltered acceleration over the last quarter of a second against the height of the peak: a "
        "filter that only rings on makes no step.",
    )
    quiet_share: float = Field(
        default=0.4,
        ge=0,
        lt=1,
        description="A walk ends earlier when a step is overdue and that amplitude has fallen below this part of the height of the steps. "
        "Larger: sooner, also where a step was only soft.",
    )
    stride_rate: float = Field(
        default=0.6, gt=0, description="rms angular rate from which a rotation back and forth may tell the stride, rad/s."
    )
    stride_correlation: float = Field(
        default=0.3,
        gt=0,
        lt=1,
        description="Autocorrelation coefficient of the rotation from which it does, at its period, and negative at half of it.",
    )
    swing_fastest_hz: float = Field(
        default=2.3,
        gt=0.5,
        le=5,
        description="A rotation tells a faster step than this, Hz, only where it is as fast as in a run. Larger: a held device that nods "
        "with each step is taken for a swinging one.",
    )
    swing_fast_rate: float = Field(default=2.2, gt=0, description="That is, from this rms angular rate on, rad/s.")
    gap_s: float = Field(
        default=0.5,
        gt=0,
        le=5,
        description="A gap longer than this, s, ends a walk and everything known about it; a shorter one is bridged.",
    )


class ModeParameters(Parameters):
    """The decision trees: every threshold of every node."""

    window_s: float = Field(
        default=1.0, gt=0.1, le=20, description="Time constant of the energies, s. Longer: steadier modes, later changes."
    )
    dwell_s: float = Field(default=0.8, ge=0, le=20, description="A mode changes when another has been found for so long, s.")
    run_hz: float = Field(default=2.4, gt=0, description="Running: least step frequency, Hz. Lower: a fast walk counts as a run.")
    run_force: float = Field(default=2.5, gt=0, description="Running: least rms acceleration, m/s². Lower: a fast walk counts as a run.")
    climb_speed: float = Field(default=0.15, gt=0, description="Stairs: least vertical speed by the pressure, m/s, either way.")
    climb_left: float = Field(default=0.1, ge=0, description="Stairs are left below this vertical speed, m/s.")
    climb_s: float = Field(default=0.7, gt=0, le=20, description="Smoothing of that speed, s. Longer: less noise of the barometer, later.")
    swing_rate: float = Field(
        default=0.5, gt=0, description="Swinging or pocket: least rms angular rate, rad/s. Lower: a lightly swung device counts."
    )
    swing_stride: float = Field(
        default=0.4,
        gt=-1,
        lt=1,
        description="Swinging or pocket: how much the rotation is the opposite of that a step ago, its autocorrelation coefficient at the "
        "step period, negative: 1 for a rotation back and forth once a stride, -1 for one with each step.",
    )
    pocket_upright: float = Field(
        default=0.8, ge=0, le=1, description="Pocket, not swinging: least |cosine| between up and the long axis of the device."
    )
    screen_up: float = Field(default=0.5, ge=-1, le=1, description="Texting: least cosine between up and the screen's normal (60°).")
    phone_top: float = Field(default=0.3, ge=-1, le=1, description="Phoning: least cosine between up and the upper end of the device.")
    phone_top_most: float = Field(
        default=0.9, ge=-1, le=1, description="And the largest: at an ear it leans, more upright (less than 26°) it stands in a bag."
    )
    phone_screen: float = Field(default=0.6, ge=0, le=1, description="Phoning: largest |cosine| between up and the screen's normal.")
    phone_rate: float = Field(default=1.2, gt=0, description="Phoning: largest rms angular rate, rad/s; beyond it is a bag's.")
    screen_axis: Axis = Field(default=(0.0, 0.0, 1.0), description="Direction out of the screen in b. A phone's is z.")
    top_axis: Axis = Field(default=(0.0, 1.0, 0.0), description="Direction to the upper end of the device in b. A phone's is y.")


class StepParameters(Parameters):
    """Step events, step frequency, motion mode and carrying mode."""

    detection: DetectionParameters = DetectionParameters()
    modes: ModeParameters = ModeParameters()

    @property
    def latency_s(self) -> float:
        """How long after its own instant a step of a walk under way is counted, s, at its latest: half a step of the slowest pace."""
        return 0.5 / self.detection.slowest_hz + 0.08


def unit(axis: Axis) -> Axis:
    """The axis at length 1."""
    n = math.hypot(*axis)
    return (axis[0] / n, axis[1] / n, axis[2] / n) if n > 0 else axis
