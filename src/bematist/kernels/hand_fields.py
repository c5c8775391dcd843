"""What a field says to the handheld filter: as a direction that stays (QSF), as one that turns (MARU, AGU), or as the Earth's.

`force` tells the two fields apart: the specific force, whose measurement has an offset, and the magnetic field, whose has none.
"""

import math

from bematist.kernels import hand_layout as at
from bematist.kernels.hand_error import (
    h1,
    h3,
    rotation_rows,
    rows_gyro,
    rows_gyro_accel,
    rows_own_field,
    rows_own_force,
    rows_quaternion,
    rows_quaternion_accel,
    times_block,
    times_offset,
    times_quaternion,
    update,
    update_scalar,
)
from bematist.kernels.hand_layout import BQ, FREF, MREF, STEP, STEP_BQ, TURN, TURN_BQ, USED_BQ, Q, W
from bematist.kernels.innovation import factor, squared
from bematist.kernels.jit import apart, inlined
from bematist.kernels.rotation import matrix


@inlined
def _measure(S, x0, x1, x2, r0, r1, r2, force, reference, own, variance, limit, references):
    """Quasi-static field update: z = r − q ⊗ x ⊗ q*, MAGYQ eqs 35-38. Returns innovation, NIS, and whether it was used.

    x is what was measured in b, freed of its offset; r the reference in n. `own`: r is the part of the state from `reference` on,
    else it is known. Erratum of eq 37: h1 takes the body field of this sample. H = [h1(q, x), 0, −C for the specific force, −I for an own
    reference].
    """
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    C = matrix(q0, q1, q2, q3)
    z0 = r0 - (C[0] * x0 + C[1] * x1 + C[2] * x2)
    z1 = r1 - (C[3] * x0 + C[4] * x1 + C[5] * x2)
    z2 = r2 - (C[6] * x0 + C[7] * x1 + C[8] * x2)
    h = h1(q0, q1, q2, q3, x0, x1, x2)
    s00, s10, s11, s20, s21, s22 = _innovation(S, h, C, force, reference, own)
    L = factor(s00 + variance, s10, s11 + variance, s20, s21, s22 + variance, z0, z1, z2)
    value = squared(L)
    used = value <= limit
    if used:
        update(S, L, references)
    return z0, z1, z2, value, used


@inlined
def _innovation(S, h, C, force, reference, own):
    """W ← H P, and the lower triangle of H P Hᵀ, of a quasi-static field."""
    b = (-C[0], -C[1], -C[2], -C[3], -C[4], -C[5], -C[6], -C[7], -C[8])
    if force:
        rows_quaternion_accel(S, h, b)
    else:
        rows_quaternion(S, h)
    if own:
        if force:
            rows_own_force(S)
        else:
            rows_own_field(S)
    s00, _, _ = times_quaternion(S, 0, h)
    s10, s11, _ = times_quaternion(S, 1, h)
    s20, s21, s22 = times_quaternion(S, 2, h)
    if force:
        t00, _, _ = times_block(S, 0, at.E_BA, b)
        t10, t11, _ = times_block(S, 1, at.E_BA, b)
        t20, t21, t22 = times_block(S, 2, at.E_BA, b)
        s00, s10, s11, s20, s21, s22 = s00 + t00, s10 + t10, s11 + t11, s20 + t20, s21 + t21, s22 + t22
    if own:
        o = W + reference
        s00, s10, s11 = s00 - S[o], s10 - S[o + 16], s11 - S[o + 17]
        s20, s21, s22 = s20 - S[o + 32], s21 - S[o + 33], s22 - S[o + 34]
    return s00, s10, s11, s20, s21, s22


@inlined
def _clone(S, x0, x1, x2, force, reference, place, variance):
    """The reference is what this sample says it is, with the errors of attitude and offset in it (erratum of eq 37: it is no truth).

    r = q ⊗ x ⊗ q*, so its error is h1 δq − C δb_a − C n: it takes over the covariances of both.
    """
    C = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    for i in range(3):
        S[place + i] = C[3 * i] * x0 + C[3 * i + 1] * x1 + C[3 * i + 2] * x2
    h = h1(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], x0, x1, x2)
    s00, s10, s11, s20, s21, s22 = _innovation(S, h, C, force, reference, False)
    for i in range(3):
        o = 16 * (reference + i)
        for c in range(16):
            S[o + c] = S[W + 16 * i + c]
        for r in range(16):
            S[16 * r + reference + i] = S[W + 16 * i + r]
    o = 17 * reference
    S[o], S[o + 17], S[o + 34] = s00 + variance, s11 + variance, s22 + variance
    S[o + 1] = S[o + 16] = s10
    S[o + 2] = S[o + 32] = s20
    S[o + 18] = S[o + 33] = s21


