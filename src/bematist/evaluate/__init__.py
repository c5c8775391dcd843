"""How far a trajectory is from its reference, and whether it knew.

Every number says how the two were laid over each other: `Evaluation.alignment`.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bematist.evaluate.alignment import Align, Alignment, align_path
from bematist.evaluate.attitude import AttitudeEvaluation, evaluate_attitude
from bematist.evaluate.doubts import doubts
from bematist.evaluate.metrics import (
    AttitudeError,
    Nees,
    Relative,
    attitude_error,
    attitude_error_vectors,
    course_error,
    distance_along,
    nees,
    nees_bounds,
    nees_summary,
    path_length,
    polygon_rows,
    relative_error,
    rms,
    rotate_packed,
)
from bematist.evaluate.pairing import Pairs, footfalls, match_footfalls, pair
from bematist.recording import Reference
from bematist.trajectory import Trajectory, percent_of

Array = NDArray[np.float64]

__all__ = [
    "Align",
    "Alignment",
    "AttitudeError",
    "AttitudeEvaluation",
    "Evaluation",
    "Nees",
    "Relative",
    "align_path",
    "evaluate",
    "evaluate_attitude",
    "footfalls",
    "match_footfalls",
    "nees",
    "nees_bounds",
]

WINDOWS_S = (10.0, 60.0)
WINDOWS_M = (10.0, 100.0)
_REFERENCE_SD = 1e-3  # m; where the filter claims better than a motion capture, its NEES says nothing


@dataclass(frozen=True, eq=False, kw_only=True)
class Evaluation:
    """What `evaluate` found. Errors are estimate − reference after `alignment`; NaN or None where a number cannot be
    had.

    Attributes
    ----------
    alignment : how the trajectory was laid over the reference.
    matched : "time" or "footfalls".
    rows : rows of the reference that were compared.
    reference_distance_m : length of the reference, from footfall to footfall (see `evaluate`).
    length_ratio : length of the trajectory between the same instants over `reference_distance_m`. No alignment touches it.
    ate_m, ate_plan_m, ate_height_m : absolute trajectory error, root mean square in space, in the plan, in height, m.
    ate_plan_median_m, ate_plan_max_m : median and largest error in the plan, m.
    end_point_m, end_point_percent : error at the last row compared (in the plan where the reference has no height), m
        and % of `reference_distance_m`.
    closure_m, closure_percent : distance of the trajectory's own last position from its first. It is no error unless
        the walk was closed.
    reference_closure_m : the same of the reference, over the rows compared.
    relative : relative errors (RTE).
    velocity_rms : root mean square error of the velocity, m/s, where the reference is a trajectory.
    attitude : attitude errors, rad, where the reference has attitudes.
    course_rms : root mean square error of the direction of travel over stretches of 1 m, rad.
    nees_position, nees_velocity, nees_attitude : see `Nees`.
    rows_used, time, error : row of the reference (K,), time (K,), s, and position error (K,3), m, in the reference's
        frame, for plots.
    notes : what a reader of the numbers must know; `doubts`, which are among them: why the reference may be of another walk.
    """

    alignment: Alignment
    matched: str
    rows: int
    method: str
    reference: str
    reference_distance_m: float
    length_ratio: float
    ate_m: float
    ate_plan_m: float
    ate_plan_median_m: float
    ate_plan_max_m: float
    ate_height_m: float
    end_point_m: float
    end_point_percent: float | None
    closure_m: float
    closure_percent: float | None
    reference_closure_m: float
    relative: tuple[Relative, ...]
    velocity_rms: float
    attitude: AttitudeError | None
    course_rms: float
    nees_position: Nees | None
    nees_velocity: Nees | None
    nees_attitude: Nees | None
    rows_used: NDArray[np.int64]
    time: Array
    error: Array
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON: angles in degrees, None where there is no number, alignment named."""
        a = self.attitude
        found = {
            "method": self.method,
            "reference": self.reference,
            "alignment": self.alignment.kind,
            "mirrored": self.alignment.mirrored,
            "matched_by": self.matched,
            "rows": self.rows,
            "reference_distance_m": self.reference_distance_m,
            "length_ratio": self.length_ratio,
            "ate_rmse_3d_m": self.ate_m,
            "ate_rmse_2d_m": self.ate_plan_m,
            "ate_median_2d_m": self.ate_plan_median_m,
            "ate_max_2d_m": self.ate_plan_max_m,
            "ate_rmse_height_m": self.ate_height_m,
            "rte": [asdict(r) for r in self.relative],
            "end_point_m": self.end_point_m,
            "end_point_percent": self.end_point_percent,
            "closure_m": self.closure_m,
            "closure_percent": self.closure_percent,
            "reference_closure_m": self.reference_closure_m,
            "velocity_rmse_m_s": self.velocity_rms,
            "heading_rmse_deg": np.degrees(a.heading) if a else None,
            "tilt_rmse_deg": np.degrees(a.tilt) if a else None,
            "attitude_rmse_deg": np.degrees(a.total) if a else None,
            "course_rmse_deg": np.degrees(self.course_rms),
            **{
                f"nees_{name}": asdict(value) if value else None
                for name, value in (
                    ("position", self.nees_position),
                    ("velocity", self.nees_velocity),
                    ("attitude", self.nees_attitude),
                )
            },
            "notes": list(self.notes),
        }
        return _plain(found)

    def table(self) -> list[tuple[str, float | str, str]]:
        """Rows (name, value, unit) for a person; numbers that cannot be had are left out, those that depend on it name
        the alignment.
        """
        by, d = f" [{self.alignment}]", self.to_dict()
        rows: list[tuple[str, float | str | None, str]] = [
            ("Alignment", str(self.alignment), ""),
            ("Compared", self.rows, self.matched if self.matched == "footfalls" else "rows"),
            ("Distance (reference)", d["reference_distance_m"], "m"),
            ("Length, trajectory over reference", d["length_ratio"], ""),
            ("ATE RMSE, 3-D" + by, d["ate_rmse_3d_m"], "m"),
            ("ATE RMSE, plan" + by, d["ate_rmse_2d_m"], "m"),
            ("ATE RMSE, height" + by, d["ate_rmse_height_m"], "m"),
            ("ATE median, plan" + by, d["ate_median_2d_m"], "m"),
            ("ATE maximum, plan" + by, d["ate_max_2d_m"], "m"),
        ]
        for r in self.relative:
            rows.append((f"RTE over {r.window:g} {r.unit}{by}", _plain(r.rms_m), "m"))
            rows.append((f"RTE over {r.window:g} {r.unit}{by}", _plain(r.percent), "%"))
        rows += [
            ("End point" + by, d["end_point_m"], "m"),
            ("End point" + by, d["end_point_percent"], "% of distance"),
            ("Closure (trajectory)", d["closure_m"], "m"),
            ("Closure (trajectory)", d["closure_percent"], "% of distance"),
            ("Closure (reference)", d["reference_closure_m"], "m"),
            ("Velocity RMSE" + by, d["velocity_rmse_m_s"], "m/s"),
            ("Heading RMSE" + by, d["heading_rmse_deg"], "deg"),
            ("Tilt RMSE" + by, d["tilt_rmse_deg"], "deg"),
            ("Attitude RMSE" + by, d["attitude_rmse_deg"], "deg"),
            ("Course RMSE over 1 m" + by, d["course_rmse_deg"], "deg"),
        ]
        for name in ("position", "velocity", "attitude"):
            if n := d[f"nees_{name}"]:
                rows.append(
                    (
                        f"NEES, {name}{by}",
                        n["mean"],
                        f"expected {n['dof']}; 95 % of rows in {n['lower']:.2f} to {n['upper']:.2f}",
                    )
                )
                rows.append((f"NEES, {name}, rows inside{by}", 100 * n["inside"], "%"))
        return [(name, value, unit) for name, value, unit in rows if value is not None]


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def evaluate(
    trajectory: Trajectory,
    reference: Reference | Trajectory,
    align: Align = "yaw",
    windows_s: Sequence[float] = WINDOWS_S,
    windows_m: Sequence[float] = WINDOWS_M,
) -> Evaluation:
    """Compare a trajectory with what is known of the true path.

    The trajectory is taken at the reference's own instants or footfalls (`pairing.pair`), aligned by these points
    (`align_path`), and its errors are stated in the reference's frame. Lengths go from footfall to footfall of the
    reference where it shows them, so that neither the arcs of the foot nor the noise of a motion capture count; see
    `metrics.polygon_rows`.

    NEES asks how a filter that started at the first row knew of its errors: the aligned path is shifted so that the two
    coincide there (with `none` nothing is shifted). A fitted rotation, of which the filter knows nothing, makes it look
    better; where the heading is known, align with none or origin.

    Parameters
    ----------
    reference : a `Reference`, or a `Trajectory` (the truth of a simulation), which has velocities too.
    align : none, origin, yaw or se3, see `Alignment`.
    windows_s, windows_m : lengths of the windows of the relative error, see `metrics.relative_error`.

    Raises
    ------
    DataError
        Trajectory and reference do not overlap, or the reference has too little for this alignment.
    UsageError
        An unknown alignment.
    """
    truth = reference if isinstance(reference, Trajectory) else None
    ref = _as_reference(truth) if truth is not None else reference
    assert isinstance(ref, Reference)
    pairs = pair(trajectory, ref)
    alignment = align_path(pairs.position, ref.position[pairs.rows], align, ref.mirrored)
    aligned, true = alignment.path(pairs.position), alignment.reference(ref.position[pairs.rows])
    error = aligned - true
    height = bool(np.isfinite(error[:, 2]).any())
    flat = error if height else np.column_stack([error[:, :2], np.zeros(len(error))])
    mine, theirs, distance = _lengths(ref, pairs)
    end = float(np.sqrt(np.nansum(error[-1] ** 2)))
    closure = float(np.linalg.norm(trajectory.position[-1] - trajectory.position[0]))
    attitude, nees_attitude, notes = _attitude(pairs, ref, alignment)
    suspicious = tuple(doubts(ref, pairs, mine, theirs))
    velocity, nees_velocity = _velocity(pairs, truth, alignment)
    return Evaluation(
        alignment=alignment,
        matched="footfalls" if pairs.by_footfall else "time",
        rows=len(pairs.rows),
        method=trajectory.method,
        reference=ref.note,
        reference_distance_m=distance,
        length_ratio=mine / theirs if theirs > 0 else float("nan"),
        ate_m=rms(error),
        ate_plan_m=rms(error[:, :2]),
        ate_plan_median_m=float(np.median(np.linalg.norm(error[:, :2], axis=1))),
        ate_plan_max_m=float(np.linalg.norm(error[:, :2], axis=1).max()),
        ate_height_m=rms(error[:, 2]),
        end_point_m=end,
        end_point_percent=percent_of(end, distance),
        closure_m=closure,
        closure_percent=percent_of(closure, distance),
        reference_closure_m=float(np.sqrt(np.nansum((true[-1] - true[0]) ** 2))),
        relative=_relative(flat, true, pairs, windows_s, windows_m),
        velocity_rms=velocity,
        attitude=attitude,
        course_rms=course_error(aligned, true),
        nees_position=_position_nees(error, alignment, pairs),
        nees_velocity=nees_velocity,
        nees_attitude=nees_attitude,
        rows_used=pairs.rows,
        time=pairs.time,
        error=error,
        notes=(*pairs.notes, *notes, *_notes(alignment, height, pairs), *suspicious),
        doubts=suspicious,
    )


