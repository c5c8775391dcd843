"""The path of a sensor in the hand: steps, each of a length and a direction, added up with their covariance.

A sample at a time; the attitude filter (`hand`) has run before and its rows come in. Everything lives in one flat workspace `W`, see
`pdr_layout`, and the detector's own `S`, see `steps_layout`.
"""

import math

from bematist.kernels import pdr_layout as at
from bematist.kernels import stance, steps
from bematist.kernels import steps_layout as detector
from bematist.kernels.barometer import height_variance, measure_height
from bematist.kernels.jit import apart, inlined, kernel
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


@inlined
def look_ahead(W, prm, C, rows, k, carrying):
    """The direction ahead, of unit length in plan, into W, and the variance of its heading.

    The axis that points ahead, levelled; where it stands too upright to tell, at right angles to the axis that points to the right.
    """
    axes = at.AXES + 6 * int(carrying)
    d0, d1, d2 = level(C, prm[axes], prm[axes + 1], prm[axes + 2])
    h2 = d0 * d0 + d1 * d1
    e, n = d0, d1
    if h2 < prm[at.STEEP] * prm[at.STEEP]:
        d0, d1, d2 = level(C, prm[axes + 3], prm[axes + 4], prm[axes + 5])
        h2 = d0 * d0 + d1 * d1
        e, n = -d1, d0
    if h2 < 1e-6:
        return
    g0, g1, g2 = heading_gradient(d0, d1, d2)
    h = math.sqrt(h2)
    e, n = e / h, n / h
    W[at.AHEAD_E] = prm[at.OFFSET_COS] * e - prm[at.OFFSET_SIN] * n
    W[at.AHEAD_N] = prm[at.OFFSET_SIN] * e + prm[at.OFFSET_COS] * n
    if prm[at.HEADING_FIXED] >= 0:
        W[at.HEADING_VAR] = prm[at.HEADING_FIXED]
    else:
        xx, xy, xz, yy, yz, zz = rows[k, 5], rows[k, 6], rows[k, 7], rows[k, 8], rows[k, 9], rows[k, 10]
        W[at.HEADING_VAR] = g0 * (g0 * xx + 2 * (g1 * xy + g2 * xz)) + g1 * (g1 * yy + 2 * g2 * yz) + g2 * g2 * zz


@inlined
def remember(W, prm, t):
    """Integrate the direction ahead up to t, and keep an entry of the history every SLOT_S. Over a gap nothing is added."""
    dt = t - W[at.TIME]
    if W[at.STARTED] > 0 and dt <= prm[at.GAP_S]:
        W[at.SUM_E] += dt * W[at.AHEAD_E]
        W[at.SUM_N] += dt * W[at.AHEAD_N]
    count = int(W[at.COUNT])
    r = at.RING + at.SLOT * ((count - 1) % at.SLOTS)
    if count == 0 or t - W[r] >= at.SLOT_S:
        r = at.RING + at.SLOT * (count % at.SLOTS)
        W[r], W[r + 1], W[r + 2], W[r + 3] = t, W[at.SUM_E], W[at.SUM_N], W[at.HEADING_VAR]
        W[at.COUNT] = count + 1
    W[at.TIME], W[at.STARTED] = t, 1.0


@inlined
def recall(W, t):
    """The integrals of the direction ahead up to a time t that is past, and the variance of the heading then."""
    count = int(W[at.COUNT])
    after_t, after_e, after_n, variance = W[at.TIME], W[at.SUM_E], W[at.SUM_N], W[at.HEADING_VAR]
    for back in range(1, min(count, at.SLOTS) + 1):
        r = at.RING + at.SLOT * ((count - back) % at.SLOTS)
        if W[r] <= t:
            if after_t > W[r]:
                u = min(1.0, (t - W[r]) / (after_t - W[r]))
                return W[r + 1] + u * (after_e - W[r + 1]), W[r + 2] + u * (after_n - W[r + 2]), variance
            return W[r + 1], W[r + 2], variance
        after_t, after_e, after_n, variance = W[r], W[r + 1], W[r + 2], W[r + 3]
    return after_e, after_n, variance


LEG = 0.53  # of the height: hip to ground
SMOOTH = 5.0  # steps that the height of the peaks is averaged over
PAUSE_S = 3.0  # and after which it begins anew


@inlined
def step_length(prm, frequency, size, motion, carrying):
    """s = h (a f + b) + c, MAGYQ eq 47; longer by a factor when running, and a tread on stairs.

    Where the screen is read, drawn to what the bounce of an inverted pendulum says (Zijlstra & Hof 2003): a leg l lifts the body by
    s²/(8 l), which at f is an acceleration of amplitude (2 pi f)² s²/(16 l).
    """
    if motion == detector.STAIRS:
        return prm[at.TREAD]
    s = max(0.0, prm[at.HEIGHT] * (prm[at.A] * frequency + prm[at.B]) + prm[at.C])
    if motion == detector.RUNNING:
        return s * prm[at.RUNNING_FACTOR]
    if prm[at.PENDULUM] > 0 and carrying == detector.TEXTING and size > 0 and s > 0:
        bounce = math.sqrt(16 * LEG * prm[at.HEIGHT] * size) / (2 * math.pi * frequency)
        s *= (bounce / s) ** prm[at.PENDULUM]
    return s


