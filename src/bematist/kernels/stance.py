"""Stance detection sample by sample: hold, centred windows by running sums, threshold rule, delay.

A sample goes in at one end (`push`); out of the other, `latency` samples later, comes a sample with its verdict (`verdict`). What lies
between is two flat arrays: `index` (int64, sizes and counters) and `memory` (float64, rings and sums).

Window sums are kept as a prefix sum of the present block of N samples and suffix sums of the block before it, so every sum is made of
additions only: nothing is ever subtracted and no rounding outlives its window.
"""

import math

from bematist.kernels.jit import inlined, kernel

# index: where things stand
COUNT_IN, COUNT_OUT, WINDOW, LOOKAHEAD, CAPACITY, DEQUE_FIRST, DEQUE_SIZE, DETECTOR, RULE = range(9)
SUFFIX, BLOCK, ROWS, STATISTIC, DEQUE, MEMORY_SIZE = range(9, 15)
REAL = 15
INDEX_SIZE = 16

# memory: fixed places before the rings
PREFIX = 0  # 7 running sums: f_x f_y f_z |f|² |w|² |f| count
HELD = 8  # last good time, f, w
HEAD_SIZE = 18

CHANNELS = 7
ROW = 11  # t f w m flag

# detectors and rules
SHOE, ARED, AMVD, AMAG, GYRO_NORM = range(5)
ABSOLUTE, RELATIVE = range(2)

# flags of a row
MEASURED, HELD_SAMPLE, MISSING = 0.0, 1.0, 2.0


@inlined
def _statistic(detector, s0, s1, s2, ff, ww, fn, n, sigma_a2, sigma_g2, g):
    """Test statistic of a window from its sums, normalised by the number of samples n.

    SHOE: MAGINAV eqs 1-2 (errata: summation index, division by N), Skog eq 13. ARED: Skog eq 20. AMVD: Skog eq 16. AMAG: Skog eq 18.
    GYRO_NORM: Li & Wang eq 35, as the root mean square over the window (erratum: one sample fires in mid-swing), rad/s.
    """
    if detector == ARED:
        return ww / (n * sigma_g2)
    if detector == AMVD:
        return (ff - (s0 * s0 + s1 * s1 + s2 * s2) / n) / (n * sigma_a2)
    if detector == AMAG:
        return (ff - 2 * g * fn + n * g * g) / (n * sigma_a2)
    if detector == GYRO_NORM:
        return math.sqrt(ww / n)
    # sum |f - g mean(f)/|mean(f)||² = sum |f|² - 2 g |sum f| + n g²
    norm = math.sqrt(s0 * s0 + s1 * s1 + s2 * s2)
    return ((ff - 2 * g * norm + n * g * g) / sigma_a2 + ww / sigma_g2) / n


@inlined
def _window(index, memory, f0, f1, f2, w0, w1, w2, valid, detector, sigma_a2, sigma_g2, g):
    """Take in one sample (or an empty place) and return the statistic of the last N places; infinite without a valid sample."""
    size = index[WINDOW]
    block = index[BLOCK]
    suffix = index[SUFFIX]
    place = index[COUNT_IN] % size
    if place == 0:
        for c in range(CHANNELS):
            memory[PREFIX + c] = 0.0
    b = block + CHANNELS * place
    if valid:
        ff = f0 * f0 + f1 * f1 + f2 * f2
        memory[b] = f0
        memory[b + 1] = f1
        memory[b + 2] = f2
        memory[b + 3] = ff
        memory[b + 4] = w0 * w0 + w1 * w1 + w2 * w2
        memory[b + 5] = math.sqrt(ff) if detector == AMAG else 0.0
        memory[b + 6] = 1.0
        for c in range(CHANNELS):
            memory[PREFIX + c] += memory[b + c]
    else:
        for c in range(CHANNELS):
            memory[b + c] = 0.0
    s = suffix + CHANNELS * (place + 1)
    n = memory[PREFIX + 6] + memory[s + 6]
    statistic = math.inf
    if n > 0:
        statistic = _statistic(
            detector,
            memory[PREFIX] + memory[s],
            memory[PREFIX + 1] + memory[s + 1],
            memory[PREFIX + 2] + memory[s + 2],
            memory[PREFIX + 3] + memory[s + 3],
            memory[PREFIX + 4] + memory[s + 4],
            memory[PREFIX + 5] + memory[s + 5],
            n,
            sigma_a2,
            sigma_g2,
            g,
        )
    if place == size - 1:
        for j in range(size - 1, 0, -1):
            for c in range(CHANNELS):
                memory[suffix + CHANNELS * j + c] = memory[suffix + CHANNELS * (j + 1) + c] + memory[block + CHANNELS * j + c]
    return max(statistic, 0.0)


