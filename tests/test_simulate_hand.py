"""The simulated hand against independent truth: re-integration, differences, steps, stairs, fields, and real recordings beside it."""

import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch

import bematist as bm
from bematist.errors import UsageError
from bematist.frames import conjugate, multiply, rotate, rotation_vector_from_quaternion
from bematist.simulate import CARRIES, POINTING, FieldRegion, Gait, IndoorField, Scenario, Walker, simulate, simulate_hand, simulate_walk
from strapdown import reintegrated

HAND = Path(__file__).parents[2] / "shared" / "data" / "hand"
ROOM = Scenario(waypoints=((0, 0, 0), (30, 0, 0), (30, 20, 0), (0, 20, 0)), pauses=((40.0, 12.0),))


@pytest.mark.parametrize("sampling", ["average", "instant"])
@pytest.mark.parametrize("carry", CARRIES)
def test_reintegration_returns_to_the_truth(carry, sampling):
    made = simulate_hand("short", carry, "ideal", rate_hz=1000.0, magnetometer_rate_hz=0.0, sampling=sampling)
    q, v, p = reintegrated(made)
    assert np.abs(p - made.truth.position).max() < 0.001 * made.motion.along[-1] / 1000  # 1 mm in 1 km
    assert np.abs(v - made.truth.velocity).max() < 1e-6
    assert np.abs(rotation_vector_from_quaternion(multiply(q, conjugate(made.truth.attitude)))).max() < 1e-8


@pytest.mark.parametrize("changes", [{"scenario": "stairs"}, {"scenario": "straight", "gait": "run"}, {"scenario": ROOM, "gestures": 30.0}])
def test_derivatives_against_finite_differences(changes):
    carries = ((0.0, "texting"), (8.0, "phoning"), (16.0, "swinging"), (24.0, "pocket"), (34.0, "texting"))
    motion = simulate_hand(sensor="ideal", rate_hz=10.0, carries=carries, **changes).motion
    t, h = np.linspace(5, motion.duration_s - 1, 4001), 2e-5
    s, before, after = motion.at(t), motion.at(t - h), motion.at(t + h)
    np.testing.assert_allclose(s.velocity, (after.position - before.position) / (2 * h), atol=1e-5)
    np.testing.assert_allclose(s.acceleration, (after.velocity - before.velocity) / (2 * h), atol=1e-3)
    turn = rotation_vector_from_quaternion(multiply(conjugate(before.attitude), after.attitude)) / (2 * h)
    np.testing.assert_allclose(s.angular_rate, turn, atol=1e-4)
    assert np.abs(s.acceleration).max() < 60  # nothing jumps, from one way of carrying to the next either


def test_steps_follow_the_model_and_the_pedestrian_the_path():
    made = simulate_hand("straight", length_m=400.0, height_m=1.62, frequency_wander=0.08)
    steps = made.steps
    assert steps.length_m.sum() == pytest.approx(400.0)
    assert (steps.begin[0], steps.begin[1:]) == (pytest.approx(10.0), pytest.approx(steps.time[:-1]))
    # Half a step at the beginning and the end; between, the model with its noise: the slope comes back.
    np.testing.assert_allclose(steps.length_m[[0, -1]], np.median(steps.length_m) / 2, rtol=0.25)
    f, length = steps.frequency_hz[1:-1], steps.length_m[1:-1]
    a, b = np.polyfit(f, length, 1)
    assert a == pytest.approx(1.62 * Walker().step_a, rel=0.1)
    assert np.std(length - a * f - b) == pytest.approx(0.03 * length.mean(), rel=0.15)
    assert f @ length / len(f) == pytest.approx(1.3 / 1.16, rel=0.06)  # the speed of the gait, as far as its frequency wanders
    # The reference is on the path, and where the feet say; the hand is before it.
    reference = made.recording.reference
    np.testing.assert_allclose(reference.position[:, 1:], 0, atol=1e-9)
    at = np.interp(steps.time, reference.time, reference.position[:, 0])
    assert np.abs(at - steps.along[1:]).max() < 0.2
    ahead = made.truth.position - reference.position
    assert ahead[:, 0].min() > 0.2 and ahead[:, 0].max() < 0.45
    assert ahead[:, 2].min() > 0.95 and ahead[:, 2].max() < 1.2


