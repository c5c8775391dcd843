"""The error state of the handheld filter and its covariance: Jacobians and updates; the prediction is in `hand_transition`.

Additive error, true = estimate + error (MAGYQ eq 27), in the order of `hand_layout`: quaternion (4), gyroscope-quaternion offset (3),
accelerometer offset (3), references of magnetic field and specific force in n (3 + 3). Erratum of eq 26: the scalar part of the
gyroscope-quaternion offset is no state. The covariance is 16 rows of 16 at the head of the workspace S.
"""

from bematist.kernels.hand_layout import Q, W, X
from bematist.kernels.innovation import whiten
from bematist.kernels.jit import apart, inlined
from bematist.kernels.rotation import normalise


@inlined
def h1(q0, q1, q2, q3, x0, x1, x2):
    """Derivative (3x4, row by row) of q ⊗ x ⊗ q* to q: MAGYQ eq 38. Erratum of eq 37: x is a vector in the body frame."""
    v0 = 2 * (q0 * x0 + q2 * x2 - q3 * x1)
    v1 = 2 * (q0 * x1 + q3 * x0 - q1 * x2)
    v2 = 2 * (q0 * x2 + q1 * x1 - q2 * x0)
    d = 2 * (q1 * x0 + q2 * x1 + q3 * x2)
    return v0, d, v2, -v1, v1, -v2, d, v0, v2, v1, -v0, d


@inlined
def h3(q0, q1, q2, q3, x0, x1, x2):
    """Derivative (3x4, row by row) of q* ⊗ x ⊗ q to q: MAGYQ eq 43."""
    v0 = 2 * (q0 * x0 - q2 * x2 + q3 * x1)
    v1 = 2 * (q0 * x1 - q3 * x0 + q1 * x2)
    v2 = 2 * (q0 * x2 - q1 * x1 + q2 * x0)
    d = 2 * (q1 * x0 + q2 * x1 + q3 * x2)
    return v0, d, -v2, v1, v1, v2, d, -v0, v2, -v1, v0, d


@inlined
def times_offset(h, D, o):
    """h (3x4) times the derivative D (4x3, at D[o]) to the gyroscope-quaternion offset: nine entries, row by row."""
    a, b, c, d = h[0], h[1], h[2], h[3]
    e, f, g, i = h[4], h[5], h[6], h[7]
    j, k, m, n = h[8], h[9], h[10], h[11]
    return (
        a * D[o] + b * D[o + 3] + c * D[o + 6] + d * D[o + 9],
        a * D[o + 1] + b * D[o + 4] + c * D[o + 7] + d * D[o + 10],
        a * D[o + 2] + b * D[o + 5] + c * D[o + 8] + d * D[o + 11],
        e * D[o] + f * D[o + 3] + g * D[o + 6] + i * D[o + 9],
        e * D[o + 1] + f * D[o + 4] + g * D[o + 7] + i * D[o + 10],
        e * D[o + 2] + f * D[o + 5] + g * D[o + 8] + i * D[o + 11],
        j * D[o] + k * D[o + 3] + m * D[o + 6] + n * D[o + 9],
        j * D[o + 1] + k * D[o + 4] + m * D[o + 7] + n * D[o + 10],
        j * D[o + 2] + k * D[o + 5] + m * D[o + 8] + n * D[o + 11],
    )


@inlined
def rows_quaternion(S, h):
    """W ← H_q P_q, for the part h (3x4) of a measurement's H that belongs to the quaternion."""
    for c in range(16):
        a0, a1, a2, a3 = S[c], S[16 + c], S[32 + c], S[48 + c]
        S[W + c] = h[0] * a0 + h[1] * a1 + (h[2] * a2 + h[3] * a3)
        S[W + 16 + c] = h[4] * a0 + h[5] * a1 + (h[6] * a2 + h[7] * a3)
        S[W + 32 + c] = h[8] * a0 + h[9] * a1 + (h[10] * a2 + h[11] * a3)


@inlined
def rows_quaternion_accel(S, h, b):
    """The same where H also has a part b (3x3) for the accelerometer's offset."""
    for c in range(16):
        a0, a1, a2, a3, x, y, z = S[c], S[16 + c], S[32 + c], S[48 + c], S[112 + c], S[128 + c], S[144 + c]
        S[W + c] = h[0] * a0 + h[1] * a1 + h[2] * a2 + h[3] * a3 + (b[0] * x + b[1] * y + b[2] * z)
        S[W + 16 + c] = h[4] * a0 + h[5] * a1 + h[6] * a2 + h[7] * a3 + (b[3] * x + b[4] * y + b[5] * z)
        S[W + 32 + c] = h[8] * a0 + h[9] * a1 + h[10] * a2 + h[11] * a3 + (b[6] * x + b[7] * y + b[8] * z)


