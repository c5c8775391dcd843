"""Where the walker goes: a body axis, levelled and averaged over a step, from the attitudes of the last seconds.

Which axis it is depends on how the device is carried, and the first steps of a walk are older than the answer. So the attitudes are kept,
not the directions.
"""

import math

from bematist.kernels import pdr_layout as at
from bematist.kernels.jit import apart, inlined
from bematist.kernels.rotation import matrix


@inlined
def level(C, x, y, z):
    """A body axis in n."""
    return C[0] * x + C[1] * y + C[2] * z, C[3] * x + C[4] * y + C[5] * z, C[6] * x + C[7] * y + C[8] * z


@inlined
def heading_gradient(d0, d1, d2):
    """d(heading of d) / d(psi): the horizontal direction of a vector d in n that turns by psi × d."""
    k = d2 / (d0 * d0 + d1 * d1)
    return -k * d0, -k * d1, 1.0


@apart
def look_ahead(W, prm, r, carrying):
    """Direction ahead (east, north), of unit length in plan, at the attitude of record r, and the variance of its heading.

    The axis that points ahead, levelled; where it stands too upright to tell, at right angles to the axis that points to the right.
    Zeros where neither tells.
    """
    C = matrix(W[r + at.R_Q], W[r + at.R_Q + 1], W[r + at.R_Q + 2], W[r + at.R_Q + 3])
    axes = at.AXES + 6 * int(carrying)
    d0, d1, d2 = level(C, prm[axes], prm[axes + 1], prm[axes + 2])
    h2 = d0 * d0 + d1 * d1
    e, n = d0, d1
    if h2 < prm[at.STEEP] * prm[at.STEEP]:
        d0, d1, d2 = level(C, prm[axes + 3], prm[axes + 4], prm[axes + 5])
        h2 = d0 * d0 + d1 * d1
        e, n = -d1, d0
    if h2 < 1e-6:
        return 0.0, 0.0, 0.0
    g0, g1, g2 = heading_gradient(d0, d1, d2)
    h = math.sqrt(h2)
    e, n = e / h, n / h
    variance = prm[at.HEADING_FIXED]
    if variance < 0:
        o = r + at.R_COVARIANCE
        xx, xy, xz, yy, yz, zz = W[o], W[o + 1], W[o + 2], W[o + 3], W[o + 4], W[o + 5]
        variance = g0 * (g0 * xx + 2 * (g1 * xy + g2 * xz)) + g1 * (g1 * yy + 2 * g2 * yz) + g2 * g2 * zz
    return prm[at.OFFSET_COS] * e - prm[at.OFFSET_SIN] * n, prm[at.OFFSET_SIN] * e + prm[at.OFFSET_COS] * n, variance


@inlined
def remember(W, t, rows, k):
    """The attitude and its covariance, row k of the attitude filter, into the newest record, and every SLOT_S into the history."""
    W[at.NOW] = t
    for i in range(1, at.SLOT):
        W[at.NOW + i] = rows[k, i]
    count = int(W[at.COUNT])
    if count == 0 or t - W[at.RING + at.SLOT * ((count - 1) % at.SLOTS)] >= at.SLOT_S:
        for i in range(at.SLOT):
            W[at.RING + at.SLOT * (count % at.SLOTS) + i] = W[at.NOW + i]
        W[at.COUNT] = count + 1


@apart
def mean_ahead(W, prm, t0, t1, carrying):
    """Integral of the direction ahead (east, north) from t0 to t1, both past, by trapezia, and the variance of its heading at t1.

    Over a gap nothing is added.
    """
    count = int(W[at.COUNT])
    later = at.NOW
    east, north, end = 0.0, 0.0, at.NOW
    for back in range(1, min(count, at.SLOTS) + 1):
        r = at.RING + at.SLOT * ((count - back) % at.SLOTS)
        a, b = W[r], W[later]
        if W[end] > t1:
            end = r
        low, high = max(a, t0), min(b, t1)
        if high > low and b - a <= prm[at.GAP_S] + at.SLOT_S:
            e0, n0, _ = look_ahead(W, prm, r, carrying)
            e1, n1, _ = look_ahead(W, prm, later, carrying)
            u = (0.5 * (low + high) - a) / (b - a)
            east += (high - low) * (e0 + u * (e1 - e0))
            north += (high - low) * (n0 + u * (n1 - n0))
        if a <= t0:
            break
        later = r
    _, _, variance = look_ahead(W, prm, end, carrying)
    return east, north, variance
