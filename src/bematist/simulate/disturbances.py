"""What bends the compass along a walk: parameters. Distances are in m along the path, sides are left of it (negative: right)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from bematist.parameters import Parameters


class ParkedCars(Parameters):
    """Cars parked on both sides of a stretch of the path, each a magnetic dipole."""

    from_m: float = Field(description="Where the stretch begins, m along the path.", ge=0)
    to_m: float = Field(description="Where it ends, m along the path.", ge=0)
    spacing_m: float = Field(default=2.7, description="Distance between neighbours, m.", gt=0)
    away_m: float = Field(default=2.0, description="Distance of the dipoles from the path, m. Nearer disturbs more (cube).", gt=0.5)
    height_m: float = Field(default=0.5, description="Height of the dipoles above the path, m.")
    moment: float = Field(default=300.0, description="Root mean square magnetic moment of a car, A·m².", ge=0)


class Dipole(Parameters):
    """A piece of iron at a place of its own; as it stands, a manhole cover on the path."""

    at_m: float = Field(description="Where it is, m along the path.", ge=0)
    left_m: float = Field(default=0.0, description="How far left of the path, m.")
    height_m: float = Field(default=-0.3, description="Height of its middle above the path, m. Nearer disturbs more (cube).")
    moment: float = Field(default=10.0, description="Root mean square magnetic moment, A·m², in a direction that is drawn.", ge=0)


class Facade(Parameters):
    """A wall with iron in it, beside the path: pillars, each magnetised along the Earth's field, and in a direction of its own."""

    from_m: float = Field(description="Where it begins, m along the path.", ge=0)
    to_m: float = Field(description="Where it ends, m along the path.", ge=0)
    away_m: float = Field(default=3.0, description="How far left of the path, m; negative is right. Nearer disturbs more.")
    spacing_m: float = Field(default=3.0, description="Distance between pillars, m.", gt=0)
    height_m: float = Field(default=1.5, description="Height of their middle above the path, m.")
    induced: float = Field(default=400.0, description="Moment of a pillar along the Earth's field, A·m².", ge=0)
    remanent: float = Field(default=250.0, description="Root mean square moment of a pillar in a direction that is drawn, A·m².", ge=0)


class FieldTurn(Parameters):
    """A stretch where the field has its norm but another direction: what a test of the norm cannot see."""

    from_m: float = Field(description="Where the field begins to turn, m along the path.", ge=0)
    to_m: float = Field(description="Where it is as before, m along the path.", ge=0)
    angle_deg: float = Field(default=15.0, description="How far it is turned, degrees.")
    axis: Literal["up", "east", "north"] = Field(
        default="up", description="About what: up changes the heading and keeps the inclination; east and north change it."
    )
    ramp_m: float = Field(default=3.0, description="Length over which it turns, and turns back, m.", gt=0)


class FieldRegion(Parameters):
    """A stretch where something constant is added to the field, as in a room of a building."""

    from_m: float = Field(description="Where the ramp to it begins, m along the path; below 0 it is there from the start.")
    to_m: float = Field(description="Where it is gone, m along the path.")
    offset_ut: tuple[float, float, float] = Field(description="What is added, East, North, Up, µT.")
    ramp_m: float = Field(default=2.5, description="Length over which it comes, and goes, m. Shorter is a steeper gradient.", gt=0)


class IndoorField(Parameters):
    """A stretch inside a building: region after region with a field of its own, from one to the next by a ramp."""

    from_m: float = Field(description="Where it begins, m along the path.", ge=0)
    to_m: float = Field(description="Where it ends, m along the path.", ge=0)
    region_m: float = Field(default=15.0, description="Mean length of a region, m; each has half of it to half as much again.", gt=1)
    spread_ut: float = Field(default=8.0, description="Standard deviation of each component of what a region adds, µT.", ge=0)
    share: float = Field(default=0.7, description="Share of the regions where anything is added.", ge=0, le=1)
    ramp_m: float = Field(default=2.5, description="Length over which one goes over into the next, m. Shorter is a steeper gradient.", gt=0)
