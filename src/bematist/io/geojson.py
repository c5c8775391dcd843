"""GeoJSON (RFC 7946): the path as one LineString."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from bematist.io.exports import geodetic, map_rows
from bematist.outputs import whole_file
from bematist.trajectory import Trajectory


def write(trajectory: Trajectory, path: Path, origin: tuple[float, float, float | None]) -> None:
    """Write a FeatureCollection of one LineString through the footfalls (longitude, latitude[, height], to 0.1 mm).

    Properties: method, source, duration_s, distance_m, and `times`, s from the start of the recording, one for each
    point.
    """
    rows = map_rows(trajectory)
    latitude, longitude, height = geodetic(trajectory.position[rows], origin)
    columns = [np.round(longitude, 9), np.round(latitude, 9)]
    if height is not None:
        columns.append(np.round(height, 4))
    points = np.column_stack(columns).tolist()
    feature = {
        "type": "Feature",
        "geometry": {"type": "LineString", "coordinates": points if len(points) > 1 else points * 2},
        "properties": {
            "method": trajectory.method,
            "source": trajectory.source,
            "duration_s": round(float(trajectory.time[-1] - trajectory.time[0]), 6),
            "distance_m": round(trajectory.distance_m, 4),
            "times": np.round(trajectory.time[rows], 6).tolist(),
        },
    }
    text = json.dumps({"type": "FeatureCollection", "features": [feature]}, ensure_ascii=False, allow_nan=False)
    with whole_file(path) as place:
        place.write_text(text + "\n", "utf-8")
