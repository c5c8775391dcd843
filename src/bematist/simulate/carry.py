"""How a pedestrian walks with a sensor in the hand: the walker, and how the sensor is carried."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, field_validator

from bematist.config import look_up
from bematist.frames import quaternion_from_euler
from bematist.parameters import Parameters
from bematist.simulate.gaits import Gait

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

POINTING = (0.0, 1.0, 0.0)
"""The axis of the device that points forward when one reads from it. Its axes are Android's: x right, y up the screen, z out of it."""


class Carry(Parameters):
    """How the sensor is carried. Axes of the walker: x forward, y left, z up. Angles are those at 1.3 m/s, and go with the speed."""

    name: str = Field(default="", description="Name, for messages and truth.")
    device_deg: Triple = Field(
        default=(20.0, 0.0, -90.0), description="Roll, pitch, yaw (z-y-x) of the device in the walker's axes, degrees."
    )
    place_m: Triple = Field(
        default=(0.35, 0.0, 1.15), description="Where it is, m forward, left and up of the ground under the body, of a walker of 1.75 m."
    )
    arm_m: float = Field(default=0.0, description="Distance from the joint about which it swings, m; the joint is `place_m`.", ge=0)
    swing_deg: float = Field(default=0.0, description="Amplitude of the swing forward and back with each stride, degrees.", ge=0)
    twist_deg: Triple = Field(
        default=(1.2, 3.0, 2.8), description="Amplitude of roll (with each stride), pitch (each step), yaw (each stride), degrees."
    )
    unsteady_deg: float = Field(default=0.4, description="Standard deviation of irregular turning in the walk, 1 to 6 Hz, degrees.", ge=0)
    wander_deg: float = Field(default=3.0, description="Standard deviation of the slow wander of each angle, degrees.", ge=0)
    tremor_deg: float = Field(default=0.04, description="Standard deviation of the tremor, walking or standing, degrees.", ge=0)
    follow: float = Field(
        default=1.4, description="Bounce and sway of the sensor, of those of the body; an arm that is bent adds to them.", ge=0
    )
    jolt_m: float = Field(default=6e-3, description="Size of the ringing after a footfall, m; 0.001 at 5 Hz is 1 m/s².", ge=0)
    ring_hz: float = Field(default=5.0, description="Its frequency, Hz.", gt=0.5, le=15)
    gestures: float = Field(default=0.0, description="Gestures a minute in a pause of the walk.", ge=0)
    gesture_deg: float = Field(default=25.0, description="Standard deviation of the turn of a gesture about each axis, degrees.", ge=0)

    @property
    def row(self) -> Array:
        """All numbers (17,) that a hand goes over from one way of carrying to another; the last four are a quaternion."""
        angles = np.radians([self.swing_deg, *self.twist_deg, self.unsteady_deg, self.wander_deg, self.tremor_deg])
        device = quaternion_from_euler(*np.radians(self.device_deg))
        return np.array([*self.place_m, self.arm_m, *angles, self.follow, self.jolt_m, *device])


CARRIES: dict[str, Carry] = {
    "texting": Carry(name="texting"),
    "phoning": Carry(
        name="phoning", device_deg=(85.0, 40.0, 180.0), place_m=(0.03, -0.12, 1.6), twist_deg=(1.0, 1.5, 3.0), wander_deg=4.0,
        follow=1.1, jolt_m=4e-3,
    ),
    "swinging": Carry(
        name="swinging", device_deg=(90.0, 82.0, 0.0), place_m=(0.0, 0.22, 1.2), arm_m=0.45, swing_deg=25.0, twist_deg=(5.0, 2.0, 7.0),
        unsteady_deg=0.8, wander_deg=5.0, follow=1.4, jolt_m=8e-3,
    ),
    "pocket": Carry(
        name="pocket", device_deg=(80.0, 0.0, 90.0), place_m=(0.1, -0.12, 0.93), arm_m=0.2, swing_deg=20.0, twist_deg=(3.0, 2.0, 6.0),
        unsteady_deg=0.8, wander_deg=2.0, tremor_deg=0.01, follow=1.2, jolt_m=4e-3, ring_hz=8.0,
    ),
    "bag": Carry(
        name="bag", device_deg=(85.0, 5.0, 180.0), place_m=(-0.05, 0.25, 0.95), twist_deg=(2.0, 1.5, 3.0), unsteady_deg=0.5, wander_deg=3.0,
        tremor_deg=0.01, follow=1.2, jolt_m=4e-3, ring_hz=7.0,
    ),
    "table": Carry(
        name="table", device_deg=(0.0, 0.0, -90.0), place_m=(0.4, 0.0, 0.75), twist_deg=(0.0, 0.0, 0.0), unsteady_deg=0.0, wander_deg=0.0,
        tremor_deg=0.0, follow=0.0, jolt_m=0.0,
    ),
}  # fmt: skip
"""Ways to carry a sensor by name; on the table it lies still, which is for rests only."""


