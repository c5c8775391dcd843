"""GPX 1.1: the path as one track, by gpxpy (`pip install bematist[gpx]`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bematist.errors import UsageError
from bematist.io.exports import geodetic, map_rows
from bematist.outputs import whole_file
from bematist.trajectory import Trajectory


def write(trajectory: Trajectory, path: Path, origin: tuple[float, float, float | None]) -> None:
    """Write one track through the footfalls, with heights where the origin has one; without times, which GPX wants in
    UTC.
    """
    try:
        from gpxpy import gpx
    except ImportError:
        raise UsageError("GPX needs the package gpxpy: install it with `pip install bematist[gpx]`, or export GeoJSON.") from None
    rows = map_rows(trajectory)
    latitude, longitude, height = geodetic(trajectory.position[rows], origin)
    heights = [None] * len(rows) if height is None else np.round(height, 4).tolist()
    points = zip(np.round(latitude, 9).tolist(), np.round(longitude, 9).tolist(), heights, strict=True)
    file, track, segment = gpx.GPX(), gpx.GPXTrack(name=trajectory.method or None), gpx.GPXTrackSegment()
    file.creator = "bematist"
    segment.points = [gpx.GPXTrackPoint(lat, lon, elevation=h) for lat, lon, h in points]
    track.segments.append(segment)
    file.tracks.append(track)
    with whole_file(path) as place:
        place.write_text(file.to_xml(version="1.1"), "utf-8")
