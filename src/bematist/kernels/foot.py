"""The foot-mounted filter: strapdown, error-state covariance and measurement updates, one sample at a time.

Error state, in this order (MAGINAV eq 18): attitude psi (rotation vector in n, C_est = exp([psi x]) C_true), velocity and position as
estimate − truth; accelerometer and gyroscope offset as what is still to be subtracted from the measurement. Closed loop: after every
update the error is fed back and is zero again. ENU, so gravity is (0, 0, -g) (MAGINAV eq 15 is NED).

Everything lives in one flat workspace `S` with constant offsets; the covariance is 15 rows of 16 (the last column is padding, zero).
"""

import math

from bematist.kernels import stance
from bematist.kernels.jit import inlined, kernel
from bematist.kernels.rotation import exp_quaternion, matrix, multiply, normalise

# workspace S
P, M, W, E, Q, V, X, BA, BG = 0, 240, 384, 432, 448, 452, 455, 458, 461
TIME, STARTED, RATE, ROW = 464, 465, 466, 472
WORKSPACE_SIZE = 488

# parameters prm
(
    G,
    PSD_ATTITUDE,
    PSD_VELOCITY,
    PSD_ACCEL_BIAS,
    PSD_GYRO_BIAS,
    WEIGHT_A,
    WEIGHT_G,
    THRESHOLD,
    ZERO_VELOCITY_SD,
    FLOOR,
    RATIO,
    GAP_S,
    GAP_RATE,
    GAP_SPEED,
    GAP_BALLISTIC_S,
    MAGNETIC_USE,
    FIELD_NORM,
    NORM_TOLERANCE,
    FIELD_INCLINATION,
    INCLINATION_TOLERANCE,
    FIELD_E,
    FIELD_N,
    FIELD_U,
    TILT_SD,
    DIRECTION_SD,
    HEADING_SD,
    HEADING_GATE,
) = range(27)
PARAMETERS = 27

MAGNETIC_OFF, MAGNETIC_RESET, MAGNETIC_HEADING = 0.0, 1.0, 2.0

# columns of the result: t p v q, then packed covariances of position, velocity, attitude
NAV = 29
# columns of the diagnostics
(
    STATISTIC,
    LIMIT,
    ZV_SD,
    INNOVATION,
    _,
    _,
    NIS,
    NORM,
    INCLINATION,
    GATE,
    STATE,
    BRIDGED,
    GYRO_BIAS,
    _,
    _,
    GYRO_BIAS_SD,
    _,
    _,
    ACCEL_BIAS,
    _,
    _,
    ACCEL_BIAS_SD,
    _,
    _,
) = range(24)
DIAG = 24

# verdicts of the magnetic gates
NO_SAMPLE, NORM_REFUSED, INCLINATION_REFUSED, INNOVATION_REFUSED, USED, PASSED = range(6)

# what a result owes to a gap, after the flags of a row
BRIDGED_OVER = 3.0


