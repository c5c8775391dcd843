"""The handheld filter, one sample at a time: turn, then what the two fields say.

Everything lives in one flat workspace `S`, see `hand_layout`.
"""

import math

from bematist.kernels import hand_layout as at
from bematist.kernels import quasi_static, stance
from bematist.kernels.hand_error import write_attitude_covariance
from bematist.kernels.hand_layout import (
    BA,
    BQ,
    LAST_F_KNOWN,
    LAST_M_KNOWN,
    RATE,
    ROW,
    STARTED,
    STEP,
    STEP_BQ,
    TIME,
    TURN,
    TURN_BQ,
    TURNED,
    USED_BQ,
    Q,
)
from bematist.kernels.hand_observe import hard_iron, observe, restart_turn
from bematist.kernels.hand_transition import add_attitude_noise, offset_derivative, project, propagate_covariance, transition
from bematist.kernels.jit import inlined, kernel
from bematist.kernels.layout import BRIDGED_OVER
from bematist.kernels.rotation import exp_quaternion, in_body, multiply, normalise


@inlined
def turned_rate(S, prm):
    """The angular rate of the sample in S[ROW:] against n, rad/s: less the Earth's own (erratum of eq 16), the offset still in it."""
    w0, w1, w2 = S[ROW + 4], S[ROW + 5], S[ROW + 6]
    e, n, u = prm[at.RATE_E], prm[at.RATE_N], prm[at.RATE_U]
    if e != 0 or n != 0 or u != 0:
        r0, r1, r2 = in_body(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], e, n, u)
        w0, w1, w2 = w0 - r0, w1 - r1, w2 - r2
    return w0, w1, w2


@inlined
def projects(prm):
    """Whether P loses what it says along the quaternion, once a sample, after all its updates and before the next turn (`transition`).

    In between, P lies along the quaternion by the square of what they turned it; of the rotation that is written it says nothing.
    """
    return prm[at.PROJECT] > 0 and prm[at.CORRECTION] == at.KALMAN


@inlined
def predict(S, prm, dt):
    """Attitude and covariance over dt seconds, up to the sample in S[ROW:]: MAGYQ eqs 17-19, 28-32. Returns the decay of eq 28.

    The gyroscope-quaternion offset in the state belongs to the nominal period; over dt it is in proportion (erratum of eq 20).
    """
    w0, w1, w2 = turned_rate(S, prm)
    share = dt / prm[at.PERIOD]
    r0, r1, r2, r3 = exp_quaternion(w0 * dt, w1 * dt, w2 * dt)
    r1, r2, r3 = r1 - share * S[BQ], r2 - share * S[BQ + 1], r3 - share * S[BQ + 2]
    n = 1 / math.sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
    w, x, y, z = r0 * n, r1 * n, r2 * n, r3 * n
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    a0, a1, a2, a3 = multiply(q0, q1, q2, q3, w, x, y, z)
    scale, p1, p2, p3 = (share * n, x, y, z) if prm[at.PROJECT] > 0 else (share, 0.0, 0.0, 0.0)
    j = 1.0 if projects(prm) else 0.0
    S[STEP], S[STEP + 1], S[STEP + 2], S[STEP + 3] = w, x, y, z
    D = offset_derivative(1.0, 0.0, 0.0, 0.0, w, x, y, z, p1, p2, p3, scale)
    for i in range(12):
        S[STEP_BQ + i] = D[i]
    S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(a0, a1, a2, a3)
    decay = 1 - prm[at.ACCEL_DECAY] * dt
    for i in range(3):
        S[BA + i] *= decay
        S[USED_BQ + i] = S[BQ + i]
        S[RATE + i] = S[ROW + 4 + i] - 2 * S[BQ + i] / prm[at.PERIOD]
    bias_walk = prm[at.BIAS_WALK] * dt
    if prm[at.BIAS_POWER] > 1:
        bias_walk *= dt
    propagate_covariance(
        S,
        transition(w, x, y, z, q0, q1, q2, q3, j * a0, j * a1, j * a2, j * a3),
        offset_derivative(q0, q1, q2, q3, a0, a1, a2, a3, p1, p2, p3, scale),
        *(0.25 * prm[at.PSD_ANGLE] * dt, bias_walk, decay, prm[at.ACCEL_BIAS_WALK] * dt),
        *(prm[at.MAGNETIC + at.WALK] * dt, prm[at.FORCE + at.WALK] * dt, prm[at.REFERENCE] == at.ESTIMATED),
    )
    return decay


@inlined
def accumulate_turn(S):
    """The rotation since the last magnetometer sample, and its derivative to the gyroscope-quaternion offset, over one more step."""
    w, x, y, z = S[STEP], S[STEP + 1], S[STEP + 2], S[STEP + 3]
    if S[TURNED] == 0:
        S[TURN], S[TURN + 1], S[TURN + 2], S[TURN + 3] = w, x, y, z
        for i in range(12):
            S[TURN_BQ + i] = S[STEP_BQ + i]
        S[TURNED] = 1.0
        return
    t0, t1, t2, t3 = S[TURN], S[TURN + 1], S[TURN + 2], S[TURN + 3]
    for i in range(3):
        a0, a1, a2, a3 = S[TURN_BQ + i], S[TURN_BQ + 3 + i], S[TURN_BQ + 6 + i], S[TURN_BQ + 9 + i]
        c0, c1, c2, c3 = multiply(a0, a1, a2, a3, w, x, y, z)
        d0, d1, d2, d3 = multiply(t0, t1, t2, t3, S[STEP_BQ + i], S[STEP_BQ + 3 + i], S[STEP_BQ + 6 + i], S[STEP_BQ + 9 + i])
        S[TURN_BQ + i], S[TURN_BQ + 3 + i], S[TURN_BQ + 6 + i], S[TURN_BQ + 9 + i] = c0 + d0, c1 + d1, c2 + d2, c3 + d3
    S[TURN], S[TURN + 1], S[TURN + 2], S[TURN + 3] = multiply(t0, t1, t2, t3, w, x, y, z)


