"""What an estimator says: the path, how sure it is, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from bematist.intervals import intervals

if TYPE_CHECKING:
    from pathlib import Path

    import polars as pl

    from bematist.floorplan import FloorPlan
    from bematist.recording import Reference

Array = NDArray[np.float64]

COLUMNS = ("time", "east", "north", "up", "ve", "vn", "vu", "qw", "qx", "qy", "qz", "sd_east", "sd_north", "sd_up", "stance")
"""Columns of `trajectory.csv`: a contract."""

PACKED = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Where the entry (i, j) of a symmetric 3x3 matrix stands in its packed upper triangle (xx, xy, xz, yy, yz, zz)."""


NORTH = {
    "true": ("true", "by the magnetic field at the start, less its declination"),
    "magnetic": ("magnetic", "by the field at the start"),
    "given": ("given", "by the heading that was given for the start"),
    "none": ("unknown", "the start is along an East of its own"),
}
"""What North is, in a word and in words."""

LEAST_M = 2.0
"""Of a shorter path, m, no error is stated in percent: it would be a large number that says nothing."""


def percent_of(part_m: float, distance_m: float) -> float | None:
    """A length in percent of the distance; None where that is shorter than `LEAST_M`."""
    return 100 * part_m / distance_m if distance_m >= LEAST_M else None


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Steps:
    """The steps of a walker, one row each.

    Attributes
    ----------
    time : (K,) s, the step's own instant.
    counted : (K,) s, the sample at which it was counted; several at once where a walk has just been recognised.
    length, length_sd : (K,) m.
    frequency : (K,) Hz.
    direction, direction_sd : (K,) rad, where it led, counter-clockwise from East.
    motion, carrying : (K,) words of `bematist.steps.MOTIONS` and `CARRYING`.
    """

    time: Array
    counted: Array
    length: Array
    length_sd: Array
    frequency: Array
    direction: Array
    direction_sd: Array
    motion: NDArray[np.str_]
    carrying: NDArray[np.str_]

    def __repr__(self) -> str:
        return f"Steps({len(self)}, {self.length.sum():.1f} m)"

    def __len__(self) -> int:
        return len(self.time)

    @property
    def heading_deg(self) -> Array:
        """Where each step led (K,), degrees clockwise from North."""
        from bematist.frames import heading_deg_from_yaw

        return heading_deg_from_yaw(self.direction)

    def columns(self) -> dict[str, NDArray[Any]]:
        """The columns of `steps.csv`, each (K,): numbers, and words."""
        numbers = {name: getattr(self, name) for name in ("time", "counted", "length", "length_sd", "frequency")}
        angles = {"heading_deg": self.heading_deg, "heading_sd_deg": np.degrees(self.direction_sd)}
        return {**numbers, **angles, "motion": self.motion, "carrying": self.carrying}

    def to_polars(self) -> pl.DataFrame:
        """The columns of `steps.csv` as a table."""
        import polars as pl

        columns = self.columns()
        words = {name: column.tolist() for name, column in columns.items() if column.dtype.kind == "U"}
        return pl.DataFrame({**columns, **words}, schema_overrides=dict.fromkeys(words, pl.String))


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Trajectory:
    """A path with its uncertainty, one row per inertial sample, in ENU.

    Attributes
    ----------
    time : (N,) s.
    position : (N,3) m, from where the recording began, unless it was `placed` elsewhere.
    velocity : (N,3) m/s.
    attitude : (N,4) wxyz, body → navigation.
    stance : (N,) uint8, 1 where the foot was taken to stand; of a hand, where a step was counted.
    packed_covariance : (N,18) upper triangles (xx xy xz yy yz zz) of the position (m²), velocity (m²/s²) and attitude (rad²,
        rotation vector in the navigation frame) covariances.
    steps : the steps of a hand's path, or None.
    north : what North is, a key of `NORTH`: "true" by `initial.earth_field`, "given" by `initial.heading_deg`.
    diagnostics : arrays of N rows (or their own length, see the method's documentation) that explain the decisions.
    method, parameters : what was run; `parameters` is the full set that was used.
    warnings : what is suspicious about data or result.
    processing_s : seconds of processing, without reading and without compiling.
    """

    time: Array
    position: Array
    velocity: Array
    attitude: Array
    stance: NDArray[np.uint8]
    packed_covariance: Array
    steps: Steps | None = None
    north: str = "none"
    diagnostics: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    method: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    processing_s: float = float("nan")
    source: str = ""

    def __repr__(self) -> str:
        duration = self.time[-1] - self.time[0] if len(self) else 0.0
        return f"Trajectory({self.method or 'no method'}, {len(self)} samples, {duration:.1f} s)"

    def __len__(self) -> int:
        return len(self.time)

    def rows(self, start: int, stop: int) -> Trajectory:
        """The rows from start to before stop, as views, without diagnostics and list of steps."""
        names = ("time", "position", "velocity", "attitude", "stance", "packed_covariance")
        part: dict[str, Any] = {name: getattr(self, name)[start:stop] for name in names}
        return replace(self, diagnostics={}, steps=None, **part)

    @property
    def covariance(self) -> Array:
        """Covariance of the position (N,3,3), m²."""
        return self.packed_covariance[:, PACKED]

    @property
    def velocity_covariance(self) -> Array:
        """Covariance of the velocity (N,3,3), m²/s²."""
        return self.packed_covariance[:, PACKED + 6]

    @property
    def attitude_covariance(self) -> Array:
        """Covariance of the attitude error, a rotation vector in the navigation frame (N,3,3), rad²."""
        return self.packed_covariance[:, PACKED + 12]

    @property
    def position_sd(self) -> Array:
        """Standard deviations of east, north, up (N,3), m."""
        return np.sqrt(np.stack([self.packed_covariance[:, k] for k in (0, 3, 5)])).T

    @property
    def has_height(self) -> bool:
        """Whether anything told the height: a path of steps without a barometer stays as high as it began."""
        up = self.position[:, 2]
        return self.steps is None or bool((up != up[0]).any())

    @property
    def euler(self) -> Array:
        """Roll, pitch, yaw (N,3), rad."""
        from bematist.frames import euler_from_quaternion

        return euler_from_quaternion(self.attitude)

    @property
    def distance_m(self) -> float:
        """Sum of the step lengths, or of a shoe the length of the path in three dimensions, from stance to stance (`stance_intervals`)."""
        if self.steps is not None:
            return float(self.steps.length.sum())
        return float(np.linalg.norm(np.diff(self.waypoints(), axis=0), axis=1).sum()) if len(self) else 0.0

    def stance_intervals(self) -> NDArray[np.int64]:
        """First and one-past-last sample of every stance phase (S,2)."""
        return intervals(self.stance)

    def waypoints(self) -> Array:
        """Start, the middle of every stance phase, and end (W,3), m: the path as footfalls, free of the foot's own arcs."""
        middle = self.stance_intervals().sum(1) // 2
        rows = np.concatenate([[0], middle, [len(self) - 1]])
        return self.position[rows[np.diff(rows, prepend=-1) > 0]]

    def summary(self) -> dict[str, Any]:
        """The content of `summary.json`: a contract."""
        from bematist import __version__, hard_iron

        closure = float(np.linalg.norm(self.position[-1] - self.position[0]))
        distance = self.distance_m
        return {
            "method": self.method,
            "source": self.source,
            "duration_s": float(self.time[-1] - self.time[0]),
            "samples": len(self),
            "distance_m": distance,
            "closure_m": closure,
            "closure_percent": percent_of(closure, distance),
            "start_m": [float(v) for v in self.position[0]],
            "height_change_m": float(self.position[-1, 2] - self.position[0, 2]) if self.has_height else None,
            "north": self.north,
            **({"stance_fraction": float(self.stance.mean())} if self.steps is None else {"steps": len(self.steps)}),
            "position_sd_m": [float(s) for s in self.rows(len(self) - 1, len(self)).position_sd[0]],
            **hard_iron.summary(self.diagnostics),
            "processing_s": self.processing_s,
            "warnings": list(self.warnings),
            "version": __version__,
        }

    def columns(self) -> list[NDArray[Any]]:
        """The values of `COLUMNS`, each (N,)."""
        return [self.time, *self.position.T, *self.velocity.T, *self.attitude.T, *self.position_sd.T, self.stance]

    def to_polars(self) -> pl.DataFrame:
        """The columns of `trajectory.csv` as a table."""
        import polars as pl

        return pl.DataFrame(dict(zip(COLUMNS, self.columns(), strict=True)))

    def placed(self, position: tuple[float, float, float] | None = None, turn_deg: float = 0.0) -> Trajectory:
        """The same path begun at `position` (east, north, up, m) and turned about the vertical, counter-clockwise in degrees."""
        from bematist.placement import Placement

        return Placement().override({"position": position, "turn_deg": turn_deg}).place(self)

    def report(
        self,
        path: str | Path,
        reference: Reference | None = None,
        *,
        floor_plan: FloorPlan | None = None,
        align: Literal["none", "origin", "yaw", "se3"] = "yaw",
    ) -> None:
        """Write one self-contained HTML page about this trajectory; `align` says how the reference is laid under it."""
        from bematist.report import write_report

        write_report([self], path, reference=reference, floor_plan=floor_plan, align=align)
