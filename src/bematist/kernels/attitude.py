"""The attitude filters over samples: state, one step, and the loop over it."""

import math

from bematist.kernels.ahrs import LONGEST_PULL_S, first_order, madgwick_direction, mahony_error
from bematist.kernels.jit import inlined, kernel
from bematist.kernels.rotation import exp_quaternion, multiply, normalise

# state S
Q, BIAS, RATE, TIME, RATE_TIME, STARTED, FIELD_TIME = 0, 4, 7, 10, 11, 12, 13
STATE_SIZE = 14

# parameters prm
FILTER, GAIN, BIAS_GAIN, EXACT, MAGNETOMETER, NORTH_E, NORTH_N, GAP_S, GAP_BALLISTIC_S = range(9)
PARAMETERS = 9
GYRO, MAHONY, MADGWICK = 0.0, 1.0, 2.0

# columns of the result: attitude, gyroscope offset, what became of the sample
BIAS_OUT, FLAG = 4, 7
OUT = 8
MEASURED, HELD, MISSING, BRIDGED = 0.0, 1.0, 2.0, 3.0


@inlined
def turn(q0, q1, q2, q3, w0, w1, w2, dt, exact):
    """The attitude after turning at w for dt seconds, exactly or to first order; the latter is not yet normalised."""
    if exact:
        r0, r1, r2, r3 = exp_quaternion(w0 * dt, w1 * dt, w2 * dt)
        return multiply(q0, q1, q2, q3, r0, r1, r2, r3)
    return first_order(q0, q1, q2, q3, w0, w1, w2, dt)


@inlined
def mahony(q0, q1, q2, q3, b0, b1, b2, w0, w1, w2, f0, f1, f2, m0, m1, m2, dt, held, prm, exact):
    """Attitude and gyroscope offset after one sample: Li & Wang eqs 29-34, with the offset b = -Ki ∫ e dt.

    A magnetometer slower than the gyroscope has a sample in few rows: it pulls for the `held` seconds since the one before, so that its
    strength does not depend on its rate. With a sample in every row that is the printed form.
    """
    e, n = prm[NORTH_E], prm[NORTH_N]
    if held == dt:
        e0, e1, e2 = mahony_error(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, e, n)
    else:
        share = held / dt if dt > 0 else 0.0
        e0, e1, e2 = mahony_error(q0, q1, q2, q3, f0, f1, f2, 0.0, 0.0, 0.0, e, n)
        d0, d1, d2 = mahony_error(q0, q1, q2, q3, 0.0, 0.0, 0.0, m0, m1, m2, e, n)
        e0, e1, e2 = e0 + share * d0, e1 + share * d1, e2 + share * d2
    ki, kp = prm[BIAS_GAIN] * dt, prm[GAIN]
    b0, b1, b2 = b0 - ki * e0, b1 - ki * e1, b2 - ki * e2
    q0, q1, q2, q3 = turn(q0, q1, q2, q3, w0 - b0 + kp * e0, w1 - b1 + kp * e1, w2 - b2 + kp * e2, dt, exact)
    return q0, q1, q2, q3, b0, b1, b2


@inlined
def madgwick(q0, q1, q2, q3, b0, b1, b2, w0, w1, w2, f0, f1, f2, m0, m1, m2, dt, prm, exact):
    """Attitude and gyroscope offset after one sample: Li & Wang eqs 24-28.

    The offset is Madgwick's (2010, eqs 47-49), which the paper leaves out: b = ζ ∫ 2 q* ⊗ d dt with the unit gradient d.
    """
    d0, d1, d2, d3 = madgwick_direction(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, prm[NORTH_E], prm[NORTH_N])
    if prm[BIAS_GAIN] > 0:
        _, x, y, z = multiply(q0, -q1, -q2, -q3, d0, d1, d2, d3)
        zeta = 2 * prm[BIAS_GAIN] * dt
        b0, b1, b2 = b0 + zeta * x, b1 + zeta * y, b2 + zeta * z
    step = prm[GAIN] * dt
    q0, q1, q2, q3 = turn(q0, q1, q2, q3, w0 - b0, w1 - b1, w2 - b2, dt, exact)
    return q0 - step * d0, q1 - step * d1, q2 - step * d2, q3 - step * d3, b0, b1, b2


