"""The error of the handheld filter from sample to sample: its derivatives and the covariance; the order is that of `hand_layout`."""

from bematist.kernels import hand_layout as at
from bematist.kernels.hand_layout import Q
from bematist.kernels.jit import apart, inlined


@inlined
def offset_derivative(q0, q1, q2, q3, a0, a1, a2, a3, p1, p2, p3, s):
    """Derivative (4x3, row by row) of a = q ⊗ q_w to the gyroscope-quaternion offset, s (a pᵀ − q ⊗ (i, j, k)).

    With p the vector part of q_w and s = 1/|q_y − b| it is that of q_w = (q_y − b)/|q_y − b| (eq 30), −s (I − q_w q_wᵀ), turned by q; with
    p = 0 and s = 1 without that normalisation. For q = 1 it is that of q_w itself.
    """
    return (
        *(s * (a0 * p1 + q1), s * (a0 * p2 + q2), s * (a0 * p3 + q3)),
        *(s * (a1 * p1 - q0), s * (a1 * p2 + q3), s * (a1 * p3 - q2)),
        *(s * (a2 * p1 - q3), s * (a2 * p2 - q0), s * (a2 * p3 + q1)),
        *(s * (a3 * p1 + q2), s * (a3 * p2 - q1), s * (a3 * p3 - q0)),
    )


@inlined
def transition(w, x, y, z, q0, q1, q2, q3, r0, r1, r2, r3):
    """Φ of the quaternion (4x4, row by row), eq 32: C(q_w) − r qᵀ; (w, x, y, z) is q_w.

    With r = q ⊗ q_w it is C(q_w) (I − q qᵀ): what P says along the quaternion q, which was normalised after every update, is left out
    (erratum of eq 32). With r = 0 it is C(q_w) alone.
    """
    return (
        *(w - r0 * q0, -x - r0 * q1, -y - r0 * q2, -z - r0 * q3),
        *(x - r1 * q0, w - r1 * q1, z - r1 * q2, -y - r1 * q3),
        *(y - r2 * q0, -z - r2 * q1, w - r2 * q2, x - r2 * q3),
        *(z - r3 * q0, y - r3 * q1, -x - r3 * q2, w - r3 * q3),
    )


@inlined
def _turned_rows(S, A, B, decay):
    """Φ P, the rows of the quaternion, and of all others the columns of the accelerometer's offset, which decay."""
    for c in range(16):
        s = decay if at.E_BA <= c < at.E_M else 1.0
        a0, a1, a2, a3 = S[c], S[16 + c], S[32 + c], S[48 + c]
        b0, b1, b2 = S[64 + c], S[80 + c], S[96 + c]
        S[c] = s * (A[0] * a0 + A[1] * a1 + A[2] * a2 + A[3] * a3 + B[0] * b0 + B[1] * b1 + B[2] * b2)
        S[16 + c] = s * (A[4] * a0 + A[5] * a1 + A[6] * a2 + A[7] * a3 + B[3] * b0 + B[4] * b1 + B[5] * b2)
        S[32 + c] = s * (A[8] * a0 + A[9] * a1 + A[10] * a2 + A[11] * a3 + B[6] * b0 + B[7] * b1 + B[8] * b2)
        S[48 + c] = s * (A[12] * a0 + A[13] * a1 + A[14] * a2 + A[15] * a3 + B[9] * b0 + B[10] * b1 + B[11] * b2)
        S[64 + c], S[80 + c], S[96 + c] = s * b0, s * b1, s * b2
        S[112 + c], S[128 + c], S[144 + c] = s * decay * S[112 + c], s * decay * S[128 + c], s * decay * S[144 + c]


@inlined
def _row(S, o):
    """Seven entries from S[o] on: what a row of Φ P holds of the quaternion and of the gyroscope-quaternion offset."""
    return S[o], S[o + 1], S[o + 2], S[o + 3], S[o + 4], S[o + 5], S[o + 6]


