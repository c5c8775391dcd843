"""What a foot on the ground says beside its velocity: angular rate (ZARU), heading (HDR), rotation of the field (MARU)."""

import math

from bematist.kernels.error_state import feed_back, row_measurement, vector_measurement
from bematist.kernels.jit import apart, inlined
from bematist.kernels.layout import (
    BG,
    FIELD_AT,
    FIELD_BIAS,
    FIELD_KNOWN,
    FIELD_S,
    HDR_AFTER_S,
    HDR_APART_S,
    HDR_AXIS,
    HDR_INNOVATION,
    HDR_LONGEST_S,
    HDR_OFF,
    HDR_STANCE,
    HDR_TOLERANCE,
    HDR_USE,
    HDR_VARIANCE,
    MARU_GATE,
    MARU_INTERVAL_S,
    MARU_NIS,
    MARU_NORM_TOLERANCE,
    MARU_USE,
    MARU_VARIANCE,
    QUIET_S,
    ROW,
    STANCE_S,
    STANCES,
    SWING_S,
    YAW_BEFORE,
    YAW_COUNT,
    YAW_FIRST,
    YAW_LAST,
    YAW_SUM,
    YAW_USED,
    ZARU_AFTER_S,
    ZARU_NIS,
    ZARU_RATE,
    ZARU_USE,
    ZARU_VARIANCE,
    Q,
)
from bematist.kernels.rotation import exp_quaternion, matrix
from bematist.kernels.stance import MEASURED


@apart
def constrain(S, prm, dt, standing, gap, diag, k):
    """All constraints on the sample in S[ROW:], dt seconds after the one before; a gap ends what they remember."""
    if gap:
        S[QUIET_S] = S[STANCES] = S[YAW_COUNT] = S[FIELD_KNOWN] = 0.0
    if prm[ZARU_USE] > 0:
        zero_angular_rate(S, prm, dt, standing, diag, k)
    if prm[HDR_USE] != HDR_OFF:
        heading_reduction(S, prm, dt, standing, diag, k)
    if prm[MARU_USE] > 0:
        magnetic_rate(S, prm, dt, standing, diag, k)


@inlined
def zero_angular_rate(S, prm, dt, standing, diag, k):
    """ZARU, Jiménez et al. 2010 (Li & Wang section 4.2): the angular rate of a foot at rest is zero, z = ω̃ - b_g = δb_g + noise.

    Erratum: a standing foot rocks, so it is not enough to stand; the rate must have been small for a while. With δb_g as what is still
    to be subtracted H is +I.
    """
    z0, z1, z2 = S[ROW + 4] - S[BG], S[ROW + 5] - S[BG + 1], S[ROW + 6] - S[BG + 2]
    if z0 * z0 + z1 * z1 + z2 * z2 > prm[ZARU_RATE] * prm[ZARU_RATE]:
        S[QUIET_S] = 0.0
    else:
        S[QUIET_S] += dt
    if standing and S[QUIET_S] >= prm[ZARU_AFTER_S] and S[ROW + 10] == MEASURED:
        diag[k, ZARU_NIS] = vector_measurement(S, 12, z0, z1, z2, 0.0, 0.0, 0.0, prm[ZARU_VARIANCE])
        feed_back(S, True)


@inlined
def wrapped(angle):
    """An angle in rad, turned to within ±π."""
    return angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)


@inlined
def yaw_row(q0, q1, q2, q3, axis):
    """Yaw of a body axis (0: x, 1: y) with attitude q, and its derivative by the error psi (the third component of it is 1).

    The axis d points along exp([psi x]) d, so its yaw is off by psi_z - d_z (d_x psi_x + d_y psi_y) / (d_x² + d_y²): Jiménez' row
    [-C31 C11, -C31 C21, C11² + C21²] / (C11² + C21²).
    """
    C0, C1, _, C3, C4, _, C6, C7, _ = matrix(q0, q1, q2, q3)
    x, y, z = (C0, C3, C6) if axis == 0 else (C1, C4, C7)
    s = -z / (x * x + y * y)
    return math.atan2(y, x), s * x, s * y


@inlined
def heading_reduction(S, prm, dt, standing, diag, k):
    """HDR, Jiménez et al. 2010 (Li & Wang section 4.2; erratum: its numbers): who walks straight has the heading of his last two stances.

    z = ψ - ½(ψ₋₁ + ψ₋₂) = h·psi + noise, with the mean yaws of the two stances before, where |z| is small. Once in a stance, with the
    mean yaw of the stance so far, or at every sample of its beginning.
    """
    if not standing:
        S[SWING_S] += dt
        return
    yaw, h0, h1 = yaw_row(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], prm[HDR_AXIS])
    if S[YAW_COUNT] == 0 or S[SWING_S] > prm[HDR_APART_S]:
        if S[YAW_COUNT] > 0 and S[STANCE_S] >= prm[HDR_AFTER_S]:
            S[YAW_BEFORE] = S[YAW_LAST]
            S[YAW_LAST] = S[YAW_FIRST] + S[YAW_SUM] / S[YAW_COUNT]
            S[STANCES] += 1
        S[YAW_FIRST] = yaw
        S[YAW_SUM] = S[YAW_COUNT] = S[STANCE_S] = S[YAW_USED] = 0.0
    else:
        S[STANCE_S] += S[SWING_S] + dt
    S[SWING_S] = 0.0
    S[YAW_SUM] += wrapped(yaw - S[YAW_FIRST])
    S[YAW_COUNT] += 1
    if S[STANCES] < 2 or S[STANCE_S] < prm[HDR_AFTER_S] or S[STANCE_S] > prm[HDR_LONGEST_S]:
        return
    if prm[HDR_USE] == HDR_STANCE:
        if S[YAW_USED] > 0:
            return
        S[YAW_USED] = 1.0
        yaw = S[YAW_FIRST] + S[YAW_SUM] / S[YAW_COUNT]
    z = wrapped(yaw - S[YAW_LAST] - 0.5 * wrapped(S[YAW_BEFORE] - S[YAW_LAST]))
    diag[k, HDR_INNOVATION] = z
    if abs(z) <= prm[HDR_TOLERANCE]:
        row_measurement(S, 0, h0, h1, 1.0, z, prm[HDR_VARIANCE], math.inf)
        feed_back(S, True)


