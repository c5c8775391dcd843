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
from bematist.kernels.pdr_ahead import mean_ahead, remember
from bematist.kernels.rotation import matrix

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
def correlated(W, prm, dt, heading_var, carrying):
    """Direction and heading errors dt after the step before.

    Both are Gauss-Markov processes. A device that is carried otherwise points otherwise: its direction's error begins anew. The heading's
    variance is what the attitude filter says at this step; where that has shrunk, so has the error that is carried on. Where it is constant
    but for its growth (an infinite time: the gyroscope alone, turned by its offset), it has grown in proportion.
    """
    d = at.P + (at.WIDTH + 1) * at.E_DIRECTION
    share = math.exp(-dt / prm[at.DIRECTION_S])
    if W[at.STEPPED] > 0 and carrying != W[at.CARRIED]:
        share = 0.0
    W[at.CARRIED] = carrying
    fade(W, at.E_DIRECTION, share, share * share * W[d] + (1 - share * share) * prm[at.DIRECTION_VAR])
    h = at.P + (at.WIDTH + 1) * at.E_HEADING
    share = math.exp(-dt / prm[at.HEADING_S])
    if W[h] > heading_var or (W[h] > 0 and math.isinf(prm[at.HEADING_S])):
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
    c, n, heading_var = mean_ahead(W, prm, t - 1 / frequency, t, carrying)
    norm = math.sqrt(c * c + n * n)
    if norm > 1e-9:
        c, n = c / norm, n / norm
    else:
        c, n = W[at.DIRECTION_E], W[at.DIRECTION_N]
    dt = t - W[at.STEP_TIME] if W[at.STEPPED] > 0 else 0.0
    correlated(W, prm, dt, heading_var, carrying)
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


LAG = 1.1  # mean square of how far the body is ahead of the last counted step, in step lengths
STRIDE_HZ = 1.8  # steps of a usual walk
STAIRS_SPEED = 0.3  # vertical, m/s, up or down


@inlined
def onset(S, prm, step_prm, t):
    """Variance of the position along each axis by steps that wait to be counted, m², and of the velocity, (m/s)².

    From a step before the first candidate on the body may walk. A walk is told after FIRST_STEPS, and candidates that no other follows are
    none.
    """
    waiting = int(S[detector.PENDING_COUNT])
    if S[detector.WALKING_NOW] > 0 or waiting == 0:
        return 0.0, 0.0
    first = S[detector.PENDING + detector.EVENT_TIME]
    last = S[detector.PENDING + detector.EVENT * (waiting - 1) + detector.EVENT_TIME]
    if (t - last) * step_prm[detector.SLOWEST_HZ] > 1.3:
        return 0.0, 0.0
    since = min(t - first + 1 / STRIDE_HZ, (step_prm[detector.FIRST_STEPS] + 1) / step_prm[detector.SLOWEST_HZ])
    return prm[at.ONSET_VAR] * since * since, prm[at.ONSET_VAR]


@inlined
def write(W, prm, S, step_prm, t, rows, nav, k):
    """Row k of the results.

    The position stands where the last step ended. While walking the body is up to a step further, and that step is counted a quarter to a
    half of a step late: LAG squared lengths along the way. At rest a step may have gone unseen, in any direction; where candidates wait to
    be counted, several. Velocity is that of the last step, zero where nobody walks.
    """
    walking = S[detector.FREQUENCY] > 0 and W[at.STEPPED] > 0
    c, n, s = W[at.DIRECTION_E], W[at.DIRECTION_N], W[at.LENGTH]
    held = LAG * s * s if walking else 0.0
    away, moving = onset(S, prm, step_prm, t)
    if not walking:
        away += s * s / 12
    sway = prm[at.SWAY_VAR] + moving
    nav[k, 0], nav[k, 1], nav[k, 2], nav[k, 3] = t, W[at.EAST], W[at.NORTH], W[at.UP]
    v = s * W[at.FREQUENCY] if walking else 0.0
    nav[k, 4], nav[k, 5], nav[k, 6] = v * c, v * n, 0.0
    for i in range(4):
        nav[k, 7 + i] = rows[k, 1 + i]
    for i in range(11, 23):
        nav[k, i] = 0.0
    nav[k, 11] = W[at.P] + held * c * c + away
    nav[k, 12] = W[at.P + 1] + held * c * n
    nav[k, 14] = W[at.P + at.WIDTH + 1] + held * n * n + away
    nav[k, 16] = height_variance(W, prm, t)
    along = v * v * (prm[at.STEP_VAR] + prm[at.SCALE_VAR])
    across = v * v * (prm[at.TURN_VAR] + W[at.P + (at.WIDTH + 1) * at.E_DIRECTION] + W[at.P + (at.WIDTH + 1) * at.E_HEADING])
    nav[k, 17] = sway + along * c * c + across * n * n
    nav[k, 18] = (along - across) * c * n
    nav[k, 20] = sway + along * n * n + across * c * c
    climbing = STAIRS_SPEED if S[detector.MOTION] == detector.STAIRS else 0.0
    nav[k, 22] = prm[at.SWAY_VAR] + climbing * climbing
    for i in range(6):
        nav[k, 23 + i] = rows[k, 5 + i]
    if prm[at.HEADING_FIXED] >= 0:
        for i in range(6):
            nav[k, 23 + i] = prm[at.HEADING_FIXED] if i in (0, 3, 5) else 0.0


@inlined
def proceed(W, prm, S, step_prm, columns, rows, k, diag, events, written):
    """One sample with values: keep its attitude, count steps, take them, hear the barometer. Returns how many steps there are now."""
    t = columns[0, k]
    C = matrix(rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4])
    remember(W, t, rows, k)
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
        write(W, prm, S, step_prm, columns[0, k], rows, nav, k)
    return written
