"""From one sample to the next: time, gaps, attitude, velocity, position and covariance.

ENU, so gravity is (0, 0, -g) (MAGINAV eq 15 is NED).
"""

from bematist.kernels import layout as at
from bematist.kernels.error_state import propagate_covariance
from bematist.kernels.jit import inlined
from bematist.kernels.layout import BA, BG, RATE, ROW, STARTED, TIME, Q, V, X
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
    reset = gate == at.PASSED and standing and prm[at.MAGNETIC_USE] == at.MAGNETIC_RESET
    if reset and not still:
        reset = False
        gate = at.MOTION_REFUSED
    if reset:
        set_attitude(S, prm)
        gate = at.USED
        w, x, y, z = multiply(S[Q], S[Q + 1], S[Q + 2], S[Q + 3], rw, -rx, -ry, -rz)
        C0, C1, C2, C3, C4, C5, C6, C7, C8 = matrix(w, x, y, z)
    diag[k, at.GATE] = gate
    if dt > 0:
        n0 = (C0 * f0 + C1 * f1 + C2 * f2) * dt
        n1 = (C3 * f0 + C4 * f1 + C5 * f2) * dt
        n2 = (C6 * f0 + C7 * f1 + C8 * f2) * dt
        integrate(S, n0, n1, n2 - prm[at.G] * dt, h)
        propagate_covariance(
            S,
            *(C0 * dt, C1 * dt, C2 * dt, C3 * dt, C4 * dt, C5 * dt, C6 * dt, C7 * dt, C8 * dt),
            *(n0, n1, n2, dt),
            *(prm[at.PSD_ATTITUDE] * dt, prm[at.PSD_VELOCITY] * dt, prm[at.PSD_ACCEL_BIAS] * dt, prm[at.PSD_GYRO_BIAS] * dt),
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
