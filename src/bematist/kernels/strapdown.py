"""From one sample to the next: time, gaps, attitude, velocity, position and covariance.

ENU, so gravity is (0, 0, -g) (MAGINAV eq 15 is NED).
"""

import math

from bematist.kernels import layout as at
from bematist.kernels.ahrs import LONGEST_PULL_S, first_order, madgwick_direction, mahony_error
from bematist.kernels.error_state import propagate_covariance
from bematist.kernels.jit import inlined
from bematist.kernels.layout import BA, BG, FIELD_TIME, INTEGRAL, PREDICTED, RATE, ROW, STARTED, TIME, Q, V, X
from bematist.kernels.magnetic import magnetic_gate, set_attitude
from bematist.kernels.rotation import exp_quaternion, matrix, multiply, normalise


@inlined
def bridge(S, prm, dt, w0, w1, w2):
    """Cross a gap of dt seconds in which nothing was measured: a short one ballistically, a long one standing still, both in doubt."""
    short = min(dt, prm[at.GAP_BALLISTIC_S])
    speed2 = prm[at.GAP_SPEED] * prm[at.GAP_SPEED]
    for i in range(3):
        S[X + i] += S[V + i] * short
        S[17 * (6 + i)] += speed2 * dt * dt
    if dt <= prm[at.GAP_BALLISTIC_S]:
        h = 0.25 * dt
        r = exp_quaternion(h * (S[RATE] + w0) * 2, h * (S[RATE + 1] + w1) * 2, h * (S[RATE + 2] + w2) * 2)
        w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], r[0], r[1], r[2], r[3])
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(w, x, y, z)
    else:
        S[V] = S[V + 1] = S[V + 2] = 0.0
    angle = min(prm[at.GAP_RATE] * dt, 0.5)
    for r in range(3):
        for c in range(15):
            S[16 * (3 + r) + c] = 0.0
            S[16 * c + 3 + r] = 0.0
    S[PREDICTED], S[PREDICTED + 1], S[PREDICTED + 2] = S[V], S[V + 1], S[V + 2]
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
    elif dt > prm[at.GAP_S]:
        bridge(S, prm, dt, S[ROW + 4] - S[BG], S[ROW + 5] - S[BG + 1], S[ROW + 6] - S[BG + 2])
        dt = 0.0
        what = at.BRIDGED_OVER
    S[TIME] = t
    S[STARTED] = 1.0
    return dt, what


