"""What a magnetometer sample says: TRIAD, gates, and heading as a measurement."""

import math

from bematist.kernels import hard_iron as iron
from bematist.kernels import hard_iron_layout as iron_layout
from bematist.kernels import layout as at
from bematist.kernels.error_state import feed_back, replace_attitude, row_measurement
from bematist.kernels.jit import apart, inlined
from bematist.kernels.layout import BA, BG, ROW, Q
from bematist.kernels.rotation import matrix, multiply, normalise


@inlined
def triad(f0, f1, f2, m0, m1, m2, e, n):
    """Quaternion of C_nb from up (specific force) and the field, whose horizontal direction in n is (e, n)/|.|.

    MAGINAV eqs 10, 11 and Appendix A. Erratum of eq 11: C(0) TRIAD(f0, m0, fk, mk)ᵀ; since C(0) f0 is up and C(0) m0 the field at
    the start, that is the rotation of (f, m) onto (up, field). Erratum of eq 10: unit vectors. The offset is taken out of f, and up
    is up, whatever f0 was.
    """
    s = 1 / math.sqrt(f0 * f0 + f1 * f1 + f2 * f2)
    u0, u1, u2 = f0 * s, f1 * s, f2 * s
    # left = up x field, both in b and in n; then forward = left x up is the horizontal field
    l0, l1, l2 = u1 * m2 - u2 * m1, u2 * m0 - u0 * m2, u0 * m1 - u1 * m0
    s = 1 / math.sqrt(l0 * l0 + l1 * l1 + l2 * l2)
    l0, l1, l2 = l0 * s, l1 * s, l2 * s
    h0, h1, h2 = l1 * u2 - l2 * u1, l2 * u0 - l0 * u2, l0 * u1 - l1 * u0
    s = 1 / math.sqrt(e * e + n * n)
    e, n = e * s, n * s
    # C = [h_n l_n u_n] [h_b l_b u_b]ᵀ with h_n = (e, n, 0), l_n = (-n, e, 0), u_n = (0, 0, 1)
    return (
        e * h0 - n * l0,
        e * h1 - n * l1,
        e * h2 - n * l2,
        n * h0 + e * l0,
        n * h1 + e * l1,
        n * h2 + e * l2,
        u0,
        u1,
        u2,
    )


@inlined
def quaternion(c0, c1, c2, c3, c4, c5, c6, c7, c8):
    """Unit quaternion of a rotation matrix given row by row (Shepperd 1978)."""
    t = c0 + c4 + c8
    if t >= c0 and t >= c4 and t >= c8:
        w, x, y, z = 1 + t, c7 - c5, c2 - c6, c3 - c1
    elif c0 >= c4 and c0 >= c8:
        w, x, y, z = c7 - c5, 1 + 2 * c0 - t, c1 + c3, c2 + c6
    elif c4 >= c8:
        w, x, y, z = c2 - c6, c1 + c3, 1 + 2 * c4 - t, c5 + c7
    else:
        w, x, y, z = c3 - c1, c2 + c6, c5 + c7, 1 + 2 * c8 - t
    return normalise(w, x, y, z)


@inlined
def refer(S, e, n, u):
    """The undisturbed field, from now on, where it gives a heading."""
    if not iron.points(e, n, u):
        return
    horizontal, norm = math.sqrt(e * e + n * n), math.sqrt(e * e + n * n + u * u)
    S[at.FIELD_NORM], S[at.FIELD_INCLINATION] = norm, -math.asin(u / norm)
    S[at.FIELD_E], S[at.FIELD_N], S[at.FIELD_U] = e, n, u
    S[at.NORTH_E], S[at.NORTH_N] = e / horizontal, n / horizontal