@kernel
def run(S, prm, columns, out):
    """Filter samples, columns (10,n); row k of out (n,8) is what is known after sample k.

    The rate of a sample holds for the time since the sample before. A missing rate is held for `GAP_S`; for longer, and over a long gap,
    nothing is known to turn. A short gap is turned over at the mean of the rates on both sides. Gravity and field are left out where they
    are missing, and over gaps.
    """
    kind, exact, field = prm[FILTER], prm[EXACT] > 0, prm[MAGNETOMETER] > 0
    gap, ballistic = prm[GAP_S], prm[GAP_BALLISTIC_S]
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    b0, b1, b2 = S[BIAS], S[BIAS + 1], S[BIAS + 2]
    v0, v1, v2 = S[RATE], S[RATE + 1], S[RATE + 2]
    before, rate_time, field_time, started = S[TIME], S[RATE_TIME], S[FIELD_TIME], S[STARTED] > 0
    m0 = m1 = m2 = math.nan
    for k in range(columns.shape[1]):
        t = columns[0, k]
        if not started:
            field_time = t
        w0, w1, w2 = columns[4, k], columns[5, k], columns[6, k]
        dt = t - before if started else 0.0
        flag = MEASURED
        if dt > gap:
            flag = BRIDGED
        if math.isfinite(w0 + w1 + w2):
            if flag == BRIDGED:
                if dt <= ballistic:
                    h = 0.5 * dt
                    q0, q1, q2, q3 = turn(q0, q1, q2, q3, v0 + w0 - 2 * b0, v1 + w1 - 2 * b1, v2 + w2 - 2 * b2, h, True)
                dt = 0.0
            v0, v1, v2, rate_time = w0, w1, w2, t
        else:
            dt = 0.0 if flag == BRIDGED else dt
            if started and t - rate_time <= gap:
                w0, w1, w2 = v0, v1, v2
                flag = max(flag, HELD)
            else:
                w0, w1, w2 = b0, b1, b2
                flag = max(flag, MISSING)
        before, started = t, True
        f0, f1, f2 = columns[1, k], columns[2, k], columns[3, k]
        if field:
            m0, m1, m2 = columns[7, k], columns[8, k], columns[9, k]
        if kind == MADGWICK:
            q0, q1, q2, q3, b0, b1, b2 = madgwick(q0, q1, q2, q3, b0, b1, b2, w0, w1, w2, f0, f1, f2, m0, m1, m2, dt, prm, exact)
        elif kind == MAHONY:
            held = dt
            if math.isfinite(m0 + m1 + m2):
                held = min(t - field_time, LONGEST_PULL_S)
                field_time = t
            q0, q1, q2, q3, b0, b1, b2 = mahony(q0, q1, q2, q3, b0, b1, b2, w0, w1, w2, f0, f1, f2, m0, m1, m2, dt, held, prm, exact)
        else:
            q0, q1, q2, q3 = turn(q0, q1, q2, q3, w0 - b0, w1 - b1, w2 - b2, dt, exact)
        q0, q1, q2, q3 = normalise(q0, q1, q2, q3)
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = q0, q1, q2, q3
        out[k, BIAS_OUT], out[k, BIAS_OUT + 1], out[k, BIAS_OUT + 2] = b0, b1, b2
        out[k, FLAG] = flag
    S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = q0, q1, q2, q3
    S[BIAS], S[BIAS + 1], S[BIAS + 2] = b0, b1, b2
    S[RATE], S[RATE + 1], S[RATE + 2] = v0, v1, v2
    S[TIME], S[RATE_TIME], S[FIELD_TIME] = before, rate_time, field_time
    if started:
        S[STARTED] = 1.0
