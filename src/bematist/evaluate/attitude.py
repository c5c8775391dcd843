"""How far attitudes are from the true ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.evaluate.metrics import AttitudeError, attitude_error, attitude_error_vectors
from bematist.evaluate.pairing import attitude_at
from bematist.frames import conjugate, multiply, quaternion_from_matrix, quaternion_from_rotation_vector, rotation_vector_from_quaternion
from bematist.recording import Reference
from bematist.trajectory import Trajectory

Array = NDArray[np.float64]
Align = Literal["none", "yaw", "frames"]

SETTLED = 60
"""Turns of the alternation of `frames`; a hundredth of a degree is reached after a dozen."""


@dataclass(frozen=True, eq=False, kw_only=True)
class AttitudeEvaluation:
    """What `evaluate_attitude` found.

    Attributes
    ----------
    error : root mean square errors, rad: heading, tilt, total.
    align : "none"; "yaw": the mean heading error was taken out first, of `turned_deg` (counter-clockwise); "frames": a constant rotation on
        either side was.
    rows : instants of the reference that were compared.
    time, attitude, vectors : these instants (K,), s, the aligned estimate (K,4) and the error's rotation vectors in the navigation frame
        (K,3), rad, for plots.
    """

    error: AttitudeError
    align: str
    turned_deg: float
    rows: int
    filter: str
    reference: str
    time: Array
    attitude: Array
    vectors: Array
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Numbers for JSON, angles in degrees."""
        return {
            "filter": self.filter,
            "reference": self.reference,
            "alignment": self.align,
            "turned_deg": self.turned_deg,
            "rows": self.rows,
            "attitude_rmse_deg": float(np.degrees(self.error.total)),
            "heading_rmse_deg": float(np.degrees(self.error.heading)),
            "tilt_rmse_deg": float(np.degrees(self.error.tilt)),
            "notes": list(self.notes),
        }

    def table(self) -> list[tuple[str, float | str, str]]:
        """Rows (name, value, unit) for a person."""
        d = self.to_dict()
        by = f" [{self.align}]"
        rows: list[tuple[str, float | str, str]] = [("Alignment", self.align, ""), ("Compared", self.rows, "rows")]
        if self.align == "yaw":
            rows.append(("Turned about the vertical", self.turned_deg, "deg"))
        names = (("Attitude RMSE", "attitude"), ("Heading RMSE", "heading"), ("Tilt RMSE", "tilt"))
        return [*rows, *((name + by, d[f"{key}_rmse_deg"], "deg") for name, key in names)]


def evaluate_attitude(estimate: Attitude | Trajectory, reference: Reference, align: Align = "none") -> AttitudeEvaluation:
    """Compare attitudes with the true ones at the reference's own instants.

    The error is the rotation between the two in the navigation frame, q_est ⊗ q_true*: its whole angle, its twist about the vertical
    (heading) and the angle between the verticals (tilt; others call it inclination), as Laidig et al. 2021 define them. Rows of the
    reference without an attitude, outside the estimate's time, or that it does not judge are left out.

    Parameters
    ----------
    align : "none"; "yaw" to take out the mean heading error first, where the two do not share their North; "frames" to take out a constant
        rotation on either side, where the reference's room is not East, North, Up and its body not the sensor's axes, as with the markers
        of a motion capture. That flatters: a constant error of the estimate, and a share of a slow one, go too.

    Raises
    ------
    DataError
        The reference has no attitude, or the two do not overlap.
    UsageError
        An unknown alignment.
    """
    if align not in get_args(Align):
        raise UsageError(f'Attitudes are aligned by {", ".join(get_args(Align))}, not by "{align}".')
    if reference.attitude is None:
        raise DataError("The reference has no attitude. Give one with the columns qw,qx,qy,qz.")
    t = estimate.time
    known = np.isfinite(reference.attitude).all(1) & np.isfinite(reference.time)
    notes = []
    if reference.judged is not None:
        notes.append(f"errors are counted over {int(reference.judged.sum())} of {len(known)} rows of the reference, as it asks")
        known &= reference.judged
    inside = (reference.time >= t[0] - 1e-6) & (reference.time <= t[-1] + 1e-6) if len(t) else np.zeros(len(known), bool)
    rows = np.flatnonzero(known & inside)
    if not len(rows):
        raise DataError("There is no instant at which both the attitudes and the reference have one. Check that their clocks are the same.")
    at = np.clip(reference.time[rows], t[0], t[-1])
    mine, true = attitude_at(estimate, at), reference.attitude[rows]
    turned = 0.0
    if align == "yaw":
        twist = multiply(mine, conjugate(true))[:, [0, 3]]
        half = twist * np.where(twist[:, :1] < 0, -1.0, 1.0)
        yaw = 2 * np.arctan2(half[:, 1], half[:, 0])
        turned = -float(np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean()))
        mine = multiply(quaternion_from_rotation_vector([0.0, 0.0, turned]), mine)
    if align == "frames":
        mine = _both_frames(mine, true)
    return AttitudeEvaluation(
        error=attitude_error(mine, true),
        align=align,
        turned_deg=float(np.degrees(turned)),
        rows=len(rows),
        filter=estimate.filter if isinstance(estimate, Attitude) else estimate.method,
        reference=reference.note,
        time=at,
        attitude=mine,
        vectors=attitude_error_vectors(mine, true),
        notes=tuple(notes),
    )


def _both_frames(mine: Array, true: Array) -> Array:
    """left ⊗ mine ⊗ right (K,4) with the constant rotations that bring it nearest to `true`.

    The right one, between the bodies, is first taken from the turns from row to row, which both bodies see (Kabsch); then each is the mean
    of what the other leaves, in turn, until they settle.
    """
    turns = [rotation_vector_from_quaternion(multiply(conjugate(q[:-1]), q[1:])) for q in (mine, true)]
    U, _, Vt = np.linalg.svd(turns[0].T @ turns[1])
    right = quaternion_from_matrix(U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt)
    moved = mine
    for _ in range(SETTLED):
        left = _mean(multiply(true, conjugate(multiply(mine, right))))
        right = _mean(multiply(conjugate(multiply(left, mine)), true))
        moved = multiply(multiply(left, mine), right)
    return moved


def _mean(q: Array) -> Array:
    """The rotation (4,) with the least sum of squared chords to rotations (K,4)."""
    return np.linalg.eigh(q.T @ q)[1][:, -1]
