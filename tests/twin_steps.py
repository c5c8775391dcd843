"""The step detector once more in plain NumPy and Python, each quantity from its definition: no running sums, no rings, no workspace."""

import numpy as np
from scipy.signal import lfilter

from bematist.kernels import steps_layout as at

H = at.CELL_S


def directions(time, f, w, level_s, g):
    """Up in b (N,3) without an attitude."""
    up = np.empty_like(f)
    up[0] = f[0] / np.linalg.norm(f[0])
    for k in range(1, len(time)):
        dt = time[k] - time[k - 1]
        gain = dt / min(level_s, time[k - 1] - time[0] + 0.3)
        u = (1 - gain) * (up[k - 1] - dt * np.cross(w[k], up[k - 1])) + gain * f[k] / g
        up[k] = u / np.linalg.norm(u)
    return up


def cell_means(time, values):
    """Means (K,c) of the straight lines between samples (N,c), over cells from the first sample on."""
    edges = time[0] + H * np.arange(int((time[-1] - time[0]) / H) + 2)
    edges = edges[edges <= time[-1]]
    grid = np.union1d(time, edges)
    on = np.stack([np.interp(grid, time, v) for v in values.T], 1)
    area = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(0.5 * (on[1:] + on[:-1]) * np.diff(grid)[:, None], 0)])
    return np.diff(area[np.searchsorted(grid, edges)], axis=0) / H, edges[:-1] + H / 2, edges[1:]


def averaged(x, seconds):
    """Exponential mean of a series (K,…), from 0."""
    a = 1 - np.exp(-H / seconds)
    return lfilter([a], [1, a - 1], x, axis=0)


def coefficients(x, seconds):
    """Autocorrelation coefficients (K, LAGS) of a series (K,) or (K,c) over an exponential window, 0 where a factor has no energy."""
    x = x.reshape(len(x), -1)
    keep = np.exp(-H / seconds)
    out = np.zeros((len(x), at.LAGS))
    energy = lfilter([1], [1, -keep], (x * x).sum(1))
    for lag in range(at.LAGS):
        later, before = x[lag:], x[: len(x) - lag]
        product = lfilter([1], [1, -keep], (later * before).sum(1))
        own, other = energy[lag:], energy[: len(x) - lag]
        good = (other >= 0.1 * own) & (other > 0)
        out[lag:, lag] = np.where(good, product / np.sqrt(np.where(good, own * other, 1)), 0)
    return out


class StateVariableFilter:
    """Two integrators by the trapezoidal rule, solved as the linear system that the rule gives.

    b' = ω (x - d b - l), l' = ω b, the integrators' memories with g = tan(ωh/2): b = m_b + g (x - d b - l), l = m_l + g b.
    """

    def __init__(self):
        self.memory = np.zeros(2)

    def __call__(self, x, hz, quality):
        g, d = np.tan(np.pi * hz * H), 1 / quality
        b, low = np.linalg.solve([[1 + g * d, g], [-g, 1]], np.add(self.memory, (g * x, 0.0)))
        self.memory = 2 * np.array([b, low]) - self.memory
        return x - d * b - low, d * b


def top(values, i):
    """Place and height of the parabola through three values about i."""
    a, b, c = values[i - 1 : i + 2]
    bend = a - 2 * b + c
    d = 0.5 * (a - c) / bend if bend < 0 else 0.0
    return i + d, b - 0.25 * (a - c) * d


def shortest_period(r, p):
    """Period, s, and its coefficient of the coefficients (LAGS,) of one cell."""
    first = max(2, int(1 / (p.fastest_hz * H)))
    best = r[first:-1].max()
    if best > 0:
        for i in range(first, at.LAGS - 1):
            if r[i] >= 0.85 * best and r[i] >= r[i - 1] and r[i] > r[i + 1]:
                place, height = top(r, i)
                return place * H, height
    return 0.0, 0.0


def best_period(r, p):
    """The same for the rotation: the highest top. A top must be above the refined height of those before it."""
    first = max(2, int(2 / (p.fastest_hz * H)))
    place = height = 0.0
    for i in range(first, at.LAGS - 1):
        if r[i] > height and r[i] >= r[i - 1] and r[i] > r[i + 1]:
            place, height = top(r, i)
    return place * H, height


def between(r, seconds):
    """Coefficient at a lag between cells, 0 beyond the last."""
    return float(np.interp(seconds / H, np.arange(at.LAGS), r)) if int(seconds / H) + 1 < at.LAGS else 0.0


