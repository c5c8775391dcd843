"""Parameters of the handheld path: step length, walking direction, height, and how uncertain each is."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from bematist.hand.parameters import HandParameters
from bematist.parameters import Parameters
from bematist.steps.parameters import StepParameters

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]


class StepLengthParameters(Parameters):
    """Step length s = h (a f + b) + c (MAGYQ eq 47) of a step frequency f, and its errors.

    The defaults are those of R. Chen, L. Pei and Y. Chen (ION GNSS 2011), s = 0.7 + 0.371 (h - 1.75) + 0.227 (f - 1.79) h / 1.75, written
    in this form: 0.70 m at 1.79 Hz and a height of 1.75 m. The numbers are as public programs quote that formula; the paper itself was
    not at hand to check them.
    """

    height: float = Field(default=1.75, gt=0.5, lt=2.8, description="Height h of the walker, m. 5 cm more: steps 3 % longer.")
    a: float = Field(default=0.1297, description="Growth with the step frequency, s (a f h is a length). Larger: fast walks become longer.")
    b: float = Field(default=0.1388, description="Share of the height, 1. With one walker only h b + c counts.")
    c: float = Field(default=0.0508, description="Constant part, m.")
    running_factor: float = Field(
        default=1.2,
        gt=0,
        description="A running step is this much longer than eq 47 says, which is for walking: about 1.1 m at 2.7 Hz and 3 m/s.",
    )
    tread: float = Field(default=0.29, gt=0, description="Horizontal length of a step on stairs, m: the tread of a stair.")
    pendulum: float = Field(
        default=0.0,
        ge=0,
        le=1,
        description="Beyond the paper, where the screen is read: share of the length that the bounce of the body tells (1) and not eq 47 "
        "(0), in the logarithm. Larger: short steps on the spot come out short, and how the hand gives way matters more.",
    )
    sd: float = Field(
        default=0.08,
        ge=0,
        description="Standard deviation of a single step's length, relative, independent of the others; missed and double steps with it.",
    )
    scale_sd: float = Field(
        default=0.08,
        ge=0,
        description="Standard deviation of the error that all steps of a walker share, relative: 0.08 for a stranger of guessed height, "
        "0.03 after calibration.",
    )


class DirectionParameters(Parameters):
    """Where the sensor points when its bearer walks ahead. MAGYQ assumes that the pointing axis is the walking direction.

    The axis is levelled. Which one it is depends on how the device is carried (`steps` tells). Body axes as Android's: x to the right of
    the screen, y to its upper edge, z out of it.
    """

    texting: Axis = Field(default="y", description="Axis that points ahead when the screen is read.")
    phoning: Axis = Field(default="-x", description="The same with the phone at the right ear; at the left ear it is x.")
    swinging: Axis = Field(default="y", description="The same in a swinging hand.")
    pocket: Axis = Field(default="z", description="The same upright in a trouser pocket, the screen away from the body.")
    bag: Axis = Field(default="-x", description="The same upright in a bag at the side, the screen to the left.")
    first: Literal["texting", "phoning", "swinging", "pocket", "bag"] = Field(
        default="texting",
        description="How the device is carried at the start: a given heading, or East where there is none, is that of its axis.",
    )
    steep: float = Field(
        default=math.radians(60),
        ge=0,
        le=math.pi / 2,
        description="Where the axis is steeper than this, rad, it tells no direction: ahead is then at right angles to the axis to the "
        "right, so that a phone that is raised before the face goes on to point ahead with its back.",
    )
    offset: float = Field(
        default=0.0, description="Angle from the axis to the walking direction, rad, counter-clockwise from above; constant."
    )
    sd: float = Field(
        default=math.radians(8),
        ge=0,
        description="Standard deviation of the walking direction about the axis, rad: a hand seldom points exactly ahead.",
    )
    time_s: float = Field(
        default=60.0, gt=0, description="Correlation time of that error, s. Longer: it adds up to more across the way; inf: constant."
    )
    step_sd: float = Field(
        default=math.radians(4), ge=0, description="What comes to it at every step, independent, rad: the sway of body and arm."
    )
    heading_time_s: float = Field(
        default=120.0,
        gt=0,
        description="Correlation time of the attitude filter's heading error, s; its size is the filter's own. inf: constant, as where the "
        "gyroscope alone is integrated.",
    )
    heading_sd: float = Field(
        default=math.radians(12), ge=0, description="Attitude error about each axis where the filter has no covariance (QUEST), rad."
    )


class HeightParameters(Parameters):
    """Height from the pressure; without a barometer it stays at 0 and its uncertainty grows."""

    barometer: bool = Field(default=True, description="Whether the pressure is used.")
    sd: float = Field(default=0.2, gt=0, description="Noise of a sample of the barometer, m. Larger: smoother and later.")
    walk: float = Field(
        default=0.05,
        ge=0,
        description="Random walk of weather and sensor, m/√s: 3 m in an hour. Larger: the height is less sure.",
    )
    climb: float = Field(default=0.15, gt=0, description="How the height may change, m/√s. Larger: stairs are followed sooner.")
    temperature_c: float = Field(
        default=15.0,
        gt=-60,
        lt=60,
        description="Temperature of the air, °C: 3 degrees more make heights 1 % larger.",
    )
    unknown: float = Field(default=0.1, ge=0, description="Without a barometer: how the ground's height may differ, m for each √m walked.")


class HandPdrParameters(HandParameters):
    """The handheld path: the attitude filter, the steps, and what is made of them."""

    steps: StepParameters = StepParameters()
    step_length: StepLengthParameters = StepLengthParameters()
    direction: DirectionParameters = DirectionParameters()
    altitude: HeightParameters = HeightParameters()
    sway_speed: float = Field(default=0.15, ge=0, description="How fast the body moves about the mean velocity of a step, m/s, rms.")
    onset_speed: float = Field(
        default=1.0,
        ge=0,
        description="How fast the body may walk while the first steps of a walk wait to be counted, m/s, rms. Larger: the position is less "
        "sure at the beginning of a walk, and where something else shakes the device.",
    )


def pdr_parameters(attitude: HandParameters) -> HandPdrParameters:
    """The path's parameters with those of an attitude filter."""
    return HandPdrParameters(**{name: getattr(attitude, name) for name in HandParameters.model_fields})