def test_pauses_gestures_and_modes():
    made = simulate_hand(ROOM, carries=((0.0, "texting"), (50.0, "swinging")), gestures=20.0, seed=3)
    steps = made.steps
    k = int(np.argmax(steps.begin[1:] - steps.time[:-1]))
    assert steps.begin[k + 1] - steps.time[k] == pytest.approx(12.0)
    assert steps.along[k + 1] == pytest.approx(40.0)
    t = np.array([5.0, steps.time[3] - 0.1, steps.time[k] + 6.0, steps.time[-2] - 0.1])
    motion, carry = made.modes_at(t)
    assert list(motion) == ["standing", "walking", "standing", "walking"]
    assert list(carry) == ["texting", "texting", "texting", "swinging"]
    spans = made.spans()
    assert [s[2:] for s in spans] == [
        ("standing", "texting"),
        ("walking", "texting"),
        ("standing", "texting"),
        ("walking", "texting"),
        ("walking", "swinging"),
        ("standing", "swinging"),
    ]
    assert all(a[1] == b[0] for a, b in pairwise(spans))
    # A hand that gestures turns far more than one that only stands.
    quiet = simulate_hand(ROOM, seed=3)
    pause = (made.truth.time > steps.time[k] + 1) & (made.truth.time < steps.begin[k + 1] - 1)
    turned = [np.ptp(rotate(m.truth.attitude[pause], POINTING), axis=0).max() for m in (made, quiet)]
    assert turned[0] > 3 * turned[1]


@pytest.mark.parametrize("angle", [0.0, 25.0])
def test_the_device_points_where_one_walks(angle):
    made = simulate_hand(ROOM, misalignment_deg=angle)
    walking = made.modes_at(made.truth.time)[0] == "walking"
    ahead = rotate(made.truth.attitude, POINTING)
    off = np.arctan2(ahead[:, 1], ahead[:, 0]) - made.direction_at(made.truth.time)
    off = np.degrees(np.angle(np.exp(1j * off)))[walking]
    assert np.mean(off) == pytest.approx(angle, abs=1.5)
    assert 1 < np.std(off) < 6
    drawn = [simulate_hand("short", misalignment_sd_deg=20.0, rate_hz=10, seed=k).truth.attitude[0] for k in range(3)]
    assert np.ptp(drawn, axis=0).max() > 0.05


def test_stairs_and_the_barometer():
    made = simulate_hand("stairs", "texting", "phone", seed=1)
    steps = made.steps
    assert ((steps.motion == "upstairs").sum(), (steps.motion == "downstairs").sum()) == (80, 80)
    up = made.recording.reference.position[:, 2]
    assert up.max() == pytest.approx(13.6, abs=1e-6)
    r = made.recording
    height = np.interp(r.pressure_time, made.truth.time, made.truth.position[:, 2])
    slope, _ = np.polyfit(height, r.pressure, 1)
    assert slope == pytest.approx(-12.0, abs=0.3)  # Pa/m near the ground
    assert not len(simulate("short", "ideal", carry="bag").pressure)


def test_running_has_the_steps_of_its_gait():
    made = simulate_hand("straight", "swinging", gait="run")
    assert set(made.steps.motion) == {"running"}
    assert made.steps.length_m[1:-1].mean() == pytest.approx(1.1, rel=0.08)
    assert made.steps.frequency_hz.mean() == pytest.approx(2 / 0.71, rel=0.08)
    walk = simulate_hand("straight", "swinging")
    force = [np.linalg.norm(m.recording.specific_force, axis=1)[2000:4000].std() for m in (made, walk)]
    assert force[0] > 1.8 * force[1]


def test_regions_of_a_constant_field():
    offset = (9.0, -5.0, 12.0)
    made = simulate_hand(ROOM, sensor="ideal", field_regions=(FieldRegion(from_m=20, to_m=40, offset_ut=offset),))
    along, earth = made.motion.travelled(made.recording.magnetic_time), made.field[0]
    np.testing.assert_allclose((made.field[(along > 22.5) & (along < 37.5)] - earth - offset), 0, atol=1e-12)
    assert (made.field[(along < 20) | (along > 40)] == earth).all()
    assert np.abs(np.diff(made.field, axis=0)).max() < 0.5
    # Indoors: constant by regions, which differ, each next to the other.
    inside = simulate_hand("straight", sensor="ideal", length_m=300.0, indoor_fields=(IndoorField(from_m=20, to_m=280, ramp_m=2.0),))
    along = inside.motion.travelled(inside.recording.magnetic_time)
    change = np.abs(np.diff(inside.field, axis=0)).max(1) > 0
    assert 0.1 < change[(along[1:] > 20) & (along[1:] < 280)].mean() < 0.35
    assert 8 < len(np.unique(inside.field[1:][~change].round(9), axis=0)) < 19
    assert (inside.field[along > 282] == inside.field[0]).all()
    # Rests may lie in one from the start.
    rest = simulate_hand("still", "table", "ideal", rest_s=20, field_regions=(FieldRegion(from_m=-9, to_m=9, ramp_m=1, offset_ut=offset),))
    np.testing.assert_allclose(rest.field - rest.field[0], 0, atol=1e-12)
    np.testing.assert_allclose(rest.field[0] - earth, offset)
    assert np.abs(rest.recording.angular_rate).max() < 1e-9