@inlined
def follow_size(W, dt, size):
    """Mean height of the peaks of the last steps, m/s²."""
    if W[at.STEPPED] == 0 or dt > PAUSE_S:
        W[at.SIZES] = 0.0
    W[at.SIZES] = min(W[at.SIZES] + 1, SMOOTH)
    W[at.SIZE] += (size - W[at.SIZE]) / W[at.SIZES]
    return W[at.SIZE]


@inlined
def fade(W, i, share, variance):
    """A correlated error, column i of P, keeps this share of itself; its variance becomes the one that is given."""
    for j in range(at.WIDTH):
        W[at.P + at.WIDTH * i + j] *= share
        W[at.P + at.WIDTH * j + i] *= share
    W[at.P + (at.WIDTH + 1) * i] = variance


@inlined
def correlated(W, prm, dt, heading_var):
    """Direction and heading errors dt after the step before.

    Both are Gauss-Markov processes. The heading's variance is what the attitude filter says at this step; where that has shrunk, so has the
    error that is carried on.
    """
    d = at.P + (at.WIDTH + 1) * at.E_DIRECTION
    share = math.exp(-dt / prm[at.DIRECTION_S])
    fade(W, at.E_DIRECTION, share, share * share * W[d] + (1 - share * share) * prm[at.DIRECTION_VAR])
    h = at.P + (at.WIDTH + 1) * at.E_HEADING
    share = math.exp(-dt / prm[at.HEADING_S])
    if W[h] > heading_var:
        share *= math.sqrt(heading_var / W[h])
    fade(W, at.E_HEADING, share, heading_var)


@inlined
def add_step(W, prm, s, c, n):
    """Position and its covariance after a step of length s towards u = (c, n), with the one at right angles v = (-n, c).

    p += s u, dp += s u (scale + own) + s v (direction + heading + own), to first order.
    """
    W[at.EAST] += s * c
    W[at.NORTH] += s * n
    for j in range(at.WIDTH):
        ds = s * W[at.P + at.WIDTH * at.E_SCALE + j]
        dq = s * (W[at.P + at.WIDTH * at.E_DIRECTION + j] + W[at.P + at.WIDTH * at.E_HEADING + j])
        W[at.P + j] += c * ds - n * dq
        W[at.P + at.WIDTH + j] += n * ds + c * dq
    for i in range(at.WIDTH):
        r = at.P + at.WIDTH * i
        ds = s * W[r + at.E_SCALE]
        dq = s * (W[r + at.E_DIRECTION] + W[r + at.E_HEADING])
        W[r] += c * ds - n * dq
        W[r + 1] += n * ds + c * dq
    along, across = s * s * prm[at.STEP_VAR], s * s * prm[at.TURN_VAR]
    W[at.P] += along * c * c + across * n * n
    W[at.P + 1] += (along - across) * c * n
    W[at.P + at.WIDTH] += (along - across) * c * n
    W[at.P + at.WIDTH + 1] += along * n * n + across * c * c


@apart
def take_step(W, prm, t, frequency, size, motion, carrying):
    """The step that ended at t, of this frequency and height of its peak (m/s²): its mean direction, its length, and where it leads."""
    period = 1 / frequency
    e1, n1, heading_var = recall(W, t)
    e0, n0, _ = recall(W, t - period)
    c, n = e1 - e0, n1 - n0
    norm = math.sqrt(c * c + n * n)
    if norm > 1e-9:
        c, n = c / norm, n / norm
    else:
        c, n = W[at.AHEAD_E], W[at.AHEAD_N]
    dt = t - W[at.STEP_TIME] if W[at.STEPPED] > 0 else 0.0
    correlated(W, prm, dt, heading_var)
    s = step_length(prm, frequency, follow_size(W, dt, size), motion, carrying)
    add_step(W, prm, s, c, n)
    W[at.STEP_TIME], W[at.LENGTH], W[at.DIRECTION_E], W[at.DIRECTION_N], W[at.FREQUENCY] = t, s, c, n, frequency
    W[at.STEPPED] = 1.0
    W[at.WALKED] += s
    W[at.UP_VAR] += prm[at.FLAT_VAR] * s