def _named(value: Any) -> Any:
    return look_up("way of carrying", value, CARRIES) if isinstance(value, str) else value


NamedCarry = Annotated[Carry, BeforeValidator(_named)]
"""A way to carry, or its name."""


class Walker(Parameters):
    """A pedestrian with a sensor in the hand. A step is s = height (a f + b) + c long at f steps a second (MAGYQ eq 47).

    The three numbers are those of R. Chen, L. Pei, Y. Chen, A smart phone based PDR solution for indoor navigation (ION GNSS 2011), in that
    form.
    """

    height_m: float = Field(default=1.75, description="Height of the walker, m. Longer steps.", gt=0.5, lt=2.5)
    step_a: float = Field(default=0.227 / 1.75, description="a of the length of a step, s: how it grows with the frequency.", ge=0)
    step_b: float = Field(default=0.371 - 0.227 * 1.79 / 1.75, description="b of the length of a step.")
    step_c: float = Field(default=0.7 - 0.371 * 1.75, description="c of the length of a step, m.")
    length_sd: float = Field(default=0.03, description="Standard deviation of a step's length about that, relative.", ge=0, le=0.2)
    frequency_sd: float = Field(default=0.02, description="Standard deviation of the frequency from step to step, relative.", ge=0, le=0.2)
    frequency_wander: float = Field(
        default=0.04, description="Standard deviation of its slow change (over 40 steps), relative. More lets a step length be calibrated.",
        ge=0, le=0.2,
    )  # fmt: skip
    bounce: float = Field(
        default=0.6, description="Rise and fall of the body, relative to an inverted pendulum; half as much in a run.", ge=0
    )
    limp: float = Field(default=0.15, description="How much more one foot makes the body rise than the other, relative.", ge=0, lt=1)
    sway_side_m: float = Field(default=0.013, description="Amplitude of the body's way from side to side, m.", ge=0)
    misalignment_deg: float = Field(default=0.0, description="Angle from the walking direction to the pointing one, degrees to the left.")
    misalignment_sd_deg: float = Field(default=0.0, description="Standard deviation of a part of it that is drawn from the seed.", ge=0)
    carries: tuple[tuple[float, NamedCarry], ...] = Field(
        default=((0.0, CARRIES["texting"]),), description="How it is carried and from where on: (m along the path, carry or its name).",
        min_length=1,
    )  # fmt: skip

    @field_validator("carries")
    @classmethod
    def _in_order(cls, value: tuple[tuple[float, Carry], ...]) -> tuple[tuple[float, Carry], ...]:
        if value[0][0] != 0.0 or any(b[0] <= a[0] for a, b in pairwise(value)):
            raise ValueError("the first way of carrying begins at 0, and each farther along the path than the one before")
        return value

    def step_length_m(self, frequency_hz: Array) -> Array:
        """Lengths, m, of steps of these frequencies, Hz (MAGYQ eq 47)."""
        return self.height_m * (self.step_a * frequency_hz + self.step_b) + self.step_c

    def pace(self, gait: Gait) -> tuple[float, float]:
        """Frequency of the steps, Hz, and their length, m, at the speed of a gait; a run has the steps of its gait."""
        every_s = (gait.swing_s + gait.stance_s) / 2
        if gait.shape == "run":
            return 1 / every_s, gait.stride_m / 2
        # v = f s(f), the positive root.
        quadratic, linear = self.height_m * self.step_a, self.height_m * self.step_b + self.step_c
        speed = gait.stride_m / 2 / every_s
        f = float(np.roots([quadratic, linear, -speed]).max()) if quadratic else speed / linear
        return f, float(self.step_length_m(np.array(f)))
