"""Stance detection: windows by running sums, then the threshold rule, over the samples of one call.

What the next call needs lies in two flat arrays: `index` (int64, sizes and counters) and `memory` (float64). In a call, samples are read
where the caller has them; only the last few are kept. `statistics` fills T, whose first entries are those kept from the call before,
and `verdict` judges a sample once everything that its window and look-ahead need is there.

A window's sums are updated by the sample that enters and the one that leaves. They are made anew from the window at every REFRESH-th
sample of the recording, and after a shock has left it, so that rounding can neither pile up nor outlive its cause.
"""

import math

from bematist.kernels.jit import inlined, kernel

# index: sizes, places and counters
(
    COUNT,  # samples taken in
    JUDGED,  # verdicts given
    WINDOW,  # N, odd
    LOOKAHEAD,  # samples on either side whose least statistic counts
    MASK,  # capacity of the rings - 1, a power of two less one
    QUEUE_FIRST,
    QUEUE_LAST,
    DETECTOR,
    RULE,
    TAIL,  # places in memory
    ROWS,
    QUEUE,
    AHEAD,  # samples of the window after the judged one
) = range(13)
INDEX_SIZE = 16

# memory: fixed places before the rings
SUMS = 0  # f_x f_y f_z |f|² |w|² (for AMAG |f|), count
HELD = 8  # times of the last good specific force and angular rate, then their values
HEAD_SIZE = 16

REFRESH = 64
SHOCK = 16.0  # a leaving |f|² or |w|² above this many times what remains
ROW = 11  # t f w m flag

# detectors and rules
SHOE, ARED, AMVD, AMAG, GYRO_NORM = range(5)
ABSOLUTE, RELATIVE = range(2)

# flags of a row
MEASURED, HELD_SAMPLE, MISSING = 0.0, 1.0, 2.0


@inlined
def _statistic(sums, detector, weight_a, weight_g, g):
    """Test statistic of a window from its sums, normalised by the number of samples n; infinite without one.

    SHOE: MAGINAV eqs 1-2 (errata: summation index, division by N), Skog eq 13. ARED: Skog eq 20. AMVD: Skog eq 16. AMAG: Skog eq 18.
    GYRO_NORM: Li & Wang eq 35, as the root mean square over the window (erratum: one sample fires in mid-swing), rad/s.
    `other` is the sum of |w|², for AMAG that of |f|.
    """
    s0, s1, s2, ff, other, n = sums
    if n == 0:
        return math.inf
    if detector == SHOE:
        # sum |f - g mean(f)/|mean(f)||² = sum |f|² - 2 g |sum f| + n g²
        value = ((ff - 2 * g * math.sqrt(s0 * s0 + s1 * s1 + s2 * s2) + n * g * g) * weight_a + other * weight_g) / n
    elif detector == ARED:
        value = other * weight_g / n
    elif detector == AMVD:
        value = (ff - (s0 * s0 + s1 * s1 + s2 * s2) / n) * weight_a / n
    elif detector == AMAG:
        value = (ff - 2 * g * other + n * g * g) * weight_a / n
    else:
        value = math.sqrt(max(0.0, other) / n)
    # Not a number, after an overflow: that is no rest.
    return max(0.0, value) if value == value else math.inf


@inlined
def _channels(f0, f1, f2, w0, w1, w2, detector):
    """What a sample adds to the sums."""
    ff = f0 * f0 + f1 * f1 + f2 * f2
    other = math.sqrt(ff) if detector == AMAG else w0 * w0 + w1 * w1 + w2 * w2
    return f0, f1, f2, ff, other, 1.0


@inlined
def _new(columns, flags, k, detector):
    """What row k of the caller's adds to the sums."""
    if flags.shape[0] > 0 and flags[k] == MISSING:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return _channels(columns[1, k], columns[2, k], columns[3, k], columns[4, k], columns[5, k], columns[6, k], detector)


@inlined
def _any(index, memory, columns, flags, k, detector):
    """What sample k adds to the sums, counted from the first of the call: before it, from the ring; outside all, nothing."""
    if k >= 0:
        if k < columns.shape[1]:
            return _new(columns, flags, k, detector)
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    j = index[COUNT] + k
    r = index[ROWS] + ROW * (j & index[MASK])
    if j < 0 or memory[r + 10] == MISSING:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return _channels(memory[r + 1], memory[r + 2], memory[r + 3], memory[r + 4], memory[r + 5], memory[r + 6], detector)


