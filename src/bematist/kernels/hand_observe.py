"""The two fields of a sample: what their detectors find, and which updates follow."""

import math

from bematist.kernels import hand_layout as at
from bematist.kernels import hard_iron as iron
from bematist.kernels import hard_iron_layout as iron_layout
from bematist.kernels import quasi_static, stance
from bematist.kernels.hand_fields import (
    clone_field,
    clone_force,
    gradient_field,
    gradient_force,
    heading,
    measure_field,
    measure_force,
)
from bematist.kernels.hand_layout import BA, FREF, LAST_F, LAST_F_KNOWN, LAST_M, LAST_M_KNOWN, LAST_M_TIME, MREF, ROW, Q
from bematist.kernels.hand_quest import headed, levelled, two_vectors
from bematist.kernels.jit import apart, inlined
from bematist.kernels.rotation import matrix

FIELD_INDEX, FORCE_INDEX = 0, at.INDEX_EACH


@inlined
def force(S, c):
    """Component c of the specific force of the sample in S[ROW:], freed of its offset."""
    return S[ROW + 1 + c] - S[BA + c]


@apart
def is_earth(S, index, memory, prm):
    """Whether the magnetic period that begins shows the Earth's own field: its norm, and with a dip gate its inclination."""
    f = at.MAGNETIC
    norm = memory[index[FIELD_INDEX + at.RING] + at.REFERENCE_NORM]
    if not prm[f + at.EARTH] > 0 or not abs(norm - S[at.EARTH_NORM]) <= prm[f + at.EARTH_TOLERANCE]:
        return False
    e = quasi_static.first_mean(index, memory, FIELD_INDEX, 1)
    n = quasi_static.first_mean(index, memory, FIELD_INDEX, 2)
    inclination = -math.atan2(quasi_static.first_mean(index, memory, FIELD_INDEX, 3), math.sqrt(e * e + n * n))
    return abs(inclination - S[at.EARTH_INCLINATION]) <= prm[at.DIP_TOLERANCE]


@inlined
def is_gravity(index, memory, prm):
    """Whether the period of the specific force that begins shows gravity alone."""
    norm = memory[index[FORCE_INDEX + at.RING] + at.REFERENCE_NORM]
    return prm[at.FORCE + at.EARTH] > 0 and abs(norm - prm[at.G]) <= prm[at.FORCE + at.EARTH_TOLERANCE]


@inlined
def detect(S, index, memory, prm, i, f, x0, x1, x2, diag, k, d):
    """A sample of a field into its detector: whether the field is static, and whether a period has just begun."""
    C = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    norm = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    n0, n1, n2 = C[0] * x0 + C[1] * x1 + C[2] * x2, C[3] * x0 + C[4] * x1 + C[5] * x2, C[6] * x0 + C[7] * x1 + C[8] * x2
    quasi_static.push(index, memory, i, norm, n0, n1, n2)
    static, starts, statistic = quasi_static.judge(index, memory, i, prm, f, norm)
    diag[k, d + at.STATISTIC] = statistic
    diag[k, d + at.VERDICT] = at.UNUSED if static else at.CHANGING
    if starts:
        earth = is_gravity(index, memory, prm) if f == at.FORCE else is_earth(S, index, memory, prm)
        memory[index[i + at.RING] + at.IS_EARTH] = 1.0 if earth else 0.0
    return static, starts


@inlined
def note(diag, k, d, result):
    """Innovation and NIS of an update into the diagnostics; whether it was used."""
    z0, z1, z2, value, used = result
    diag[k, d + at.NU], diag[k, d + at.NU + 1], diag[k, d + at.NU + 2], diag[k, d + at.NIS] = z0, z1, z2, value
    return used


