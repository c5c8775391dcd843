"""The error state and its covariance: prediction, updates, feedback.

Error state, in this order (MAGINAV eq 18): attitude psi (rotation vector in n, C_est = exp([psi x]) C_true), velocity and position as
estimate − truth; accelerometer and gyroscope offset as what is still to be subtracted from the measurement. Closed loop: after every
update the error is fed back and is zero again.

The covariance is 15 rows of 16 at the head of the workspace S (the last column is padding, zero).
"""

import math

from bematist.kernels import layout as at
from bematist.kernels.innovation import factor, squared, whiten
from bematist.kernels.jit import inlined
from bematist.kernels.layout import BA, E, M, Q, V, W
from bematist.kernels.rotation import exp_quaternion, multiply, normalise


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
def vector_measurement(S, first, z0, z1, z2, t0, t1, t2, variance):
    """Estimate the error E from z = x[first:first + 3] + t x psi + noise, the variance the same on each axis; update P. Returns the NIS.

    MAGINAV eqs 21, 22, 24 (erratum: H is 3x15) for z = v and t = 0; first is at least 3. With t = v, z is the error dv + v x psi of the
    velocity in axes turned by psi, to which a turn of the whole path about up, dv = psi x v, adds nothing; since the true velocity is
    zero, z is that error too. With S = H P Hᵀ + R = L Lᵀ and W = P Hᵀ L⁻ᵀ: P ← P - W Wᵀ, which is symmetric by construction, and
    E = W L⁻¹ z.
    """
    p, q, r = 16 * first, 16 * first + 16, 16 * first + 32
    for c in range(16):
        S[W + c] = S[p + c] + t1 * S[32 + c] - t2 * S[16 + c]
        S[W + 16 + c] = S[q + c] + t2 * S[c] - t0 * S[32 + c]
        S[W + 32 + c] = S[r + c] + t0 * S[16 + c] - t1 * S[c]
    o = W + first
    L = factor(
        S[o] + t1 * S[W + 2] - t2 * S[W + 1] + variance,
        S[o + 16] + t1 * S[W + 18] - t2 * S[W + 17],
        S[o + 17] + t2 * S[W + 16] - t0 * S[W + 18] + variance,
        S[o + 32] + t1 * S[W + 34] - t2 * S[W + 33],
        S[o + 33] + t2 * S[W + 32] - t0 * S[W + 34],
        S[o + 34] + t0 * S[W + 33] - t1 * S[W + 32] + variance,
        z0,
        z1,
        z2,
    )
    whiten(S, W, E, L, 16, False)
    for row in range(15):
        a, b, g = S[W + row], S[W + 16 + row], S[W + 32 + row]
        for c in range(16):
            S[16 * row + c] -= a * S[W + c] + b * S[W + 16 + c] + g * S[W + 32 + c]
    return squared(L)


@inlined
def row_measurement(S, first, h0, h1, h2, nu, variance, tolerance):
    """One scalar measurement nu = h·x[first:first + 3] + noise: update P and estimate E. False, and nothing done, where nu is too large.

    Too large: beyond both `tolerance` (in the unit of nu) and twice what the filter itself is unsure of, taken together as squares.
    """
    p = 16 * first
    for c in range(16):
        S[W + c] = h0 * S[p + c] + h1 * S[p + 16 + c] + h2 * S[p + 32 + c]
    own = h0 * S[W + first] + h1 * S[W + first + 1] + h2 * S[W + first + 2]
    if nu * nu > tolerance * tolerance + 4 * own:
        return False
    i = 1 / math.sqrt(own + variance)
    for c in range(16):
        S[W + c] *= i
        S[E + c] = S[W + c] * (nu * i)
    for r in range(15):
        a = S[W + r]
        for c in range(16):
            S[16 * r + c] -= a * S[W + c]
    return True


@inlined
def replace_attitude(S, prm, c0, c1, c2, c3, c4, c5):
    """Covariance after the attitude was replaced by TRIAD's, of which (c0 … c5) are the first two rows (erratum of Table 2).

    First-order errors of TRIAD, with up exact in its first vector: psi_x = e_y / g, psi_y = -e_x / g, with e the error of the specific
    force in n, and psi_z = ((h·psi) m_z - t·e_m) / m_h, with h the horizontal direction of the field and t across it. The old errors of the
    attitude are gone. Of e, white noise is new, but the accelerometer's offset x is not: e = C x, so psi = A x + noise, and psi takes over
    A times the covariances of x. Without them every stance would seem to tell tilt and offset apart, which it cannot.
    """
    horizontal = math.sqrt(S[at.FIELD_E] * S[at.FIELD_E] + S[at.FIELD_N] * S[at.FIELD_N])
    slope = S[at.FIELD_U] / horizontal
    he, hn = S[at.FIELD_E] / horizontal, S[at.FIELD_N] / horizontal
    g = 1 / prm[at.G]
    a00, a01, a02 = c3 * g, c4 * g, c5 * g
    a10, a11, a12 = -c0 * g, -c1 * g, -c2 * g
    z0, z1 = slope * he, slope * hn
    for c in range(3, 15):
        b0, b1, b2 = S[144 + c], S[160 + c], S[176 + c]
        x = a00 * b0 + a01 * b1 + a02 * b2
        y = a10 * b0 + a11 * b1 + a12 * b2
        z = z0 * x + z1 * y
        S[c], S[16 + c], S[32 + c] = x, y, z
        S[16 * c], S[16 * c + 1], S[16 * c + 2] = x, y, z
    tilt = prm[at.TILT_SD] * prm[at.TILT_SD]
    xx = a00 * S[9] + a01 * S[10] + a02 * S[11] + tilt
    xy = a10 * S[9] + a11 * S[10] + a12 * S[11]
    yy = a10 * S[25] + a11 * S[26] + a12 * S[27] + tilt
    S[0], S[17] = xx, yy
    S[1] = S[16] = xy
    S[2] = S[32] = z0 * xx + z1 * xy
    S[18] = S[33] = z0 * xy + z1 * yy
    S[34] = z0 * z0 * xx + 2 * z0 * z1 * xy + z1 * z1 * yy + prm[at.DIRECTION_SD] * prm[at.DIRECTION_SD]


@inlined
def write_block(S, o, nav, k, j):
    """Packed upper triangle of the 3x3 block of P whose first entry is S[o]."""
    nav[k, j], nav[k, j + 1], nav[k, j + 2] = S[o], S[o + 1], S[o + 2]
    nav[k, j + 3], nav[k, j + 4], nav[k, j + 5] = S[o + 17], S[o + 18], S[o + 34]
