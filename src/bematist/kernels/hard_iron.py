"""A magnetometer's hard iron, followed from the turning of the sensor alone: a Kalman filter of six states.

A magnetometer reads y = Aᵀ F + b + noise: F the field where it is, in a frame that the gyroscope carries along (A turns the body's axes
into it; it begins as the body lies and knows neither up nor North), b a field that turns with the body. F does not turn with the sensor
and b does: that alone tells them apart. Turned into the frame of the gyroscope

    A y = F + A b + noise,    x = (F, b),    H = [I  A],

linear, whatever the attitude is. Samples near each other are averaged, with their A, into one measurement ("block"): H = [I  mean A] is
still exact. Between blocks F walks: by `DRIFT` at any time, by what the gyroscope is out in the angle turned, and by a walk in motion
whose size is learned from the innovations (nothing, in the open; several µT a stride, in a building). An innovation beyond `JUMP` is a
field that has changed at once: F is then begun anew from this block, which forgets F and nothing that is known of b.

Evidence. With prior N(0, p² I) of b and what is known now, N(b, P), the likelihood of all innovations so far with b over the likelihood
without is (Savage and Dickey) p(b = 0 before)/p(b = 0 now), for a b that stays:

    ln B = ½ bᵀ P⁻¹ b − ½ ln(p⁶ / |P|).

The first term is the chi-square of b against 0, the second what a free b pays for being free.
"""

import math

from bematist.kernels.hard_iron_layout import (
    ANGLE,
    APPLIED,
    BEGAN,
    BEGUN,
    BLOCK_S,
    CHI,
    CORRECT,
    COUNT,
    DELAY,
    DRIFT,
    ENDED,
    EVIDENCE,
    EXCESS,
    FROM,
    IRON,
    IRON_SD,
    JUMP,
    KNOWN,
    LAST,
    LEAST,
    LN_B,
    MEMORY_S,
    MOVED,
    NIS,
    NOISE,
    OVER_S,
    OWN_WALK,
    PRIOR,
    SUM_A,
    SUM_RATE,
    SUM_Y,
    TOLD,
    TURN,
    USE,
    USED,
    WALK,
    A,
    B,
    E,
    P,
    W,
    X,
)
from bematist.kernels.innovation import factor, squared, whiten
from bematist.kernels.jit import apart, inlined
from bematist.kernels.layout import LEAST_HORIZONTAL
from bematist.kernels.rotation import exp_quaternion, matrix, multiply, normalise


@inlined
def step(S, o, prm, p, t, dt, w0, w1, w2, m0, m1, m2, moving, apart, lost):
    """One inertial sample at t: turned by (w0, w1, w2) dt, with a magnetometer sample in µT or NaN. Whether b has changed.

    moving: the sensor is carried about, so that the field may change with its place. apart: the block ends before this sample.
    lost: nothing is known of the turn since the sample before.
    """
    if lost:
        S[o + KNOWN] = S[o + COUNT] = 0.0
    heard = m0 * m0 + m1 * m1 + m2 * m2 < math.inf
    closed = S[o + COUNT] > 0 and (apart or t - S[o + BEGAN] >= prm[p + BLOCK_S])
    if closed:
        close(S, o, prm, p)
    rate = math.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
    r0, r1, r2, r3 = exp_quaternion(w0 * dt, w1 * dt, w2 * dt)
    a0, a1, a2, a3 = multiply(S[o + A], S[o + A + 1], S[o + A + 2], S[o + A + 3], r0, r1, r2, r3)
    S[o + A], S[o + A + 1], S[o + A + 2], S[o + A + 3] = a0, a1, a2, a3
    S[o + ANGLE] += rate * dt
    if moving:
        S[o + MOVED] += dt
    if heard:
        gather(S, o, t, rate, m0, m1, m2)
    return closed


@inlined
def gather(S, o, t, rate, m0, m1, m2):
    """A sample into the block."""
    q0, q1, q2, q3 = normalise(S[o + A], S[o + A + 1], S[o + A + 2], S[o + A + 3])
    S[o + A], S[o + A + 1], S[o + A + 2], S[o + A + 3] = q0, q1, q2, q3
    C = matrix(q0, q1, q2, q3)
    if S[o + COUNT] == 0:
        for i in range(SUM_Y, COUNT):
            S[o + i] = 0.0
        S[o + BEGAN] = t
    for i in range(3):
        S[o + SUM_Y + i] += C[3 * i] * m0 + C[3 * i + 1] * m1 + C[3 * i + 2] * m2
    for i in range(9):
        S[o + SUM_A + i] += C[i]
    S[o + SUM_RATE] += rate * rate
    S[o + COUNT] += 1.0
    S[o + ENDED] = t