@inlined
def bridge(S, prm, index, memory, dt):
    """Cross a gap of dt seconds: a short one at the mean of the rates on both sides, a long one without turning; attitude in doubt.

    Both fields may have changed: their periods end.
    """
    if projects(prm):
        project(S)
    if dt <= prm[at.GAP_BALLISTIC_S]:
        h = 0.5 * dt
        b = 2 / prm[at.PERIOD]
        r0, r1, r2, r3 = exp_quaternion(
            h * (S[RATE] + S[ROW + 4] - b * S[BQ]),
            h * (S[RATE + 1] + S[ROW + 5] - b * S[BQ + 1]),
            h * (S[RATE + 2] + S[ROW + 6] - b * S[BQ + 2]),
        )
        w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], r0, r1, r2, r3)
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(w, x, y, z)
    angle = min(prm[at.GAP_RATE] * dt, 0.5)
    add_attitude_noise(S, 0.25 * angle * angle)
    quasi_static.forget(index, memory, 0)
    quasi_static.forget(index, memory, at.INDEX_EACH)
    S[LAST_M_KNOWN] = S[LAST_F_KNOWN] = 0.0
    restart_turn(S)


@inlined
def elapse(S, prm, index, memory):
    """Time from the last sample to the one in S[ROW:], s; a gap is bridged here and counts as 0 afterwards. Also what was done."""
    t = S[ROW]
    dt = t - S[TIME]
    what = S[ROW + 10]
    if S[STARTED] == 0:
        dt = 0.0
        restart_turn(S)
    elif dt > prm[at.GAP_S]:
        bridge(S, prm, index, memory, dt)
        dt = 0.0
        what = BRIDGED_OVER
    S[TIME] = t
    S[STARTED] = 1.0
    return dt, what


@inlined
def navigate(S, prm, index, memory, nav, diag, k):
    """One sample, in S[ROW:]: turn, observe, and write row k of the results."""
    for c in range(at.DIAG):
        diag[k, c] = math.nan
    diag[k, at.FIELD_M + at.VERDICT] = diag[k, at.FIELD_F + at.VERDICT] = at.NO_SAMPLE
    diag[k, at.BRIDGED] = S[ROW + 10]
    if S[ROW + 10] < stance.MISSING:
        dt, diag[k, at.BRIDGED] = elapse(S, prm, index, memory)
        decay = 1.0
        if dt > 0:
            decay = predict(S, prm, dt)
            if prm[at.MAGNETIC + at.GRADIENT] > 0:
                accumulate_turn(S)
        if prm[at.IRON_USE] > 0:
            w0, w1, w2 = turned_rate(S, prm)
            b = 2 / prm[at.PERIOD]
            lost = diag[k, at.BRIDGED] == BRIDGED_OVER
            hard_iron(S, prm, dt, w0 - b * S[BQ], w1 - b * S[BQ + 1], w2 - b * S[BQ + 2], lost, diag, k)
        if prm[at.CORRECTION] != at.NOTHING:
            observe(S, prm, index, memory, dt, decay, diag, k)
    write(S, prm, nav, diag, k)


@inlined
def write(S, prm, nav, diag, k):
    """Row k of the results: attitude, its covariance, the offsets."""
    nav[k, 0] = S[ROW]
    for i in range(4):
        nav[k, 1 + i] = S[Q + i]
    write_attitude_covariance(S, nav, k, 5)
    rate = 2 / prm[at.PERIOD]
    for i in range(3):
        diag[k, at.GYRO_BIAS + i] = rate * S[BQ + i]
        diag[k, at.GYRO_BIAS_SD + i] = rate * math.sqrt(S[17 * (at.E_BQ + i)])
        diag[k, at.ACCEL_BIAS + i] = S[BA + i]
        diag[k, at.ACCEL_BIAS_SD + i] = math.sqrt(S[17 * (at.E_BA + i)])


@kernel
def run(index, memory, S, prm, columns, flags, nav, diag):
    """Filter samples, columns (10,n), and write n rows of results.

    One row or a million: the same compiled code, so that chunks of any size give the same bits. columns must be complete, or come with the
    flags that `stance.fill` gave; else nothing is done and -1 returned.
    """
    n = columns.shape[1]
    if flags.shape[0] == 0 and not stance.complete(columns):
        return -1
    for k in range(n):
        for c in range(10):
            S[ROW + c] = columns[c, k]
        S[ROW + 10] = stance.MEASURED if flags.shape[0] == 0 else flags[k]
        navigate(S, prm, index, memory, nav, diag, k)
    stance.hold_last(memory, columns, flags)
    return n
