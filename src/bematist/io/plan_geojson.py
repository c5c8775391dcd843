"""A plan as GeoJSON (RFC 7946): lines, outlines and points, in degrees or in plain metres."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.errors import DataError, UsageError
from bematist.floorplan import FloorPlan, FloorPlanParameters, axes

Array = NDArray[np.float64]
Part = tuple[str, Array]
"""A name, and the corners (K,2) of a line or outline, or a single point (1,2)."""

MOST_BYTES = 50_000_000
"""A larger file is refused: it is a city, and the page would hold all of it."""

_DEPTH = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
"""How deep the positions of a geometry are nested."""


def read(path: Path, given: FloorPlanParameters) -> FloorPlan:
    """Lines and points of all features, in metres."""
    if path.stat().st_size > MOST_BYTES:
        raise DataError(f"{path}: the plan is larger than {MOST_BYTES / 1e6:.0f} MB. Cut it to the building.")
    try:
        found = list(_parts(json.loads(path.read_text("utf-8-sig")), ""))
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        raise DataError(f"{path}: this is no readable GeoJSON ({error}). Check it with an editor of maps.") from None
    if not found:
        raise DataError(f"{path}: there is no geometry in this GeoJSON: no point, line or polygon. Export the plan with its walls.")
    lengths = [len(points) for _, points in found]
    placed = _placed(path, np.concatenate([points for _, points in found]), given)
    west, south, east, north = (float(v) for v in (*placed.min(0), *placed.max(0)))
    parts = np.split(placed, np.cumsum(lengths)[:-1])
    lines = [np.vstack([part, [np.nan, np.nan]]) for part in parts if len(part) > 1]
    points = [(name, part[0]) for (name, _), part in zip(found, parts, strict=True) if len(part) == 1]
    return FloorPlan(
        bounds=(west, south, east, north),
        lines=np.concatenate(lines) if lines else np.empty((0, 2)),
        places=np.array([p for _, p in points]).reshape(-1, 2),
        names=tuple(name for name, _ in points),
        parameters=given,
    )


def _parts(value: dict[str, Any], name: str) -> Iterator[Part]:
    """Lines and points of an object, whatever it is nested in."""
    kind = value["type"]
    if kind == "FeatureCollection":
        for feature in value["features"]:
            yield from _parts(feature, name)
    elif kind == "Feature":
        if value.get("geometry"):
            yield from _parts(value["geometry"], str((value.get("properties") or {}).get("name") or ""))
    elif kind == "GeometryCollection":
        for geometry in value["geometries"]:
            yield from _parts(geometry, name)
    elif kind in _DEPTH:
        for points in _split(value["coordinates"], _DEPTH[kind]):
            if not kind.endswith("Point"):
                yield name, points
            else:
                yield from ((name, point[None]) for point in points)
    else:
        raise ValueError(f'"{kind}" is no type of GeoJSON')


def _split(coordinates: Any, depth: int) -> Iterator[Array]:
    """Rows (K,2) of positions; a height is left out."""
    if depth > 1:
        for inner in coordinates:
            yield from _split(inner, depth - 1)
        return
    rows = np.array([[float(p[0]), float(p[1])] for p in (coordinates if depth else [coordinates])]).reshape(-1, 2)
    if not np.isfinite(rows).all():
        raise ValueError("a coordinate is no number")
    if len(rows):
        yield rows


def _placed(path: Path, points: Array, given: FloorPlanParameters) -> Array:
    """Points (K,2), East and North, m."""
    may_be_degrees = bool((np.abs(points) <= [180.0, 90.0]).all())
    if given.scale is not None or not may_be_degrees:
        plain = (points - np.array(given.origin or (0.0, 0.0))) * (given.scale or 1.0)
        return plain @ axes(given.rotation_deg).T
    if given.origin is None:
        raise UsageError(
            f"{path}: are the coordinates degrees or metres? For degrees give --map-origin LAT,LON, where 0, 0 of the path is; for metres "
            "--map-scale 1."
        )
    latitude, longitude = given.origin
    if abs(latitude) > 90 or abs(longitude) > 360:
        raise UsageError(
            f"{path}: the coordinates are degrees, and --map-origin {latitude:g},{longitude:g} is no latitude and longitude. Are the "
            "coordinates metres? Then give --map-scale 1."
        )
    from pymap3d import geodetic2enu

    east, north, _ = geodetic2enu(points[:, 1], points[:, 0], np.zeros(len(points)), latitude, longitude, 0.0)
    return np.column_stack([east, north]) @ axes(given.rotation_deg).T