@inlined
def _plus(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@inlined
def _minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]


@inlined
def shocked(leaving, sums):
    """Whether a sample that left was so large, or no number, that its rounding may matter in what remains."""
    return not (leaving[3] <= SHOCK * sums[3] and leaving[4] <= SHOCK * max(sums[4], 1e-6))


@inlined
def _anew(index, memory, columns, flags, last, detector):
    """Sums of the window that ends with sample `last`, counted from the first of the call."""
    sums = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(last + 1 - index[WINDOW], last + 1):
        sums = _plus(sums, _any(index, memory, columns, flags, i, detector))
    return sums


@inlined
def statistics(index, memory, columns, flags, finish, weight_a, weight_g, g, T):
    """Statistic of every sample whose window is full, or cut off by the end, into T; returns how many samples have one by now.

    T holds, at the start, room for the 2·LOOKAHEAD statistics kept from the last call, and then one for every sample of the call (and, at
    the end, for AHEAD more): T[c - first] belongs to sample c, with first = count - AHEAD - 2·LOOKAHEAD.
    """
    n = columns.shape[1]
    start = index[COUNT]
    size = index[WINDOW]
    detector = index[DETECTOR]
    ahead = index[AHEAD]
    kept = 2 * index[LOOKAHEAD]
    for c in range(kept):
        T[c] = memory[index[TAIL] + c]
    sums = (memory[SUMS], memory[SUMS + 1], memory[SUMS + 2], memory[SUMS + 3], memory[SUMS + 4], memory[SUMS + 5])
    end = n + (ahead if finish else 0)
    k = 0
    while k < end:
        if (start + k) % REFRESH == 0:
            sums = _anew(index, memory, columns, flags, k - 1, detector)
        stop = min(end, k + REFRESH - (start + k) % REFRESH)
        if k >= size and stop <= n:
            for i in range(k, stop):
                leaving = _new(columns, flags, i - size, detector)
                sums = _minus(_plus(sums, _new(columns, flags, i, detector)), leaving)
                if shocked(leaving, sums):
                    sums = _anew(index, memory, columns, flags, i, detector)
                T[kept + i] = _statistic(sums, detector, weight_a, weight_g, g)
        else:
            for i in range(k, stop):
                leaving = _any(index, memory, columns, flags, i - size, detector)
                sums = _minus(_plus(sums, _any(index, memory, columns, flags, i, detector)), leaving)
                if shocked(leaving, sums):
                    sums = _anew(index, memory, columns, flags, i, detector)
                T[kept + i] = _statistic(sums, detector, weight_a, weight_g, g)
        k = stop
    memory[SUMS], memory[SUMS + 1], memory[SUMS + 2], memory[SUMS + 3], memory[SUMS + 4], memory[SUMS + 5] = sums
    for c in range(kept):
        memory[index[TAIL] + c] = T[n + c]
    return start + n if finish else max(0, start + n - ahead)


@inlined
def keep(index, memory, columns, flags):
    """After a call: keep the last samples in the ring, and what a missing value would be held at."""
    n = columns.shape[1]
    mask = index[MASK]
    start = index[COUNT]
    for k in range(max(0, n - mask - 1), n):
        r = index[ROWS] + ROW * ((start + k) & mask)
        for c in range(10):
            memory[r + c] = columns[c, k]
        memory[r + 10] = MEASURED if flags.shape[0] == 0 else flags[k]
    hold_last(memory, columns, flags)
    index[COUNT] = start + n


@inlined
def hold_last(memory, columns, flags):
    """After a call with complete samples: what a missing value would be held at."""
    n = columns.shape[1]
    if n > 0 and flags.shape[0] == 0:
        memory[HELD] = memory[HELD + 1] = columns[0, n - 1]
        for c in range(6):
            memory[HELD + 2 + c] = columns[1 + c, n - 1]


@inlined
def complete(columns):
    """Whether every specific force and angular rate is a number."""
    total = 0.0
    for k in range(columns.shape[1]):
        for c in range(1, 7):
            total += columns[c, k] - columns[c, k]
    return total == 0.0


