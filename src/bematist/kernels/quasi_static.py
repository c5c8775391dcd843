"""Detectors of a quasi-static field: is a field, of which only the body components are measured, constant in the navigation frame?

The norm does not depend on the attitude, so the norms of the last values decide (MAGYQ section 5). What the next sample needs lies in
`index` (sizes and counters) and `memory` (sums, and a ring of the last norms and of the fields turned into n), for each of the two fields
from `i` on.
"""

import math

from bematist.kernels import hand_layout as at
from bematist.kernels.hand_layout import CHANGES, COUNT, DETECTOR_HEAD, ENTRY, FIRST, LENGTH, PLACE, RING, SQUARES, STATIC, SUM
from bematist.kernels.jit import apart, inlined


@inlined
def place_of(index, i):
    """index[i], a place in an array or a number of values: not negative, which is said here so that it is not asked at every access."""
    return index[i] & 0x7FFFFFFF


@inlined
def forget(index, memory, i):
    """The values so far say nothing about the next: after a gap, or where the period was wrong."""
    o = place_of(index, i + RING)
    index[i + COUNT] = index[i + PLACE] = 0
    memory[o + SUM] = memory[o + SQUARES] = memory[o + CHANGES] = memory[o + STATIC] = 0.0


@inlined
def _anew(index, memory, i):
    """The sums, made anew from the full ring whose oldest value stands first."""
    o, length = place_of(index, i + RING), place_of(index, i + LENGTH)
    ring = o + DETECTOR_HEAD
    total = squares = changes = 0.0
    for k in range(length):
        norm = memory[ring + ENTRY * k]
        total += norm
        squares += norm * norm
        if k > 0:
            d = norm - memory[ring + ENTRY * (k - 1)]
            changes += d * d
    memory[o + SUM], memory[o + SQUARES], memory[o + CHANGES] = total, squares, changes


@apart
def push(index, memory, i, norm, n0, n1, n2):
    """Take a value into the window; the oldest leaves. The sums are made anew once a window, so that rounding cannot pile up."""
    o, length = place_of(index, i + RING), place_of(index, i + LENGTH)
    count, place = place_of(index, i + COUNT), place_of(index, i + PLACE)
    ring = o + DETECTOR_HEAD
    r = ring + ENTRY * place
    after = place + 1 if place + 1 < length else 0
    if count == length:
        old = memory[r]
        d = memory[ring + ENTRY * after] - old
        memory[o + SUM] -= old
        memory[o + SQUARES] -= old * old
        memory[o + CHANGES] -= d * d
    if count > 0:
        d = norm - memory[ring + ENTRY * (place - 1 if place > 0 else length - 1)]
        memory[o + CHANGES] += d * d
    memory[o + SUM] += norm
    memory[o + SQUARES] += norm * norm
    memory[r], memory[r + 1], memory[r + 2], memory[r + 3] = norm, n0, n1, n2
    index[i + COUNT], index[i + PLACE] = min(count + 1, length), after
    if after == 0:
        _anew(index, memory, i)


@apart
def first_mean(index, memory, i, c):
    """Mean of column c of the first values of a full window: the reference of a period that begins with it."""
    ring, length, place = place_of(index, i + RING) + DETECTOR_HEAD, place_of(index, i + LENGTH), place_of(index, i + PLACE)
    total = 0.0
    for _ in range(place_of(index, i + FIRST)):
        total += memory[ring + ENTRY * place + c]
        place += 1
        if place == length:
            place = 0
    return total / place_of(index, i + FIRST)


@inlined
def _deviation(index, memory, i, reference):
    """Root mean square of norm − reference over the window: MAGYQ eq 33 (erratum: N+1 terms, up to now; gamma_1 squared is a variance)."""
    o, length = place_of(index, i + RING), place_of(index, i + LENGTH)
    square = (memory[o + SQUARES] - 2 * reference * memory[o + SUM]) / length + reference * reference
    return math.sqrt(max(0.0, square))


@inlined
def _statistic(index, memory, i, prm, f, reference):
    """The test statistic and its limit: eq 33, or the likelihood ratio of the norm's change, Σ (|m_k| − |m_k-1|)² / (2 N σ²)."""
    if prm[f + at.DETECTOR] == at.BY_LIKELIHOOD:
        changes = memory[place_of(index, i + RING) + CHANGES]
        return max(0.0, changes) / (2 * (place_of(index, i + LENGTH) - 1) * prm[f + at.VARIANCE]), prm[f + at.LIKELIHOOD]
    return _deviation(index, memory, i, reference), prm[f + at.DEVIATION]


@apart
def judge(index, memory, i, prm, f, norm):
    """Whether the field is static now, whether a new period has just begun, and the statistic.

    A period lasts while the statistic stays within its limit and the last norm within `OUTLIER` of the reference (eq 34, erratum: its
    absolute value). Where the old reference fails, the window itself may begin a new period.
    """
    o = place_of(index, i + RING)
    if place_of(index, i + COUNT) < place_of(index, i + LENGTH):
        return False, False, math.nan
    if memory[o + STATIC] > 0:
        reference = memory[o + at.REFERENCE_NORM]
        statistic, limit = _statistic(index, memory, i, prm, f, reference)
        if statistic < limit and abs(norm - reference) <= prm[f + at.OUTLIER]:
            return True, False, statistic
        memory[o + STATIC] = 0.0
    # No reference makes the deviation less than the mean does.
    statistic, limit = _statistic(index, memory, i, prm, f, memory[o + SUM] / place_of(index, i + LENGTH))
    if not statistic < limit:
        return False, False, statistic
    reference = first_mean(index, memory, i, 0)
    statistic, limit = _statistic(index, memory, i, prm, f, reference)
    if not (statistic < limit and abs(norm - reference) <= prm[f + at.OUTLIER]):
        return False, False, statistic
    memory[o + STATIC], memory[o + at.REFERENCE_NORM] = 1.0, reference
    return True, True, statistic