class Walk:
    """Candidates, and the steps they become."""

    def __init__(self, p):
        self.p = p
        self.walking = False
        self.period = self.size = 0.0
        self.last = -np.inf
        self.quiet = 0.0
        self.frequency = 0.0
        self.waiting: list[tuple[float, float]] = []

    def count(self, times, short, period):
        self.last, self.quiet, self.frequency = times[-1], short, 1 / period
        return [(t, self.frequency) for t in times]

    def consider(self, t, size, short, period, score, demand):
        p = self.p
        since = t - self.last
        if self.walking:
            if since < p.refractory * self.period or size < p.peak_share * self.size:
                return []
            missed = since > (2 - p.irregularity) * self.period
            target = since if since < (1 + p.irregularity) * self.period else period if score >= demand else self.period
            self.period = max(1 / p.fastest_hz, 0.7 * self.period + 0.3 * target)
            self.size = 0.8 * self.size + 0.2 * size
            return self.count([t - since / 2, t] if missed else [t], short, self.period)
        if self.waiting:
            since = t - self.waiting[-1][0]
            if since < 0.8 / p.fastest_hz:
                self.waiting[-1] = max(self.waiting[-1], (t, size), key=lambda c: c[1])
                return []
            if since > 1.3 / p.slowest_hz:
                self.waiting = []
        elif since < 1 / p.fastest_hz:
            return []
        self.waiting = [*self.waiting, (t, size)][-at.MAX_NEW :]
        need = p.first_steps
        if len(self.waiting) < need or score < demand or period <= 0:
            return []
        times, sizes = np.array(self.waiting).T
        mean, usual = (times[-1] - times[-need]) / (need - 1), sizes[-need:].mean()
        fits = (np.abs(np.diff(times) - mean) <= p.irregularity * mean) & (sizes[:-1] >= p.peak_share * usual)
        chain = 1 + int(np.cumprod(fits[::-1]).sum())
        if abs(mean - period) > 0.5 * p.irregularity * period or chain < need:
            return []
        self.walking, self.period, self.size, self.waiting = True, max(1 / p.fastest_hz, mean), usual, []
        return self.count(list(times[-chain:]), short, period)

    def pause(self, t, short):
        if self.walking:
            p = self.p
            self.quiet = min(self.quiet, short)
            since = (t - self.last) / self.period
            quiet = 2 * self.quiet < (p.quiet_share * self.size) ** 2
            if since > p.pause or (since > 1 + p.irregularity and quiet):
                self.walking, self.waiting, self.frequency = False, [], 0.0


class Mode:
    """A mode that changes when another has been found for so long."""

    def __init__(self, mode):
        self.mode, self.found, self.since = mode, mode, 0.0

    def __call__(self, now, t, dwell_s):
        if now != self.found:
            self.found, self.since = now, t
        if t - self.since > dwell_s - H / 2:
            self.mode = now


def motion(now, p, frequency, force, climb):
    if frequency >= p.run_hz and force >= p.run_force:
        return at.RUNNING
    return at.STAIRS if abs(climb) >= (p.climb_left if now == at.STAIRS else p.climb_speed) else at.WALKING


def carrying(p, rate, stride, screen, upper):
    if rate >= p.swing_rate and stride >= p.swing_stride:
        return at.POCKET if abs(upper) >= p.pocket_upright else at.SWINGING
    if screen >= p.screen_up:
        return at.TEXTING
    phone = p.phone_top <= upper <= p.phone_top_most and abs(screen) <= p.phone_screen and rate <= p.phone_rate
    return at.PHONING if phone else at.BAG


def climbing(time, pressure, seconds):
    """Speed of climbing (N,) at the samples: what a double exponential smoothing of the height says. One run, without long gaps."""
    speed, out, last, level = 0.0, np.zeros(len(time)), None, 0.0
    for k in np.flatnonzero(np.isfinite(pressure)):
        height = -8434.0 * np.log(pressure[k] / 101325.0)
        if last is None:
            level = height
        else:
            dt = time[k] - last
            a = dt / (dt + seconds)
            ahead = level + speed * dt
            speed += a * a * (height - ahead) / dt
            level = ahead + a * (2 - a) * (height - ahead)
        last, out[k:] = time[k], speed
    return out


