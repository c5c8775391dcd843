"""What the paper claims, sentence by sentence, with numbers. Every verdict follows from them by the rule of `verdict`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import polars as pl
from scipy.stats import binom

from bematist.evaluate import nees_bounds
from bematist.reproduce.magyq import gyroscope
from bematist.reproduce.magyq.choices import SENSORS
from bematist.reproduce.magyq.walks import WALKERS
from bematist.reproduce.study import Claim, Results

Array = np.ndarray

RULE = (
    "A verdict counts the runs in which a claim is true: it *holds* from nine in ten on, *holds mostly* from five in ten, *holds seldom* "
    "from one in ten, and below that *does not hold*. What counts as true is said in the last column."
)


def verdict(share: float) -> str:
    """In words, from the share of the runs in which a claim is true."""
    return "holds" if share >= 0.9 else "holds mostly" if share >= 0.5 else "holds seldom" if share >= 0.1 else "does not hold"


def verdicts(shares: Mapping[str, float]) -> str:
    """The same for several cases by their names, those with the same verdict together."""
    names: dict[str, list[str]] = {}
    for name, share in shares.items():
        names.setdefault(verdict(share), []).append(name)
    if len(names) == 1:
        return next(iter(names))
    return "; ".join(f"{word}: {', '.join(cases)}" for word, cases in names.items())


def claims(results: Mapping[str, Results]) -> list[Claim]:
    """The claims that the parts at hand can answer."""
    found = []
    if "quaternion" in results and "test" in results:
        found += _model(results["quaternion"], results["test"])
    if "rest" in results:
        found += _rest(results["rest"])
    if "outdoors" in results:
        found.append(_offset(results["outdoors"]))
    if "walks" in results:
        found += [_below_ten(results["walks"]), _rivals(results["walks"]), _one_walk(results["walks"]), _budget(results["walks"])]
        found += _updates(results["walks"])
    if "consistency" in results:
        found.append(_covariance(results["consistency"]))
    return found


def _of(results: Results, method: str, column: str, **where: str) -> Array:
    conditions = [pl.col(name) == value for name, value in {"method": method, **where}.items()]
    order = [name for name in ("walker", "seed") if name in results.frame.columns]
    return results.frame.filter(*conditions).sort(order)[column].to_numpy()


def _size(values: Array, unit: str = "°") -> str:
    low, middle, high = np.quantile(np.abs(values), [0.1, 0.5, 0.9])
    return f"{middle:.2g}{unit} ({low:.2g} – {high:.2g})"


def _constant(curve: Array) -> float:
    """How far a curve strays from its median, relative."""
    return float(np.abs(curve / np.median(curve) - 1).max())


def _slope(frequency: Array, density: Array) -> float:
    """Power of the frequency with which a density grows."""
    return float(np.polyfit(np.log(frequency), np.log(density), 1)[0])


def _model(quaternion: Results, test: Results) -> list[Claim]:
    return [*_curves(quaternion), *_distances(test)]


def _curves(quaternion: Results) -> list[Claim]:
    arrays = [case.arrays for case in quaternion.cases]
    strays = {name: max(_constant(a[f"{name} deviation"] / a["rate deviation"]) for a in arrays) for name in ("fourth", "first")}
    alike = max(_constant(a["fourth density"] / a["rate density"]) for a in arrays)
    slopes = []
    for a in arrays:
        f = a["frequency"]
        ends = (f > 0) & (f < 10 * f[f > 0].min()), f > f.max() / 10
        slopes.append([_slope(f[end], a["rate density"][end]) for end in ends])
    low, high = np.median(slopes, axis=0)
    return [
        Claim(
            "the same trend is observed for all four components of the gyroscope quaternion (Figure 5)",
            "the fourth is shown",
            f"Allan deviation over that of the rate: of the fourth constant to {strays['fourth']:.1g} of it over all averaging times, of "
            f"the first to {strays['first']:.1g}",
            verdicts({name: float(stray < 0.1) for name, stray in strays.items()}),
            "The vector part is half the angle; the scalar part is 1 − T²|y|²/8. True: constant to 10 %.",
        ),
        Claim(
            "spectral densities of rate and quaternion look alike: −20 dB a decade, then flat (Figures 6, 7)",
            "figures only",
            f"the same curve up to (T/2)², to {alike:.1g} of it; {10 * low:.0f} dB in its lowest decade of frequency, {10 * high:.0f} dB "
            "in its highest",
            verdict(float(alike < 0.01 and abs(low + 2) < 0.3 and abs(high) < 0.3)),
            "By the same identity; the test cannot fail. True: alike to 1 %, and slopes to 3 dB a decade.",
        ),
    ]


def _distances(test: Results) -> list[Claim]:
    limit = gyroscope.critical(test.cases[0].settings["samples"])
    texts, passes = [], {}
    for walk in gyroscope.WALKS:
        group = test.frame.filter((pl.col("walk") == walk) & pl.col("component").is_in((2, 3, 4)))["distance"].to_numpy()
        rejected = int((group > limit).sum())
        texts.append(f"random walk {walk}: {rejected} of {len(group)}")
        passes[walk] = float(rejected <= binom.ppf(0.975, len(group), 0.05))
    first = test.frame.filter(pl.col("component") == 1)["distance"].to_numpy()
    return [
        Claim(
            "the hypothesis of one distribution is verified with a probability above 80 % for components two to four (3.3.2)",
            "> 80 %, critical value 1.36/√N",
            f"above the right critical value, 0.90 √(2/N) for samples that are normalised, which 5 % should be: {'; '.join(texts)}",
            verdicts(passes),
            "A test rejects or does not; it gives no probability that a hypothesis holds. And it asks for independent samples: with a "
            "random walk large enough to be seen, two draws of one model differ. True: no more rejected than 5 % give by chance (97.5 %).",
        ),
        Claim(
            "only the first component slightly fails",
            "slightly",
            f"distance {np.median(first):.3g}, at least {first.min():.3g}, against {limit:.2g}",
            verdict(float(np.mean((first > limit) & (first < 2 * limit)))),
            "It is a sum of three squares. That it is very small is a reason to leave it out, as the paper does. True: above the critical "
            "value by less than a factor of two.",
        ),
    ]


def _rest(results: Results) -> list[Claim]:
    def last(method: str, field: str) -> Array:
        return _of(results, method, "heading_largest_deg", field=field)

    far, near = "disturbed", "of the Earth's norm"
    alone, misled = last("gyint", far), last("quest", near)
    return [
        Claim(
            "at rest in a constant disturbed field MAGYQ is stable over 5000 s (Figure 9)",
            "figure only",
            f"largest heading error: field {far} {_size(last('magyq', far))}; {near} {_size(last('magyq', near))}, with a dip gate "
            f"{_size(last('with a dip gate', near))}; magyq-estimated {_size(last('magyq-estimated', near))}",
            verdicts({f"field {field}": float(np.mean(last("magyq", field) < 1)) for field in (far, near)}),
            "A field that stays holds the heading, whatever its direction. One that has the Earth's norm is taken for the Earth's, and "
            "pulls. True: below 1°.",
        ),
        Claim(
            "the gyroscope alone drifts; QUEST's yaw is badly corrected by a field with a norm near the Earth's (Figure 9)",
            "figure only",
            f"largest heading error: gyint {_size(alone)}; quest, field {far}, {_size(last('quest', far))}, {near} {_size(misled)}",
            verdicts({"gyint": float(np.mean(alone > 1)), "quest": float(np.mean(misled > 10))}),
            "QUEST takes the direction of such a field at once. True: gyint above 1°, quest above 10°.",
        ),
    ]


def _offset(results: Results) -> Claim:
    biased, fixed = (_of(results, name, "heading_last_deg") for name in ("gyint, biased", "magyq, biased"))
    rms = _of(results, "magyq, biased", "heading_largest_deg")
    share = int((rms < 10).sum())
    return Claim(
        "outdoors MAGYQ corrects an exaggerated offset of the gyroscope; the heading error stays below 10° (Figure 10)",
        "< 10°",
        f"error at the end: gyint {_size(biased)}, magyq {_size(fixed)}; magyq below 10° throughout in {share} of {len(rms)} walks",
        verdict(share / len(rms)),
        "The Earth's field is there most of the time, and corrects heading and offset; what is beside a car or a facade and has its norm "
        "pulls as much. True: below 10° throughout.",
    )


def _below_ten(results: Results) -> Claim:
    texts, shares = [], []
    for sensor in SENSORS:
        for method in ("gyint", "magyq", "magyq-estimated", "hand"):
            largest = _of(results, method, "heading_largest_deg", sensor=sensor)
            shares.append((sensor, method, float(np.mean(largest < 10))))
            texts.append(f"{sensor}, {method}: {_size(largest)}, below 10° in {int((largest < 10).sum())} of {len(largest)}")
    of = {(sensor, method): share for sensor, method, share in shares}
    return Claim(
        "the heading error is below 10° after 1.5 km (abstract)",
        "< 10°, three walks",
        "largest error of a walk: " + "; ".join(texts),
        verdicts({sensor: of[sensor, "magyq"] for sensor in SENSORS}),
        "With that sensor it proves little: the gyroscope alone, its offset known from a rest, stays below 10° in "
        f"{100 * of['adis16488', 'gyint']:.0f} % of the walks. True: below 10° throughout.",
    )


def _rivals(results: Results) -> Claim:
    texts, shares = [], {}
    for sensor in SENSORS:
        ours = _of(results, "magyq", "heading_rms_deg", sensor=sensor)
        for method in ("gyint", "quest"):
            theirs = _of(results, method, "heading_rms_deg", sensor=sensor)
            shares[f"{method} with {sensor}"] = float(np.mean(ours < theirs))
            texts.append(f"{sensor}: {method} {_size(theirs)} against {_size(ours)}, worse in {int((ours < theirs).sum())} of {len(ours)}")
    return Claim(
        "MAGYQ is better than the gyroscope alone and QUEST, above all indoors",
        "three walks",
        "rms of the heading: " + "; ".join(texts),
        verdicts(shares),
        "QUEST believes every field of the right norm. Against a good gyroscope the fixed reference of a static period is a gamble: it "
        "is made with the attitude as it is, and the covariance takes it for the truth. True: a smaller rms of the heading.",
    )


def _one_walk(results: Results) -> Claim:
    texts, shares = [], {}
    for walker in WALKERS:
        alone, ours = (_of(results, m, "path_rms_m", sensor="adis16488", walker=walker) for m in ("gyint", "magyq"))
        alike = np.abs(ours - alone) < 0.2 * np.maximum(ours, alone)
        shares[walker] = float(np.mean(alike if walker == "M1" else (ours < alone) & ~alike))
        texts.append(
            f"{walker}: gyint {_size(alone, ' m')}, magyq {_size(ours, ' m')}, nearer in {int((ours < alone).sum())} of {len(ours)}, "
            f"alike in {int(alike.sum())}"
        )
    return Claim(
        "for M1 the two paths hardly differ, for W1 and M2 the gyroscope alone drifts (Figures 11 to 13)",
        "figures only",
        "rms of the path: " + "; ".join(texts),
        verdicts(shares),
        "The offset that the rest leaves is drawn anew for each walk; walkers do not differ. True: for M1 alike, to 20 % of the larger; "
        "for W1 and M2 magyq nearer by more than that.",
    )


def _budget(results: Results) -> Claim:
    texts, shares = [], {}
    for sensor in SENSORS:
        lengths = _of(results, "magyq", "lengths_rms_m", sensor=sensor)
        for method in ("gyint", "magyq", "hand"):
            headings = _of(results, method, "position_rms_m", sensor=sensor)
            shares[f"{method} with {sensor}"] = float(np.mean(lengths > headings))
            whole = _of(results, method, "path_rms_m", sensor=sensor)
            texts.append(f"{sensor}, {method}: path {_size(whole, ' m')}, headings alone {_size(headings, ' m')}")
        texts.append(f"{sensor}: lengths alone {_size(lengths, ' m')}")
    return Claim(
        "errors of the step length dominate those of the position",
        "figures only",
        "rms: " + "; ".join(texts),
        verdicts(shares),
        "With lengths calibrated for the walker, and steps that follow the model but for 3 % of noise each, which averages out. A height "
        "that is 5 cm wrong makes 3 % of the distance. True: lengths alone lead farther off than headings alone.",
    )


def _updates(results: Results) -> list[Claim]:
    whole = _of(results, "magyq", "heading_rms_deg")

    def without(name: str) -> str:
        values = _of(results, name, "heading_rms_deg")
        change = 100 * np.median(np.abs(values - whole) / whole)
        return f"{name}: rms {_size(values)} against {_size(whole)}, changed by {change:.2g} % in the median"

    def helps(name: str) -> str:
        return verdict(float(np.mean(_of(results, f"without {name}", "heading_rms_deg") > 1.05 * whole)))

    return [
        Claim(
            "MARU is very powerful for estimating the drift of the gyroscope, even inside buildings",
            "none",
            f"{without('without MARU')}; {without('without local QSF')}",
            helps("MARU"),
            "One sample's noise enters two innovations with opposite signs and is taken for new each time: the update is far too "
            "pessimistic. What holds, or spoils, the heading is QSF. True: the heading is worse by more than 5 % without MARU.",
        ),
        Claim(
            "AGU estimates the offsets of accelerometer and gyroscope",
            "none",
            without("without AGU"),
            helps("AGU"),
            "A hand that walks gives the specific force hardly a static period, and the block of the accelerometer's offset is |ω|T small. "
            "True: worse by more than 5 % without AGU.",
        ),
    ]


def _covariance(results: Results) -> Claim:
    found = {name: _of(results, name, "nees") for name in results.frame["method"].unique(maintain_order=True)}
    low, high = nees_bounds(len(results.cases))
    mean = found["magyq"].mean()
    return Claim(
        "the assumptions of the Kalman filter are verified (3.3.2, and conclusion)",
        "none",
        "NEES at the end of a walk, 2.4 expected in the median: "
        + "; ".join(f"{name} {_size(v, '')}" for name, v in found.items())
        + f"; mean of magyq {mean:.3g}",
        verdict(float(low <= mean <= high)),
        "The reference of a static period is made from the estimate, and then taken for the truth; in the state it costs three "
        "components. What looks like the Earth's field errs for seconds: of that no covariance here is honest. "
        f"True: the mean lies between {low:.2f} and {high:.2f}, as it does in 95 % where a covariance is honest.",
    )
