"""How periodic the last seconds were, and with which period: autocorrelations over an exponential window, one lag a cell.

Of the acceleration x: R_l = sum λ^(k-j) x_j x_(j-l), against the energies of both factors. That of the second factor is the
energy of l cells ago, E_(k-l) = sum λ^(k-j) x_(j-l)², so that one ring of 1/√E does for all lags. Of the angular rate the same with the
scalar product: a swinging arm or leg turns back and forth once a stride, a held device with each step if at all.
"""

import math

from bematist.kernels import steps_layout as at
from bematist.kernels.jit import apart, inlined


@inlined
def _scale(energy):
    """What makes a correlation a coefficient, once for each of its factors; 0 without energy."""
    return 1 / math.sqrt(energy) if energy > 0 else 0.0


@apart
def correlate(S, prm, k, x, w0, w1, w2):
    """Take the k-th cell into both correlations."""
    keep = prm[at.CORRELATION_DECAY]
    p = k & (at.RING - 1)
    for o in (p, p + at.RING):
        S[at.RING_X + o] = x
        S[at.RING_W + o], S[at.RING_W + 2 * at.RING + o], S[at.RING_W + 4 * at.RING + o] = w0, w1, w2
    now = p + at.RING
    for lag in range(at.LAGS):
        o = now - lag
        S[at.CORRELATION_X + lag] = keep * S[at.CORRELATION_X + lag] + x * S[at.RING_X + o]
        S[at.CORRELATION_W + lag] = keep * S[at.CORRELATION_W + lag] + (
            w0 * S[at.RING_W + o] + w1 * S[at.RING_W + 2 * at.RING + o] + w2 * S[at.RING_W + 4 * at.RING + o]
        )
    S[at.SCALE_X + p], S[at.SCALE_W + p] = _scale(S[at.CORRELATION_X]), _scale(S[at.CORRELATION_W])


@inlined
def _normalised(S, correlation, scales, k, lag):
    """Correlation coefficient at a lag; 0 where the earlier factor has less than a tenth of the energy of the later, or none."""
    a = S[scales + (k & (at.RING - 1))]
    b = S[scales + ((k - lag) & (at.RING - 1))]
    return S[correlation + lag] * a * b if b * b <= 10 * a * a else 0.0


@inlined
def of_force(S, k, lag):
    """Coefficient of the acceleration at a lag, cells."""
    return _normalised(S, at.CORRELATION_X, at.SCALE_X, k, lag)


@inlined
def of_rate(S, k, lag):
    """Coefficient of the angular rate at a lag, cells."""
    return _normalised(S, at.CORRELATION_W, at.SCALE_W, k, lag)


@inlined
def _between(S, correlation, scales, k, seconds):
    """Coefficient at a lag in s, between cells on a line; 0 beyond the last lag."""
    lag = seconds / at.CELL_S
    i = int(lag)
    if i + 1 >= at.LAGS:
        return 0.0
    a = _normalised(S, correlation, scales, k, i)
    return a + (lag - i) * (_normalised(S, correlation, scales, k, i + 1) - a)


@inlined
def force_at(S, k, seconds):
    """Coefficient of the acceleration at a lag in s."""
    return _between(S, at.CORRELATION_X, at.SCALE_X, k, seconds)


@inlined
def rate_at(S, k, seconds):
    """Coefficient of the angular rate at a lag in s."""
    return _between(S, at.CORRELATION_W, at.SCALE_W, k, seconds)


@inlined
def _top(a, b, c):
    """Where between -½ and ½ a parabola through three values at -1, 0, 1 is highest, and how high."""
    bend = a - 2 * b + c
    if not bend < 0:
        return 0.0, b
    d = 0.5 * (a - c) / bend
    return d, b - 0.25 * (a - c) * d


@apart
def find_period(S, prm, k):
    """Period of the acceleration, s, and its coefficient: the shortest lag that is nearly as good as the best; 0 where none is.

    A signal repeats after two and three periods too. Sought is the shortest lag at a top of at least 0.85 of the highest.
    """
    first = max(2, int(1 / (prm[at.FASTEST_HZ] * at.CELL_S)))
    best = 0.0
    for lag in range(first, at.LAGS - 1):
        best = max(best, of_force(S, k, lag))
    if best <= 0:
        return 0.0, 0.0
    b = of_force(S, k, first - 1)
    c = of_force(S, k, first)
    for lag in range(first, at.LAGS - 1):
        a, b = b, c
        c = of_force(S, k, lag + 1)
        if b >= 0.85 * best and b >= a and b > c:
            shift, height = _top(a, b, c)
            return (lag + shift) * at.CELL_S, height
    return 0.0, 0.0


@apart
def find_rate_period(S, prm, k):
    """Period of the angular rate, s, and its coefficient: from the stride of the fastest step to the last lag.

    That is 1.6 s: strides of steps below 1.25 Hz are not seen.
    """
    first = max(2, int(2 / (prm[at.FASTEST_HZ] * at.CELL_S)))
    best = 0.0
    where = 0.0
    for lag in range(first, at.LAGS - 1):
        b = of_rate(S, k, lag)
        if b > best:
            a, c = of_rate(S, k, lag - 1), of_rate(S, k, lag + 1)
            if b >= a and b > c:
                shift, best = _top(a, b, c)
                where = (lag + shift) * at.CELL_S
    return where, best
