"""A measurement of three numbers: the factor of its innovation's covariance, and the estimated error that follows."""

import math

from bematist.kernels.jit import inlined


@inlined
def factor(s00, s10, s11, s20, s21, s22, z0, z1, z2):
    """The innovation's covariance as L D Lᵀ, the diagonal of L being 1: 1/d0, l10, 1/d1, l20, l21, 1/d2, and y = L⁻¹ z.

    No square root stands between one pivot and the next, and the last two are divided by at once: all that follows waits for them.
    """
    i0 = 1 / s00
    l10, l20 = s10 * i0, s20 * i0
    t11, t21, t22 = s11 - l10 * s10, s21 - l20 * s10, s22 - l20 * s20
    i1, i2 = 1 / t11, t11 / (t11 * t22 - t21 * t21)
    l21 = t21 * i1
    y1 = z1 - l10 * z0
    return i0, l10, i1, l20, l21, i2, z0, y1, z2 - l20 * z0 - l21 * y1


@inlined
def squared(L):
    """The NIS, yᵀ D⁻¹ y; nan where D is not positive."""
    a, b, g = L[6] * math.sqrt(L[0]), L[7] * math.sqrt(L[2]), L[8] * math.sqrt(L[5])
    return a * a + b * b + g * g


@inlined
def whiten(S, w, x, L, n, add):
    """Rows H P (3 by n), at S[w:], become Wᵀ = D^-½ L⁻¹ H P; the estimated error W D^-½ y goes to S[x:], or is added to what is there."""
    i0, l10, i1, l20, l21, i2, y0, y1, y2 = L
    r0, r1, r2 = math.sqrt(i0), math.sqrt(i1), math.sqrt(i2)
    e0, e1, e2 = y0 * i0, y1 * i1, y2 * i2
    for c in range(n):
        u = S[w + c]
        v = S[w + n + c] - l10 * u
        t = S[w + 2 * n + c] - l20 * u - l21 * v
        S[w + c], S[w + n + c], S[w + 2 * n + c] = u * r0, v * r1, t * r2
        S[x + c] = (S[x + c] if add else 0.0) + e0 * u + e1 * v + e2 * t