@inlined
def magnetic_updates(S, index, memory, prm, starts, still, diag, k):
    """Quasi-static field update by the magnetic field, in a static period. Returns the verdict.

    With REST_VARIANCE the field is compared with itself only in a rest, from where that begins.
    """
    m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
    f, d, o = at.MAGNETIC, at.FIELD_M, quasi_static.place_of(index, FIELD_INDEX + at.RING)
    references = prm[at.REFERENCE] == at.ESTIMATED
    earth = memory[o + at.IS_EARTH] > 0
    r, local = prm[f + at.VARIANCE], prm[f + at.LOCAL] > 0
    if prm[at.REST_VARIANCE] > 0:
        r, local = prm[at.REST_VARIANCE], still
        starts = starts or (still and S[at.ANCHORED] == 0)
        if still:
            S[at.ANCHORED] = 1.0
    if starts:
        if references:
            clone_field(S, m0, m1, m2, r)
        else:
            for c in range(3):
                S[MREF + c] = quasi_static.first_mean(index, memory, FIELD_INDEX, 1 + c)
    used = refused = False
    if local and (not starts if references else not earth):
        r0, r1, r2 = S[MREF], S[MREF + 1], S[MREF + 2]
        used = note(diag, k, d, measure_field(S, m0, m1, m2, r0, r1, r2, references, r, prm[f + at.LIMIT], references))
        refused = not used
    if earth:
        r0, r1, r2 = S[at.EARTH_E], S[at.EARTH_N], S[at.EARTH_U]
        r = prm[f + at.EARTH_VARIANCE]
        used = note(diag, k, d, measure_field(S, m0, m1, m2, r0, r1, r2, False, r, prm[f + at.LIMIT], references))
        refused = refused or not used
    return verdict(S, memory, prm, f, o, at.FAULTS, starts, earth, used, refused)


@inlined
def force_updates(S, index, memory, prm, starts, diag, k):
    """Quasi-static field update by the specific force, in a static period. Returns the verdict."""
    f, d, o = at.FORCE, at.FIELD_F, quasi_static.place_of(index, FORCE_INDEX + at.RING)
    references = prm[at.REFERENCE] == at.ESTIMATED
    earth = memory[o + at.IS_EARTH] > 0
    if starts:
        if references:
            clone_force(S, force(S, 0), force(S, 1), force(S, 2), prm[f + at.VARIANCE])
        else:
            for c in range(3):
                S[FREF + c] = quasi_static.first_mean(index, memory, FORCE_INDEX, 1 + c)
    used = refused = False
    if prm[f + at.LOCAL] > 0 and (not starts if references else not earth):
        f0, f1, f2, r0, r1, r2 = force(S, 0), force(S, 1), force(S, 2), S[FREF], S[FREF + 1], S[FREF + 2]
        r = prm[f + at.VARIANCE]
        used = note(diag, k, d, measure_force(S, f0, f1, f2, r0, r1, r2, references, r, prm[f + at.LIMIT], references))
        refused = not used
    if earth:
        f0, f1, f2, r = force(S, 0), force(S, 1), force(S, 2), prm[f + at.EARTH_VARIANCE]
        used = note(diag, k, d, measure_force(S, f0, f1, f2, 0.0, 0.0, prm[at.G], False, r, prm[f + at.LIMIT], references))
        refused = refused or not used
    return verdict(S, memory, prm, f, o, at.FAULTS + 1, starts, earth, used, refused)


@inlined
def verdict(S, memory, prm, f, o, faults, starts, earth, used, refused):
    """What became of the sample; after too many refusals in a row the period ends (fault detection, MAGYQ section 5)."""
    S[faults] = S[faults] + 1 if refused and not starts else 0.0
    if S[faults] > prm[f + at.PATIENCE]:
        memory[o + at.STATIC] = 0.0
    if refused:
        return at.FAULT
    if used:
        return at.EARTH_USED if earth else at.LOCAL_USED
    return at.UNUSED


@inlined
def gradients(S, prm, dt, decay, steady, still, diag, k):
    """MARU and AGU. They come first: the rotation they test was made with the offset as it was before this sample."""
    references = prm[at.REFERENCE] == at.ESTIMATED
    if steady and prm[at.MAGNETIC + at.GRADIENT] > 0 and S[LAST_M_KNOWN] > 0:
        x0, x1, x2 = S[LAST_M], S[LAST_M + 1], S[LAST_M + 2]
        r = 2 * prm[at.MAGNETIC + at.VARIANCE] + (x0 * x0 + x1 * x1 + x2 * x2) * prm[at.PSD_ANGLE] * (S[ROW] - S[LAST_M_TIME])
        diag[k, at.FIELD_M + at.GRADIENT_NIS] = gradient_field(
            S, x0, x1, x2, S[ROW + 7], S[ROW + 8], S[ROW + 9], r, prm[at.MAGNETIC + at.LIMIT], references
        )
    if still and prm[at.FORCE + at.GRADIENT] > 0 and S[LAST_F_KNOWN] > 0 and dt > 0:
        x0, x1, x2 = S[LAST_F] - S[BA] / decay, S[LAST_F + 1] - S[BA + 1] / decay, S[LAST_F + 2] - S[BA + 2] / decay
        r = 2 * prm[at.FORCE + at.VARIANCE] + (x0 * x0 + x1 * x1 + x2 * x2) * prm[at.PSD_ANGLE] * dt
        diag[k, at.FIELD_F + at.GRADIENT_NIS] = gradient_force(
            S, x0, x1, x2, force(S, 0), force(S, 1), force(S, 2), decay, r, prm[at.FORCE + at.LIMIT], references
        )


