"""MAGYQ's study: the test of distributions, the path by true steps, and the whole on short walks."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from scipy.stats import ks_2samp

from bematist.ahrs.filters import find_filter
from bematist.frames import multiply, quaternion_from_euler
from bematist.reproduce import find_study
from bematist.reproduce.magyq import choices, consistency, gyroscope, outdoors, rest, walks
from bematist.reproduce.numbers import attitude_numbers
from bematist.reproduce.run import Run
from bematist.simulate import simulate_hand

SHORTER = {"quaternion": {"hours": 0.05}, "test": {"samples": 2000}, "rest": {"seconds": 60.0}}
WALKED = {"length_m": 40.0, "pauses": ()}


def short(part):
    """Rests of a minute, walks of 40 m."""

    def cases(seeds):
        more = SHORTER.get(part.name, {})
        return [{**s, **more} if more else {**s, "changes": {**s["changes"], **WALKED}} for s in part.cases(seeds)]

    return replace(part, cases=cases)


def test_end_to_end(tmp_path: Path):
    study = find_study("magyq")
    run = Run(replace(study, parts=tuple(map(short, study.parts))), tmp_path, seeds=1)
    run.compute()
    text = run.write().read_text()
    assert "None" not in text and "nan" not in text
    assert text.count("![") == 11
    claims = pl.read_csv(tmp_path / "tables/claims.csv")
    assert len(claims) == 14 and claims["verdict"].null_count() == 0
    assert not [p for p in (tmp_path / "figures").glob("*.png") if p.stat().st_size > 300_000]
    frame = pl.read_csv(tmp_path / "tables/walks-cases.csv")
    assert frame["method"].n_unique() == len(choices.FILTERS | choices.ABLATIONS)
    assert frame["heading_rms_deg"].is_between(0, 30).all()


def test_distances_are_those_of_scipy():
    rng = np.random.default_rng(3)
    a, b = rng.standard_normal((500, 2)), np.column_stack([rng.standard_normal(500), rng.exponential(size=500)])
    centred = [(x - x.mean(0)) / x.std(0) for x in (a, b)]
    expected = [ks_2samp(x, y).statistic for x, y in zip(centred[0].T, centred[1].T, strict=True)]
    np.testing.assert_allclose(gyroscope.distances(a, b), expected)


def test_the_critical_value_is_exceeded_in_five_percent():
    rng = np.random.default_rng(5)
    d = gyroscope.distances(rng.standard_normal((1000, 1500)), rng.standard_normal((1000, 1500)))
    assert np.mean(d > gyroscope.critical(1000)) == pytest.approx(0.05, abs=0.015)


def test_the_first_component_fails_and_a_large_walk_too():
    def found(walk):
        return [gyroscope.compute_test({"seed": s, "walk": walk, "samples": 20_000}).rows for s in range(6)]

    limit = gyroscope.critical(20_000)
    white = np.array([[row["distance"] for row in rows] for rows in found("none")])
    assert (white[:, 0] > 8 * limit).all()
    assert (white[:, 1:] > limit).mean() < 0.2
    large = np.array([gyroscope.distances(*_drawn(seed)) for seed in range(6)])
    assert (large[:, 1:] > limit).mean() > 0.8


def _drawn(seed):
    rng = np.random.default_rng(seed)
    return (gyroscope.modelled(np.radians(0.05), 20_000, rng) for _ in range(2))


def test_headings_of_the_truth_lead_along_the_path():
    made = simulate_hand("building", length_m=200.0, wander_deg=0.0, unsteady_deg=0.0, twist_deg=(0, 0, 0), pauses=(), seed=2)
    path = made.motion.places(made.steps.along)[0][:, :2]
    led = walks.dead_reckoned(made, made.truth.attitude)
    assert np.linalg.norm(led - path, axis=1).max() < 0.5
    turned = multiply(quaternion_from_euler(0.0, 0.0, np.radians(20.0)), made.truth.attitude)
    c, s = np.cos(np.radians(20)), np.sin(np.radians(20))
    np.testing.assert_allclose(walks.dead_reckoned(made, turned), led @ [[c, s], [-s, c]], atol=1e-9)


def test_attitude_numbers():
    truth = np.tile([1.0, 0, 0, 0], (50, 1))
    angles = np.radians(np.linspace(0, 10, 50))
    found = attitude_numbers(quaternion_from_euler(0 * angles, 0 * angles, angles), truth)
    assert (found["heading_largest_deg"], found["heading_last_deg"]) == (pytest.approx(10), pytest.approx(10))
    assert found["heading_rms_deg"] == pytest.approx(10 / np.sqrt(3), rel=0.02)
    assert found["tilt_rms_deg"] == pytest.approx(0, abs=1e-6)


def test_a_field_of_the_earths_norm():
    """The second field of Figure 9 has the norm of the Earth's, and another direction."""
    from bematist.simulate import SCENARIOS
    from bematist.simulate.field import earth_field

    earth = earth_field(SCENARIOS["still"])
    there = earth + rest.FIELDS["of the Earth's norm"]
    assert np.linalg.norm(there) == pytest.approx(np.linalg.norm(earth), abs=0.02)
    assert np.degrees(np.arctan2(there[0], there[1])) == pytest.approx(31, abs=1)


def test_every_run_is_one_the_filters_know():
    for runs in (choices.FILTERS | choices.ABLATIONS, outdoors.RUNS, consistency.RUNS):
        made = {name: find_filter(kind).parameters.override(more) for name, (kind, more) in runs.items()}
        assert len({str(p) for p in made.values()}) >= len(runs) - (runs is outdoors.RUNS)
    for sensor in choices.SENSORS:
        for name, (kind, more) in choices.told(sensor, choices.ABLATIONS, choices.STEADY).items():
            told = find_filter(kind).parameters.override(more)
            assert told.attitude.noise.angle_random_walk == choices.TOLD[sensor]["attitude"]["noise"]["angle_random_walk"], name
