"""A measurement of three numbers: the factor of its innovation's covariance, and the estimated error that follows."""

import math

from bematist.kernels.jit import inlined


@inlined
def factor(s00, s10, s11, s20, s21, s22, z0, z1, z2):
    """The innovation's covariance as L D Lᵀ: 1/√d0, l10, 1/√d1, l20, l21, 1/√d2, and y = D^-½ L⁻¹ z, whose square is the NIS.

    The diagonal of L is 1: no square root then stands between one pivot and the next, where all that follows would wait for it.
    """
    i0 = 1 / s00
    l10, l20 = s10 * i0, s20 * i0
    t11, t21, t22 = s11 - l10 * s10, s21 - l20 * s10, s22 - l20 * s20
    i1, i2 = 1 / t11, t11 / (t11 * t22 - t21 * t21)
    l21 = t21 * i1
    y1 = z1 - l10 * z0
    y2 = z2 - l20 * z0 - l21 * y1
    r0, r1, r2 = math.sqrt(i0), math.sqrt(i1), math.sqrt(i2)
    return r0, l10, r1, l20, l21, r2, z0 * r0, y1 * r1, y2 * r2


@inlined
def whiten(S, w, e, L, n):
    """Rows H P (3 by n), at S[w:], become Wᵀ = D^-½ L⁻¹ H P, and the estimated error goes to S[e:]; L as from `factor`."""
    r0, l10, r1, l20, l21, r2, y0, y1, y2 = L
    for c in range(n):
        u = S[w + c]
        v = S[w + n + c] - l10 * u
        t = S[w + 2 * n + c] - l20 * u - l21 * v
        a, b, g = u * r0, v * r1, t * r2
        S[w + c], S[w + n + c], S[w + 2 * n + c] = a, b, g
        S[e + c] = a * y0 + b * y1 + g * y2
