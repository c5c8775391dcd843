"""What the paper claims, sentence by sentence, with numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import polars as pl

from bematist.reproduce.magyq import gyroscope
from bematist.reproduce.magyq.choices import SENSORS
from bematist.reproduce.magyq.walks import WALKERS
from bematist.reproduce.study import Claim, Results

Array = np.ndarray


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


def _model(quaternion: Results, test: Results) -> list[Claim]:
    limit = gyroscope.critical(test.cases[0].settings["samples"])
    ratios = quaternion.frame.select("ratio_smallest", "ratio_largest").to_numpy()
    apart = np.abs(ratios - 1).max()

    def rejected(walk: str, *components: int) -> str:
        group = test.frame.filter((pl.col("walk") == walk) & pl.col("component").is_in(components))["distance"].to_numpy()
        return f"{(group > limit).sum()} of {len(group)}"

    first = test.frame.filter(pl.col("component") == 1)["distance"].to_numpy()
    walks = "; ".join(f"random walk {walk}: {rejected(walk, 2, 3, 4)}" for walk in gyroscope.WALKS)
    return [
        Claim(
            "the same trend is observed for all four components of the gyroscope quaternion (Figure 5)",
            "the fourth is shown",
            f"the fourth is T/2 times the rate at every averaging time, to {apart:.1g} of it; the first has no random walk and no floor "
            "of its own",
            "holds for three components",
            "The vector part is half the angle; the scalar part is 1 − T²|y|²/8.",
        ),
        Claim(
            "spectral densities of rate and quaternion look alike: −20 dB a decade, then flat (Figures 6, 7)",
            "figures only",
            "the same curve up to (T/2)²",
            "holds",
            "By the same identity; the test cannot fail.",
        ),
        Claim(
            "the hypothesis of one distribution is verified with a probability above 80 % for components two to four (3.3.2)",
            "> 80 %, critical value 1.36/√N",
            f"above the right critical value, 0.90 √(2/N) for samples that are normalised, which 5 % should be: {walks}",
            "a misuse of the test",
            "A test rejects or does not; it gives no probability that a hypothesis holds. And it asks for independent samples: with a "
            "random walk large enough to be seen, two draws of one model differ.",
        ),
        Claim(
            "only the first component slightly fails",
            "slightly",
            f"distance {np.median(first):.3g}, at least {first.min():.3g}, against {limit:.2g}",
            "fails grossly",
            "It is a sum of three squares. That it is very small is a reason to leave it out, as the paper does.",
        ),
    ]


def _rest(results: Results) -> list[Claim]:
    def last(method: str, field: str) -> Array:
        return _of(results, method, "heading_largest_deg", field=field)

    far, near = "disturbed", "of the Earth's norm"
    magyq, turned = last("magyq", far), last("magyq", near)
    held = [name for name, values in ((far, magyq), (near, turned)) if np.max(values) < 1]
    return [
        Claim(
            "at rest in a constant disturbed field MAGYQ is stable over 5000 s (Figure 9)",
            "figure only",
            f"largest heading error: field {far} {_size(magyq)}; {near} {_size(turned)}, with a dip gate "
            f"{_size(last('with a dip gate', near))}; magyq-estimated {_size(last('magyq-estimated', near))}",
            "holds" if len(held) == 2 else "holds where the norm differs from the Earth's" if held == [far] else "does not hold",
            "A field that stays holds the heading, whatever its direction. One that has the Earth's norm is taken for the Earth's, and "
            "pulls.",
        ),
        Claim(
            "the gyroscope alone drifts; QUEST's yaw is badly corrected by a field with a norm near the Earth's (Figure 9)",
            "figure only",
            f"largest heading error: gyint {_size(last('gyint', far))}; quest, field {far}, {_size(last('quest', far))}, {near} "
            f"{_size(last('quest', near))}",
            "holds",
            "QUEST takes the direction of such a field at once.",
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
        "holds" if share == len(rms) else "holds mostly" if share > 0.6 * len(rms) else "does not hold",
        "The Earth's field is there most of the time, and corrects heading and offset.",
    )


def _below_ten(results: Results) -> Claim:
    texts, shares = [], []
    for sensor in SENSORS:
        for method in ("gyint", "magyq", "magyq-estimated", "hand"):
            largest = _of(results, method, "heading_largest_deg", sensor=sensor)
            shares.append((sensor, method, float(np.mean(largest < 10))))
            texts.append(f"{sensor}, {method}: {_size(largest)}, below 10° in {int((largest < 10).sum())} of {len(largest)}")
    of = {(sensor, method): share for sensor, method, share in shares}
    own = of["adis16488", "magyq"]
    return Claim(
        "the heading error is below 10° after 1.5 km (abstract)",
        "< 10°, three walks",
        "largest error of a walk: " + "; ".join(texts),
        f"holds in {100 * own:.0f} % of the walks with the paper's sensor, {100 * of['phone', 'magyq']:.0f} % with a phone's",
        "With that sensor it proves little: the gyroscope alone, its offset known from a rest, stays below 10° in "
        f"{100 * of['adis16488', 'gyint']:.0f} % of the walks.",
    )


def _rivals(results: Results) -> Claim:
    texts, shares = [], []
    for sensor in SENSORS:
        ours = _of(results, "magyq", "heading_rms_deg", sensor=sensor)
        for method in ("gyint", "quest"):
            theirs = _of(results, method, "heading_rms_deg", sensor=sensor)
            shares.append(float(np.mean(ours < theirs)))
            texts.append(f"{sensor}: {method} {_size(theirs)} against {_size(ours)}, worse in {int((ours < theirs).sum())} of {len(ours)}")
    return Claim(
        "MAGYQ is better than the gyroscope alone and QUEST, above all indoors",
        "three walks",
        "rms of the heading: " + "; ".join(texts),
        "holds" if min(shares) > 0.9 else "holds against QUEST" if min(shares[1::2]) > 0.9 else "holds mostly",
        "QUEST believes every field of the right norm. Against a good gyroscope the fixed reference of a static period is a gamble: it "
        "is made with the attitude as it is, and the covariance takes it for the truth.",
    )


def _one_walk(results: Results) -> Claim:
    texts = []
    for walker in WALKERS:
        alone, ours = (_of(results, m, "path_rms_m", sensor="adis16488", walker=walker) for m in ("gyint", "magyq"))
        texts.append(
            f"{walker}: gyint {_size(alone, ' m')}, magyq {_size(ours, ' m')}, nearer in {int((ours < alone).sum())} of {len(ours)}"
        )
    return Claim(
        "for M1 the two paths hardly differ, for W1 and M2 the gyroscope alone drifts (Figures 11 to 13)",
        "figures only",
        "rms of the path: " + "; ".join(texts),
        "a matter of the draw",
        "The offset that the rest leaves is drawn anew for each walk; walkers do not differ.",
    )


def _budget(results: Results) -> Claim:
    texts, shares = [], []
    for sensor in SENSORS:
        lengths = _of(results, "magyq", "lengths_rms_m", sensor=sensor)
        for method in ("gyint", "magyq", "hand"):
            headings = _of(results, method, "position_rms_m", sensor=sensor)
            shares.append(float(np.mean(lengths > headings)))
            whole = _of(results, method, "path_rms_m", sensor=sensor)
            texts.append(f"{sensor}, {method}: path {_size(whole, ' m')}, headings alone {_size(headings, ' m')}")
        texts.append(f"{sensor}: lengths alone {_size(lengths, ' m')}")
    return Claim(
        "errors of the step length dominate those of the position",
        "figures only",
        "rms: " + "; ".join(texts),
        "holds" if min(shares) > 0.9 else "does not hold" if max(shares) < 0.5 else "depends on the filter",
        "With lengths calibrated for the walker, and steps that follow the model but for 3 % of noise each, which averages out. A height "
        "that is 5 cm wrong makes 3 % of the distance.",
    )


def _updates(results: Results) -> list[Claim]:
    whole = _of(results, "magyq", "heading_rms_deg")

    def without(name: str) -> str:
        values = _of(results, name, "heading_rms_deg")
        change = 100 * np.median(np.abs(values - whole) / whole)
        return f"{name}: rms {_size(values)} against {_size(whole)}, changed by {change:.2g} % in the median"

    ratios = [np.median(np.abs(_of(results, f"without {n}", "heading_rms_deg") / whole - 1)) for n in ("MARU", "AGU")]
    small = "adds nothing" if max(ratios) < 0.05 else "changes little" if max(ratios) < 0.3 else "matters"
    return [
        Claim(
            "MARU is very powerful for estimating the drift of the gyroscope, even inside buildings",
            "none",
            f"{without('without MARU')}; {without('without local QSF')}",
            small,
            "One sample's noise enters two innovations with opposite signs and is taken for new each time: the update is far too "
            "pessimistic. What holds, or spoils, the heading is QSF.",
        ),
        Claim(
            "AGU estimates the offsets of accelerometer and gyroscope",
            "none",
            without("without AGU"),
            small,
            "A hand that walks gives the specific force hardly a static period, and the block of the accelerometer's offset is |ω|T small.",
        ),
    ]


def _covariance(results: Results) -> Claim:
    found = {name: _of(results, name, "nees") for name in results.frame["method"].unique(maintain_order=True)}
    return Claim(
        "the assumptions of the Kalman filter are verified (3.3.2, and conclusion)",
        "none",
        "NEES at the end of a walk, 2.4 expected in the median: " + "; ".join(f"{name} {_size(v, '')}" for name, v in found.items()),
        "does not hold",
        "The reference of a static period is made from the estimate, and then taken for the truth; in the state it costs three "
        "components. What looks like the Earth's field errs for seconds: of that no covariance here is honest.",
    )
