"""The foot-mounted filter, one sample at a time: strapdown, then what stance and field say.

Everything lives in one flat workspace `S`, see `layout`.
"""

import math

from bematist.kernels import layout as at
from bematist.kernels import stance
from bematist.kernels.constraints import constrain
from bematist.kernels.error_state import feed_back, vector_measurement, write_block
from bematist.kernels.jit import inlined, kernel
from bematist.kernels.layout import BA, BG, ROW, Q, V, X
from bematist.kernels.magnetic import hard_iron, magnetic_heading, set_attitude
from bematist.kernels.pace import follow
from bematist.kernels.rotation import exp_quaternion, in_body, matrix
from bematist.kernels.strapdown import elapse, predict


@inlined
def turn_velocity_error(S):
    """Let the corrected velocity be exp(-[psi x]) (v - dv - v x psi), as the invariant error means it, and not v - dv, its first order.

    After a gap velocity and psi are large; to first order v x psi would remain, and the next samples would take it for more psi.
    """
    e0, e1, e2 = S[at.E], S[at.E + 1], S[at.E + 2]
    v0, v1, v2 = S[V], S[V + 1], S[V + 2]
    u0 = v0 - S[at.E + 3] - (v1 * e2 - v2 * e1)
    u1 = v1 - S[at.E + 4] - (v2 * e0 - v0 * e2)
    u2 = v2 - S[at.E + 5] - (v0 * e1 - v1 * e0)
    w, x, y, z = exp_quaternion(-e0, -e1, -e2)
    C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
    S[at.E + 3] = v0 - (C0 * u0 + C1 * u1 + C2 * u2)
    S[at.E + 4] = v1 - (C3 * u0 + C4 * u1 + C5 * u2)
    S[at.E + 5] = v2 - (C6 * u0 + C7 * u1 + C8 * u2)


@inlined
def correct(S, prm, sd, reset, diag, k):
    """The updates of a sample in stance, states 2 and 3 of MAGINAV Table 2."""
    for i in range(3):
        diag[k, at.INNOVATION + i] = -S[V + i]
    v0, v1, v2, t = S[V], S[V + 1], S[V + 2], prm[at.INVARIANT]
    diag[k, at.NIS] = vector_measurement(S, 3, v0, v1, v2, t * v0, t * v1, t * v2, sd * sd)
    diag[k, at.ZV_SD] = sd
    diag[k, at.STATE] = 3.0 if reset else 2.0
    if t > 0 and not reset:
        turn_velocity_error(S)
    feed_back(S, not reset)
    if reset:
        # The attitude stays TRIAD's (eq 12), with the accelerometer's offset as it now is.
        set_attitude(S, prm)
    elif diag[k, at.GATE] == at.PASSED and prm[at.MAGNETIC_USE] == at.MAGNETIC_HEADING:
        diag[k, at.GATE] = magnetic_heading(S, prm, S[ROW + 7], S[ROW + 8], S[ROW + 9])


@inlined
def leave_earth(S, prm):
    """Take the rotation of the Earth out of the angular rate in S[ROW:]: what is left is the rate against n, and the offset."""
    e, n, u = prm[at.EARTH_E], prm[at.EARTH_N], prm[at.EARTH_U]
    if e != 0 or n != 0 or u != 0:
        r0, r1, r2 = in_body(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], e, n, u)
        S[ROW + 4] -= r0
        S[ROW + 5] -= r1
        S[ROW + 6] -= r2


@inlined
def navigate(S, prm, statistic, limit, sd, nav, diag, k):
    """One sample, in S[ROW:], with its stance verdict: predict, correct, and write row k of the results."""
    for c in range(at.DIAG):
        diag[k, c] = math.nan
    diag[k, at.STATISTIC] = statistic
    diag[k, at.LIMIT] = limit
    diag[k, at.STATE] = 1.0
    diag[k, at.GATE] = at.NO_SAMPLE
    diag[k, at.BRIDGED] = S[ROW + 10]
    if S[ROW + 10] < stance.MISSING:
        leave_earth(S, prm)
        dt, diag[k, at.BRIDGED] = elapse(S, prm)
        if prm[at.IRON_USE] > 0:
            hard_iron(S, prm, dt, sd > 0, diag[k, at.BRIDGED] == at.BRIDGED_OVER, diag, k)
        reset = predict(S, prm, dt, sd > 0, statistic <= prm[at.STILL_FRACTION] * limit, diag, k)
        if sd > 0:
            correct(S, prm, sd, reset, diag, k)
        if prm[at.CONSTRAINED] > 0:
            constrain(S, prm, dt, sd > 0, diag[k, at.BRIDGED] == at.BRIDGED_OVER, diag, k)
        if prm[at.PACE_USE] > 0:
            diag[k, at.PACE] = S[at.CLASS]
            follow(S, prm)
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
        diag[k, at.GYRO_BIAS + i] = S[BG + i]
        diag[k, at.ACCEL_BIAS + i] = S[BA + i]
        diag[k, at.GYRO_BIAS_SD + i] = math.sqrt(S[17 * (12 + i)])
        diag[k, at.ACCEL_BIAS_SD + i] = math.sqrt(S[17 * (9 + i)])


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
    known = stance.statistics(index, memory, columns, flags, finish, prm[at.WEIGHT_A], prm[at.WEIGHT_G], prm[at.G], T)
    judged = index[stance.JUDGED]
    last = known if finish else known - index[stance.LOOKAHEAD]
    for j in range(judged, last):
        statistic, limit, sd = stance.verdict(
            index, memory, T, first, j, known, S[at.LIMIT_NOW], prm[at.ZERO_VELOCITY_SD], prm[at.FLOOR], prm[at.RATIO]
        )
        load(index, memory, columns, flags, start, j, S)
        navigate(S, prm, statistic, limit, sd, nav, diag, j - judged)
    index[stance.JUDGED] = max(judged, last)
    stance.keep(index, memory, columns, flags)
    return index[stance.JUDGED] - judged
