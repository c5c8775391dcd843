"""Step events and modes, one sample at a time: the direction up, means over cells of 40 ms, and then what `steps_cell` does with each.

The cells make everything after them independent of the sampling rate: a step has nothing above 10 Hz. Everything lives in one flat
workspace `S`, see `steps_layout`.
"""

import math

from bematist.kernels import stance
from bematist.kernels import steps_layout as at
from bematist.kernels.jit import apart, inlined, kernel
from bematist.kernels.steps_cell import close_cell


@inlined
def _channels(S, prm, f0, f1, f2, w0, w1, w2):
    """What a sample is to the cells: the acceleration that tells steps, and rates.

    The former is the mean of the upward part and of the norm, less g. Both have the bounce of the body. What a swinging arm adds to them
    differs: upward where it rises at the ends of its way, along itself where it turns fastest, so that the mean has less of it than either.
    """
    v = f0 * S[at.UP] + f1 * S[at.UP + 1] + f2 * S[at.UP + 2]
    return 0.5 * (v + math.sqrt(f0 * f0 + f1 * f1 + f2 * f2)) - prm[at.G], w0, w1, w2


@inlined
def _set_up(S, a, b, c, otherwise0, otherwise1, otherwise2):
    """Up in b from a vector along it; where it has no length, the other."""
    n = math.sqrt(a * a + b * b + c * c)
    if n > 1e-6:
        S[at.UP], S[at.UP + 1], S[at.UP + 2] = a / n, b / n, c / n
    else:
        S[at.UP], S[at.UP + 1], S[at.UP + 2] = otherwise0, otherwise1, otherwise2


@inlined
def _follow_up(S, prm, dt, f0, f1, f2, w0, w1, w2):
    """The direction up in b without an attitude: turned by the gyroscope, du/dt = -w × u, and drawn to the specific force.

    At the start it is drawn as the mean of what has come would be, so that it is right after a step or two.
    """
    u0, u1, u2 = S[at.UP], S[at.UP + 1], S[at.UP + 2]
    gain = dt / min(prm[at.LEVEL_S], S[at.AGE] + 0.3)
    share = gain / prm[at.G]
    keep = 1 - gain
    _set_up(
        S,
        keep * (u0 - dt * (w1 * u2 - w2 * u1)) + share * f0,
        keep * (u1 - dt * (w2 * u0 - w0 * u2)) + share * f1,
        keep * (u2 - dt * (w0 * u1 - w1 * u0)) + share * f2,
        *(u0, u1, u2),
    )


@apart
def _begin(S, prm, t, f0, f1, f2):
    """Start, or start anew after a gap: nothing is known but the number of steps and the modes."""
    for i in range(at.TIME, at.WORKSPACE_SIZE):
        if not at.MOTION_NEXT <= i < at.FEATURES:
            S[i] = 0.0
    S[at.FREQUENCY] = 0.0
    S[at.MOTION] = at.STATIC
    S[at.HEIGHT_KNOWN] = 0.0
    S[at.STARTED], S[at.ORIGIN], S[at.CENTRE] = 1.0, t, prm[at.START_HZ]
    _set_up(S, f0, f1, f2, 0.0, 0.0, 1.0)


@inlined
def _pressure(S, prm, t, pressure):
    """Speed of climbing from the pressure, smoothed twice over CLIMB_S: near the ground 8.4 km of air weigh as much as all of it.

    With the share a of a new value, gains 2a − a² and a² are those of two equal decays, 1 − a each, at any interval.
    """
    height = -8434.0 * math.log(pressure / 101325.0)
    if S[at.HEIGHT_KNOWN] == 0 or not t - S[at.HEIGHT_TIME] < 5:
        S[at.HEIGHT], S[at.CLIMB], S[at.HEIGHT_KNOWN] = height, 0.0, 1.0
    else:
        dt = t - S[at.HEIGHT_TIME]
        a = dt / (dt + prm[at.CLIMB_S])
        change = a * (height - S[at.HEIGHT] - S[at.CLIMB] * dt)
        S[at.HEIGHT] += S[at.CLIMB] * dt + (2 - a) * change
        if dt > 0:
            S[at.CLIMB] += a * change / dt
    S[at.HEIGHT_TIME] = t