def _as_reference(truth: Trajectory) -> Reference:
    return Reference(time=truth.time, position=truth.position, attitude=truth.attitude, note=truth.method or truth.source)


def _lengths(ref: Reference, pairs: Pairs) -> tuple[float, float, float]:
    # Lengths of trajectory and reference through the same points, and of the whole reference.
    position = ref.position[pairs.rows]
    mine = _as_known(pairs.position, position)
    if pairs.by_footfall:
        known = ref.position[np.isfinite(ref.position[:, :2]).all(1)]
        return path_length(mine), path_length(position), path_length(known)
    rows = polygon_rows(pairs.time, position)
    length = path_length(position[rows])
    return path_length(mine[rows]), length, length


def _as_known(position: Array, reference: Array) -> Array:
    # The trajectory with as many dimensions as the reference.
    return np.where(np.isfinite(reference), position, np.nan)


def _relative(error: Array, true: Array, pairs: Pairs, windows_s: Sequence[float], windows_m: Sequence[float]) -> tuple[Relative, ...]:
    gone = distance_along(true)
    by_time = [relative_error(error, pairs.time, w, "s") for w in windows_s]
    return (*by_time, *(relative_error(error, gone, w, "m") for w in windows_m))


def _attitude(pairs: Pairs, ref: Reference, alignment: Alignment) -> tuple[AttitudeError | None, Nees | None, list[str]]:
    if ref.attitude is None:
        return None, None, []
    if alignment.mirrored:
        return None, None, ["the reference is mirrored, so its attitudes cannot be compared"]
    q = ref.attitude[pairs.rows]
    known = np.isfinite(q).all(1)
    if not known.any():
        return None, None, []
    mine = alignment.attitude(pairs.attitude[known])
    packed = rotate_packed(alignment.rotation, pairs.packed_covariance[known, 12:])
    return attitude_error(mine, q[known]), nees_summary(attitude_error_vectors(mine, q[known]), packed), []


