"""Plans of buildings to draw paths on: pictures and GeoJSON files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bematist.errors import DataError, UsageError
from bematist.floorplan import FloorPlan, FloorPlanParameters

WIDEST_M = 50_000.0
"""A plan larger than this is none of a building or a campus, m."""

FARTHEST_M = 20_000.0
"""A plan whose nearest edge is farther than this from the path's origin is misplaced, m."""


def read_floor_plan(
    path: str | Path,
    *,
    scale: float | None = None,
    origin: tuple[float, float] | None = None,
    rotation_deg: float = 0.0,
) -> FloorPlan:
    """A plan to draw paths on, from a picture or a GeoJSON file.

    Parameters
    ----------
    path : PNG, JPEG or another picture, with or without a world file beside it (plan.pgw, plan.jgw, plan.wld); or GeoJSON.
    scale : metres of a pixel; of a GeoJSON file: metres of a unit, which says that the coordinates are plain and not degrees.
    origin : the point of the plan that is (0, 0) of the path: pixels from the upper left corner, right and down; x, y of the world file
        or of plain GeoJSON coordinates; or latitude, longitude in degrees where the coordinates are degrees.
    rotation_deg : direction of the plan's up, degrees clockwise from the path's North.

    Raises
    ------
    UsageError
        Scale or origin are missing, or do not fit this plan.
    DataError
        The file cannot be read as a plan, or its place makes no sense.
    """
    path = Path(path)
    given = FloorPlanParameters().override({"file": str(path), "scale": scale, "origin": origin, "rotation_deg": rotation_deg})
    try:
        with path.open("rb") as file:
            start = file.read(512)
    except OSError as error:
        raise DataError(f"{path}: the plan cannot be opened ({error.strerror}). Check the name given with --map.") from None
    if start.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"["):
        from bematist.io.plan_geojson import read
    elif b"<svg" in start or start[:4] == b"%PDF":
        raise DataError(f"{path}: a plan is a picture of pixels or GeoJSON. Save this drawing as PNG first.")
    else:
        from bematist.io.plan_image import read
    plan = read(path, given)
    _sensible(plan, path)
    return plan


def _sensible(plan: FloorPlan, path: Path) -> None:
    west, south, east, north = plan.bounds
    size = max(east - west, north - south)
    if not size <= WIDEST_M:
        raise UsageError(
            f"{path}: the plan would be {size / 1000:,.0f} km wide. Check --map-scale, the metres of a pixel or of a unit, and whether the "
            "coordinates are degrees (then give --map-origin LAT,LON and no --map-scale)."
        )
    far = float(np.hypot(max(west, -east, 0.0), max(south, -north, 0.0)))
    if far > FARTHEST_M:
        raise UsageError(
            f"{path}: the plan would lie {far / 1000:,.0f} km from where the path has its 0, 0. Check --map-origin: it is the point of "
            "the plan that is 0, 0 of the path, in the plan's own coordinates; for degrees LATITUDE,LONGITUDE in this order."
        )
