"""Attitude from directions: of two the optimum of QUEST, of one the nearest to the attitude before."""

import math

from bematist.kernels.jit import inlined
from bematist.kernels.magnetic import quaternion
from bematist.kernels.rotation import matrix, multiply, normalise


@inlined
def _unit(x, y, z):
    s = 1 / math.sqrt(x * x + y * y + z * z)
    return x * s, y * s, z * s


@inlined
def _cross(a0, a1, a2, b0, b1, b2):
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@inlined
def two_vectors(a0, a1, a2, b0, b1, b2, r0, r1, r2, s0, s1, s2, wa, wb):
    """Quaternion that turns a to r and b to s as well as the weights wa and wb (1/rad²) say: the solution of Wahba's problem.

    What QUEST finds by iteration is closed for two vectors (Markley 2002, "Fast Quaternion Attitude Estimation from Two Vector
    Measurements"): the plane of a and b turns onto that of r and s, and within it the misfit of the angle between them is shared.
    """
    a0, a1, a2 = _unit(a0, a1, a2)
    b0, b1, b2 = _unit(b0, b1, b2)
    r0, r1, r2 = _unit(r0, r1, r2)
    s0, s1, s2 = _unit(s0, s1, s2)
    p0, p1, p2 = _cross(a0, a1, a2, b0, b1, b2)
    u0, u1, u2 = _cross(r0, r1, r2, s0, s1, s2)
    between = math.atan2(math.sqrt(p0 * p0 + p1 * p1 + p2 * p2), a0 * b0 + a1 * b1 + a2 * b2)
    wanted = math.atan2(math.sqrt(u0 * u0 + u1 * u1 + u2 * u2), r0 * s0 + r1 * s1 + r2 * s2)
    # In the plane: a stands at the angle x from r, b at x + between, where s is at wanted; the best x solves
    # wa sin(x) + wb sin(x + between − wanted) = 0.
    e = between - wanted
    x = -math.atan2(wb * math.sin(e), wa + wb * math.cos(e))
    p0, p1, p2 = _unit(p0, p1, p2)
    u0, u1, u2 = _unit(u0, u1, u2)
    l0, l1, l2 = _cross(p0, p1, p2, a0, a1, a2)
    k0, k1, k2 = _cross(u0, u1, u2, r0, r1, r2)
    c, s = math.cos(x), math.sin(x)
    g0, g1, g2 = c * r0 + s * k0, c * r1 + s * k1, c * r2 + s * k2
    k0, k1, k2 = c * k0 - s * r0, c * k1 - s * r1, c * k2 - s * r2
    return quaternion(
        g0 * a0 + k0 * l0 + u0 * p0,
        g0 * a1 + k0 * l1 + u0 * p1,
        g0 * a2 + k0 * l2 + u0 * p2,
        g1 * a0 + k1 * l0 + u1 * p0,
        g1 * a1 + k1 * l1 + u1 * p1,
        g1 * a2 + k1 * l2 + u1 * p2,
        g2 * a0 + k2 * l0 + u2 * p0,
        g2 * a1 + k2 * l1 + u2 * p1,
        g2 * a2 + k2 * l2 + u2 * p2,
    )


@inlined
def levelled(q0, q1, q2, q3, f0, f1, f2):
    """The attitude turned as little as possible, so that f points up."""
    C = matrix(q0, q1, q2, q3)
    u0, u1, u2 = _unit(C[0] * f0 + C[1] * f1 + C[2] * f2, C[3] * f0 + C[4] * f1 + C[5] * f2, C[6] * f0 + C[7] * f1 + C[8] * f2)
    if u2 < -0.999999:
        return q0, q1, q2, q3
    w, x, y, z = normalise(1 + u2, u1, -u0, 0.0)
    w, x, y, z = multiply(w, x, y, z, q0, q1, q2, q3)
    return normalise(w, x, y, z)


@inlined
def headed(q0, q1, q2, q3, m0, m1, m2, east, north):
    """The attitude turned about up, so that m points in plan as (east, north) does."""
    C = matrix(q0, q1, q2, q3)
    e = C[0] * m0 + C[1] * m1 + C[2] * m2
    n = C[3] * m0 + C[4] * m1 + C[5] * m2
    half = 0.5 * math.atan2(e * north - n * east, e * east + n * north)
    w, x, y, z = multiply(math.cos(half), 0.0, 0.0, math.sin(half), q0, q1, q2, q3)
    return normalise(w, x, y, z)