@inlined
def push(index, memory, row, k, empty, sigma_a2, sigma_g2, g, gap_s):
    """Take in sample row k (or, after the end, an empty place). True when a verdict is ready to be taken.

    NaN in specific force or angular rate: the last good value is held for at most `gap_s`; longer, the sample is missing.
    """
    i = index[COUNT_IN]
    capacity = index[CAPACITY]
    flag = MEASURED
    f0 = f1 = f2 = w0 = w1 = w2 = 0.0
    if empty:
        flag = MISSING
    else:
        t = row[k, 0]
        f0, f1, f2, w0, w1, w2 = row[k, 1], row[k, 2], row[k, 3], row[k, 4], row[k, 5], row[k, 6]
        bad_f = not math.isfinite(f0 + f1 + f2)
        bad_w = not math.isfinite(w0 + w1 + w2)
        if bad_f:
            flag = HELD_SAMPLE if t - memory[HELD] <= gap_s else MISSING
            f0, f1, f2 = memory[HELD + 2], memory[HELD + 3], memory[HELD + 4]
        else:
            memory[HELD], memory[HELD + 2], memory[HELD + 3], memory[HELD + 4] = t, f0, f1, f2
        if bad_w:
            flag = max(flag, HELD_SAMPLE if t - memory[HELD + 1] <= gap_s else MISSING)
            w0, w1, w2 = memory[HELD + 5], memory[HELD + 6], memory[HELD + 7]
        else:
            memory[HELD + 1], memory[HELD + 5], memory[HELD + 6], memory[HELD + 7] = t, w0, w1, w2
        r = index[ROWS] + ROW * (i % capacity)
        memory[r] = t
        memory[r + 1], memory[r + 2], memory[r + 3] = f0, f1, f2
        memory[r + 4], memory[r + 5], memory[r + 6] = w0, w1, w2
        memory[r + 7], memory[r + 8], memory[r + 9] = row[k, 7], row[k, 8], row[k, 9]
        memory[r + 10] = flag
    statistic = _window(index, memory, f0, f1, f2, w0, w1, w2, flag < MISSING, index[DETECTOR], sigma_a2, sigma_g2, g)
    index[COUNT_IN] = i + 1
    if not empty:
        index[REAL] = i + 1
    centre = i - (index[WINDOW] - 1) // 2
    if centre >= index[REAL]:
        statistic = math.inf
    if centre >= 0:
        memory[index[STATISTIC] + centre % capacity] = statistic
        if index[LOOKAHEAD] > 0:
            _keep_minimum(index, memory, centre, statistic)
    return centre >= index[LOOKAHEAD]


@inlined
def _keep_minimum(index, memory, centre, statistic):
    """Add a statistic to the rising queue whose first entry is the least within ±LOOKAHEAD of the sample to be judged."""
    capacity, queue = index[CAPACITY], index[DEQUE]
    first, size = index[DEQUE_FIRST], index[DEQUE_SIZE]
    while size > 0:
        last = int(memory[queue + (first + size - 1) % capacity])
        if memory[index[STATISTIC] + last % capacity] < statistic:
            break
        size -= 1
    memory[queue + (first + size) % capacity] = centre
    size += 1
    while int(memory[queue + first]) < centre - 2 * index[LOOKAHEAD]:
        first = (first + 1) % capacity
        size -= 1
    index[DEQUE_FIRST] = first
    index[DEQUE_SIZE] = size


@inlined
def verdict(index, memory, threshold, zero_velocity_sd, floor, ratio):
    """Statistic, threshold and standard deviation of the zero velocity (0: swing) of the next sample, and where its row stands.

    ABSOLUTE: MAGINAV eq 3, T < threshold. RELATIVE: T < ratio·m with m the least T within ±LOOKAHEAD samples, at least `floor`; the noise
    follows the statistic, sd·(m/floor)^¼·T/m, so that a rolling foot is believed less than a standing one.
    """
    capacity = index[CAPACITY]
    j = index[COUNT_OUT]
    index[COUNT_OUT] = j + 1
    statistic = memory[index[STATISTIC] + j % capacity]
    sd = 0.0
    if index[RULE] == RELATIVE:
        least = statistic
        if index[LOOKAHEAD] > 0:
            least = memory[index[STATISTIC] + int(memory[index[DEQUE] + index[DEQUE_FIRST]]) % capacity]
        base = max(floor, least)
        limit = ratio * base
        if statistic < limit:
            sd = zero_velocity_sd * math.sqrt(math.sqrt(base / floor)) * max(statistic / base, 0.25)
    else:
        limit = threshold
        if statistic < limit:
            sd = zero_velocity_sd
    return statistic, limit, sd, index[ROWS] + ROW * (j % capacity)


@kernel
def detect(index, memory, rows, finish, sigma_a2, sigma_g2, g, gap_s, threshold, zero_velocity_sd, floor, ratio, out):
    """Statistic, threshold and zero-velocity standard deviation of every sample: the detector without the filter.

    rows (n,10) sample rows; finish: no more will come; out (≥ n + latency, 3). Returns the number of rows written.
    """
    n = rows.shape[0]
    written = 0
    extra = index[LOOKAHEAD] + (index[WINDOW] - 1) // 2 if finish else 0
    for k in range(n + extra):
        if push(index, memory, rows, k, k >= n, sigma_a2, sigma_g2, g, gap_s):
            if index[COUNT_OUT] >= index[REAL]:
                break
            statistic, limit, sd, _ = verdict(index, memory, threshold, zero_velocity_sd, floor, ratio)
            out[written, 0] = statistic
            out[written, 1] = limit
            out[written, 2] = sd
            written += 1
    return written
