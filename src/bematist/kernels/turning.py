"""A turn by a gyroscope with scale factors and misalignments S: the attitude, and how it changes with S."""

import math

from bematist.kernels.jit import inlined, kernel
from bematist.kernels.rotation import exp_quaternion, matrix, multiply, normalise


@inlined
def right_jacobian(x, y, z):
    """The nine entries of J_r, row by row, with exp(θ + dθ) = exp(θ) exp(J_r dθ).

    J_r = I − a [θ]× + b [θ]×², a = (1 − cos θ)/θ², b = (θ − sin θ)/θ³.
    """
    s = x * x + y * y + z * z
    if s < 1e-4:
        a, b = 0.5 - s / 24, 1 / 6 - s / 120
    else:
        t = math.sqrt(s)
        a, b = (1 - math.cos(t)) / s, (t - math.sin(t)) / (s * t)
    return (
        1 - b * (y * y + z * z),
        a * z + b * x * y,
        -a * y + b * x * z,
        -a * z + b * x * y,
        1 - b * (x * x + z * z),
        a * x + b * y * z,
        a * y + b * x * z,
        -a * x + b * y * z,
        1 - b * (x * x + y * y),
    )


@kernel
def propagate(w, dt, S, q, G):
    """Attitudes q (n,4) after each of the steps dt (n,), s, relative to before the first, with the rates S w, rad/s; w is (n,3), S (9,).

    G (27,) becomes the derivative at the end: a change dS turns the end by dφ_a = Σ G_abc dS_bc, in the axes of the end. At each step
    G ← exp(θ)ᵀ G + J_r(θ) ⊗ (w dt). An empty G is left alone.
    """
    a, b, c, d = 1.0, 0.0, 0.0, 0.0
    derive = len(G) == 27
    for i in range(27 if derive else 0):
        G[i] = 0.0
    for i in range(len(dt)):
        u, v, t = w[i, 0] * dt[i], w[i, 1] * dt[i], w[i, 2] * dt[i]
        x = S[0] * u + S[1] * v + S[2] * t
        y = S[3] * u + S[4] * v + S[5] * t
        z = S[6] * u + S[7] * v + S[8] * t
        e, f, g, h = exp_quaternion(x, y, z)
        a, b, c, d = multiply(a, b, c, d, e, f, g, h)
        a, b, c, d = normalise(a, b, c, d)
        q[i, 0], q[i, 1], q[i, 2], q[i, 3] = a, b, c, d
        if derive:
            r0, r1, r2, r3, r4, r5, r6, r7, r8 = matrix(e, f, g, h)
            j0, j1, j2, j3, j4, j5, j6, j7, j8 = right_jacobian(x, y, z)
            for k in range(9):
                p0, p1, p2 = G[k], G[9 + k], G[18 + k]
                s = u if k % 3 == 0 else (v if k % 3 == 1 else t)
                row = k // 3
                m0 = j0 if row == 0 else (j1 if row == 1 else j2)
                m1 = j3 if row == 0 else (j4 if row == 1 else j5)
                m2 = j6 if row == 0 else (j7 if row == 1 else j8)
                G[k] = r0 * p0 + r3 * p1 + r6 * p2 + m0 * s
                G[9 + k] = r1 * p0 + r4 * p1 + r7 * p2 + m1 * s
                G[18 + k] = r2 * p0 + r5 * p1 + r8 * p2 + m2 * s