def steps(time, f, w, parameters, g, up=None, pressure=None):
    """Events (M,3) time, frequency, confirmed; and of each cell (K,…) when it closes, frequency, modes, features."""
    d, m = parameters.detection, parameters.modes
    up = directions(time, f, w, d.level_s, g) if up is None else up
    signal = 0.5 * ((f * up).sum(1) + np.linalg.norm(f, axis=1)) - g
    cells, middle, ends = cell_means(time, np.column_stack([signal, w]))
    closing = np.searchsorted(time, ends)  # the sample at which a cell is full
    a, rates = cells[:, 0], cells[:, 1:]
    high = StateVariableFilter()
    x = np.array([high(v, d.high_pass_hz, np.sqrt(0.5))[0] for v in a])
    rates = rates - (rates[0] + averaged(rates - rates[0], 2.0))
    energy, short = averaged(x**2, m.window_s), averaged(x**2, 0.25)
    rate = np.sqrt(averaged((rates**2).sum(1), m.window_s))
    gravity = averaged(up[closing], m.window_s)
    gravity /= np.linalg.norm(gravity, axis=1, keepdims=True)
    screen, upper = gravity @ np.array(m.screen_axis), gravity @ np.array(m.top_axis)
    climb = climbing(time, np.full(len(time), np.nan) if pressure is None else pressure, m.climb_s)[closing]
    of_force, of_rate = coefficients(x, d.correlation_s), coefficients(rates, d.correlation_s)

    walk, first, second = Walk(d), StateVariableFilter(), StateVariableFilter()
    centre, stride, opened, peak = d.start_hz, False, 0.0, 0.0
    band = np.zeros(3)
    moves, carries = Mode(at.STATIC), Mode(at.TEXTING)
    events, rows = [], []
    for k, t in enumerate(middle):
        period, score = shortest_period(of_force[k], d)
        turning, turning_score = best_period(of_rate[k], d)
        opposite = min(turning_score, -between(of_rate[k], turning / 2))
        fast = turning < 2 / d.swing_fastest_hz and rate[k] < d.swing_fast_rate
        stride = bool(turning and rate[k] > d.stride_rate and not fast and opposite > (0.5 if stride else 1) * d.stride_correlation)
        if stride:
            period = turning / 2
            score, demand = max(between(of_force[k], turning), between(of_force[k], period)), d.stride_periodic
        else:
            demand = min(d.periodic_most, d.periodic + d.periodic_rate * rate[k])
            if period > 1 / d.slowest_hz or (walk.walking and rate[k] > d.stride_rate and period > 1.6 * walk.period):
                period /= 2
        target = 1 / period if period and score > demand / 2 else 1 / walk.period if walk.walking else d.start_hz
        centre += (1 - np.exp(-H / d.follow_s)) * (target - centre)
        quality = d.stride_selectivity if stride else d.selectivity
        band = np.array([second(first(a[k], centre, quality)[1], centre, quality)[1], *band[:2]])
        if band[1] > max(0, opened, band[2]) and band[1] >= band[0]:
            bend = band[2] - 2 * band[1] + band[0]
            peak, opened = t - H + H * 0.5 * (band[2] - band[0]) / bend, band[1]
        if band[0] <= 0 and opened > 0:
            if opened > d.least_force and np.sqrt(2 * short[k]) > d.ringing * opened:
                found = walk.consider(peak, opened, short[k], period, score, demand)
                events += [(*e, time[closing[k]]) for e in found]
            opened = 0.0
        walk.pause(t, short[k])
        against = -between(of_rate[k], period) if period else 0.0
        if walk.walking:
            begins = moves.mode == at.STATIC
            now = motion(moves.mode, m, walk.frequency, np.sqrt(energy[k]), climb[k])
            smooth = begins or at.STAIRS in (now, moves.mode)
            moves(now, t, 0.0 if smooth else m.dwell_s)
            carries(carrying(m, rate[k], against, screen[k], upper[k]), t, 0.0 if begins else m.dwell_s)
        else:
            moves.mode = at.STATIC
        own = (walk.frequency, moves.mode, carries.mode)
        rows.append(
            (
                *own,
                np.sqrt(energy[k]),
                rate[k],
                score,
                demand,
                1 / period if period else 0.0,
                against,
                screen[k],
                upper[k],
                climb[k],
                band[0],
                x[k],
            )
        )
    return np.array(events).reshape(-1, 3), closing, np.array(rows)
