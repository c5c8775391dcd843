"""Laying one path over another: the rigid motion that takes a trajectory into the frame of its reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bematist.errors import DataError, UsageError
from bematist.frames import multiply, quaternion_from_matrix

Array = NDArray[np.float64]
Align = Literal["none", "origin", "yaw", "se3"]

MIRROR = np.array([1.0, -1.0, 1.0])
"""How a left-handed reference is made right-handed: its second axis turns round."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Alignment:
    """The motion `p_ref = rotation @ p + translation` from the trajectory's frame into the reference's.

    Attributes
    ----------
    kind : none (the frames are one), origin (the first points coincide), yaw (rotation about the vertical and
        translation, least squares) or se3 (rotation and translation, least squares); there is never a scale.
    rotation : (3,3), right-handed.
    translation : (3,) m.
    mirrored : whether the reference's second axis was turned round first, because its frame is left-handed.
    """

    kind: Align
    rotation: Array
    translation: Array
    mirrored: bool = False

    def path(self, position: ArrayLike) -> Array:
        """Positions (…,3) of the trajectory in the reference's frame, m."""
        return np.asarray(position, float) @ self.rotation.T + self.translation

    def vectors(self, v: ArrayLike) -> Array:
        """Vectors (…,3) of the trajectory, such as velocities, in the reference's frame."""
        return np.asarray(v, float) @ self.rotation.T

    def attitude(self, q: ArrayLike) -> Array:
        """Attitudes (…,4) of the trajectory in the reference's frame."""
        return multiply(quaternion_from_matrix(self.rotation), q)

    def covariance(self, P: ArrayLike) -> Array:
        """Covariances (…,3,3) of the trajectory in the reference's frame."""
        return self.rotation @ np.asarray(P, float) @ self.rotation.T

    def reference(self, position: ArrayLike) -> Array:
        """Positions (…,3) of the reference, mirrored where the alignment asks for it."""
        return np.asarray(position, float) * (MIRROR if self.mirrored else 1.0)

    def onto_trajectory(self, position: ArrayLike) -> Array:
        """Positions (…,3) of the reference in the trajectory's frame, to draw it there; what is unknown stays NaN."""
        p = self.reference(position)
        known = np.isfinite(p)
        back = (np.where(known, p, self.translation) - self.translation) @ self.rotation
        return np.where(known & known[..., :2].all(-1, keepdims=True), back, np.nan)

    def __str__(self) -> str:
        return self.kind + (", mirrored" if self.mirrored else "")


def align_path(position: ArrayLike, reference: ArrayLike, kind: Align = "yaw", mirrored: bool = False) -> Alignment:
    """Alignment of a path to the reference, row by row.

    Parameters
    ----------
    position : (K,3) m, the trajectory.
    reference : (K,3) m, the same instants in the reference; up may be NaN, except for se3.
    kind : see `Alignment`.
    mirrored : whether the reference may be left-handed. The mirror image is then tried too, with yaw and se3, and kept
        where it fits better (the others fit nothing, so they cannot tell).

    Raises
    ------
    UsageError
        An unknown kind.
    DataError
        No row to align by, or se3 with a reference that has no height.

    Source: S. Umeyama, IEEE Trans. Pattern Anal. Mach. Intell. 13, 1991, without the scale; in the plan, its closed
    form.
    """
    if kind not in get_args(Align):
        raise UsageError(f'Alignment "{kind}" is not known: choose one of {", ".join(get_args(Align))}.')
    p, r = np.asarray(position, float), np.asarray(reference, float)
    rows = np.isfinite(p).all(1) & np.isfinite(r[:, :2]).all(1)
    p, r = p[rows], r[rows]
    if not len(p):
        raise DataError("There is no instant at which both the trajectory and the reference have a position: nothing to align.")
    if kind == "se3" and not np.isfinite(r).all():
        raise DataError("The reference has no height everywhere, so se3 alignment cannot be fitted: align with yaw instead.")
    fit = {"none": _nothing, "origin": _origin, "yaw": _yaw, "se3": _se3}[kind]
    plain = Alignment(kind=kind, rotation=(a := fit(p, r))[0], translation=a[1])
    if not mirrored or kind in ("none", "origin"):
        return plain
    mirror = Alignment(kind=kind, rotation=(b := fit(p, r * MIRROR))[0], translation=b[1], mirrored=True)
    return min((plain, mirror), key=lambda x: np.nansum((x.path(p) - x.reference(r)) ** 2))


def _nothing(p: Array, r: Array) -> tuple[Array, Array]:
    return np.eye(3), np.zeros(3)


def _origin(p: Array, r: Array) -> tuple[Array, Array]:
    up = np.flatnonzero(np.isfinite(r[:, 2]))[:1]
    height = r[up, 2] - p[up, 2] if len(up) else [0.0]
    return np.eye(3), np.array([*(r[0, :2] - p[0, :2]), *height])


def _yaw(p: Array, r: Array) -> tuple[Array, Array]:
    a, b = p[:, :2] - p[:, :2].mean(0), r[:, :2] - r[:, :2].mean(0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    t = np.zeros(3)
    t[:2] = r[:, :2].mean(0) - R[:2, :2] @ p[:, :2].mean(0)
    up = np.isfinite(r[:, 2])
    t[2] = (r[up, 2] - p[up, 2]).mean() if up.any() else 0.0
    return R, t


def _se3(p: Array, r: Array) -> tuple[Array, Array]:
    """Kabsch's rotation (Umeyama 1991 without scale). DataError where the path is a line, about which any roll would fit."""
    U, size, Vt = np.linalg.svd((r - r.mean(0)).T @ (p - p.mean(0)))
    if size[1] < 1e-3 * size[0]:
        raise DataError("The path is straight, so that se3 alignment would be free to roll about it: align with yaw instead.")
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    return R, r.mean(0) - R @ p.mean(0)