@apart
def close(S, o, prm, p):
    """The block is complete: measure."""
    share = 1 / S[o + COUNT]
    for i in range(SUM_Y, COUNT):
        S[o + i] *= share
    y0, y1, y2 = S[o + SUM_Y], S[o + SUM_Y + 1], S[o + SUM_Y + 2]
    x = o + X if S[o + KNOWN] > 0 else o + SUM_Y
    square = S[x] * S[x] + S[x + 1] * S[x + 1] + S[x + 2] * S[x + 2]
    variance = prm[p + NOISE] + square * prm[p + DELAY] * S[o + SUM_RATE]
    S[o + NIS] = math.nan
    if not (S[o + KNOWN] > 0 and measure(S, o, prm, p, y0, y1, y2, square, variance)):
        begin(S, o, y0, y1, y2, variance)
    walked = prm[p + OWN_WALK] * (S[o + ENDED] - S[o + LAST])
    for i in range(3):
        S[o + P + 7 * (3 + i)] += walked
    S[o + LAST] = S[o + ENDED]
    S[o + ANGLE] = S[o + MOVED] = S[o + COUNT] = 0.0
    judge(S, o, prm, p)


@inlined
def measure(S, o, prm, p, y0, y1, y2, square, variance):
    """Kalman update by a block; False, and only the noises added, where the field has jumped."""
    for i in range(3):
        a0, a1, a2 = S[o + SUM_A + 3 * i], S[o + SUM_A + 3 * i + 1], S[o + SUM_A + 3 * i + 2]
        for c in range(6):
            S[o + W + 6 * i + c] = S[o + P + 6 * i + c] + a0 * S[o + P + 18 + c] + a1 * S[o + P + 24 + c] + a2 * S[o + P + 30 + c]
    b0, b1, b2 = S[o + B], S[o + B + 1], S[o + B + 2]
    z0 = y0 - S[o + X] - (S[o + SUM_A] * b0 + S[o + SUM_A + 1] * b1 + S[o + SUM_A + 2] * b2)
    z1 = y1 - S[o + X + 1] - (S[o + SUM_A + 3] * b0 + S[o + SUM_A + 4] * b1 + S[o + SUM_A + 5] * b2)
    z2 = y2 - S[o + X + 2] - (S[o + SUM_A + 6] * b0 + S[o + SUM_A + 7] * b1 + S[o + SUM_A + 8] * b2)
    s00, s10, s11 = own(S, o, 0, 0), own(S, o, 1, 0), own(S, o, 1, 1)
    s20, s21, s22 = own(S, o, 2, 0), own(S, o, 2, 1), own(S, o, 2, 2)
    known = square * prm[p + TURN] * S[o + ANGLE] + prm[p + DRIFT] * (S[o + ENDED] - S[o + LAST])
    walk = max(prm[p + WALK], S[o + EXCESS] / S[o + OVER_S])
    noise = known + walk * S[o + MOVED]
    if S[o + MOVED] > 0:
        # What the walk adds to the innovation's square in expectation is 3 walk s; a jump shall not count for more than it may weigh.
        expected = s00 + s11 + s22 + 3 * (variance + known)
        found = min(z0 * z0 + z1 * z1 + z2 * z2, prm[p + JUMP] / 3 * (expected + 3 * walk * S[o + MOVED]))
        fade = math.exp(-S[o + MOVED] / prm[p + MEMORY_S])
        S[o + EXCESS] = S[o + EXCESS] * fade + found - expected
        S[o + OVER_S] = S[o + OVER_S] * fade + 3 * S[o + MOVED]
    for i in range(3):
        S[o + P + 7 * i] += noise
        S[o + W + 7 * i] += noise
    r = variance + noise
    L = factor(s00 + r, s10, s11 + r, s20, s21, s22 + r, z0, z1, z2)
    nis = squared(L)
    S[o + NIS] = nis
    if not nis <= prm[p + JUMP]:
        return False
    whiten(S, o + W, o + E, L, 6, False)
    for i in range(6):
        S[o + X + i] += S[o + E + i]
        u0, u1, u2 = S[o + W + i], S[o + W + 6 + i], S[o + W + 12 + i]
        for c in range(6):
            S[o + P + 6 * i + c] -= u0 * S[o + W + c] + u1 * S[o + W + 6 + c] + u2 * S[o + W + 12 + c]
    S[o + USED] += 1.0
    return True


