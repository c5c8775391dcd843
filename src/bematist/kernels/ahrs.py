"""What gravity and the magnetic field say about an attitude: Mahony's error and Madgwick's gradient, for one sample.

ENU, a level sensor at rest reads +g up. (he, hn) is the unit horizontal direction of the magnetic field in the navigation frame: (0, 1)
for an East-North-Up frame of magnetic north, (1, 0) for a frame whose x axis points to magnetic north. A specific force that is zero or
not finite, and likewise a magnetic flux density, is left out. Quaternions must have unit norm.
"""

import math

from bematist.kernels.jit import inlined
from bematist.kernels.rotation import matrix

LONGEST_PULL_S = 0.1
"""A magnetometer sample stands for at most this long in Mahony's filter, s."""


@inlined
def _error(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, he, hn):
    """Mahony's error (3), and the part of Madgwick's gradient along the quaternion itself, which turns nothing.

    Li & Wang eqs 19-21 and 30-32 (errata: f and m are unit vectors, and the field is levelled by the attitude). With E = prediction −
    measurement of a pair (prediction p, its value r in a frame whose x axis points to magnetic north), the part along q is 2 (p - r)·E: it
    comes from Madgwick's writing of C_nb with 1 − 2(y² + z²) on the diagonal, which is no rotation where q is no unit quaternion.
    """
    C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(q0, q1, q2, q3)
    e0 = e1 = e2 = along = 0.0
    square = f0 * f0 + f1 * f1 + f2 * f2
    if 0 < square < math.inf:
        s = 1 / math.sqrt(square)
        u0, u1, u2 = f0 * s, f1 * s, f2 * s
        e0, e1, e2 = u1 * C8 - u2 * C7, u2 * C6 - u0 * C8, u0 * C7 - u1 * C6
        E0, E1, E2 = C6 - u0, C7 - u1, C8 - u2
        along = C6 * E0 + C7 * E1 + C8 * E2 - E2
    square = m0 * m0 + m1 * m1 + m2 * m2
    if 0 < square < math.inf:
        s = 1 / math.sqrt(square)
        u0, u1, u2 = m0 * s, m1 * s, m2 * s
        h0 = C0 * u0 + C1 * u1 + C2 * u2
        h1 = C3 * u0 + C4 * u1 + C5 * u2
        bz = C6 * u0 + C7 * u1 + C8 * u2
        bx = math.sqrt(h0 * h0 + h1 * h1)
        b0, b1 = he * bx, hn * bx
        w0 = C0 * b0 + C3 * b1 + C6 * bz
        w1 = C1 * b0 + C4 * b1 + C7 * bz
        w2 = C2 * b0 + C5 * b1 + C8 * bz
        e0 += u1 * w2 - u2 * w1
        e1 += u2 * w0 - u0 * w2
        e2 += u0 * w1 - u1 * w0
        E0, E1, E2 = w0 - u0, w1 - u1, w2 - u2
        along += w0 * E0 + w1 * E1 + w2 * E2 - bx * E0 - bz * E2
    return e0, e1, e2, 2 * along


@inlined
def mahony_error(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, he, hn):
    """Rotation error in the body frame, f × v + m × w of unit vectors: Li & Wang eqs 30-32.

    v is up and w the field as the attitude predicts them. To first order it is the rotation vector (rad) that the body frame still has to
    turn; with gravity alone its vertical component is zero.
    """
    e0, e1, e2, _ = _error(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, he, hn)
    return e0, e1, e2


@inlined
def madgwick_direction(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, he, hn):
    """Unit quaternion along the gradient Jᵀ E of ½ |E|²; zero where the gradient is zero. Li & Wang eqs 25-28.

    Errata: unit vectors, and a normalised gradient descent, no Gauss-Newton step. Across q, Jᵀ E is -2 q ⊗ (0, e) with Mahony's error e:
    both filters correct about the same axis, Mahony in proportion to the error, Madgwick by up to 2 β dt whatever it is. The length along q
    is as in Madgwick's own formulas, in which x points to magnetic north, whatever (he, hn) is here: so the step does not depend on the
    frame.
    """
    e0, e1, e2, along = _error(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, he, hn)
    square = 4 * (e0 * e0 + e1 * e1 + e2 * e2) + along * along
    if not square > 0:
        return 0.0, 0.0, 0.0, 0.0
    s = 1 / math.sqrt(square)
    a, t = along * s, -2 * s
    return (
        a * q0 + t * (-q1 * e0 - q2 * e1 - q3 * e2),
        a * q1 + t * (q0 * e0 + q2 * e2 - q3 * e1),
        a * q2 + t * (q0 * e1 - q1 * e2 + q3 * e0),
        a * q3 + t * (q0 * e2 + q1 * e1 - q2 * e0),
    )


@inlined
def first_order(q0, q1, q2, q3, w0, w1, w2, dt):
    """q + ½ q ⊗ (0, w) dt, Li & Wang eqs 24 and 29, not yet normalised."""
    h = 0.5 * dt
    x, y, z = h * w0, h * w1, h * w2
    return (
        q0 - q1 * x - q2 * y - q3 * z,
        q1 + q0 * x + q2 * z - q3 * y,
        q2 + q0 * y - q1 * z + q3 * x,
        q3 + q0 * z + q1 * y - q2 * x,
    )
