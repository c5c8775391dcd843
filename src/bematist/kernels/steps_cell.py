"""What is done with each cell: filters, period, candidates for steps, whether one walks, modes."""

import math

from bematist.kernels import steps_layout as at
from bematist.kernels.jit import apart, inlined
from bematist.kernels.modes import features, judge
from bematist.kernels.steps_events import candidate, pause
from bematist.kernels.steps_period import correlate, find_period, find_rate_period, force_at, rate_at


@inlined
def _filter(S, o, x, g, damping):
    """State variable filter (trapezoidal), its two states from S[o:]: high-pass and band-pass output, the latter 1 at its centre.

    g = tan(π f h) with the cell's length h; damping = 1/Q.
    """
    h = (x - (damping + g) * S[o] - S[o + 1]) / (1 + g * (damping + g))
    band = S[o] + g * h
    S[o] = band + g * h
    low = S[o + 1] + g * band
    S[o + 1] = low + g * band
    return h, damping * band


@inlined
def _centre(S, prm, k):
    """Period of the steps from those of acceleration and rotation, its score, and the band pass to it.

    Where the device turns back and forth strongly with a period in which a stride could be done, that is the stride, and the acceleration
    too has the stride's period (an arm that swings more to the front): a step is half of it. So it is where the period is longer than that
    of the slowest step. A held device that nods with each step turns too fast for the strides of a walk; in a run it would turn faster.
    """
    period, score = find_period(S, prm, k)
    turning, turning_score = find_rate_period(S, prm, k)
    rate = math.sqrt(S[at.RATE_ENERGY])
    opposite = 0.0
    if turning > 0 and rate > prm[at.STRIDE_RATE]:
        opposite = min(turning_score, -rate_at(S, k, 0.5 * turning))
        if turning * prm[at.SWING_FASTEST_HZ] < 2 and rate < prm[at.SWING_FAST_RATE]:
            opposite = 0.0
    # Once it is the stride, half as much will do: a turn disturbs the rotation for a while.
    if opposite > (0.5 if S[at.STRIDE] > 0 else 1.0) * prm[at.STRIDE_CORRELATION]:
        period = 0.5 * turning
        score = max(force_at(S, k, turning), force_at(S, k, period))
        S[at.STRIDE] = 1.0
        S[at.DEMAND] = prm[at.STRIDE_PERIODIC]
    else:
        S[at.STRIDE] = 0.0
        S[at.DEMAND] = min(prm[at.PERIODIC_MOST], prm[at.PERIODIC] + prm[at.PERIODIC_RATE] * rate)
        doubled = S[at.WALKING_NOW] > 0 and rate > prm[at.STRIDE_RATE] and period > 1.6 * S[at.STEP_PERIOD]
        if period * prm[at.SLOWEST_HZ] > 1 or doubled:
            period = 0.5 * period
    S[at.PERIOD], S[at.SCORE] = period, score
    target = prm[at.START_HZ]
    if period > 0 and score > 0.5 * S[at.DEMAND]:
        target = 1 / period
    elif S[at.WALKING_NOW] > 0:
        target = 1 / S[at.STEP_PERIOD]
    S[at.CENTRE] += (1 - prm[at.CENTRE_DECAY]) * (target - S[at.CENTRE])


@apart
def close_cell(S, prm, t, new):
    """The cell whose middle is t is full: returns the number of steps counted at this sample so far."""
    inverse = 1 / at.CELL_S
    v = S[at.SUM + at.V] * inverse
    w0, w1, w2 = S[at.SUM + at.WX] * inverse, S[at.SUM + at.WY] * inverse, S[at.SUM + at.WZ] * inverse
    for c in range(at.CHANNELS):
        S[at.SUM + c] = 0.0
    k = int(S[at.CELLS]) - 1
    x, _ = _filter(S, at.HIGH_PASS, v, math.tan(math.pi * prm[at.HIGH_PASS_HZ] * at.CELL_S), math.sqrt(2.0))
    slow = 1 - prm[at.SLOW_DECAY]
    if k == 0:
        S[at.SLOW_W], S[at.SLOW_W + 1], S[at.SLOW_W + 2] = w0, w1, w2
    S[at.SLOW_W] += slow * (w0 - S[at.SLOW_W])
    S[at.SLOW_W + 1] += slow * (w1 - S[at.SLOW_W + 1])
    S[at.SLOW_W + 2] += slow * (w2 - S[at.SLOW_W + 2])
    w0, w1, w2 = w0 - S[at.SLOW_W], w1 - S[at.SLOW_W + 1], w2 - S[at.SLOW_W + 2]
    features(S, prm, x, w0, w1, w2)
    correlate(S, prm, k, x, w0, w1, w2)
    _centre(S, prm, k)
    g = math.tan(math.pi * S[at.CENTRE] * at.CELL_S)
    damping = 1 / (prm[at.STRIDE_SELECTIVITY] if S[at.STRIDE] > 0 else prm[at.SELECTIVITY])
    _, y = _filter(S, at.BAND_1, v, g, damping)
    _, y = _filter(S, at.BAND_2, y, g, damping)
    S[at.BAND + 2], S[at.BAND + 1], S[at.BAND] = S[at.BAND + 1], S[at.BAND], y
    new = candidate(S, prm, t, new)
    pause(S, prm, t)
    judge(S, prm, t, k, x)
    return new