@inlined
def level(S, prm, dt, diag, k):
    """Gravity, also in motion: on the average over a stride the specific force is up. R = LEVEL_PSD/dt, more where its norm is not g."""
    f0, f1, f2 = force(S, 0), force(S, 1), force(S, 2)
    off = prm[at.LEVEL_SPREAD] * (math.sqrt(f0 * f0 + f1 * f1 + f2 * f2) - prm[at.G])
    r = (prm[at.LEVEL_PSD] + off * off) / dt
    references = prm[at.REFERENCE] == at.ESTIMATED
    note(diag, k, at.FIELD_F, measure_force(S, f0, f1, f2, 0.0, 0.0, prm[at.G], False, r, math.inf, references))


@inlined
def north(S, prm, diag, k):
    """Heading from a sample whose norm and inclination are near the Earth's, whatever the samples before it were.

    What disturbs the field within the plane of the meridian shows in norm and inclination; across it, where it turns the heading, it is
    as large on the average: R = (HEADING_PSD + HEADING_SPREAD d²)/dt with d = |disturbance in the plane| / (√2 horizontal field), rad. Such
    disturbances last for some time, so that after a pause of the magnetometer a sample stands for no more than that.
    """
    m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
    C = matrix(S[Q], S[Q + 1], S[Q + 2], S[Q + 3])
    norm = math.sqrt(m0 * m0 + m1 * m1 + m2 * m2)
    dt = S[ROW] - S[LAST_M_TIME]
    along = norm - S[at.EARTH_NORM]
    if norm > 0 and dt > 0 and abs(along) <= prm[at.HEADING_NORM] * S[at.EARTH_NORM]:
        down = -math.asin(min(1.0, max(-1.0, (C[6] * m0 + C[7] * m1 + C[8] * m2) / norm))) - S[at.EARTH_INCLINATION]
        if abs(down) <= prm[at.HEADING_DIP]:
            across = S[at.EARTH_NORM] * down
            e, n = S[at.EARTH_E], S[at.EARTH_N]
            squared = (along * along + across * across) / (2 * (e * e + n * n))
            r = (prm[at.HEADING_PSD] + prm[at.HEADING_SPREAD] * squared) / min(dt, prm[at.HEADING_LONGEST_S])
            nu, _ = heading(S, m0, m1, m2, r, prm[at.MAGNETIC + at.LIMIT], prm[at.REFERENCE] == at.ESTIMATED)
            diag[k, at.HEADING_NU] = nu


@inlined
def replace(S, prm, index, memory, still, steady, diag, k):
    """The baseline QUEST: where gravity or the Earth's field is detected, the attitude is replaced by what they say (section 8.2.1)."""
    up = still and memory[index[FORCE_INDEX + at.RING] + at.IS_EARTH] > 0
    known = steady and memory[index[FIELD_INDEX + at.RING] + at.IS_EARTH] > 0
    q0, q1, q2, q3 = S[Q], S[Q + 1], S[Q + 2], S[Q + 3]
    f0, f1, f2, m0, m1, m2 = force(S, 0), force(S, 1), force(S, 2), S[ROW + 7], S[ROW + 8], S[ROW + 9]
    e, n, u = S[at.EARTH_E], S[at.EARTH_N], S[at.EARTH_U]
    if up and known:
        a = prm[at.G] * prm[at.G] / prm[at.FORCE + at.EARTH_VARIANCE]
        b = S[at.EARTH_NORM] * S[at.EARTH_NORM] / prm[at.MAGNETIC + at.EARTH_VARIANCE]
        q0, q1, q2, q3 = two_vectors(f0, f1, f2, m0, m1, m2, 0.0, 0.0, 1.0, e, n, u, a, b)
    elif up:
        q0, q1, q2, q3 = levelled(q0, q1, q2, q3, f0, f1, f2)
    elif known:
        q0, q1, q2, q3 = headed(q0, q1, q2, q3, m0, m1, m2, e, n)
    if q0 == q0:
        S[Q], S[Q + 1], S[Q + 2], S[Q + 3] = q0, q1, q2, q3
    if up:
        diag[k, at.FIELD_F + at.VERDICT] = at.EARTH_USED
    if known:
        diag[k, at.FIELD_M + at.VERDICT] = at.EARTH_USED


