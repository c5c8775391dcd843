"""How somebody walks or runs: stride, times and size of the movements of one foot; and named gaits."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from bematist.config import look_up
from bematist.parameters import Parameters


class Gait(Parameters):
    """Movement of one shoe. A stride is two steps; its speed is `stride_m` / (`swing_s` + `stance_s`)."""

    name: str = Field(default="", description="Name, for messages.")
    shape: Literal["walk", "run"] = Field(default="walk", description="Which measured stride the swing follows.")
    stride_m: float = Field(default=1.3, description="Length of a stride, m; fitted so that a stretch has a whole number.", gt=0.1)
    swing_s: float = Field(default=0.86, description="Time from heel-off to foot flat, s. Less makes larger accelerations.", gt=0.1)
    stance_s: float = Field(default=0.3, description="Time the foot is flat, s. Less gives a detector less to find.", gt=0.03)
    variation: float = Field(
        default=0.03, description="Standard deviation from stride to stride of lengths, times, pitch and height, relative.", ge=0, le=0.2
    )
    direction_sd_deg: float = Field(
        default=1.5, description="Standard deviation of the foot's direction from print to print, degrees.", ge=0, le=20
    )
    pitch: float = Field(default=1.0, description="Pitch of the foot in swing relative to the measured stride.", ge=0, le=1.3)
    roll_deg: float = Field(default=8.0, description="Largest roll of the foot in swing, degrees.")
    sway_m: float = Field(default=0.01, description="Standard deviation of the sideways excursion in swing, m.", ge=0)
    clearance_m: float = Field(default=0.06, description="Largest height of the sensor in swing, m.", ge=0)
    impact_m: float = Field(
        default=1e-3, description="Size of the jolt at heel strike, m; 0.001 is a peak of about 20 m/s². More strains range and rate.", ge=0
    )
    rocking_deg: float = Field(
        default=0.0, description="How far the standing foot rocks about its toes and back, degrees; 0 is exactly still."
    )


GAITS: dict[str, Gait] = {
    "slow": Gait(name="slow", stride_m=0.9, swing_s=1.05, stance_s=0.5, pitch=0.8, clearance_m=0.05, impact_m=5e-4),
    "walk": Gait(name="walk"),
    "brisk": Gait(name="brisk", stride_m=1.6, swing_s=0.75, stance_s=0.24, impact_m=1.4e-3),
    "jog": Gait(
        name="jog", shape="run", stride_m=1.6, swing_s=0.62, stance_s=0.15, clearance_m=0.11, impact_m=1.8e-3, rocking_deg=3.0, sway_m=0.02
    ),
    "run": Gait(
        name="run", shape="run", stride_m=2.2, swing_s=0.57, stance_s=0.14, clearance_m=0.13, impact_m=2.4e-3, rocking_deg=4.0, sway_m=0.02
    ),
    "stairs": Gait(name="stairs", stride_m=0.58, swing_s=0.7, stance_s=0.45, pitch=0.6, roll_deg=4.0, clearance_m=0.1, impact_m=7e-4),
}
"""Gaits by name."""


def _named(value: Any) -> Any:
    return look_up("gait", value, GAITS) if isinstance(value, str) else value


NamedGait = Annotated[Gait, BeforeValidator(_named)]
"""A gait, or its name."""
