"""Slow, walking or running: the stance threshold follows the speed of the filter itself (Li & Wang eq 36).

The trailing mean over n samples, and of it the trailing maximum over n samples, in constant memory: two rings of n after the workspace.
The second holds, from the place of writing on, the suffix maxima of the block before, so that the maximum of a window is that of a
suffix and of a prefix. Both are made anew at the end of each block of n, so that rounding cannot pile up.
"""

import math

from bematist.kernels.jit import apart, inlined
from bematist.kernels.layout import (
    CLASS,
    FILLED,
    LARGEST,
    LIMIT_NOW,
    PACE_HYSTERESIS,
    PACE_LIMIT,
    PACE_RUN,
    PACE_SAMPLES,
    PACE_WALK,
    PLACE,
    RUNNING,
    SLOW,
    SPEEDS,
    WALKING,
    WORKSPACE_SIZE,
    V,
)


@apart
def follow(S, prm):
    """Take in the speed of this sample; once n are there, set the class and with it the threshold of the next sample."""
    n = int(prm[PACE_SAMPLES])
    i = int(S[PLACE])
    speeds, means = WORKSPACE_SIZE, WORKSPACE_SIZE + n
    speed = math.sqrt(S[V] * S[V] + S[V + 1] * S[V + 1] + S[V + 2] * S[V + 2])
    S[SPEEDS] += speed - S[speeds + i]
    S[speeds + i] = speed
    if S[FILLED] < n:
        S[FILLED] += 1
    if S[FILLED] == n:
        mean = S[SPEEDS] / n
        S[LARGEST] = max(S[LARGEST], mean)
        largest = S[LARGEST] if i == n - 1 else max(S[LARGEST], S[means + i + 1])
        S[means + i] = mean
        S[CLASS] = classify(prm, S[CLASS], largest)
        S[LIMIT_NOW] = prm[PACE_LIMIT + int(S[CLASS])]
    S[PLACE] = i + 1
    if i == n - 1:
        S[PLACE] = 0
        S[LARGEST] = 0.0
        S[SPEEDS] = S[speeds + n - 1]
        for j in range(n - 2, -1, -1):
            S[means + j] = max(S[means + j], S[means + j + 1])
            S[SPEEDS] += S[speeds + j]


@inlined
def classify(prm, now, speed):
    """Class of a speed, Li & Wang eq 36 (its limits: errata); a class is left only `hysteresis` below the speed that leads to it."""
    keep = 1 - prm[PACE_HYSTERESIS]
    if speed >= prm[PACE_RUN] or (now == RUNNING and speed >= keep * prm[PACE_RUN]):
        return RUNNING
    if speed >= prm[PACE_WALK] or (now >= WALKING and speed >= keep * prm[PACE_WALK]):
        return WALKING
    return SLOW