@inlined
def _gradient(S, x0, x1, x2, y0, y1, y2, turn, derivative, force, decay, variance, limit, references):
    """A static field turns in b as the sensor turns the other way: z = y − q_w* ⊗ x ⊗ q_w, MAGYQ eqs 40-46. Returns the NIS.

    x is the field of the sample before and y that of this one, both freed of their offset; `turn` and `derivative` are the places of q_w,
    the rotation in between, and its derivative to the gyroscope-quaternion offset. H = [0, h3(q_w, x) ∂q_w/∂b_q, I − C(q_w)ᵀ/decay for the
    specific force] (erratum of eq 46: the state is that of this sample). Errata of eqs 42 and 46: R also holds what the gyroscope's noise
    does to the prediction. As in the paper, the noise of x is taken for new, though it was the noise of y a sample ago.
    """
    q0, q1, q2, q3 = S[turn], S[turn + 1], S[turn + 2], S[turn + 3]
    C = matrix(q0, q1, q2, q3)
    b = times_offset(h3(q0, q1, q2, q3, x0, x1, x2), S, derivative)
    # The rotation was made with the offset that was known then.
    d0, d1, d2 = S[BQ] - S[USED_BQ], S[BQ + 1] - S[USED_BQ + 1], S[BQ + 2] - S[USED_BQ + 2]
    z0 = y0 - (C[0] * x0 + C[3] * x1 + C[6] * x2) - (b[0] * d0 + b[1] * d1 + b[2] * d2)
    z1 = y1 - (C[1] * x0 + C[4] * x1 + C[7] * x2) - (b[3] * d0 + b[4] * d1 + b[5] * d2)
    z2 = y2 - (C[2] * x0 + C[5] * x1 + C[8] * x2) - (b[6] * d0 + b[7] * d1 + b[8] * d2)
    e = 1 / decay
    a = (1 - C[0] * e, -C[3] * e, -C[6] * e, -C[1] * e, 1 - C[4] * e, -C[7] * e, -C[2] * e, -C[5] * e, 1 - C[8] * e)
    if force:
        rows_gyro_accel(S, b, a)
    else:
        rows_gyro(S, b)
    s00, _, _ = times_block(S, 0, at.E_BQ, b)
    s10, s11, _ = times_block(S, 1, at.E_BQ, b)
    s20, s21, s22 = times_block(S, 2, at.E_BQ, b)
    if force:
        t00, _, _ = times_block(S, 0, at.E_BA, a)
        t10, t11, _ = times_block(S, 1, at.E_BA, a)
        t20, t21, t22 = times_block(S, 2, at.E_BA, a)
        s00, s10, s11, s20, s21, s22 = s00 + t00, s10 + t10, s11 + t11, s20 + t20, s21 + t21, s22 + t22
    L = factor(s00 + variance, s10, s11 + variance, s20, s21, s22 + variance, z0, z1, z2)
    value = squared(L)
    if value <= limit:
        update(S, L, references)
    return value


@apart
def heading(S, m0, m1, m2, variance, limit, references):
    """Heading from the Earth's field as a scalar measurement, tilt left alone. Returns the innovation (rad) and whether it was used.

    The field turned into n is exp([psi×]) m_n, so its horizontal direction is off by nu = psi_z − (h·psi) m_z/m_h.
    """
    C = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    e = C[0] * m0 + C[1] * m1 + C[2] * m2
    n = C[3] * m0 + C[4] * m1 + C[5] * m2
    scale = 1 / math.sqrt(S[at.EARTH_E] * S[at.EARTH_E] + S[at.EARTH_N] * S[at.EARTH_N])
    he, hn, slope = S[at.EARTH_E] * scale, S[at.EARTH_N] * scale, S[at.EARTH_U] * scale
    nu = math.atan2(he * n - hn * e, he * e + hn * n)
    g0, g1 = -slope * he, -slope * hn
    a, b, c, d = rotation_rows(S)
    # nu = estimate − truth of the direction, psi likewise; the error of the state is truth − estimate and psi linear in it.
    k0, k1 = g0 * a[0] + g1 * a[1] + a[2], g0 * b[0] + g1 * b[1] + b[2]
    k2, k3 = g0 * c[0] + g1 * c[1] + c[2], g0 * d[0] + g1 * d[1] + d[2]
    for col in range(16):
        S[W + col] = k0 * S[col] + k1 * S[16 + col] + k2 * S[32 + col] + k3 * S[48 + col]
    own = k0 * S[W] + k1 * S[W + 1] + k2 * S[W + 2] + k3 * S[W + 3]
    i = 1 / math.sqrt(own + variance)
    used = nu * nu <= limit * (own + variance)
    if used:
        update_scalar(S, nu * i, i, references)
    return nu, used


@apart
def measure_force(S, x0, x1, x2, r0, r1, r2, own, variance, limit, references):
    """`_measure` of the specific force."""
    return _measure(S, x0, x1, x2, r0, r1, r2, True, at.E_F, own, variance, limit, references)


@apart
def measure_field(S, x0, x1, x2, r0, r1, r2, own, variance, limit, references):
    """`_measure` of the magnetic field."""
    return _measure(S, x0, x1, x2, r0, r1, r2, False, at.E_M, own, variance, limit, references)


@apart
def clone_force(S, x0, x1, x2, variance):
    """`_clone` of the specific force."""
    _clone(S, x0, x1, x2, True, at.E_F, FREF, variance)


@apart
def clone_field(S, x0, x1, x2, variance):
    """`_clone` of the magnetic field."""
    _clone(S, x0, x1, x2, False, at.E_M, MREF, variance)


@apart
def gradient_force(S, x0, x1, x2, y0, y1, y2, decay, variance, limit, references):
    """AGU, MAGYQ eqs 44-46: from sample to sample."""
    return _gradient(S, x0, x1, x2, y0, y1, y2, STEP, STEP_BQ, True, decay, variance, limit, references)


@apart
def gradient_field(S, x0, x1, x2, y0, y1, y2, variance, limit, references):
    """MARU, MAGYQ eqs 40-43: from one magnetometer sample to the next, however many of the gyroscope lie between."""
    return _gradient(S, x0, x1, x2, y0, y1, y2, TURN, TURN_BQ, False, 1.0, variance, limit, references)
