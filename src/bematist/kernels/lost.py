"""Where samples were lost, from late and jittered stamps: a beam of hypotheses, as Viterbi's trellis with a tracked clock."""

import numpy as np

from bematist.kernels.jit import kernel

BEAM = 16


@kernel
def lost_samples(t, period, jitter, penalty, clip):
    """Samples lost before each stamp but the first, (N-1,) int64.

    Each hypothesis follows the clock (level and period, an alpha-beta tracker) and pays the squared residual of every stamp in
    units of `jitter` (s), at most `clip`, and `penalty` for each loss. Hypotheses with equal totals merge into the better.
    """
    n = len(t)
    alpha, beta = 0.06, 0.0009
    cost = np.full(BEAM, np.inf)
    level = np.zeros(BEAM)
    step = np.zeros(BEAM)
    total = np.zeros(BEAM, np.int64)
    cost[0], level[0], step[0] = 0.0, t[0], period
    parent = np.zeros((n, BEAM), np.int8)
    jump = np.zeros((n, BEAM), np.int32)
    m = 4 * BEAM
    c2 = np.empty(m)
    l2 = np.empty(m)
    s2 = np.empty(m)
    n2 = np.empty(m, np.int64)
    p2 = np.empty(m, np.int64)
    j2 = np.empty(m, np.int64)
    for k in range(1, n):
        count = 0
        for h in range(BEAM):
            if not cost[h] < np.inf:
                continue
            predicted = level[h] + step[h]
            e = t[k] - predicted
            whole = int(np.round(e / step[h]))
            for c in range(4):
                loss = 0 if c == 0 else whole + c - 2
                if c > 0 and loss < 1:
                    continue
                r = e - loss * step[h]
                price = min(0.5 * (r / jitter) ** 2, clip) + (penalty if loss > 0 else 0.0)
                r = min(max(r, -3 * jitter), 3 * jitter)
                c2[count] = cost[h] + price
                l2[count] = predicted + loss * step[h] + alpha * r
                s2[count] = min(max(step[h] + beta * r, 0.98 * period), 1.02 * period)
                n2[count] = total[h] + loss
                p2[count] = h
                j2[count] = loss
                count += 1
        best = np.argsort(c2[:count])
        low = c2[best[0]]
        kept = 0
        for i in best:
            again = False
            for q in range(kept):
                if total[q] == n2[i]:
                    again = True
                    break
            if again:
                continue
            cost[kept] = c2[i] - low
            level[kept] = l2[i]
            step[kept] = s2[i]
            total[kept] = n2[i]
            parent[k, kept] = p2[i]
            jump[k, kept] = j2[i]
            kept += 1
            if kept == BEAM:
                break
        for q in range(kept, BEAM):
            cost[q] = np.inf
            total[q] = -1
    out = np.zeros(n - 1, np.int64)
    h = int(np.argmin(cost))
    for k in range(n - 1, 0, -1):
        out[k - 1] = jump[k, h]
        h = parent[k, h]
    return out
