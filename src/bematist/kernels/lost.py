"""Where samples were lost, from late and jittered stamps: a beam of hypotheses, as Viterbi's trellis with a tracked clock."""

import math

from bematist.kernels.jit import kernel

BEAM = 16
NEXT = 4 * BEAM

# rows of `real` (6, NEXT): the hypotheses, and those that follow from them
COST, LEVEL, STEP, COST_NEXT, LEVEL_NEXT, STEP_NEXT = range(6)
# rows of `whole` (4, NEXT)
TOTAL, TOTAL_NEXT, PARENT_NEXT, LOSS_NEXT = range(4)

ALPHA, BETA = 0.06, 0.0009
"""Gains of the tracker of level and period: it follows a clock within some tens of samples."""


@kernel
def lost_samples(t, period, jitter, penalty, clip, real, whole, parent, loss, out):
    """Samples lost before each stamp but the first, into out (N-1,) int64.

    Each hypothesis follows the clock (level and period, an alpha-beta tracker) and pays the squared residual of every stamp t (N,)
    in units of `jitter` (s), at most `clip`, and `penalty` for each loss. Hypotheses with equal totals merge into the better.
    Workspace: real (6, NEXT), whole (4, NEXT) int64, parent (N, BEAM) and loss (N, BEAM) integers.
    """
    n = len(t)
    alive = 1
    real[COST, 0], real[LEVEL, 0], real[STEP, 0] = 0.0, t[0], period
    whole[TOTAL, 0] = 0
    for k in range(1, n):
        count = 0
        for h in range(alive):
            predicted = real[LEVEL, h] + real[STEP, h]
            e = t[k] - predicted
            # No loss, or as many as the stamp suggests, one more or less.
            guess = math.floor(e / real[STEP, h] + 0.5)
            for c in range(4):
                lost = 0 if c == 0 else int(guess) + c - 2
                if c > 0 and lost < 1:
                    continue
                r = e - lost * real[STEP, h]
                price = min(0.5 * (r / jitter) ** 2, clip)
                if lost > 0:
                    price += penalty
                r = min(max(r, -3 * jitter), 3 * jitter)
                real[COST_NEXT, count] = real[COST, h] + price
                real[LEVEL_NEXT, count] = predicted + lost * real[STEP, h] + ALPHA * r
                real[STEP_NEXT, count] = min(max(real[STEP, h] + BETA * r, 0.98 * period), 1.02 * period)
                whole[TOTAL_NEXT, count] = whole[TOTAL, h] + lost
                whole[PARENT_NEXT, count] = h
                whole[LOSS_NEXT, count] = lost
                count += 1
        alive = 0
        low = math.inf
        while alive < BEAM:
            best = -1
            for i in range(count):
                if real[COST_NEXT, i] < math.inf and (best < 0 or real[COST_NEXT, i] < real[COST_NEXT, best]):
                    best = i
            if best < 0:
                break
            low = min(low, real[COST_NEXT, best])
            real[COST, alive] = real[COST_NEXT, best] - low
            real[LEVEL, alive] = real[LEVEL_NEXT, best]
            real[STEP, alive] = real[STEP_NEXT, best]
            whole[TOTAL, alive] = whole[TOTAL_NEXT, best]
            parent[k, alive] = whole[PARENT_NEXT, best]
            loss[k, alive] = whole[LOSS_NEXT, best]
            for i in range(count):
                if whole[TOTAL_NEXT, i] == whole[TOTAL, alive]:
                    real[COST_NEXT, i] = math.inf
            alive += 1
    h = 0  # the cheapest comes first
    for k in range(n - 1, 0, -1):
        out[k - 1] = loss[k, h]
        h = parent[k, h]