@apart
def advance(S, prm, t, f0, f1, f2, w0, w1, w2, u0, u1, u2, pressure):
    """One sample: returns how many steps are counted at it; their records stand in S[EVENTS:].

    t s, f m/s², w rad/s; u: up in b, third row of C_nb, or u0 NaN where no attitude is known; pressure Pa, or NaN where there is none.
    """
    dt = t - S[at.TIME]
    if S[at.STARTED] == 0 or not dt <= prm[at.GAP_S]:
        _begin(S, prm, t, f0, f1, f2)
        dt = 0.0
    if u0 == u0:
        S[at.UP], S[at.UP + 1], S[at.UP + 2] = u0, u1, u2
    elif dt > 0:
        _follow_up(S, prm, dt, f0, f1, f2, w0, w1, w2)
    S[at.AGE] += dt
    if pressure > 0:
        _pressure(S, prm, t, pressure)
    now = _channels(S, prm, f0, f1, f2, w0, w1, w2)
    new = 0
    left = dt
    while left > 0:
        # A trapezium up to the sample, or to the end of the cell if that comes first.
        start = t - left
        end = S[at.ORIGIN] + at.CELL_S * (S[at.CELLS] + 1)
        whole = t < end
        part = left if whole else max(0.0, end - start)
        share = part / left
        for c in range(at.CHANNELS):
            after = S[at.PREVIOUS + c] + share * (now[c] - S[at.PREVIOUS + c])
            S[at.SUM + c] += 0.5 * part * (S[at.PREVIOUS + c] + after)
            S[at.PREVIOUS + c] = after
        left -= part
        if whole:
            left = 0.0
        else:
            S[at.CELLS] += 1
            new = close_cell(S, prm, end - 0.5 * at.CELL_S, new)
    for c in range(at.CHANNELS):
        S[at.PREVIOUS + c] = now[c]
    S[at.TIME] = t
    return new


@kernel
def run(memory, S, prm, columns, flags, up, pressure, out, events):
    """Detector over samples, columns (10,n), complete or with the flags that `stance.fill` gave.

    up (3,n), or (3,0) where no attitude is known; pressure (n,) with NaN where there is no new value, or (0,). Writes a row of `out` a
    sample, and one of `events` (at.EVENT_ROW) a step; returns the number of steps.
    """
    written = 0
    last = math.nan
    if S[at.COUNT] > 0:
        last = S[at.LAST_EVENT]
    for k in range(columns.shape[1]):
        new = 0
        if flags.shape[0] == 0 or flags[k] != stance.MISSING:
            u0, u1, u2 = math.nan, math.nan, math.nan
            if up.shape[1] > 0:
                u0, u1, u2 = up[0, k], up[1, k], up[2, k]
            p = pressure[k] if pressure.shape[0] > 0 else math.nan
            new = advance(
                *(S, prm, columns[0, k], columns[1, k], columns[2, k], columns[3, k], columns[4, k], columns[5, k], columns[6, k]),
                *(u0, u1, u2, p),
            )
        for i in range(new):
            for c in range(at.EVENT):
                events[written, c] = S[at.EVENTS + at.EVENT * i + c]
            last = events[written, at.EVENT_TIME]
            events[written, at.EVENT_CONFIRMED] = columns[0, k]
            events[written, at.EVENT_MOTION], events[written, at.EVENT_CARRYING] = S[at.MOTION], S[at.CARRYING]
            written += 1
        out[k, at.OUT_COUNT] = new
        out[k, at.OUT_TIME] = last
        out[k, at.OUT_FREQUENCY] = S[at.FREQUENCY]
        out[k, at.OUT_MOTION] = S[at.MOTION]
        out[k, at.OUT_CARRYING] = S[at.CARRYING]
        for c in range(at.FEATURE_SIZE):
            out[k, at.OUT_FEATURES + c] = S[at.FEATURES + c]
    stance.hold_last(memory, columns, flags)
    return written