def test_seeds():
    a, b, c = (simulate("short", "phone", carry="texting", seed=k) for k in (1, 1, 2))
    for name in ("specific_force", "magnetic_flux_density", "pressure"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        assert np.abs(getattr(a, name)[:50] - getattr(c, name)[:50]).max() > 0
    d = simulate_hand("short", "swinging", "ideal", seed=1)
    np.testing.assert_array_equal(d.steps.time, simulate_hand("short", seed=1).steps.time)


def test_a_quarter_of_an_hour_is_quickly_made():
    before = time.process_time()
    made = simulate_hand()
    assert time.process_time() - before < 6  # about 2 s
    assert made.recording.duration_s == pytest.approx(16 * 60, abs=60)
    assert made.steps.length_m.sum() == pytest.approx(1500.0)
    np.testing.assert_allclose(made.recording.reference.position[-1], 0, atol=1e-6)


def bands(f, w, edges):
    """Root mean square (K,) of the specific force (m/s², all axes) and of the rate (°/s) in bands of frequency, Hz."""
    found = []
    for x in (f, np.degrees(w)):
        frequency, power = welch(x, 100, nperseg=1024, axis=0)
        inside = [(frequency >= lo) & (frequency < hi) for lo, hi in edges]
        found.append([np.sqrt(power[i].sum() * frequency[1]) for i in inside])
    return np.array(found)


def at_100_hz(recording, begin, end):
    t = np.arange(begin, end, 0.01)
    return (
        np.column_stack([np.interp(t, recording.time, x) for x in values.T])
        for values in (recording.specific_force, recording.angular_rate)
    )


REAL = {
    "texting": ("ms_indoor20/site2_F2_5dd3793144333f00067aa1c7.txt", 5, 25, 1.45),
    "swinging": ("nexus5_mocap/Thibaud_Nexus5_NoDist_Swinging", 8, 48, 1.1),
}


@pytest.mark.parametrize("carry", REAL)
def test_real_hands_beside_it(carry):
    """Energies by bands of frequency, within a factor of two: the stride and the step, their harmonics, footfalls."""
    name, begin, end, speed = REAL[carry]
    if not (HAND / name).exists():
        pytest.skip("../shared/data/hand is not there")
    gait = Gait(stride_m=speed * 1.1, swing_s=0.8, stance_s=0.3)
    made = simulate_hand("rectangle", carry, length_m=120.0, gaits=((0.0, gait),), seed=2)
    edges = [(0.5, 1.3), (1.3, 2.4), (2.4, 4.5), (4.5, 8.0), (8.0, 15.0)]
    real = bands(*at_100_hz(bm.read(HAND / name), begin, end), edges)
    ours = bands(*at_100_hz(made.recording, 12.0, 60.0), edges)
    ratio = ours / real
    assert (ratio[:, :4] > 0.45).all() and (ratio[:, :4] < 2.2).all(), ratio.round(2)
    assert (ratio[:, 4] > 0.1).all() and (ratio[:, 4] < 2.2).all(), ratio.round(2)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        ({"carry": "juggling"}, "texting"),
        ({"carries": ((0, "texting"), (30, "juggling"))}, "juggling"),
        ({"carries": ((5, "texting"),)}, "begins at 0"),
        ({"height_m": 9}, "height_m"),
        ({"swing": 9}, "swing_deg"),
    ],
)
def test_wrong_use_is_said(call, says):
    with pytest.raises(UsageError, match=says):
        simulate_hand("short", **call)
    with pytest.raises(UsageError, match=r"parameter.*height_m"):
        simulate_walk("short", height_m=1.8)