@apart
def hard_iron(S, prm, dt, standing, lost, diag, k):
    """The sample in S[ROW:] for `kernels.hard_iron`, from its blocks in stance: what is found is told, and, where asked for, taken out.

    In swing a foot is at other places, where near the ground the field is another, and always at those to which it has turned: that would
    look like hard iron.
    """
    m0 = S[ROW + 7] if standing else math.nan
    w0, w1, w2 = S[ROW + 4] - S[BG], S[ROW + 5] - S[BG + 1], S[ROW + 6] - S[BG + 2]
    o, p = at.IRON, at.IRON_USE
    changed = iron.step(S, o, prm, p, S[ROW], dt, w0, w1, w2, m0, S[ROW + 8], S[ROW + 9], not standing, not standing, lost)
    if changed and prm[p] == iron_layout.CORRECT:
        e, n, u = iron.reference(S, o, prm, p, prm[at.START_E], prm[at.START_N], prm[at.START_U])
        refer(S, e, n, u)
    iron.settle(S, o, ROW + 7, changed, diag, k, at.IRON_DIAG)


@inlined
def set_attitude(S, prm):
    """State 3 of MAGINAV Table 2 (eqs 12, 13): the attitude is TRIAD's for the sample in S[ROW:], and so is its covariance."""
    f0, f1, f2 = S[ROW + 1] - S[BA], S[ROW + 2] - S[BA + 1], S[ROW + 3] - S[BA + 2]
    c = triad(f0, f1, f2, S[ROW + 7], S[ROW + 8], S[ROW + 9], S[at.FIELD_E], S[at.FIELD_N])
    w, x, y, z = quaternion(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8])
    if prm[at.TRIAD_PRINTED] != 0:
        # C(0) TRIAD(f0, m0, fk, mk) as printed is C(0) C(k)ᵀ C(0).
        a = prm[at.START], prm[at.START + 1], prm[at.START + 2], prm[at.START + 3]
        w, x, y, z = multiply(a[0], a[1], a[2], a[3], w, -x, -y, -z)
        w, x, y, z = multiply(w, x, y, z, a[0], a[1], a[2], a[3])
    S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = w, x, y, z
    if prm[at.KEEP_COVARIANCE] == 0:
        replace_attitude(S, prm, c[0], c[1], c[2], c[3], c[4], c[5])


@inlined
def magnetic_gate(S, prm, C6, C7, C8, diag, k):
    """Gates of the magnetometer sample of a row, if there is one; (C6, C7, C8) is up in b.

    Norm: MAGINAV eqs 4, 5, with a relative tolerance. Inclination: a field that was turned keeps its norm.
    """
    m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
    norm = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
    if not norm >= 0:
        return at.NO_SAMPLE
    inclination = -math.asin(min(1.0, max(-1.0, (C6 * m0 + C7 * m1 + C8 * m2) / norm))) if norm > 0 else 0.0
    diag[k, at.NORM] = norm
    diag[k, at.INCLINATION] = inclination
    if abs(norm - S[at.FIELD_NORM]) > prm[at.NORM_TOLERANCE] * S[at.FIELD_NORM]:
        return at.NORM_REFUSED
    if abs(inclination - S[at.FIELD_INCLINATION]) > prm[at.INCLINATION_TOLERANCE]:
        return at.INCLINATION_REFUSED
    return at.PASSED


@inlined
def magnetic_heading(S, prm, m0, m1, m2):
    """Heading from the field as a scalar measurement, with tilt from the filter; returns the gate's verdict.

    The field turned into n by the estimate is exp([psi x]) m_n, so its horizontal direction is off by
    psi_z - (h·psi) m_z/m_h, with h the direction of the horizontal field.
    """
    C0, C1, C2, C3, C4, C5, _, _, _ = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    e = C0 * m0 + C1 * m1 + C2 * m2
    n = C3 * m0 + C4 * m1 + C5 * m2
    horizontal = math.sqrt(S[at.FIELD_E] * S[at.FIELD_E] + S[at.FIELD_N] * S[at.FIELD_N])
    he, hn = S[at.FIELD_E] / horizontal, S[at.FIELD_N] / horizontal
    slope = S[at.FIELD_U] / horizontal
    nu = math.atan2(he * n - hn * e, he * e + hn * n)
    variance = prm[at.HEADING_SD] * prm[at.HEADING_SD]
    if row_measurement(S, 0, -slope * he, -slope * hn, 1.0, nu, variance, prm[at.HEADING_TOLERANCE]):
        feed_back(S, True)
        return at.USED
    return at.INNOVATION_REFUSED
