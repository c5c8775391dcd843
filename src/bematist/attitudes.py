"""What an attitude filter says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from bematist.frames import euler_from_quaternion, heading_deg_from_yaw
from bematist.trajectory import PACKED

if TYPE_CHECKING:
    from pathlib import Path

    import polars as pl

    from bematist.recording import Reference

Array = NDArray[np.float64]

COLUMNS = ("time", "qw", "qx", "qy", "qz", "heading_deg", "roll_deg", "pitch_deg", "gyro_bias_x", "gyro_bias_y", "gyro_bias_z")
"""Columns of `attitude.csv`: s, body → ENU, degrees, rad/s."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Attitude:
    """Attitudes of a sensor, one row per inertial sample.

    Attributes
    ----------
    time : (N,) s.
    attitude : (N,4) wxyz, body → navigation (ENU).
    gyro_bias : (N,3) rad/s, the gyroscope's offset as the filter believes it, in the body frame.
    packed_covariance : (N,6) upper triangles (xx xy xz yy yz zz) of the covariance of the attitude error, rad², a rotation vector in the
        navigation frame; None where the filter has none.
    north : what North is: "magnetic", "true" (by `initial.earth_field`), "given" (by `initial.heading_deg`), or "none": the sensor's x axis
        starts along East.
    diagnostics : arrays of N rows that explain the decisions.
    filter, parameters : what was run; `parameters` is the full set that was used.
    warnings : what is suspicious about data or result.
    processing_s : seconds of processing, without reading and without compiling.
    """

    time: Array
    attitude: Array
    gyro_bias: Array
    packed_covariance: Array | None = None
    north: str = "none"
    diagnostics: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    filter: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    processing_s: float = float("nan")
    source: str = ""

    def __repr__(self) -> str:
        duration = self.time[-1] - self.time[0] if len(self) else 0.0
        return f"Attitude({self.filter or 'no filter'}, {len(self)} samples, {duration:.1f} s)"

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def euler(self) -> Array:
        """Roll, pitch, yaw (N,3), rad, z-y-x; yaw counter-clockwise from East."""
        return euler_from_quaternion(self.attitude)

    @property
    def covariance(self) -> Array | None:
        """Covariance of the attitude error (N,3,3), rad², or None."""
        return None if self.packed_covariance is None else self.packed_covariance[:, PACKED]

    @property
    def roll(self) -> Array:
        """Turn about the sensor's x axis (N,), rad."""
        return self.euler[:, 0]

    @property
    def pitch(self) -> Array:
        """Turn about the level y axis (N,), rad, positive with the x axis down."""
        return self.euler[:, 1]

    @property
    def heading_deg(self) -> Array:
        """Heading of the sensor's x axis (N,), degrees clockwise from North, [0, 360)."""
        return heading_deg_from_yaw(self.euler[:, 2])

    def summary(self) -> dict[str, Any]:
        """The content of `summary.json`."""
        from bematist import __version__, hard_iron

        return {
            "filter": self.filter,
            "source": self.source,
            "duration_s": float(self.time[-1] - self.time[0]),
            "samples": len(self),
            "north": self.north,
            "heading_start_deg": float(self.heading_deg[0]),
            "heading_end_deg": float(self.heading_deg[-1]),
            "gyro_bias_end_rad_s": [float(b) for b in self.gyro_bias[-1]],
            **hard_iron.summary(self.diagnostics),
            "processing_s": self.processing_s,
            "warnings": list(self.warnings),
            "version": __version__,
        }

    def report(self, path: str | Path, reference: Reference | None = None, *, align: Literal["none", "yaw", "frames"] = "none") -> None:
        """Write one self-contained HTML page about these attitudes; with the errors where the reference knows the true ones."""
        from bematist.report import write_attitude_page

        write_attitude_page([self], path, reference, align=align)

    def to_polars(self) -> pl.DataFrame:
        """The columns of `attitude.csv` as a table."""
        import polars as pl

        level = np.degrees(self.euler[:, :2]).T
        values = [self.time, *self.attitude.T, self.heading_deg, *level, *self.gyro_bias.T]
        return pl.DataFrame(dict(zip(COLUMNS, values, strict=True)))
