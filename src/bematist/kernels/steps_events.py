"""From the band-passed acceleration to steps: peaks, and whether they belong to a walk.

A peak becomes a candidate when the signal has come down to zero after it, a quarter of a step later. Candidates wait until so many
regular ones are there, and the acceleration is periodic, that one walks; then all of them are counted, each with its own time. From then
on a candidate is counted at once, until none has come for longer than a pause.
"""

import math

from bematist.kernels import steps_layout as at
from bematist.kernels.jit import apart, inlined


@inlined
def candidate(S, prm, t, new):
    """Follow the band-passed signal up to the cell at t; returns the number of steps counted at this sample."""
    y0, y1, y2 = S[at.BAND], S[at.BAND + 1], S[at.BAND + 2]
    if y1 > 0 and y1 > y2 and y1 >= y0 and y1 > S[at.PEAK_OPEN]:
        bend = y2 - 2 * y1 + y0
        shift = 0.5 * (y2 - y0) / bend if bend < 0 else 0.0
        S[at.PEAK_TIME] = t - at.CELL_S + shift * at.CELL_S
        S[at.PEAK_OPEN] = y1
    if y0 <= 0 and S[at.PEAK_OPEN] > 0:
        size = S[at.PEAK_OPEN]
        S[at.PEAK_OPEN] = 0.0
        if size > prm[at.LEAST_FORCE] and math.sqrt(2 * S[at.SHORT]) > prm[at.RINGING] * size:
            new = _consider(S, prm, S[at.PEAK_TIME], size, new)
    return new


@apart
def _consider(S, prm, t, size, new):
    """A candidate with the time t of its peak and its height."""
    since = t - S[at.LAST_EVENT]
    if S[at.WALKING_NOW] > 0:
        period = S[at.STEP_PERIOD]
        if since < prm[at.REFRACTORY] * period or size < prm[at.PEAK_SHARE] * S[at.STEP_SIZE]:
            return new
        seen = S[at.PERIOD] if S[at.SCORE] >= S[at.DEMAND] else period
        if since < (1 + prm[at.IRREGULARITY]) * period:
            seen = since
        S[at.STEP_PERIOD] = max(1 / prm[at.FASTEST_HZ], period + 0.3 * (seen - period))
        if since > (2 - prm[at.IRREGULARITY]) * period:
            # One between them had no peak of its own, as where the device is taken elsewhere; one walked on all the time.
            new = _count(S, t - 0.5 * since, size, S[at.STEP_PERIOD], new)
        S[at.STEP_SIZE] += 0.2 * (size - S[at.STEP_SIZE])
        return _count(S, t, size, S[at.STEP_PERIOD], new)
    waiting = int(S[at.PENDING_COUNT])
    if waiting > 0:
        o = at.PENDING + at.EVENT * (waiting - 1)
        since = t - S[o + at.EVENT_TIME]
        if since * prm[at.FASTEST_HZ] < 0.8:
            if size > S[o + at.EVENT_SIZE]:
                S[o + at.EVENT_TIME], S[o + at.EVENT_SIZE] = t, size
            return new
        if since * prm[at.SLOWEST_HZ] > 1.3:
            waiting = 0
    elif S[at.COUNT] > 0 and since < 1 / prm[at.FASTEST_HZ]:
        return new
    if waiting == at.MAX_NEW:
        for i in range(at.EVENT * (at.MAX_NEW - 1)):
            S[at.PENDING + i] = S[at.PENDING + i + at.EVENT]
        waiting -= 1
    o = at.PENDING + at.EVENT * waiting
    S[o + at.EVENT_TIME], S[o + at.EVENT_SIZE] = t, size
    S[at.PENDING_COUNT] = waiting + 1
    return _confirm(S, prm, new)


@inlined
def _confirm(S, prm, new):
    """Whether the waiting candidates are a walk; then they are counted, from the first that fits on."""
    n = int(S[at.PENDING_COUNT])
    need = int(prm[at.FIRST_STEPS])
    period = S[at.PERIOD]
    if n < need or S[at.SCORE] < S[at.DEMAND] or period <= 0:
        return new
    # the last ones: as regular as a walk, and at the period that the acceleration has
    last = at.PENDING + at.EVENT * (n - 1)
    mean = (S[last + at.EVENT_TIME] - S[last - at.EVENT * (need - 1) + at.EVENT_TIME]) / (need - 1)
    size = 0.0
    for i in range(need):
        size += S[last - at.EVENT * i + at.EVENT_SIZE] / need
    if abs(mean - period) > 0.5 * prm[at.IRREGULARITY] * period:
        return new
    first = n - 1
    for i in range(n - 1, 0, -1):
        o = at.PENDING + at.EVENT * i
        since = S[o + at.EVENT_TIME] - S[o - at.EVENT + at.EVENT_TIME]
        if abs(since - mean) > prm[at.IRREGULARITY] * mean or S[o - at.EVENT + at.EVENT_SIZE] < prm[at.PEAK_SHARE] * size:
            break
        first = i - 1
    if n - first < need:
        return new
    S[at.WALKING_NOW] = 1.0
    S[at.STEP_PERIOD], S[at.STEP_SIZE] = max(1 / prm[at.FASTEST_HZ], mean), size
    # Their peaks come while the band pass still finds the pace; the autocorrelation knows it already.
    for i in range(first, n):
        o = at.PENDING + at.EVENT * i
        new = _count(S, S[o + at.EVENT_TIME], S[o + at.EVENT_SIZE], period, new)
    S[at.PENDING_COUNT] = 0.0
    return new


@inlined
def _count(S, t, size, period, new):
    """A step at t, written after those that this sample has already; its frequency is 1 / period."""
    if new == at.MAX_NEW:
        return new
    o = at.EVENTS + at.EVENT * new
    S[o + at.EVENT_TIME], S[o + at.EVENT_SIZE] = t, size
    S[o + at.EVENT_FREQUENCY] = S[at.FREQUENCY] = 1 / period
    S[at.LAST_EVENT] = t
    S[at.QUIET] = S[at.SHORT]
    S[at.COUNT] += 1
    return new + 1


@inlined
def pause(S, prm, t):
    """The walk ends when no step has come for longer than a pause, or a step is overdue and the device was quiet meanwhile."""
    if S[at.WALKING_NOW] == 0:
        return
    S[at.QUIET] = min(S[at.QUIET], S[at.SHORT])
    since = (t - S[at.LAST_EVENT]) / S[at.STEP_PERIOD]
    quiet = 2 * S[at.QUIET] < (prm[at.QUIET_SHARE] * S[at.STEP_SIZE]) ** 2
    if since > prm[at.PAUSE] or (since > 1 + prm[at.IRREGULARITY] and quiet):
        S[at.WALKING_NOW] = S[at.PENDING_COUNT] = S[at.FREQUENCY] = 0.0