@inlined
def propagate_covariance(S, D0, D1, D2, D3, D4, D5, D6, D7, D8, F0, F1, F2, dt, qa, qv, qf, qg):
    """P ← Φ P Φᵀ + Q, MAGINAV eqs 19, 20, 23, with D = C_nb dt and F = f_n dt.

    Φ = I + {psi←b_g: D, v←psi: -[F x], v←b_a: D, p←v: dt I}. Erratum of eq 23: Q = PSD·dt, in (rad/s)²/Hz and so on. Only the upper
    triangle of Φ P Φᵀ is computed and then mirrored, so that P stays symmetric to the last bit.
    """
    for c in range(16):
        a0, a1, a2 = S[c], S[16 + c], S[32 + c]
        v0, v1, v2 = S[48 + c], S[64 + c], S[80 + c]
        b0, b1, b2 = S[144 + c], S[160 + c], S[176 + c]
        g0, g1, g2 = S[192 + c], S[208 + c], S[224 + c]
        S[M + c] = a0 + D0 * g0 + D1 * g1 + D2 * g2
        S[M + 16 + c] = a1 + D3 * g0 + D4 * g1 + D5 * g2
        S[M + 32 + c] = a2 + D6 * g0 + D7 * g1 + D8 * g2
        S[M + 48 + c] = v0 + F2 * a1 - F1 * a2 + D0 * b0 + D1 * b1 + D2 * b2
        S[M + 64 + c] = v1 - F2 * a0 + F0 * a2 + D3 * b0 + D4 * b1 + D5 * b2
        S[M + 80 + c] = v2 + F1 * a0 - F0 * a1 + D6 * b0 + D7 * b1 + D8 * b2
        S[M + 96 + c] = S[96 + c] + dt * v0
        S[M + 112 + c] = S[112 + c] + dt * v1
        S[M + 128 + c] = S[128 + c] + dt * v2
    for r in range(9):
        m = M + 16 * r
        o = 16 * r
        a0, a1, a2 = S[m], S[m + 1], S[m + 2]
        v0, v1, v2 = S[m + 3], S[m + 4], S[m + 5]
        b0, b1, b2 = S[m + 9], S[m + 10], S[m + 11]
        g0, g1, g2 = S[m + 12], S[m + 13], S[m + 14]
        if r < 3:
            S[o] = a0 + D0 * g0 + D1 * g1 + D2 * g2
            S[o + 1] = a1 + D3 * g0 + D4 * g1 + D5 * g2
            S[o + 2] = a2 + D6 * g0 + D7 * g1 + D8 * g2
        if r < 6:
            S[o + 3] = v0 + F2 * a1 - F1 * a2 + D0 * b0 + D1 * b1 + D2 * b2
            S[o + 4] = v1 - F2 * a0 + F0 * a2 + D3 * b0 + D4 * b1 + D5 * b2
            S[o + 5] = v2 + F1 * a0 - F0 * a1 + D6 * b0 + D7 * b1 + D8 * b2
        S[o + 6], S[o + 7], S[o + 8] = S[m + 6] + dt * v0, S[m + 7] + dt * v1, S[m + 8] + dt * v2
        S[o + 9], S[o + 10], S[o + 11], S[o + 12], S[o + 13], S[o + 14] = b0, b1, b2, g0, g1, g2
    for r in range(9):
        for c in range(r + 1, 15):
            S[16 * c + r] = S[16 * r + c]
    for i in range(3):
        S[17 * i] += qa
        S[17 * (3 + i)] += qv
        S[17 * (9 + i)] += qf
        S[17 * (12 + i)] += qg