@inlined
def write_step(W, prm, S, t, events, row):
    """A row of the list of steps."""
    h = W[at.P + (at.WIDTH + 1) * at.E_HEADING] + W[at.P + (at.WIDTH + 1) * at.E_DIRECTION] + prm[at.TURN_VAR]
    events[row, at.S_TIME] = W[at.STEP_TIME]
    events[row, at.S_COUNTED] = t
    events[row, at.S_LENGTH] = W[at.LENGTH]
    events[row, at.S_LENGTH_SD] = W[at.LENGTH] * math.sqrt(prm[at.STEP_VAR] + prm[at.SCALE_VAR])
    events[row, at.S_FREQUENCY] = W[at.FREQUENCY]
    events[row, at.S_DIRECTION] = math.atan2(W[at.DIRECTION_N], W[at.DIRECTION_E])
    events[row, at.S_DIRECTION_SD] = math.sqrt(h)
    events[row, at.S_MOTION], events[row, at.S_CARRYING] = S[detector.MOTION], S[detector.CARRYING]


@inlined
def write(W, prm, S, t, rows, nav, k):
    """Row k of the results.

    The position stands where the last step ended; while walking the body may be up to a step further, with equal chance: a third of the
    squared length along the way. Velocity is that of the last step, zero where nobody walks.
    """
    walking = S[detector.FREQUENCY] > 0 and W[at.STEPPED] > 0
    c, n, s = W[at.DIRECTION_E], W[at.DIRECTION_N], W[at.LENGTH]
    held = s * s / 3 if walking else s * s / 12
    nav[k, 0], nav[k, 1], nav[k, 2], nav[k, 3] = t, W[at.EAST], W[at.NORTH], W[at.UP]
    v = s * W[at.FREQUENCY] if walking else 0.0
    nav[k, 4], nav[k, 5], nav[k, 6] = v * c, v * n, 0.0
    for i in range(4):
        nav[k, 7 + i] = rows[k, 1 + i]
    for i in range(11, 23):
        nav[k, i] = 0.0
    nav[k, 11] = W[at.P] + held * c * c
    nav[k, 12] = W[at.P + 1] + held * c * n
    nav[k, 14] = W[at.P + at.WIDTH + 1] + held * n * n
    nav[k, 16] = height_variance(W, prm, t)
    along = v * v * (prm[at.STEP_VAR] + prm[at.SCALE_VAR])
    across = v * v * (prm[at.TURN_VAR] + W[at.P + 6 * at.E_DIRECTION] + W[at.P + 6 * at.E_HEADING])
    nav[k, 17] = prm[at.SWAY_VAR] + along * c * c + across * n * n
    nav[k, 18] = (along - across) * c * n
    nav[k, 20] = prm[at.SWAY_VAR] + along * n * n + across * c * c
    nav[k, 22] = prm[at.SWAY_VAR]
    for i in range(6):
        nav[k, 23 + i] = rows[k, 5 + i]
    if prm[at.HEADING_FIXED] >= 0:
        for i in range(6):
            nav[k, 23 + i] = prm[at.HEADING_FIXED] if i in (0, 3, 5) else 0.0


@inlined
def proceed(W, prm, S, step_prm, columns, rows, k, diag, events, written):
    """One sample with values: look ahead, count steps, take them, hear the barometer. Returns how many steps there are now."""
    t = columns[0, k]
    C = matrix(rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4])
    look_ahead(W, prm, C, rows, k, S[detector.CARRYING])
    remember(W, prm, t)
    pressure = columns[10, k]
    new = steps.advance(
        *(S, step_prm, t, columns[1, k], columns[2, k], columns[3, k], columns[4, k], columns[5, k], columns[6, k]),
        *(C[6], C[7], C[8], pressure),
    )
    for i in range(new):
        e = detector.EVENTS + detector.EVENT * i
        take_step(
            *(W, prm, S[e + detector.EVENT_TIME], S[e + detector.EVENT_FREQUENCY], S[e + detector.EVENT_SIZE]),
            *(S[detector.MOTION], S[detector.CARRYING]),
        )
        write_step(W, prm, S, t, events, written + i)
    diag[k, at.STEPS] = new
    diag[k, at.PRESSURE_HEIGHT] = math.nan
    if pressure > 0 and prm[at.BARO_USE] > 0:
        diag[k, at.PRESSURE_HEIGHT] = measure_height(W, prm, t, pressure)
    return written + new


@kernel
def run(S, step_prm, W, prm, columns, flags, rows, nav, diag, events):
    """Path over samples, columns (11,n) as `stance.filled` gave them with the pressure last, and the attitude filter's rows (n,11).

    Writes n rows of nav and diag, and one of events (`pdr_layout.STEP_ROW`) a step; returns the number of steps.
    """
    written = 0
    for k in range(columns.shape[1]):
        diag[k, at.STEPS] = 0.0
        diag[k, at.PRESSURE_HEIGHT] = math.nan
        if flags.shape[0] == 0 or flags[k] != stance.MISSING:
            written = proceed(W, prm, S, step_prm, columns, rows, k, diag, events, written)
        diag[k, at.STEP_FREQUENCY] = S[detector.FREQUENCY]
        diag[k, at.MOTION], diag[k, at.CARRYING] = S[detector.MOTION], S[detector.CARRYING]
        write(W, prm, S, columns[0, k], rows, nav, k)
    return written