@inlined
def turn(S, prm, dt, heard, f0, f1, f2, w0, w1, w2):
    """The attitude over dt seconds by an AHRS or to first order, into S; returns the attitude at the middle of the interval.

    The turn a (rad) is w dt, with Mahony's correction added (Li & Wang eqs 30-34), or the quaternion moves against Madgwick's unit gradient
    (eqs 24-28); w is free of the filter's offset already (erratum: the filters themselves remove none with ki = 0). f and, where `heard`,
    the magnetometer sample pull at the attitude before the turn. Mahony's pull is proportional: a magnetometer sample counts for the time
    since the one before, at most LONGEST_PULL_S, so that its strength does not depend on the magnetometer's rate. Madgwick's step has one
    length whatever the error, so that a sample which is used once turns the attitude by as much as gravity does in one sample.
    """
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    a0, a1, a2 = w0 * dt, w1 * dt, w2 * dt
    g0 = g1 = g2 = g3 = m0 = m1 = m2 = held = 0.0
    e, n = S[at.NORTH_E], S[at.NORTH_N]
    if heard:
        m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
        held = min(S[ROW] - S[FIELD_TIME], LONGEST_PULL_S)
        S[FIELD_TIME] = S[ROW]
    if prm[at.PROPAGATION] == at.MAHONY:
        e0, e1, e2 = mahony_error(q0, q1, q2, q3, f0, f1, f2, 0.0, 0.0, 0.0, e, n)
        e0, e1, e2 = e0 * dt, e1 * dt, e2 * dt
        if heard:
            d0, d1, d2 = mahony_error(q0, q1, q2, q3, 0.0, 0.0, 0.0, m0, m1, m2, e, n)
            e0, e1, e2 = e0 + d0 * held, e1 + d1 * held, e2 + d2 * held
        S[INTEGRAL] += prm[at.KI] * e0
        S[INTEGRAL + 1] += prm[at.KI] * e1
        S[INTEGRAL + 2] += prm[at.KI] * e2
        a0 += prm[at.KP] * e0 + S[INTEGRAL] * dt
        a1 += prm[at.KP] * e1 + S[INTEGRAL + 1] * dt
        a2 += prm[at.KP] * e2 + S[INTEGRAL + 2] * dt
    elif prm[at.PROPAGATION] == at.MADGWICK:
        g0, g1, g2, g3 = madgwick_direction(q0, q1, q2, q3, f0, f1, f2, m0, m1, m2, e, n)
        s = prm[at.BETA] * dt
        g0, g1, g2, g3 = g0 * s, g1 * s, g2 * s, g3 * s
    rw, rx, ry, rz = exp_quaternion(0.5 * a0, 0.5 * a1, 0.5 * a2)
    h0, h1, h2, h3 = multiply(q0, q1, q2, q3, rw, rx, ry, rz)
    if prm[at.INTEGRATION] == at.EXACT:
        q0, q1, q2, q3 = multiply(h0, h1, h2, h3, rw, rx, ry, rz)
    elif prm[at.INTEGRATION] == at.FIRST_ORDER:
        q0, q1, q2, q3 = first_order(q0, q1, q2, q3, a0, a1, a2, 1.0)
    else:
        # The rotation nearest to I + [a x] turns by atan|a| about a.
        angle = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
        s = math.atan(angle) / angle if angle > 0 else 1.0
        rw, rx, ry, rz = exp_quaternion(s * a0, s * a1, s * a2)
        q0, q1, q2, q3 = multiply(q0, q1, q2, q3, rw, rx, ry, rz)
    S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(q0 - g0, q1 - g1, q2 - g2, q3 - g3)
    if prm[at.PROPAGATION] != at.MADGWICK:
        return h0, h1, h2, h3
    return normalise(h0 - 0.5 * g0, h1 - 0.5 * g1, h2 - 0.5 * g2, h3 - 0.5 * g3)


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
    gate = magnetic_gate(S, prm, C6, C7, C8, diag, k)
    if prm[at.PROPAGATION] == at.COMMON and prm[at.INTEGRATION] == at.EXACT:
        w, x, y, z = multiply(w, x, y, z, rw, rx, ry, rz)
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(w, x, y, z)
    else:
        heard = gate != at.NO_SAMPLE and prm[at.LISTEN] >= (at.LISTEN_GATED if gate == at.PASSED else at.LISTEN_ALL)
        w, x, y, z = turn(S, prm, dt, heard, f0, f1, f2, w0, w1, w2)
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
        if heard and prm[at.MAGNETIC_USE] == at.MAGNETIC_OFF:
            gate = at.USED
    reset = gate == at.PASSED and standing and prm[at.MAGNETIC_USE] == at.MAGNETIC_RESET
    if reset and not still:
        reset = False
        gate = at.MOTION_REFUSED
    if reset:
        set_attitude(S, prm)
        gate = at.USED
        w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], rw, -rx, -ry, -rz)
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
    if prm[at.AT_END] != 0:
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    diag[k, at.GATE] = gate
    if dt > 0:
        n0 = (C0 * f0 + C1 * f1 + C2 * f2) * dt
        n1 = (C3 * f0 + C4 * f1 + C5 * f2) * dt
        n2 = (C6 * f0 + C7 * f1 + C8 * f2) * dt
        # The errors of velocity are counted with the velocity as predicted; corrections moved it by d since (see `zero_velocity`).
        t = prm[at.INVARIANT]
        d0, d1, d2 = t * (S[V] - S[PREDICTED]), t * (S[V + 1] - S[PREDICTED + 1]), t * (S[V + 2] - S[PREDICTED + 2])
        integrate(S, n0, n1, n2 - prm[at.G] * dt, h)
        propagate_covariance(
            S,
            *(C0 * dt, C1 * dt, C2 * dt, C3 * dt, C4 * dt, C5 * dt, C6 * dt, C7 * dt, C8 * dt),
            *(n0 + d0, n1 + d1, n2 + d2, dt),
            *(prm[at.PSD_ATTITUDE] * dt, prm[at.PSD_VELOCITY] * dt, prm[at.PSD_ACCEL_BIAS] * dt, prm[at.PSD_GYRO_BIAS] * dt),
        )
    S[PREDICTED], S[PREDICTED + 1], S[PREDICTED + 2] = S[V], S[V + 1], S[V + 2]
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