@inlined
def feed_back(S, attitude):
    """Take the estimated error E out of the state (MAGINAV eq 12 state 2, with δC = exp(-[psi x]), erratum of eq 25)."""
    if attitude:
        rw, rx, ry, rz = exp_quaternion(-S[E], -S[E + 1], -S[E + 2])
        w, x, y, z = multiply(rw, rx, ry, rz, S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(w, x, y, z)
    for i in range(6):
        S[V + i] -= S[E + 3 + i]
    for i in range(6):
        S[BA + i] += S[E + 9 + i]


@inlined
def zero_velocity(S, variance):
    """Estimate the error E from z = v - 0 (MAGINAV eqs 21, 22, 24; erratum: H is 3x15) and update P. Returns the NIS.

    With S = H P Hᵀ + R = L Lᵀ and W = P Hᵀ L⁻ᵀ: P ← P - W Wᵀ, which is symmetric by construction, and E = W L⁻¹ z.
    """
    l00 = math.sqrt(S[51] + variance)
    i0 = 1 / l00
    l10 = S[67] * i0
    l20 = S[83] * i0
    i1 = 1 / math.sqrt(S[68] + variance - l10 * l10)
    l21 = (S[84] - l20 * l10) * i1
    i2 = 1 / math.sqrt(S[85] + variance - l20 * l20 - l21 * l21)
    y0 = S[V] * i0
    y1 = (S[V + 1] - l10 * y0) * i1
    y2 = (S[V + 2] - l20 * y0 - l21 * y1) * i2
    for c in range(16):
        a = S[48 + c] * i0
        b = (S[64 + c] - l10 * a) * i1
        g = (S[80 + c] - l20 * a - l21 * b) * i2
        S[W + c], S[W + 16 + c], S[W + 32 + c] = a, b, g
        S[E + c] = a * y0 + b * y1 + g * y2
    for r in range(15):
        a, b, g = S[W + r], S[W + 16 + r], S[W + 32 + r]
        for c in range(16):
            S[16 * r + c] -= a * S[W + c] + b * S[W + 16 + c] + g * S[W + 32 + c]
    return y0 * y0 + y1 * y1 + y2 * y2


@inlined
def attitude_measurement(S, h0, h1, h2, nu, variance, gate):
    """One scalar measurement nu = h·psi + noise: update P and estimate E unless nu²/S exceeds `gate`. True when used."""
    s = variance
    for c in range(16):
        S[W + c] = h0 * S[c] + h1 * S[16 + c] + h2 * S[32 + c]
    s += h0 * S[W] + h1 * S[W + 1] + h2 * S[W + 2]
    if nu * nu > gate * s:
        return False
    i = 1 / math.sqrt(s)
    for c in range(16):
        S[W + c] *= i
        S[E + c] = S[W + c] * (nu * i)
    for r in range(15):
        a = S[W + r]
        for c in range(16):
            S[16 * r + c] -= a * S[W + c]
    return True


@inlined
def forget_attitude(S, prm):
    """The attitude was replaced: its cross-covariances are void and its covariance is that of TRIAD (erratum of Table 2).

    First-order errors of TRIAD with up exact in the first vector: tilt from the accelerometer, yaw from the transverse field and from
    tilt through the dip, psi_z = ((h·psi) m_z - t·e_m) / m_h with h the horizontal direction of the field and t across it.
    """
    horizontal = math.sqrt(prm[FIELD_E] * prm[FIELD_E] + prm[FIELD_N] * prm[FIELD_N])
    slope = prm[FIELD_U] / horizontal
    he, hn = prm[FIELD_E] / horizontal, prm[FIELD_N] / horizontal
    tilt = prm[TILT_SD] * prm[TILT_SD]
    for r in range(3):
        for c in range(15):
            S[16 * r + c] = 0.0
            S[16 * c + r] = 0.0
    S[0] = tilt
    S[17] = tilt
    S[34] = slope * slope * tilt + prm[DIRECTION_SD] * prm[DIRECTION_SD]
    S[2] = S[32] = slope * he * tilt
    S[18] = S[33] = slope * hn * tilt


@inlined
def triad(f0, f1, f2, m0, m1, m2, e, n):
    """Quaternion of C_nb from up (specific force) and the field, whose horizontal direction in n is (e, n)/|.|.

    MAGINAV eqs 10, 11 and Appendix A. Erratum of eq 11: C(0) TRIAD(f0, m0, fk, mk)ᵀ; since C(0) f0 is up and C(0) m0 the field at
    the start, that is the rotation of (f, m) onto (up, field). Erratum of eq 10: unit vectors. The accelerometer's offset is in f0 and
    therefore stays in fk.
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
def bridge(S, prm, dt, w0, w1, w2):
    """Cross a gap of dt seconds in which nothing was measured: a short one ballistically, a long one standing still, both in doubt."""
    short = min(dt, prm[GAP_BALLISTIC_S])
    speed2 = prm[GAP_SPEED] * prm[GAP_SPEED]
    for i in range(3):
        S[X + i] += S[V + i] * short
        S[17 * (6 + i)] += speed2 * dt * dt
    if dt <= prm[GAP_BALLISTIC_S]:
        h = 0.25 * dt
        r = exp_quaternion(h * (S[RATE] + w0) * 2, h * (S[RATE + 1] + w1) * 2, h * (S[RATE + 2] + w2) * 2)
        w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], r[0], r[1], r[2], r[3])
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(w, x, y, z)
    else:
        S[V] = S[V + 1] = S[V + 2] = 0.0
    angle = min(prm[GAP_RATE] * dt, 0.5)
    for r in range(3):
        for c in range(15):
            S[16 * (3 + r) + c] = 0.0
            S[16 * c + 3 + r] = 0.0
    for i in range(3):
        S[17 * i] += angle * angle
        S[17 * (3 + i)] = speed2


@inlined
def magnetic_gate(S, prm, C6, C7, C8, diag, k):
    """Gates of the magnetometer sample of a row, if there is one; (C6, C7, C8) is up in b.

    Norm: MAGINAV eqs 4, 5, with a relative tolerance. Inclination: a field that was turned keeps its norm.
    """
    m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
    norm = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
    if not norm >= 0:
        return NO_SAMPLE
    inclination = -math.asin(min(1.0, max(-1.0, (C6 * m0 + C7 * m1 + C8 * m2) / norm))) if norm > 0 else 0.0
    diag[k, NORM] = norm
    diag[k, INCLINATION] = inclination
    if abs(norm - prm[FIELD_NORM]) > prm[NORM_TOLERANCE] * prm[FIELD_NORM]:
        return NORM_REFUSED
    if abs(inclination - prm[FIELD_INCLINATION]) > prm[INCLINATION_TOLERANCE]:
        return INCLINATION_REFUSED
    return PASSED


@inlined
def elapse(S, prm):
    """Time from the last sample to the one in S[ROW:], s; a gap is bridged here and counts as 0 afterwards. Also what was done."""
    t = S[ROW]
    dt = t - S[TIME]
    what = S[ROW + 10]
    if S[STARTED] == 0:
        dt = 0.0
    elif dt > prm[GAP_S]:
        bridge(S, prm, dt, S[ROW + 4] - S[BG], S[ROW + 5] - S[BG + 1], S[ROW + 6] - S[BG + 2])
        dt = 0.0
        what = BRIDGED_OVER
    S[TIME] = t
    S[STARTED] = 1.0
    return dt, what


@inlined
def predict(S, prm, dt, standing, diag, k):
    """Attitude, velocity, position and covariance over dt seconds, up to the sample in S[ROW:]. True where TRIAD set the attitude."""
    f0, f1, f2 = S[ROW + 1] - S[BA], S[ROW + 2] - S[BA + 1], S[ROW + 3] - S[BA + 2]
    w0, w1, w2 = S[ROW + 4] - S[BG], S[ROW + 5] - S[BG + 1], S[ROW + 6] - S[BG + 2]
    S[RATE], S[RATE + 1], S[RATE + 2] = w0, w1, w2
    h = 0.5 * dt
    rw, rx, ry, rz = exp_quaternion(h * w0, h * w1, h * w2)
    w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], rw, rx, ry, rz)
    # The specific force is turned by the attitude at the middle of the interval (erratum of eq 14: the end is half a sample late).
    C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
    w, x, y, z = multiply(w, x, y, z, rw, rx, ry, rz)
    S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(w, x, y, z)

    gate = magnetic_gate(S, prm, C6, C7, C8, diag, k)
    reset = gate == PASSED and standing and prm[MAGNETIC_USE] == MAGNETIC_RESET
    if reset:
        # State 3, MAGINAV eqs 12, 13: the attitude is TRIAD's, from here on and for this sample's specific force.
        c = triad(S[ROW + 1], S[ROW + 2], S[ROW + 3], S[ROW + 7], S[ROW + 8], S[ROW + 9], prm[FIELD_E], prm[FIELD_N])
        w, x, y, z = quaternion(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8])
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = w, x, y, z
        w, x, y, z = multiply(w, x, y, z, rw, -rx, -ry, -rz)
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
        forget_attitude(S, prm)
        gate = USED
    diag[k, GATE] = gate
    if dt > 0:
        n0 = (C0 * f0 + C1 * f1 + C2 * f2) * dt
        n1 = (C3 * f0 + C4 * f1 + C5 * f2) * dt
        n2 = (C6 * f0 + C7 * f1 + C8 * f2) * dt
        integrate(S, n0, n1, n2 - prm[G] * dt, h)
        propagate_covariance(
            S,
            *(C0 * dt, C1 * dt, C2 * dt, C3 * dt, C4 * dt, C5 * dt, C6 * dt, C7 * dt, C8 * dt),
            *(n0, n1, n2, dt),
            *(prm[PSD_ATTITUDE] * dt, prm[PSD_VELOCITY] * dt, prm[PSD_ACCEL_BIAS] * dt, prm[PSD_GYRO_BIAS] * dt),
        )
    return reset


@inlined
def integrate(S, a0, a1, a2, h):
    """Velocity by its change (a0, a1, a2) and position by the trapezium over 2h seconds.

    MAGINAV eqs 15-17, from the corrected velocity and position of the step before (erratum: closed loop).
    """
    v0, v1, v2 = S[V], S[V + 1], S[V + 2]
    S[V] = v0 + a0
    S[V + 1] = v1 + a1
    S[V + 2] = v2 + a2
    S[X] += h * (v0 + S[V])
    S[X + 1] += h * (v1 + S[V + 1])
    S[X + 2] += h * (v2 + S[V + 2])


@inlined
def correct(S, prm, sd, reset, diag, k):
    """The updates of a sample in stance, states 2 and 3 of MAGINAV Table 2."""
    for i in range(3):
        diag[k, INNOVATION + i] = -S[V + i]
    diag[k, NIS] = zero_velocity(S, sd * sd)
    diag[k, ZV_SD] = sd
    diag[k, STATE] = 3.0 if reset else 2.0
    feed_back(S, not reset)
    if reset:
        # The attitude stays TRIAD's (eq 12), so what the update said of it is undone.
        forget_attitude(S, prm)
    elif diag[k, GATE] == PASSED and prm[MAGNETIC_USE] == MAGNETIC_HEADING:
        diag[k, GATE] = magnetic_heading(S, prm, S[ROW + 7], S[ROW + 8], S[ROW + 9])


@inlined
def navigate(S, prm, statistic, limit, sd, nav, diag, k):
    """One sample, in S[ROW:], with its stance verdict: predict, correct, and write row k of the results."""
    for c in range(DIAG):
        diag[k, c] = math.nan
    diag[k, STATISTIC] = statistic
    diag[k, LIMIT] = limit
    diag[k, STATE] = 1.0
    diag[k, GATE] = NO_SAMPLE
    diag[k, BRIDGED] = S[ROW + 10]
    if S[ROW + 10] < stance.MISSING:
        dt, diag[k, BRIDGED] = elapse(S, prm)
        reset = predict(S, prm, dt, sd > 0, diag, k)
        if sd > 0:
            correct(S, prm, sd, reset, diag, k)
    write(S, S[ROW], nav, diag, k)


@inlined
def write(S, t, nav, diag, k):
    """Row k of the results: state and covariances."""
    nav[k, 0] = t
    for i in range(3):
        nav[k, 1 + i] = S[X + i]
        nav[k, 4 + i] = S[V + i]
    for i in range(4):
        nav[k, 7 + i] = S[Q + i]
    write_block(S, 17 * 6, nav, k, 11)
    write_block(S, 17 * 3, nav, k, 17)
    write_block(S, 0, nav, k, 23)
    for i in range(3):
        diag[k, GYRO_BIAS + i] = S[BG + i]
        diag[k, ACCEL_BIAS + i] = S[BA + i]
        diag[k, GYRO_BIAS_SD + i] = math.sqrt(S[17 * (12 + i)])
        diag[k, ACCEL_BIAS_SD + i] = math.sqrt(S[17 * (9 + i)])


@inlined
def magnetic_heading(S, prm, m0, m1, m2):
    """Heading from the field as a scalar measurement, with tilt from the filter; returns the gate's verdict.

    The field turned into n by the estimate is exp([psi x]) m_n, so its horizontal direction is off by
    psi_z - (h·psi) m_z/m_h, with h the direction of the horizontal field.
    """
    C0, C1, C2, C3, C4, C5, _, _, _ = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    e = C0 * m0 + C1 * m1 + C2 * m2
    n = C3 * m0 + C4 * m1 + C5 * m2
    horizontal = math.sqrt(prm[FIELD_E] * prm[FIELD_E] + prm[FIELD_N] * prm[FIELD_N])
    he, hn = prm[FIELD_E] / horizontal, prm[FIELD_N] / horizontal
    slope = prm[FIELD_U] / horizontal
    nu = math.atan2(he * n - hn * e, he * e + hn * n)
    variance = prm[HEADING_SD] * prm[HEADING_SD]
    if attitude_measurement(S, -slope * he, -slope * hn, 1.0, nu, variance, prm[HEADING_GATE]):
        feed_back(S, True)
        return USED
    return INNOVATION_REFUSED


@inlined
def write_block(S, o, nav, k, j):
    """Packed upper triangle of the 3x3 block of P whose first entry is S[o]."""
    nav[k, j], nav[k, j + 1], nav[k, j + 2] = S[o], S[o + 1], S[o + 2]
    nav[k, j + 3], nav[k, j + 4], nav[k, j + 5] = S[o + 17], S[o + 18], S[o + 34]


@inlined
def load(index, memory, rows, flags, start, j, S):
    """Copy sample j (in the caller's rows from `start` on, in the ring before) to S[ROW:]."""
    if j < start:
        r = index[stance.ROWS] + stance.ROW * (j & index[stance.MASK])
        for c in range(11):
            S[ROW + c] = memory[r + c]
    else:
        for c in range(10):
            S[ROW + c] = rows[j - start, c]
        S[ROW + 10] = stance.MEASURED if flags.shape[0] == 0 else flags[j - start]


@kernel
def run(index, memory, S, prm, rows, flags, finish, T, nav, diag):
    """Filter sample rows (n,10); write results of the samples whose verdict is known. Returns how many rows were written.

    One row or a million: the same compiled code, so that chunks of any size give the same bits. rows must be complete, or come with the
    flags that `stance.fill` gave; else nothing is done and -1 returned. `finish`: no more will come, and what still waits for its window
    is written too; nav and diag need n + latency rows then, n otherwise. T is scratch, see `stance.statistics`.
    """
    if flags.shape[0] == 0 and not stance.complete(rows):
        return -1
    start = index[stance.COUNT]
    first = stance.origin(index)
    known = stance.statistics(index, memory, rows, flags, finish, prm[WEIGHT_A], prm[WEIGHT_G], prm[G], T)
    judged = index[stance.JUDGED]
    last = known if finish else known - index[stance.LOOKAHEAD]
    for j in range(judged, last):
        statistic, limit, sd = stance.verdict(
            index, memory, T, first, j, known, prm[THRESHOLD], prm[ZERO_VELOCITY_SD], prm[FLOOR], prm[RATIO]
        )
        load(index, memory, rows, flags, start, j, S)
        navigate(S, prm, statistic, limit, sd, nav, diag, j - judged)
    index[stance.JUDGED] = max(judged, last)
    stance.keep(index, memory, rows, flags)
    return index[stance.JUDGED] - judged