@inlined
def own(S, o, i, j):
    """Entry (i, j) of H P Hᵀ, with H P in W."""
    w, a = o + W + 6 * i, o + SUM_A + 3 * j
    return S[w + j] + S[w + 3] * S[a] + S[w + 4] * S[a + 1] + S[w + 5] * S[a + 2]


@inlined
def begin(S, o, y0, y1, y2, variance):
    """The field is what this block says, with the errors of b in it: F = y − A b, so that P takes over −A P_bb and A P_bb Aᵀ + R."""
    y = (y0, y1, y2)
    for i in range(3):
        a0, a1, a2 = S[o + SUM_A + 3 * i], S[o + SUM_A + 3 * i + 1], S[o + SUM_A + 3 * i + 2]
        S[o + X + i] = y[i] - (a0 * S[o + B] + a1 * S[o + B + 1] + a2 * S[o + B + 2])
        for c in range(3, 6):
            v = -(a0 * S[o + P + 18 + c] + a1 * S[o + P + 24 + c] + a2 * S[o + P + 30 + c])
            S[o + P + 6 * i + c] = S[o + P + 6 * c + i] = v
    for i in range(3):
        for j in range(3):
            a = o + SUM_A + 3 * j
            S[o + P + 6 * i + j] = -(S[o + P + 6 * i + 3] * S[a] + S[o + P + 6 * i + 4] * S[a + 1] + S[o + P + 6 * i + 5] * S[a + 2])
        S[o + P + 7 * i] += variance
    S[o + KNOWN] = 1.0
    S[o + BEGUN] += 1.0


@inlined
def judge(S, o, prm, p):
    """Evidence for b, and whether it is taken out: from where ln B and its length pass their limits, until ln B is back at 0."""
    d = o + P + 21
    b0, b1, b2 = S[o + B], S[o + B + 1], S[o + B + 2]
    L = factor(S[d], S[d + 6], S[d + 7], S[d + 12], S[d + 13], S[d + 14], b0, b1, b2)
    chi = squared(L)
    found = 0.5 * chi - 1.5 * math.log(prm[p + PRIOR]) - 0.5 * math.log(L[0] * L[2] * L[5])
    S[o + CHI], S[o + LN_B] = chi, found
    if prm[p + USE] == CORRECT:
        if found >= prm[p + EVIDENCE] and b0 * b0 + b1 * b1 + b2 * b2 >= prm[p + LEAST] * prm[p + LEAST]:
            S[o + APPLIED] = 1.0
        elif found < 0:
            S[o + APPLIED] = 0.0


@inlined
def tell(S, o, closed, diag, k, d):
    """Row k of the diagnostics, from column d on."""
    for i in range(3):
        diag[k, d + IRON + i] = S[o + B + i]
        diag[k, d + IRON_SD + i] = math.sqrt(S[o + P + 7 * (3 + i)])
    for i in range(6):
        diag[k, d + TOLD + i] = S[o + CHI + i]
    if not closed:
        diag[k, d + TOLD + NIS - CHI] = math.nan


@inlined
def reference(S, o, prm, p, e, n, u):
    """The reference (e, n, u) of the start, less what b did to it there; where that could give no heading, b stays in and so does it."""
    a = S[o + APPLIED]
    b0, b1, b2 = a * S[o + B], a * S[o + B + 1], a * S[o + B + 2]
    f = p + FROM
    x = e - (prm[f] * b0 + prm[f + 1] * b1 + prm[f + 2] * b2)
    y = n - (prm[f + 3] * b0 + prm[f + 4] * b1 + prm[f + 5] * b2)
    z = u - (prm[f + 6] * b0 + prm[f + 7] * b1 + prm[f + 8] * b2)
    if points(x, y, z):
        return x, y, z
    S[o + APPLIED] = 0.0
    return e, n, u


@inlined
def points(e, n, u):
    """Whether a field has a horizontal part that gives a heading."""
    return math.sqrt(e * e + n * n) > LEAST_HORIZONTAL * math.sqrt(e * e + n * n + u * u)


@inlined
def settle(S, o, m, changed, diag, k, d):
    """The magnetometer sample in S[m:] less b, where that is taken out, and what is known of b in row k of the diagnostics."""
    if S[o + APPLIED] > 0:
        for i in range(3):
            S[m + i] -= S[o + B + i]
    tell(S, o, changed, diag, k, d)
