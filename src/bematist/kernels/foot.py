"""The foot-mounted filter, one sample at a time: strapdown, then what stance and field say.

ENU, so gravity is (0, 0, -g) (MAGINAV eq 15 is NED). Everything lives in one flat workspace `S`, see `layout`.
"""

import math

from bematist.kernels import stance
from bematist.kernels.error_state import feed_back, propagate_covariance, write_block, zero_velocity
from bematist.kernels.jit import inlined, kernel
from bematist.kernels.layout import (
    ACCEL_BIAS,
    ACCEL_BIAS_SD,
    BA,
    BG,
    BRIDGED,
    BRIDGED_OVER,
    DIAG,
    FLOOR,
    GAP_BALLISTIC_S,
    GAP_RATE,
    GAP_S,
    GAP_SPEED,
    GATE,
    GYRO_BIAS,
    GYRO_BIAS_SD,
    INNOVATION,
    LIMIT,
    MAGNETIC_HEADING,
    MAGNETIC_RESET,
    MAGNETIC_USE,
    MOTION_REFUSED,
    NIS,
    NO_SAMPLE,
    PASSED,
    PSD_ACCEL_BIAS,
    PSD_ATTITUDE,
    PSD_GYRO_BIAS,
    PSD_VELOCITY,
    RATE,
    RATIO,
    ROW,
    STARTED,
    STATE,
    STATISTIC,
    STILL_FRACTION,
    THRESHOLD,
    TIME,
    USED,
    WEIGHT_A,
    WEIGHT_G,
    ZERO_VELOCITY_SD,
    ZV_SD,
    G,
    Q,
    V,
    X,
)
from bematist.kernels.magnetic import magnetic_gate, magnetic_heading, set_attitude
from bematist.kernels.rotation import exp_quaternion, matrix, multiply, normalise


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
def predict(S, prm, dt, standing, still, diag, k):
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
    if reset and not still:
        reset = False
        gate = MOTION_REFUSED
    if reset:
        set_attitude(S, prm)
        gate = USED
        w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], rw, -rx, -ry, -rz)
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
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
        # The attitude stays TRIAD's (eq 12), with the accelerometer's offset as it now is.
        set_attitude(S, prm)
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
        reset = predict(S, prm, dt, sd > 0, statistic <= prm[STILL_FRACTION] * limit, diag, k)
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
def load(index, memory, columns, flags, start, j, S):
    """Copy sample j (in the caller's columns from `start` on, in the ring before) to S[ROW:]."""
    if j < start:
        r = index[stance.ROWS] + stance.ROW * (j & index[stance.MASK])
        for c in range(11):
            S[ROW + c] = memory[r + c]
    else:
        for c in range(10):
            S[ROW + c] = columns[c, j - start]
        S[ROW + 10] = stance.MEASURED if flags.shape[0] == 0 else flags[j - start]


@kernel
def run(index, memory, S, prm, columns, flags, finish, T, nav, diag):
    """Filter samples, columns (10,n); write results of the samples whose verdict is known. Returns how many rows were written.

    One row or a million: the same compiled code, so that chunks of any size give the same bits. columns must be complete, or come with the
    flags that `stance.fill` gave; else nothing is done and -1 returned. `finish`: no more will come, and what still waits for its window
    is written too; nav and diag need n + latency rows then, n otherwise. T is scratch, see `stance.statistics`.
    """
    if flags.shape[0] == 0 and not stance.complete(columns):
        return -1
    start = index[stance.COUNT]
    first = stance.origin(index)
    known = stance.statistics(index, memory, columns, flags, finish, prm[WEIGHT_A], prm[WEIGHT_G], prm[G], T)
    judged = index[stance.JUDGED]
    last = known if finish else known - index[stance.LOOKAHEAD]
    for j in range(judged, last):
        statistic, limit, sd = stance.verdict(
            index, memory, T, first, j, known, prm[THRESHOLD], prm[ZERO_VELOCITY_SD], prm[FLOOR], prm[RATIO]
        )
        load(index, memory, columns, flags, start, j, S)
        navigate(S, prm, statistic, limit, sd, nav, diag, j - judged)
    index[stance.JUDGED] = max(judged, last)
    stance.keep(index, memory, columns, flags)
    return index[stance.JUDGED] - judged
