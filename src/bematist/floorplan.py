"""A plan of the building, or of the ground, that paths are drawn on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, FiniteFloat

from bematist.parameters import Parameters

Array = NDArray[np.float64]


class FloorPlanParameters(Parameters):
    """Which plan, and how it lies under the path. The plan's own coordinates are pixels from the upper left corner of a picture (right,
    down), what its world file says, or the coordinates of a GeoJSON file."""

    file: str | None = Field(default=None, description="Picture (PNG, JPEG …) or GeoJSON file.")
    scale: float | None = Field(
        default=None,
        gt=0,
        allow_inf_nan=False,
        description="Metres of a pixel, or of a unit of plain GeoJSON coordinates; none: a world file tells, or the coordinates are "
        "degrees where an origin is given.",
    )
    origin: tuple[FiniteFloat, FiniteFloat] | None = Field(
        default=None,
        description="The point of the plan that is 0, 0 of the path: x, y in the plan's own coordinates, or latitude, longitude, degrees.",
    )
    rotation_deg: float = Field(
        default=0.0, allow_inf_nan=False, description="Direction of the plan's up, degrees clockwise from the path's North."
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class FloorPlan:
    """A plan in the frame of the path, m.

    Attributes
    ----------
    image : a PNG or JPEG picture whose sides lie along East and North, or None; `media` is its kind, "png" or "jpeg".
    bounds : west, south, east, north of the plan, m.
    lines : (L,2) m, the corners of all lines and outlines, a row of NaN after each.
    places : (P,2) m, single points, with `names` (empty where they have none).
    parameters : how it was read.
    """

    bounds: tuple[float, float, float, float]
    image: bytes | None = None
    media: str = "png"
    lines: Array = field(default_factory=lambda: np.empty((0, 2)))
    places: Array = field(default_factory=lambda: np.empty((0, 2)))
    names: tuple[str, ...] = ()
    parameters: FloorPlanParameters = field(default_factory=FloorPlanParameters)

    def share_inside(self, position: Array) -> float:
        """Share of points (N,2 or more), m, that lie within the bounds."""
        west, south, east, north = self.bounds
        x, y = position[:, 0], position[:, 1]
        return float(((x >= west) & (x <= east) & (y >= south) & (y <= north)).mean())


def axes(rotation_deg: float) -> Array:
    """(2,2): the first column is the plan's right in East and North, the second its up, which is rotation_deg clockwise from North."""
    r = np.radians(rotation_deg)
    return np.array([[np.cos(r), np.sin(r)], [-np.sin(r), np.cos(r)]])