@inlined
def observe(S, prm, index, memory, dt, decay, diag, k):
    """The two fields of the sample in S[ROW:]: their detectors, and what they say."""
    m0, m1, m2 = S[ROW + 7], S[ROW + 8], S[ROW + 9]
    measured = S[ROW + 10] == stance.MEASURED and prm[at.FORCE + at.USE] > 0
    magnetic = m0 * m0 + m1 * m1 + m2 * m2 < math.inf and prm[at.MAGNETIC + at.USE] > 0
    still = begins = steady = starts = False
    if measured:
        f0, f1, f2 = force(S, 0), force(S, 1), force(S, 2)
        still, begins = detect(S, index, memory, prm, FORCE_INDEX, at.FORCE, f0, f1, f2, diag, k, at.FIELD_F)
        if not still:
            S[at.ANCHORED] = 0.0
    if magnetic:
        steady, starts = detect(S, index, memory, prm, FIELD_INDEX, at.MAGNETIC, m0, m1, m2, diag, k, at.FIELD_M)
    if prm[at.CORRECTION] == at.REPLACE:
        replace(S, prm, index, memory, still, steady, diag, k)
    else:
        gradients(S, prm, dt, decay, steady, still, diag, k)
        unused = measured
        if still:
            said = force_updates(S, index, memory, prm, begins, diag, k)
            diag[k, at.FIELD_F + at.VERDICT] = said
            unused = said == at.UNUSED
        if unused and prm[at.LEVEL_PSD] > 0 and dt > 0:
            level(S, prm, dt, diag, k)
        if steady:
            diag[k, at.FIELD_M + at.VERDICT] = magnetic_updates(S, index, memory, prm, starts, still, diag, k)
        elif magnetic:
            S[at.ANCHORED] = 0.0
        if magnetic and prm[at.HEADING_PSD] > 0 and S[LAST_M_KNOWN] > 0:
            north(S, prm, diag, k)
    remember(S, magnetic, measured)


@inlined
def refer(S, e, n, u):
    """The Earth's field, from now on, where it gives a heading."""
    if not iron.points(e, n, u):
        return
    S[at.EARTH_E], S[at.EARTH_N], S[at.EARTH_U] = e, n, u
    S[at.EARTH_NORM], S[at.EARTH_INCLINATION] = math.sqrt(e * e + n * n + u * u), -math.atan2(u, math.sqrt(e * e + n * n))


@apart
def hard_iron(S, prm, dt, w0, w1, w2, lost, diag, k):
    """The sample in S[ROW:], turned at (w0, w1, w2), for `kernels.hard_iron`: what is found is told, and, where asked for, taken out."""
    o, p = at.IRON, at.IRON_USE
    changed = iron.step(S, o, prm, p, S[ROW], dt, w0, w1, w2, S[ROW + 7], S[ROW + 8], S[ROW + 9], True, False, lost)
    if changed and prm[p] == iron_layout.CORRECT:
        e, n, u = iron.reference(S, o, prm, p, prm[at.START_E], prm[at.START_N], prm[at.START_U])
        refer(S, e, n, u)
        S[at.ANCHORED] = 0.0  # what was held had the iron in it
    iron.settle(S, o, ROW + 7, changed, diag, k, at.IRON_DIAG)


@inlined
def remember(S, magnetic, measured):
    """What MARU and AGU of the next samples compare with."""
    for c in range(3):
        S[LAST_F + c] = S[ROW + 1 + c]
    S[LAST_F_KNOWN] = 1.0 if measured else 0.0
    if magnetic:
        for c in range(3):
            S[LAST_M + c] = S[ROW + 7 + c]
        S[LAST_M_KNOWN] = 1.0
        S[LAST_M_TIME] = S[ROW]
        restart_turn(S)


@inlined
def restart_turn(S):
    """No rotation since the last magnetometer sample."""
    S[at.TURNED] = 0.0
