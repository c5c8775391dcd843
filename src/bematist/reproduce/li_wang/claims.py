"""What the paper claims, sentence by sentence, with numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import polars as pl

from bematist.reproduce.li_wang.pairs import Compared, compare
from bematist.reproduce.study import Claim, Results

PLAIN = ("rectangle", "ellipse", "mixed", "laps")
ROCKING = ("ellipse, rocking", "laps, rocking")
FIGURES = "figures only"


def claims(results: Mapping[str, Results]) -> list[Claim]:
    """The claims that the parts at hand can answer."""
    if "routes" not in results:
        return []
    frame = results["routes"].frame
    part = results.get("recordings")
    real = part.frame.filter(pl.col("rms_m").is_not_null()) if part and part.cases else None
    return [*_attitudes(frame, real), *_states(frame, real), *_thresholds(frame, real)]


def _found(
    frame: pl.DataFrame, changed: str, base: str, column: str, routes: Iterable[str], real: pl.DataFrame | None
) -> tuple[str, list[Compared]]:
    """Words about one pair on each course, and on the real recordings; the comparisons on the courses."""
    made = {r: compare(frame.filter(pl.col("route") == r), changed, base, column) for r in routes}
    words = [f"{r} {c}" for r, c in made.items() if c]
    found = None if real is None else compare(real, changed, base, column, by="recording")
    if found:
        words.append(f"real recordings {found}")
    return "; ".join(words), [c for c in made.values() if c]


def verdict(found: Iterable[Compared]) -> str:
    """In words, from the courses on which the difference is no chance (p < 0.05)."""
    for_it = against = open_ = 0
    for c in found:
        if c.p >= 0.05:
            open_ += 1
        elif c.better > c.worse:
            for_it += 1
        else:
            against += 1
    total = for_it + against + open_
    if for_it == total:
        return "holds"
    if against == total:
        return "does not hold, the opposite does"
    if open_ == total:
        return "undecided"
    undecided = f", undecided on {open_}" if open_ else ""
    return f"holds on {for_it} of {total} courses, the opposite on {against}{undecided}"


def _pair(
    frame: pl.DataFrame,
    real: pl.DataFrame | None,
    claim: str,
    changed: str,
    base: str,
    column: str,
    why: str,
    routes: tuple[str, ...] = PLAIN,
) -> Claim:
    words, found = _found(frame, changed, base, column, routes, real)
    return Claim(claim, FIGURES, f"{changed} against {base}: {words}", verdict(found), why)


def _medians(frame: pl.DataFrame, variants: Iterable[str], column: str, routes: Iterable[str], unit: str) -> str:
    def middle(route: str, variant: str) -> float:
        rows = frame.filter((pl.col("route") == route) & (pl.col("variant") == variant))
        return float(rows[column].abs().median())  # type: ignore[arg-type]

    return "; ".join(f"{r} " + ", ".join(f"{v} {middle(r, v):.2g}{unit}" for v in variants) for r in routes)


def _wide(frame: pl.DataFrame, column: str, variants: Iterable[str]) -> pl.DataFrame:
    """A row for each walk, a column for each variant."""
    return frame.filter(pl.col("variant").is_in(list(variants))).pivot("variant", index=["route", "seed"], values=column)


NINE = ("common-9", "mahony-9", "madgwick-9")


def _attitudes(frame: pl.DataFrame, real: pl.DataFrame | None) -> list[Claim]:
    two = ("rectangle", "ellipse")
    on_two = frame.filter(pl.col("route").is_in(two))
    yaw = _wide(on_two, "yaw_end_deg", NINE)
    sd = _wide(on_two, "yaw_sd_deg", NINE)
    between = ((yaw["madgwick-9"] - yaw["common-9"]) * (yaw["madgwick-9"] - yaw["mahony-9"]) < 0).sum()
    smallest = int(((sd["madgwick-9"] < sd["common-9"]) & (sd["madgwick-9"] < sd["mahony-9"])).sum())
    n = len(yaw)
    return [
        _pair(
            frame, real, "Madgwick is the closest to the truth, Common is poor (4.1, Figure 4)", "madgwick-9", "common-9", "rms_m",
            "Without a magnetometer the corrections of both have no vertical part: they cannot see yaw. In swing they take the foot's "
            "acceleration for gravity; the tilt so made becomes yaw as the foot turns. With the offset taken out (eqs 5-6), the "
            "gyroscope alone is better.", routes=two,
        ),
        _pair(frame, real, "Mahony is relatively accurate, Common poor (4.1)", "mahony-9", "common-9", "rms_m", "As above.", routes=two),
        _pair(
            frame, real, "Madgwick is better than Mahony (4.1)", "madgwick-9", "mahony-9", "rms_m",
            "Their gains decide: β 0.1 turns by at most 11.5 °/s, K_p 1 by more in a swing.", routes=two,
        ),
        Claim(
            "the differences of pitch and roll are not significant (4.1)", FIGURES,
            "rms of the tilt: " + _medians(frame, NINE, "tilt_deg", two, "°"), "does not hold",
            "The AHRS pulls the attitude to the acceleration of the swing and lets it come back in stance, where it is looked at.",
        ),
        Claim(
            "the yaw of Madgwick lies between those of Mahony and Common (4.1)", FIGURES, f"at the end in {between} of {n} walks",
            "holds" if between > 0.9 * n else "does not hold" if between < 0.5 * n else "holds mostly",
            "How far an AHRS turns depends on its gain and on the course; being in the middle says nothing about the truth.",
        ),
        Claim(
            "the covariance of Madgwick's yaw is the smallest, so it is the most accurate (4.1, Figure 7)", FIGURES,
            f"smallest in {smallest} of {n} walks; sd at the end: {_medians(frame, NINE, 'yaw_sd_deg', two, '°')}; yaw error there: "
            f"{_medians(frame, NINE, 'yaw_end_deg', two, '°')}",
            "the conclusion does not hold",
            "P does not contain the AHRS: it depends on the specific force that was turned by the attitude, the time step and the "
            "number of updates. A wrong tilt changes the force, and with it P, whatever the error.",
        ),
        _pair(
            frame, real, "AHRS compensate attitude errors continuously, improving the directional accuracy (contribution 2)", "madgwick-9",
            "common-9", "heading_deg", "In stance, where gravity is all there is, the zero-velocity update levels already.",
        ),
        _pair(
            frame, real, "bias correction is included in Mahony and Madgwick, eqs 5-6 are not needed (2.1)", "madgwick-9 raw",
            "madgwick-9", "rms_m", "With K_i 0 (Table 1) and β alone neither estimates an offset; all of it stays in yaw (see the pair "
            "for Common). What Madgwick turns by itself is as much, so that an offset of the other sign looks like a help.",
        ),
    ]  # fmt: skip


def _states(frame: pl.DataFrame, real: pl.DataFrame | None) -> list[Claim]:
    rest = "The foot rests only at both ends of the course, and the 10 s at the start have told the offset already."
    held = "HDR holds back a part of the turn that Madgwick makes, on straight legs. " + rest
    return [
        _pair(
            frame, real, "offsets as states correct the drift of the 9-state filter (4.2)", "15", "common-9", "rms_m",
            "The offsets are known from the rest before the walk; what is left is little.",
        ),
        _pair(
            frame, real, "the same with Madgwick (4.2)", "15m", "madgwick-9", "rms_m",
            "The offset absorbs a part of what the AHRS does wrong.",
        ),
        _pair(frame, real, "ZARU and HDR help: 15MZH is closer to the truth than 15M (4.2, Figures 8, 9)", "15mzh", "15m", "rms_m", held),
        _pair(frame, real, "… ZARU alone, without Madgwick", "15z", "15", "rms_m", rest),
        _pair(
            frame, real, "… HDR alone, without Madgwick", "15h", "15", "rms_m",
            "It takes slow turns and the scatter of the feet for drift, and there is little drift to hold back.",
        ),
        _pair(
            frame, real, "… both at every sample with the wide σ of reference 23, with Madgwick", "15mzh literal", "15m", "rms_m", held,
        ),
        _pair(
            frame, real, "Madgwick helps: 15MZH is closer to the truth than 15ZH (4.2, Figures 8, 9)", "15mzh", "15zh", "rms_m",
            "As with nine states.",
        ),
        _pair(
            frame, real, "with Madgwick the height is better (4.2, Figure 10)", "15mzh", "15zh", "height_rms_m",
            "A tilt of 3° in swing turns the forward acceleration into the vertical.",
        ),
    ]  # fmt: skip


def _thresholds(frame: pl.DataFrame, real: pl.DataFrame | None) -> list[Claim]:
    runs = None if real is None else real.filter(pl.col("gait") == "run")
    walks = None if real is None else real.filter(pl.col("gait") == "walk")
    every = (*PLAIN, *ROCKING)
    adaptive = ("mixed", "ellipse, rocking", "laps, rocking")
    long = _medians(frame, ("15mzh", "15mzha"), "length_percent", ("laps", "laps, rocking"), " %")
    turned = _medians(frame, ("15mzh", "15mzha"), "heading_2_deg", ("laps", "laps, rocking"), "°")
    missed = _medians(frame, ("15zh", "15zha"), "missed_percent", every, " %")
    growing = frame.filter((pl.col("variant") == "15mzha") & (pl.col("route") == "laps"))
    laps = int(((growing["heading_1_deg"] < growing["heading_2_deg"]) & (growing["heading_2_deg"] < growing["heading_3_deg"])).sum())
    return [
        Claim(
            "running, a threshold for walking misses stances (4.3)", FIGURES, f"missed: {missed}",
            "depends on the foot",
            "A foot that lies flat for a moment is found by any threshold; one that rolls on is not. Real runners are of the second kind.",
        ),
        _pair(
            frame, walks, "too large a threshold takes a moving foot for a standing one (4.3)", "15zh", "15zh wide", "rms_m",
            "The angular rate of a swinging foot passes through zero too; the walks alone are counted of the real recordings.",
            routes=("rectangle", "mixed", "laps"),
        ),
        _pair(
            frame, runs, "the adaptive threshold improves Route 3, and running, significantly (4.3, Figure 17)", "15mzha", "15mzh", "rms_m",
            "It matters where stances are missed otherwise; of the real recordings the runs alone are counted.", routes=adaptive,
        ),
        _pair(frame, runs, "… the same without Madgwick", "15zha", "15zh", "rms_m", "As above.", routes=adaptive),
        _pair(frame, walks, "… and costs nothing on a walk", "15mzha", "15mzh", "rms_m", "The class is walking.", routes=("rectangle",)),
        _pair(
            frame, None, "more exact stances reduce the covariance of the direction, and with it the error (4.3)", "15mzha", "15mzh",
            "yaw_sd_deg", "Yaw is not observed by a zero velocity but through the force that turns with it; see the errors of yaw.",
            routes=every,
        ),
        Claim(
            "with the fixed threshold the jogged lap makes the path much longer and the direction wrong (4.4, Figure 20)", FIGURES,
            f"length off by {long}; rms heading in the second lap {turned}",
            "the length holds where stances are missed, the direction does not",
            "Between missed stances the velocity is dead reckoning. A zero velocity does not show yaw, so that missing it costs "
            "little direction.",
        ),
        Claim(
            "the directional error grows from lap to lap (4.4)", FIGURES,
            f"15mzha: in {laps} of {len(growing)} walks; " + "; ".join(
                f"lap {k} {float(growing[f'heading_{k}_deg'].median()):.2g}°" for k in (1, 2, 3)  # type: ignore[arg-type]
            ),
            "holds" if laps > 0.9 * len(growing) else "holds in some walks",
            "Nothing observes yaw: what turns it adds up.",
        ),
    ]  # fmt: skip
