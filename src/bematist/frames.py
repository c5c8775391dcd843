"""Rotations outside the kernels, vectorised over rows. Quaternions are Hamilton, scalar first, body → navigation (ENU).

The compiled twins for one sample live in `kernels.rotation`.
"""

import re

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bematist.errors import UsageError

Array = NDArray[np.float64]


def matrix_from_quaternion(q: ArrayLike) -> Array:
    """Attitude matrices C_nb (…,3,3) of unit quaternions (…,4)."""
    q = np.asarray(q, float)
    w, x, y, z = np.moveaxis(q, -1, 0)
    C = np.empty((*q.shape[:-1], 3, 3))
    C[..., 0, 0] = 1 - 2 * (y * y + z * z)
    C[..., 0, 1] = 2 * (x * y - w * z)
    C[..., 0, 2] = 2 * (x * z + w * y)
    C[..., 1, 0] = 2 * (x * y + w * z)
    C[..., 1, 1] = 1 - 2 * (x * x + z * z)
    C[..., 1, 2] = 2 * (y * z - w * x)
    C[..., 2, 0] = 2 * (x * z - w * y)
    C[..., 2, 1] = 2 * (y * z + w * x)
    C[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return C


def quaternion_from_matrix(C: ArrayLike) -> Array:
    """Unit quaternions (…,4), w ≥ 0, of rotation matrices (…,3,3) (the numerically safe form of Shepperd 1978)."""
    C = np.asarray(C, float)
    d = np.diagonal(C, axis1=-2, axis2=-1)
    t = d.sum(-1)
    four = np.stack([t, d[..., 0], d[..., 1], d[..., 2]], -1)
    k = np.argmax(four, -1)
    a = C[..., 2, 1] - C[..., 1, 2]
    b = C[..., 0, 2] - C[..., 2, 0]
    c = C[..., 1, 0] - C[..., 0, 1]
    d01, d02, d12 = C[..., 0, 1] + C[..., 1, 0], C[..., 0, 2] + C[..., 2, 0], C[..., 1, 2] + C[..., 2, 1]
    candidates = np.stack(
        [
            np.stack([1 + t, a, b, c], -1),
            np.stack([a, 1 + 2 * d[..., 0] - t, d01, d02], -1),
            np.stack([b, d01, 1 + 2 * d[..., 1] - t, d12], -1),
            np.stack([c, d02, d12, 1 + 2 * d[..., 2] - t], -1),
        ],
        -2,
    )
    q = np.take_along_axis(candidates, k[..., None, None], -2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., :1] < 0, -q, q)


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Hamilton product p ⊗ q of quaternions (…,4)."""
    a, b, c, d = np.moveaxis(np.asarray(p, float), -1, 0)
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        -1,
    )


def conjugate(q: ArrayLike) -> Array:
    """Inverse rotations of unit quaternions (…,4)."""
    return np.asarray(q, float) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Vectors (…,3) turned by unit quaternions (…,4): v_n = C_nb v_b."""
    return np.einsum("...ij,...j->...i", matrix_from_quaternion(q), np.asarray(v, float))


def quaternion_from_rotation_vector(r: ArrayLike) -> Array:
    """Unit quaternions (…,4) of rotation vectors (…,3), rad."""
    r = np.asarray(r, float)
    angle = np.linalg.norm(r, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * r], -1)


def rotation_vector_from_quaternion(q: ArrayLike) -> Array:
    """Rotation vectors (…,3), rad, |r| ≤ π, of unit quaternions (…,4)."""
    q = np.asarray(q, float)
    q = np.where(q[..., :1] < 0, -q, q)
    s = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(s, q[..., :1])
    return np.where(s > 1e-12, angle / np.where(s > 1e-12, s, 1.0), 2.0) * q[..., 1:]


def euler_from_quaternion(q: ArrayLike) -> Array:
    """Roll, pitch, yaw (…,3) in rad, z-y-x, yaw counter-clockwise from East."""
    w, x, y, z = np.ascontiguousarray(np.moveaxis(np.asarray(q, float), -1, 0))
    roll = np.arctan2(2 * (y * z + w * x), 1 - 2 * (x * x + y * y))
    pitch = -np.arcsin(np.clip(2 * (x * z - w * y), -1.0, 1.0))
    yaw = np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], -1)


def quaternion_from_euler(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> Array:
    """Unit quaternions (…,4) of roll, pitch, yaw in rad (z-y-x)."""
    r, p, y = (np.asarray(a, float) / 2 for a in (roll, pitch, yaw))
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        -1,
    )


def heading_deg_from_yaw(yaw_rad: ArrayLike) -> Array:
    """Heading in degrees clockwise from North, [0, 360), of yaw in rad counter-clockwise from East."""
    return np.mod(90.0 - np.degrees(np.asarray(yaw_rad, float)), 360.0)


def yaw_from_heading_deg(heading_deg: ArrayLike) -> Array:
    """Yaw in rad counter-clockwise from East, (−π, π], of heading in degrees clockwise from North."""
    return np.radians(180.0 - np.mod(90.0 + np.asarray(heading_deg, float), 360.0))


def axes_matrix(text: str) -> Array:
    """Signed permutation M (3,3) of an axis remap such as `"x,-z,y"`: v_new = M v_old.

    The k-th entry names the old axis, with its sign, that becomes the new k-th axis.

    Raises
    ------
    UsageError
        The text does not name each of x, y, z once, or it would make a left-handed sensor.
    """
    parts = [p.strip().lower() for p in text.split(",")]
    found = [re.fullmatch(r"([+-]?)([xyz])", p) for p in parts]
    if len(parts) != 3 or not all(found) or {m[2] for m in found if m} != {"x", "y", "z"}:
        raise UsageError(f'Axes "{text}": name each of x, y and z once, with a sign where it turns, such as "x,-z,y".')
    M = np.zeros((3, 3))
    for row, m in enumerate(found):
        assert m is not None
        M[row, "xyz".index(m[2])] = -1.0 if m[1] == "-" else 1.0
    if np.linalg.det(M) < 0:
        raise UsageError(f'Axes "{text}" would turn a right-handed sensor into its mirror image: change one sign or swap two axes.')
    return M