@inlined
def _times(row, A, B, k):
    """A row of Φ P times row k of Φ."""
    a0, a1, a2, a3, b0, b1, b2 = row
    i, j = 4 * k, 3 * k
    return a0 * A[i] + a1 * A[i + 1] + a2 * A[i + 2] + a3 * A[i + 3] + b0 * B[j] + b1 * B[j + 1] + b2 * B[j + 2]


@apart
def propagate_covariance(S, A, B, noise, bias_walk, decay, accel_walk, field_walk, force_walk, references):
    """P ← Φ P Φᵀ + Q, MAGYQ eq 32, with Φ = {q←q: A (4x4), q←b_q: B (4x3), b_a←b_a: decay}.

    Errata: the noise of the accelerometer offset is its own; the normalisations are in A and B. The quaternion in S is the new one
    already; `noise` is (dt/2)² times the variance of a gyroscope sample. Without `references` in the state their rows stay zero.
    """
    _turned_rows(S, A, B, decay)
    if references:
        for r in range(10, 16):
            o = 16 * r
            S[o], S[o + 1], S[o + 2], S[o + 3] = S[r], S[16 + r], S[32 + r], S[48 + r]
            for c in range(7, 10):
                S[o + c] = S[16 * c + r]
        for i in range(3):
            S[17 * (at.E_M + i)] += field_walk
            S[17 * (at.E_F + i)] += force_walk
    for r in range(4, 10):
        o = 16 * r
        S[o], S[o + 1], S[o + 2], S[o + 3] = S[r], S[16 + r], S[32 + r], S[48 + r]
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    row = _row(S, 0)
    p00 = _times(row, A, B, 0) + noise * (1 - q0 * q0)
    p01 = _times(row, A, B, 1) - noise * q0 * q1
    p02 = _times(row, A, B, 2) - noise * q0 * q2
    p03 = _times(row, A, B, 3) - noise * q0 * q3
    row = _row(S, 16)
    p11 = _times(row, A, B, 1) + noise * (1 - q1 * q1)
    p12 = _times(row, A, B, 2) - noise * q1 * q2
    p13 = _times(row, A, B, 3) - noise * q1 * q3
    row = _row(S, 32)
    p22 = _times(row, A, B, 2) + noise * (1 - q2 * q2)
    p23 = _times(row, A, B, 3) - noise * q2 * q3
    p33 = _times(_row(S, 48), A, B, 3) + noise * (1 - q3 * q3)
    S[0], S[1], S[2], S[3] = p00, p01, p02, p03
    S[16], S[17], S[18], S[19] = p01, p11, p12, p13
    S[32], S[33], S[34], S[35] = p02, p12, p22, p23
    S[48], S[49], S[50], S[51] = p03, p13, p23, p33
    for i in range(3):
        S[17 * (at.E_BQ + i)] += bias_walk
        S[17 * (at.E_BA + i)] += accel_walk


@inlined
def add_attitude_noise(S, noise):
    """P_qq ← P_qq + noise · (I − q qᵀ): a rotation vector of variance 4·noise about each axis."""
    for r in range(4):
        S[17 * r] += noise
        for c in range(4):
            S[16 * r + c] -= noise * (S[Q + r] * S[Q + c])


@apart
def project(S):
    """Take out of P what it says along the quaternion: J P Jᵀ, J = I − q qᵀ (erratum of eq 32), as `transition` does it."""
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    for c in range(16):
        a0, a1, a2, a3 = S[c], S[16 + c], S[32 + c], S[48 + c]
        t = q0 * a0 + q1 * a1 + q2 * a2 + q3 * a3
        S[c], S[16 + c], S[32 + c], S[48 + c] = a0 - q0 * t, a1 - q1 * t, a2 - q2 * t, a3 - q3 * t
    for r in range(4):
        o = 16 * r
        t = q0 * S[o] + q1 * S[o + 1] + q2 * S[o + 2] + q3 * S[o + 3]
        S[o] -= q0 * t
        S[o + 1] -= q1 * t
        S[o + 2] -= q2 * t
        S[o + 3] -= q3 * t
    for r in range(4):
        for c in range(r + 1, 16):
            S[16 * c + r] = S[16 * r + c]