@inlined
def rows_gyro(S, g):
    """W ← H_b P_b, for the part g (3x3) of a measurement's H that belongs to the gyroscope-quaternion offset."""
    for c in range(16):
        b0, b1, b2 = S[64 + c], S[80 + c], S[96 + c]
        S[W + c] = g[0] * b0 + g[1] * b1 + g[2] * b2
        S[W + 16 + c] = g[3] * b0 + g[4] * b1 + g[5] * b2
        S[W + 32 + c] = g[6] * b0 + g[7] * b1 + g[8] * b2


@inlined
def rows_gyro_accel(S, g, b):
    """The same where H also has a part b (3x3) for the accelerometer's offset."""
    for c in range(16):
        b0, b1, b2, x, y, z = S[64 + c], S[80 + c], S[96 + c], S[112 + c], S[128 + c], S[144 + c]
        S[W + c] = g[0] * b0 + g[1] * b1 + g[2] * b2 + (b[0] * x + b[1] * y + b[2] * z)
        S[W + 16 + c] = g[3] * b0 + g[4] * b1 + g[5] * b2 + (b[3] * x + b[4] * y + b[5] * z)
        S[W + 32 + c] = g[6] * b0 + g[7] * b1 + g[8] * b2 + (b[6] * x + b[7] * y + b[8] * z)


@inlined
def rows_own_field(S):
    """W ← W − P_m, where the reference of the magnetic field is a part of the state."""
    for c in range(16):
        S[W + c] -= S[160 + c]
        S[W + 16 + c] -= S[176 + c]
        S[W + 32 + c] -= S[192 + c]


@inlined
def rows_own_force(S):
    """W ← W − P_f, where the reference of the specific force is a part of the state."""
    for c in range(16):
        S[W + c] -= S[208 + c]
        S[W + 16 + c] -= S[224 + c]
        S[W + 32 + c] -= S[240 + c]


@inlined
def times_quaternion(S, r, h):
    """Row r of W times H_qᵀ: three numbers."""
    o = W + 16 * r
    a0, a1, a2, a3 = S[o], S[o + 1], S[o + 2], S[o + 3]
    return (
        a0 * h[0] + a1 * h[1] + a2 * h[2] + a3 * h[3],
        a0 * h[4] + a1 * h[5] + a2 * h[6] + a3 * h[7],
        a0 * h[8] + a1 * h[9] + a2 * h[10] + a3 * h[11],
    )


@inlined
def times_block(S, r, e, h):
    """Row r of W, from column e on, times H_bᵀ (3x3): three numbers."""
    o = W + 16 * r + e
    b0, b1, b2 = S[o], S[o + 1], S[o + 2]
    return b0 * h[0] + b1 * h[1] + b2 * h[2], b0 * h[3] + b1 * h[4] + b2 * h[5], b0 * h[6] + b1 * h[7] + b2 * h[8]


@inlined
def _subtract_four(S, n):
    """P ← P − W Wᵀ, n columns of the rows of the quaternion. Several rows in one loop: else no vector registers are used."""
    a0, b0, g0 = S[W + 0], S[W + 16], S[W + 32]
    a1, b1, g1 = S[W + 1], S[W + 17], S[W + 33]
    a2, b2, g2 = S[W + 2], S[W + 18], S[W + 34]
    a3, b3, g3 = S[W + 3], S[W + 19], S[W + 35]
    for c in range(n):
        x, y, z = S[W + c], S[W + 16 + c], S[W + 32 + c]
        S[c] = S[c] - a0 * x - b0 * y - g0 * z
        S[16 + c] = S[16 + c] - a1 * x - b1 * y - g1 * z
        S[32 + c] = S[32 + c] - a2 * x - b2 * y - g2 * z
        S[48 + c] = S[48 + c] - a3 * x - b3 * y - g3 * z


@inlined
def _subtract_six(S, r, n):
    """The same of six rows from r on: two blocks of three components."""
    w, o = W + r, 16 * r
    a0, b0, g0 = S[w], S[w + 16], S[w + 32]
    a1, b1, g1 = S[w + 1], S[w + 17], S[w + 33]
    a2, b2, g2 = S[w + 2], S[w + 18], S[w + 34]
    a3, b3, g3 = S[w + 3], S[w + 19], S[w + 35]
    a4, b4, g4 = S[w + 4], S[w + 20], S[w + 36]
    a5, b5, g5 = S[w + 5], S[w + 21], S[w + 37]
    for c in range(n):
        x, y, z = S[W + c], S[W + 16 + c], S[W + 32 + c]
        S[o + c] = S[o + c] - a0 * x - b0 * y - g0 * z
        S[o + 16 + c] = S[o + 16 + c] - a1 * x - b1 * y - g1 * z
        S[o + 32 + c] = S[o + 32 + c] - a2 * x - b2 * y - g2 * z
        S[o + 48 + c] = S[o + 48 + c] - a3 * x - b3 * y - g3 * z
        S[o + 64 + c] = S[o + 64 + c] - a4 * x - b4 * y - g4 * z
        S[o + 80 + c] = S[o + 80 + c] - a5 * x - b5 * y - g5 * z


