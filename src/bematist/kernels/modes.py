"""Features of motion and carrying, and the decision trees over them (after Renaudin, Susi and Lachapelle 2012, reference 25 of MAGYQ)."""

import math

from bematist.kernels import steps_layout as at
from bematist.kernels.jit import apart, inlined
from bematist.kernels.steps_period import rate_at


@inlined
def features(S, prm, x, w0, w1, w2):
    """Energies and directions over exponential windows, with the cell's acceleration x and rates w."""
    a = 1 - prm[at.FEATURE_DECAY]
    S[at.ENERGY] += a * (x * x - S[at.ENERGY])
    S[at.SHORT] += (1 - prm[at.SHORT_DECAY]) * (x * x - S[at.SHORT])
    S[at.RATE_ENERGY] += a * (w0 * w0 + w1 * w1 + w2 * w2 - S[at.RATE_ENERGY])
    b = 1 - prm[at.GRAVITY_DECAY]
    for i in range(3):
        S[at.GRAVITY + i] += b * (S[at.UP + i] - S[at.GRAVITY + i])


@inlined
def _dot(S, prm, o):
    """Cosine between the mean direction up and an axis of the device."""
    g0, g1, g2 = S[at.GRAVITY], S[at.GRAVITY + 1], S[at.GRAVITY + 2]
    n = math.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
    return (g0 * prm[o] + g1 * prm[o + 1] + g2 * prm[o + 2]) / n if n > 0 else 0.0


@inlined
def motion(S, prm):
    """Static, walking, running or stairs."""
    F = at.FEATURES
    if S[at.WALKING_NOW] == 0:
        return at.STATIC
    if S[at.FREQUENCY] >= prm[at.RUN_HZ] and S[F + at.FEATURE_FORCE] >= prm[at.RUN_FORCE]:
        return at.RUNNING
    if abs(S[F + at.FEATURE_CLIMB]) >= (prm[at.CLIMB_LEFT] if S[at.MOTION] == at.STAIRS else prm[at.CLIMB_SPEED]):
        return at.STAIRS
    return at.WALKING


@inlined
def carrying(S, prm):
    """Texting, phoning, swinging, pocket or bag."""
    F = at.FEATURES
    rate, screen, top = S[F + at.FEATURE_RATE], S[F + at.FEATURE_SCREEN], S[F + at.FEATURE_TOP]
    if rate >= prm[at.SWING_RATE] and S[F + at.FEATURE_STRIDE] >= prm[at.SWING_STRIDE]:
        return at.POCKET if abs(top) >= prm[at.POCKET_UPRIGHT] else at.SWINGING
    if screen >= prm[at.SCREEN_UP]:
        return at.TEXTING
    if prm[at.PHONE_TOP] <= top <= prm[at.PHONE_TOP_MOST] and abs(screen) <= prm[at.PHONE_SCREEN] and rate <= prm[at.PHONE_RATE]:
        return at.PHONING
    return at.BAG


@inlined
def _change(S, mode, following, now, t, dwell_s):
    """The mode at S[mode] becomes `now` once that has been found for so long; S[following:] holds what was found, and since when."""
    if now != S[following]:
        S[following], S[following + 1] = now, t
    if t - S[following + 1] > dwell_s - 0.5 * at.CELL_S:
        S[mode] = now


@apart
def judge(S, prm, t, k, x):
    """Features of the cell at t, and the modes: at the beginning of a walk at once, later once they have been found for DWELL_S."""
    F = at.FEATURES
    period = S[at.PERIOD]
    S[F + at.FEATURE_FORCE] = math.sqrt(S[at.ENERGY])
    S[F + at.FEATURE_RATE] = math.sqrt(S[at.RATE_ENERGY])
    S[F + at.FEATURE_PERIODICITY], S[F + at.FEATURE_DEMAND] = S[at.SCORE], S[at.DEMAND]
    S[F + at.FEATURE_FREQUENCY] = 1 / period if period > 0 else 0.0
    S[F + at.FEATURE_STRIDE] = -rate_at(S, k, period) if period > 0 else 0.0
    S[F + at.FEATURE_SCREEN] = _dot(S, prm, at.SCREEN_AXIS)
    S[F + at.FEATURE_TOP] = _dot(S, prm, at.TOP_AXIS)
    S[F + at.FEATURE_CLIMB] = S[at.CLIMB]
    S[F + at.FEATURE_BAND] = S[at.BAND]
    S[F + at.FEATURE_ACCELERATION] = x
    now = motion(S, prm)
    if now == at.STATIC:
        S[at.MOTION] = now
        return
    begins = S[at.MOTION] == at.STATIC
    # The speed of climbing is smoothed already.
    dwell = 0.0 if begins or now == at.STAIRS or S[at.MOTION] == at.STAIRS else prm[at.DWELL_S]
    _change(S, at.MOTION, at.MOTION_NEXT, now, t, dwell)
    _change(S, at.CARRYING, at.CARRYING_NEXT, carrying(S, prm), t, 0.0 if begins else prm[at.DWELL_S])
