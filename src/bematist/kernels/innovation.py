"""A measurement of three numbers: the factor of its innovation's covariance, and the estimated error that follows."""

import math

from bematist.kernels.jit import inlined


@inlined
def factor(s00, s10, s11, s20, s21, s22, z0, z1, z2):
    """Factor L of the innovation's covariance, as 1/l00, l10, 1/l11, l20, l21, 1/l22, and y = L⁻¹ z, whose square is the NIS."""
    i0 = 1 / math.sqrt(s00)
    l10, l20 = s10 * i0, s20 * i0
    i1 = 1 / math.sqrt(s11 - l10 * l10)
    l21 = (s21 - l20 * l10) * i1
    i2 = 1 / math.sqrt(s22 - l20 * l20 - l21 * l21)
    y0 = z0 * i0
    y1 = (z1 - l10 * y0) * i1
    y2 = (z2 - l20 * y0 - l21 * y1) * i2
    return i0, l10, i1, l20, l21, i2, y0, y1, y2


@inlined
def whiten(S, w, e, L, n):
    """Rows H P (3 by n), at S[w:], become Wᵀ = L⁻¹ H P, and the estimated error W L⁻¹ z goes to S[e:]; L as `factor` returns it."""
    i0, l10, i1, l20, l21, i2, y0, y1, y2 = L
    for c in range(n):
        a = S[w + c] * i0
        b = (S[w + n + c] - l10 * a) * i1
        g = (S[w + 2 * n + c] - l20 * a - l21 * b) * i2
        S[w + c], S[w + n + c], S[w + 2 * n + c] = a, b, g
        S[e + c] = a * y0 + b * y1 + g * y2