@kernel
def fill(memory, columns, flags, gap_s):
    """Hold the last good value over NaN in specific force or angular rate, in place, for at most `gap_s`; say in flags what was done.

    A sample whose values have been missing for longer is set to zero and flagged MISSING.
    """
    for k in range(columns.shape[1]):
        t = columns[0, k]
        flags[k] = MEASURED
        for sensor in range(2):
            c = 1 + 3 * sensor
            if math.isfinite(columns[c, k] + columns[c + 1, k] + columns[c + 2, k]):
                memory[HELD + sensor] = t
                for i in range(3):
                    memory[HELD + 2 + 3 * sensor + i] = columns[c + i, k]
            else:
                flags[k] = max(flags[k], HELD_SAMPLE if t - memory[HELD + sensor] <= gap_s else MISSING)
                for i in range(3):
                    columns[c + i, k] = memory[HELD + 2 + 3 * sensor + i]
        if flags[k] == MISSING:
            for c in range(1, 7):
                columns[c, k] = 0.0


@inlined
def _least(index, memory, T, first, j, known):
    """Least statistic within ±LOOKAHEAD of sample j, of those known: the front of a queue of rising statistics."""
    mask, queue, look = index[MASK], index[QUEUE], index[LOOKAHEAD]
    front, back = index[QUEUE_FIRST], index[QUEUE_LAST]
    # Up to j + LOOKAHEAD - 1 is in the queue from the sample before; at the start, nothing.
    for c in range(0 if j == 0 else j + look, min(j + look + 1, known)):
        while back > front and T[int(memory[queue + ((back - 1) & mask)]) - first] >= T[c - first]:
            back -= 1
        memory[queue + (back & mask)] = c
        back += 1
    while int(memory[queue + (front & mask)]) < j - look:
        front += 1
    index[QUEUE_FIRST] = front
    index[QUEUE_LAST] = back
    return T[int(memory[queue + (front & mask)]) - first]


@inlined
def verdict(index, memory, T, first, j, known, threshold, zero_velocity_sd, floor, ratio):
    """Statistic, threshold and standard deviation of the zero velocity (0: swing) of sample j.

    ABSOLUTE: MAGINAV eq 3, T < threshold (which may follow the speed, `pace`). RELATIVE: T < ratio·m with m the least T within
    ±LOOKAHEAD samples, at least `floor`; the noise follows the statistic, sd·(m/floor)^¼·T/m (at least a quarter of it), so that a rolling
    foot is believed less than a standing one.
    """
    statistic = T[j - first]
    sd = 0.0
    if index[RULE] == RELATIVE:
        base = max(floor, _least(index, memory, T, first, j, known))
        limit = ratio * base
        if statistic < limit:
            sd = zero_velocity_sd * math.sqrt(math.sqrt(base / floor)) * max(statistic / base, 0.25)
    else:
        limit = threshold
        if statistic < limit:
            sd = zero_velocity_sd
    return statistic, limit, sd


@inlined
def origin(index):
    """The sample whose statistic stands at T[0] in this call."""
    return index[COUNT] - index[AHEAD] - 2 * index[LOOKAHEAD]


@kernel
def detect(index, memory, columns, flags, finish, weight_a, weight_g, g, threshold, zero_velocity_sd, floor, ratio, T, out):
    """Statistic, threshold and zero-velocity standard deviation of every sample: the detector without the filter.

    columns (10,n) samples without NaN in force and rate, or with the flags (n,) that `fill` gave, else flags (0,); finish: no more will
    come; T scratch (see `statistics`); out (n + latency, 3), or (0, 3) where only the statistics in T are wanted. Returns the number of
    rows written.
    """
    first = origin(index)
    known = statistics(index, memory, columns, flags, finish, weight_a, weight_g, g, T)
    if out.shape[0] == 0:
        keep(index, memory, columns, flags)
        return 0
    judged = index[JUDGED]
    last = known if finish else known - index[LOOKAHEAD]
    for j in range(judged, last):
        statistic, limit, sd = verdict(index, memory, T, first, j, known, threshold, zero_velocity_sd, floor, ratio)
        out[j - judged, 0], out[j - judged, 1], out[j - judged, 2] = statistic, limit, sd
    index[JUDGED] = max(judged, last)
    keep(index, memory, columns, flags)
    return index[JUDGED] - judged