@apart
def update(S, L, references):
    """x ← x + W D^-½ y and P ← P − W Wᵀ with W = P Hᵀ L⁻ᵀ D^-½ (W holds H P before), L, D, y as `factor` has them.

    Then the quaternion is a unit quaternion again. Without `references` in the state, their rows and columns are zero and left out.
    """
    whiten(S, W, X, L, 16, True)
    unite(S)
    subtract(S, references)


@inlined
def subtract(S, references):
    """P ← P − W Wᵀ."""
    if references:
        _subtract_four(S, 16)
        _subtract_six(S, 4, 16)
        _subtract_six(S, 10, 16)
    else:
        _subtract_four(S, 12)
        _subtract_six(S, 4, 12)


@inlined
def unite(S):
    """The quaternion as a unit quaternion."""
    S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = normalise(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])


@inlined
def _subtract_row(S, references):
    """P ← P − w wᵀ with w the first row of W."""
    a0, a1, a2, a3, a4 = S[W], S[W + 1], S[W + 2], S[W + 3], S[W + 4]
    a5, a6, a7, a8, a9 = S[W + 5], S[W + 6], S[W + 7], S[W + 8], S[W + 9]
    for c in range(16):
        w = S[W + c]
        S[c] -= a0 * w
        S[16 + c] -= a1 * w
        S[32 + c] -= a2 * w
        S[48 + c] -= a3 * w
        S[64 + c] -= a4 * w
        S[80 + c] -= a5 * w
        S[96 + c] -= a6 * w
        S[112 + c] -= a7 * w
        S[128 + c] -= a8 * w
        S[144 + c] -= a9 * w
    if references:
        a10, a11, a12, a13, a14, a15 = S[W + 10], S[W + 11], S[W + 12], S[W + 13], S[W + 14], S[W + 15]
        for c in range(16):
            w = S[W + c]
            S[160 + c] -= a10 * w
            S[176 + c] -= a11 * w
            S[192 + c] -= a12 * w
            S[208 + c] -= a13 * w
            S[224 + c] -= a14 * w
            S[240 + c] -= a15 * w


@apart
def update_scalar(S, y, i, references):
    """The same for one number: W holds H P in its first row, i = 1/√(H P Hᵀ + R), y = i·z."""
    for c in range(16):
        S[W + c] *= i
        S[X + c] += S[W + c] * y
    unite(S)
    _subtract_row(S, references)


@inlined
def rotation_rows(S):
    """−2 Gᵀ by columns: with them the quaternion's error becomes the rotation vector psi in n, C_est = exp([psi×]) C_true.

    q_true = exp(−psi/2) ⊗ q, so δq = −½ G psi with G = C(q)[:, 1:4] and, as δq is normal to q, psi = −2 Gᵀ δq.
    """
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    return (
        (2 * q1, 2 * q2, 2 * q3),
        (-2 * q0, -2 * q3, 2 * q2),
        (2 * q3, -2 * q0, -2 * q1),
        (-2 * q2, 2 * q1, -2 * q0),
    )


@inlined
def _times_quaternion_covariance(S, a, b, c, d):
    """(a, b, c, d) P_qq."""
    return (
        a * S[0] + b * S[16] + c * S[32] + d * S[48],
        a * S[1] + b * S[17] + c * S[33] + d * S[49],
        a * S[2] + b * S[18] + c * S[34] + d * S[50],
        a * S[3] + b * S[19] + c * S[35] + d * S[51],
    )


@inlined
def _dot(t, a, b, c, d):
    return t[0] * a + t[1] * b + t[2] * c + t[3] * d


@apart
def write_attitude_covariance(S, nav, k, j):
    """Packed covariance of psi (rad², rotation vector in n): 4 Gᵀ P_qq G."""
    a, b, c, d = rotation_rows(S)
    t = _times_quaternion_covariance(S, a[0], b[0], c[0], d[0])
    nav[k, j] = _dot(t, a[0], b[0], c[0], d[0])
    nav[k, j + 1] = _dot(t, a[1], b[1], c[1], d[1])
    nav[k, j + 2] = _dot(t, a[2], b[2], c[2], d[2])
    t = _times_quaternion_covariance(S, a[1], b[1], c[1], d[1])
    nav[k, j + 3] = _dot(t, a[1], b[1], c[1], d[1])
    nav[k, j + 4] = _dot(t, a[2], b[2], c[2], d[2])
    t = _times_quaternion_covariance(S, a[2], b[2], c[2], d[2])
    nav[k, j + 5] = _dot(t, a[2], b[2], c[2], d[2])
