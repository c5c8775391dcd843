"""Satellite fixes that a phone recorded along, as a reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bematist.recording import Reference

Array = NDArray[np.float64]


def fixes(
    time: Array,
    latitude: Array,
    longitude: Array,
    height: Array | None = None,
    accuracy: Array | None = None,
    what: str = "satellite fixes: no truth, and none indoors",
) -> Reference | None:
    """Fixes (K,), degrees and m, as ENU about the first of them; those with a negative accuracy are none. None without a fix."""
    good = np.isfinite(time) & (np.abs(latitude) <= 90) & (np.abs(longitude) <= 180)
    if accuracy is not None:
        good &= ~(accuracy < 0)
    if not good.any():
        return None
    from pymap3d import geodetic2enu

    rows = np.flatnonzero(good)[np.argsort(time[good], kind="stable")]
    lat, lon = latitude[rows], longitude[rows]
    up = np.full(len(rows), np.nan) if height is None else height[rows]
    base = float(up[0]) if np.isfinite(up[0]) else 0.0
    east, north, _ = geodetic2enu(lat, lon, np.full(len(rows), base), lat[0], lon[0], base)
    how = "" if accuracy is None else f", stated accuracy {np.nanmedian(accuracy[rows]):.3g} m"
    return Reference(
        time=time[rows],
        position=np.column_stack([east, north, up - up[0]]),
        origin=(float(lat[0]), float(lon[0]), float(up[0])),
        note=f"{what}; about {lat[0]:.6f}°, {lon[0]:.6f}°{how}",
    )