def _position_nees(error: Array, alignment: Alignment, pairs: Pairs) -> Nees | None:
    packed = rotate_packed(alignment.rotation, pairs.packed_covariance[:, :6])
    if alignment.kind != "none":
        error = error - error[0]
    if np.isfinite(error[:, 2]).any():
        return nees_summary(error, packed, least_sd=_REFERENCE_SD)
    # The plan alone: a height that is independent and has no error adds nothing.
    flat = np.column_stack([error[:, :2], np.zeros(len(error))])
    packed[:, [2, 4]] = 0.0
    packed[:, 5] = np.maximum(packed[:, 0], packed[:, 3])
    return nees_summary(flat, packed, dof=2, least_sd=_REFERENCE_SD)


def _velocity(pairs: Pairs, truth: Trajectory | None, alignment: Alignment) -> tuple[float, Nees | None]:
    if truth is None:
        return float("nan"), None
    error = alignment.vectors(pairs.velocity) - truth.velocity[pairs.rows]
    return rms(error), nees_summary(error, rotate_packed(alignment.rotation, pairs.packed_covariance[:, 6:12]))


def _notes(alignment: Alignment, height: bool, pairs: Pairs) -> list[str]:
    notes = []
    if alignment.mirrored:
        notes.append(
            "the reference was mirrored before aligning, since its frame may be left-handed: if it is not, a sensor axis has the wrong sign"
        )
    if not height:
        notes.append("the reference has no height: errors and lengths are in the plan")
    if len(pairs.rows) < 3 and alignment.kind in ("yaw", "se3"):
        notes.append(f"only {len(pairs.rows)} rows: the alignment absorbs most of the error")
    return notes


class _Callable(types.ModuleType):
    # `bematist.evaluate` is this module once it is imported, and the function `evaluate` to whoever calls it.
    def __call__(self, *args: Any, **kwargs: Any) -> Evaluation:
        return evaluate(*args, **kwargs)


sys.modules[__name__].__class__ = _Callable
