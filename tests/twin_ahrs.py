"""Plain NumPy twins of the attitude filters, written from Madgwick's and Mahony's formulas: matrices, Jacobians, one sample at a time."""

import numpy as np
from scipy.spatial.transform import Rotation


def matrix(q):
    """C_nb with ones on the diagonal, as Madgwick writes it: a rotation for unit quaternions only."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y**2 + z**2), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x**2 + z**2), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x**2 + y**2)],
        ]
    )


def product(p, q):
    a, b, c, d = p
    w, x, y, z = q
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def usable(v):
    return v is not None and np.isfinite(v).all() and np.linalg.norm(v) > 0


def pairs(q, f, m, north):
    """Reference directions in n and measured unit vectors in b; the field's reference follows from the attitude (eqs 19-21)."""
    found = []
    if usable(f):
        found.append((np.array([0.0, 0.0, 1.0]), f / np.linalg.norm(f)))
    if usable(m):
        m = m / np.linalg.norm(m)
        h = matrix(q) @ m
        found.append((np.append(np.linalg.norm(h[:2]) * np.asarray(north), h[2]), m))
    return found


def error(q, f, m, north):
    """Li & Wang eqs 30-32."""
    return sum((np.cross(s, matrix(q).T @ r) for r, s in pairs(q, f, m, north)), np.zeros(3))


def misfit(q, references):
    """E of Li & Wang eq 26, stacked."""
    return np.concatenate([matrix(q).T @ r - s for r, s in references])


def jacobian(q, references):
    """dE/dq, the derivative of C_nbᵀ r entry by entry."""
    w, x, y, z = q
    d = 2 * np.array(
        [
            [[0, -z, y], [z, 0, -x], [-y, x, 0]],
            [[0, y, z], [y, -2 * x, -w], [z, w, -2 * x]],
            [[-2 * y, x, w], [x, 0, z], [-w, z, -2 * y]],
            [[-2 * z, -w, x], [w, -2 * z, y], [x, y, 0]],
        ]
    )
    return np.concatenate([np.stack([D.T @ r for D in d], 1) for r, _ in references])


def gradient(q, f, m):
    """Jᵀ E in a frame whose x axis points to magnetic north."""
    references = pairs(q, f, m, (1.0, 0.0))
    return jacobian(q, references).T @ misfit(q, references) if references else np.zeros(4)


def turn(q, w, dt, exact):
    if exact:
        x, y, z, s = Rotation.from_rotvec(np.asarray(w) * dt).as_quat()
        return product(q, [s, x, y, z])
    return q + 0.5 * product(q, [0, *w]) * dt


def run(recording, start, bias, kind, gain, bias_gain, exact, north, magnetometer=True):
    """Attitudes (N,4) and offsets (N,3) of a recording without gaps, one sample after the other. Li & Wang eqs 24-34."""
    rows = recording.samples()
    q, b = np.array(start, float), np.array(bias, float)
    attitudes, offsets = [q], [b]
    seen = rows[0, 0]
    half = 0.5 * np.arctan2(north[1], north[0])
    frame = np.array([np.cos(half), 0, 0, np.sin(half)])
    for k in range(1, len(rows)):
        dt = rows[k, 0] - rows[k - 1, 0]
        f, w, m = rows[k, 1:4], rows[k, 4:7], rows[k, 7:10] if magnetometer else None
        if kind == "mahony":
            e = error(q, f, None, north)
            if usable(m):
                e = e + error(q, None, m, north) * min(rows[k, 0] - seen, 0.1) / dt
                seen = rows[k, 0]
            b = b - bias_gain * e * dt
            q = turn(q, w - b + gain * e, dt, exact)
        elif kind == "madgwick":
            g = gradient(product(frame * [1, -1, -1, -1], q), f, m)
            d = product(frame, g / np.linalg.norm(g))
            b = b + bias_gain * 2 * product(q * [1, -1, -1, -1], d)[1:] * dt
            q = turn(q, w - b, dt, exact) - gain * d * dt
        else:
            q = turn(q, w - b, dt, exact)
        q = q / np.linalg.norm(q)
        attitudes.append(q)
        offsets.append(b)
    return np.array(attitudes), np.array(offsets)