@inlined
def magnetic_rate(S, prm, dt, standing, diag, k):
    """MARU, Li & Wang's reference 22, MAGYQ eqs 40-43: a constant field seen from a turning sensor tells how fast it turns.

    The field seen at the start of an interval, turned on by the gyroscope, is compared with the one at its end. Within one stance, where
    the sensor keeps its place and a disturbed field is as good as any other. Successive samples share their noise (erratum of eq 42), so
    that an interval of many of them says more than as many steps.
    """
    if S[FIELD_KNOWN] > 0:
        w0, w1, w2 = S[ROW + 4] - S[FIELD_BIAS], S[ROW + 5] - S[FIELD_BIAS + 1], S[ROW + 6] - S[FIELD_BIAS + 2]
        w, x, y, z = exp_quaternion(-w0 * dt, -w1 * dt, -w2 * dt)
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
        p0, p1, p2 = S[FIELD_AT], S[FIELD_AT + 1], S[FIELD_AT + 2]
        S[FIELD_AT] = C0 * p0 + C1 * p1 + C2 * p2
        S[FIELD_AT + 1] = C3 * p0 + C4 * p1 + C5 * p2
        S[FIELD_AT + 2] = C6 * p0 + C7 * p1 + C8 * p2
        S[FIELD_S] += dt
    if not standing:
        S[FIELD_KNOWN] = 0.0
        return
    m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
    if not math.isfinite(m0 + m1 + m2):
        return
    if S[FIELD_KNOWN] == 0:
        keep_field(S)
    elif S[FIELD_S] >= prm[MARU_INTERVAL_S]:
        compare_field(S, prm, m0, m1, m2, diag, k)
        keep_field(S)


@inlined
def keep_field(S):
    """An interval begins with the field in S[ROW:]."""
    for i in range(3):
        S[FIELD_AT + i] = S[ROW + 7 + i]
        S[FIELD_BIAS + i] = S[BG + i]
    S[FIELD_S] = 0.0
    S[FIELD_KNOWN] = 1.0


@inlined
def compare_field(S, prm, m0, m1, m2, diag, k):
    """Measure δb_g by z = m̂ - m = T [m x] δb_g + noise, where norm and innovation pass.

    m̂ was turned on with the offset at the start of the interval; what changed of it since is taken into z. To first order in the angle
    turned in the interval. Three scalar measurements, one after the other, of noise as if the two samples were this pair's alone.
    """
    T = S[FIELD_S]
    p0, p1, p2 = S[FIELD_AT], S[FIELD_AT + 1], S[FIELD_AT + 2]
    mm, pp = m0 * m0 + m1 * m1 + m2 * m2, p0 * p0 + p1 * p1 + p2 * p2
    if abs(math.sqrt(mm) - math.sqrt(pp)) > prm[MARU_NORM_TOLERANCE] * math.sqrt(pp):
        return
    t0, t1, t2 = T * m0, T * m1, T * m2
    d0, d1, d2 = S[FIELD_BIAS] - S[BG], S[FIELD_BIAS + 1] - S[BG + 1], S[FIELD_BIAS + 2] - S[BG + 2]
    z0, z1, z2 = p0 - m0 + t1 * d2 - t2 * d1, p1 - m1 + t2 * d0 - t0 * d2, p2 - m2 + t0 * d1 - t1 * d0
    # The trace of [t x] P [t x]ᵀ, of the block of b_g: how large |z|² is to be expected.
    quadratic = t0 * t0 * S[204] + t1 * t1 * S[221] + t2 * t2 * S[238] + 2 * (t0 * t1 * S[205] + t0 * t2 * S[206] + t1 * t2 * S[222])
    expected = T * T * mm * (S[204] + S[221] + S[238]) - quadratic + 3 * prm[MARU_VARIANCE]
    nis = 3 * (z0 * z0 + z1 * z1 + z2 * z2) / expected
    diag[k, MARU_NIS] = nis
    if nis > 3 * prm[MARU_GATE] * prm[MARU_GATE]:
        return
    b0, b1, b2 = S[BG], S[BG + 1], S[BG + 2]
    row_measurement(S, 12, 0.0, -t2, t1, z0, prm[MARU_VARIANCE], math.inf)
    feed_back(S, True)
    row_measurement(S, 12, t2, 0.0, -t0, z1 + t2 * (b0 - S[BG]) - t0 * (b2 - S[BG + 2]), prm[MARU_VARIANCE], math.inf)
    feed_back(S, True)
    row_measurement(S, 12, -t1, t0, 0.0, z2 + t0 * (b1 - S[BG + 1]) - t1 * (b0 - S[BG]), prm[MARU_VARIANCE], math.inf)
    feed_back(S, True)
