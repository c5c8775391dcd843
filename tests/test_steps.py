"""Steps and modes: what is counted, what is not, and that pieces give the bits of the whole."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import bematist as bm
import twin_steps
from bematist import frames, stance, steps
from bematist.kernels import stance as stance_kernel
from bematist.kernels import steps as kernel
from bematist.kernels import steps_layout as at
from bematist.recording import Recording
from bematist.simulate import simulate_hand

G = 9.80665


def walk(rate_hz=100.0, pace_hz=1.8, walk_s=30.0, rest_s=5.0, size=2.0, seed=0):
    """A device held flat: rest, walk, rest. Returns the recording and how many periods of the steps the walk has."""
    rng = np.random.default_rng(seed)
    t = np.arange(round((2 * rest_s + walk_s) * rate_hz)) / rate_hz
    on = np.clip(np.minimum(t - rest_s, rest_s + walk_s - t) / 0.2, 0, 1)
    phase = 2 * np.pi * pace_hz * (t - rest_s)
    f = np.stack([0.5 * on * np.sin(phase / 2), 0.5 * on * np.cos(phase), G - size * on * np.cos(phase)], 1)
    w = np.stack([0.2 * on * np.sin(phase), 0 * t, 0.1 * on * np.sin(phase / 2)], 1)
    f += 0.03 * rng.standard_normal(f.shape)
    return Recording(time=t, specific_force=f, angular_rate=w + 0.005 * rng.standard_normal(w.shape)), round(pace_hz * walk_s)


def in_pieces(rows, sizes, parameters=None):
    """Results and events of the kernel fed with pieces of these sizes, again and again."""
    p = parameters or steps.StepParameters()
    S, prm = steps.workspace(), steps.kernel_parameters(p)
    memory = np.zeros(stance_kernel.HEAD_SIZE)
    memory[stance_kernel.HELD : stance_kernel.HELD + 2] = -np.inf
    out, events = steps.results(rows[:, 0], p)
    start = written = piece = 0
    while start < len(rows):
        stop = min(len(rows), start + sizes[piece % len(sizes)])
        columns, flags = stance.filled(memory, rows[start:stop], 0.02)
        written += kernel.run(memory, S, prm, columns, flags, np.empty((3, 0)), np.empty(0), out[start:stop], events[written:])
        start, piece = stop, piece + 1
    return out, events[:written]


@pytest.mark.parametrize("rate_hz", [25.0, 50.0, 100.0, 200.0, 500.0])
@pytest.mark.parametrize("pace_hz", [1.2, 1.8, 2.4])
def test_steps_of_a_regular_walk(rate_hz, pace_hz):
    recording, count = walk(rate_hz, pace_hz)
    found = steps.analyse(recording)
    assert abs(len(found.event_time) - count) <= 1
    assert found.count.sum() == len(found.event_time)
    peaks = 5.0 + (np.arange(count) + 0.5) / pace_hz  # where the vertical acceleration is largest
    inner = found.event_time[4:-2]
    assert np.abs(inner[:, None] - peaks).min(1).max() < 0.03
    assert np.abs(found.event_frequency[8:] - pace_hz).max() < 0.05
    assert np.bincount(found.event_carrying, minlength=5).argmax() == steps.CARRYING.index("texting")
    assert (found.event_confirmed >= found.event_time).all()


def test_pieces_give_the_bits_of_the_whole():
    recording, _ = walk()
    rows = recording.samples()
    rows[700:720, 1] = np.nan
    rows[1500:1510, 4:7] = np.nan
    rows = np.delete(rows, slice(2000, 2100), 0)
    whole = in_pieces(rows, [len(rows)])
    for sizes in ([1], [7, 1, 64], [1000]):
        for a, b in zip(in_pieces(rows, sizes), whole, strict=True):
            np.testing.assert_array_equal(a, b)
    assert len(whole[1]) > 40


def test_kernel_is_the_twin():
    made = simulate_hand(
        "building",
        sensor="phone",
        seed=4,
        length_m=220.0,
        gestures=20.0,
        pauses=((60.0, 12.0),),
        carries=((0.0, "texting"), (90.0, "swinging"), (160.0, "phoning")),
    )
    r = made.recording
    p = steps.StepParameters()
    rows = r.samples(pressure=True)
    for up in (None, frames.matrix_from_quaternion(made.truth.attitude)[:, 2]):
        out, events = steps.detect(rows[:, :10], p, up=up, pressure=rows[:, 10].copy())
        expected, closing, cells = twin_steps.steps(r.time, r.specific_force, r.angular_rate, p, G, up, rows[:, 10])
        assert len(events) > 250
        np.testing.assert_allclose(events[:, [at.EVENT_TIME, at.EVENT_FREQUENCY, at.EVENT_CONFIRMED]], expected, rtol=1e-7)
        last = np.append(np.diff(closing) > 0, True)  # of cells that one sample closes, the result shows the last
        np.testing.assert_allclose(out[closing[last]][:, at.OUT_FREQUENCY :], cells[last], atol=2e-6)


def simulated(sensor="phone", seed=1):
    """Ten minutes in which a device is carried in every way, with pauses in which it is turned about."""
    return simulate_hand(
        "building",
        sensor=sensor,
        seed=seed,
        length_m=700.0,
        gestures=10.0,
        pauses=((80.0, 15.0), (280.0, 10.0), (450.0, 20.0)),
        carries=((0.0, "texting"), (150.0, "swinging"), (300.0, "phoning"), (420.0, "pocket"), (560.0, "bag")),
    )


@pytest.mark.parametrize("with_attitude", [False, True])
@pytest.mark.parametrize("sensor", ["phone", "adis16488"])
def test_simulated_walk(sensor, with_attitude):
    made = simulated(sensor)
    found = steps.analyse(made.recording, attitude=made.truth.attitude if with_attitude else None)
    assert abs(len(found.event_time) / len(made.steps) - 1) < 0.01
    motion, carry = made.modes_at(found.time)
    walks = motion == "walking"
    assert ((np.array(steps.MOTIONS)[found.motion] == "walking") == walks).mean() > 0.93
    assert (np.array(steps.CARRYING)[found.carrying] == carry)[walks].mean() > 0.95
    near = np.interp(found.event_time, made.steps.time, made.steps.frequency_hz)
    assert np.std(found.event_frequency / near - 1) < 0.04


@pytest.mark.parametrize("carry", ["texting", "phoning", "swinging", "pocket", "bag"])
@pytest.mark.parametrize(("gait", "motion"), [("slow", "walking"), ("brisk", "walking"), ("run", "running")])
def test_gaits_and_ways_to_carry(carry, gait, motion):
    made = simulate_hand("straight", carry, "phone", seed=2, gait=gait, length_m=120.0)
    found = steps.analyse(made.recording)
    assert abs(len(found.event_time) - len(made.steps)) <= 0.02 * len(made.steps) + 1
    half = len(found.event_time) // 2
    assert set(found.event_motion[half:]) == {steps.MOTIONS.index(motion)}
    assert (found.event_carrying[half:] == steps.CARRYING.index(carry)).mean() > 0.95


def test_stairs_by_the_barometer():
    made = simulate_hand("stairs", "texting", "phone", seed=3)
    stairs = steps.MOTIONS.index("stairs")
    found = steps.analyse(made.recording)
    truth = np.isin(made.modes_at(found.time)[0], ["upstairs", "downstairs"])
    assert (found.motion == stairs)[truth].mean() > 0.7  # seen about 1.5 s late, and a flight lasts 6 s
    without = steps.analyse(made.recording.replace(pressure_time=np.empty(0), pressure=np.empty(0)))
    assert not (without.motion == stairs).any()
    np.testing.assert_array_equal(without.event_time, found.event_time)


@pytest.mark.parametrize("every_s", [0.1, 1.0, 4.5])
def test_climbing_by_a_pressure_of_any_interval(every_s):
    r, _ = walk(walk_s=60.0)
    t = np.arange(0.0, r.time[-1], every_s)
    pressure = 101325 * np.exp(-0.3 * t / 8434)
    climb = steps.analyse(r.replace(pressure_time=t, pressure=pressure)).features[:, steps.FEATURES.index("climb_speed")]
    np.testing.assert_allclose(climb[r.time > 40], 0.3, rtol=0.01)
    assert climb.max() < 0.33


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("turn_rad", "shift_m", "every_s", "without"),
    [(0.1, 0.1, (0.3, 1.5), 4), (0.3, 0.05, (0.1, 1.0), 40), (0.6, 0.1, (0.2, 0.8), 100)],
)
def test_gestures_of_one_who_stands_are_no_steps(seed, turn_rad, shift_m, every_s, without):
    """Three minutes of turning about, taking up and putting down, slow and fast, but not in the beat of a walk; steps would be 330."""
    rng = np.random.default_rng(seed)
    t = np.arange(18000) / 100
    knots = np.cumsum(rng.uniform(*every_s, 800))
    turn, shift = (
        scale * PchipInterpolator(knots, rng.normal(size=(800, 3)))(np.clip(t, knots[0], knots[-1])) for scale in (turn_rad, shift_m)
    )
    q = frames.quaternion_from_rotation_vector(turn)
    acceleration = np.gradient(np.gradient(shift, 0.01, axis=0), 0.01, axis=0)
    f = frames.rotate(frames.conjugate(q), acceleration + np.array([0, 0, G]))
    w = np.zeros_like(f)
    w[1:] = frames.rotation_vector_from_quaternion(frames.multiply(frames.conjugate(q[:-1]), q[1:])) * 100
    recording = Recording(time=t, specific_force=f, angular_rate=w)
    assert len(steps.analyse(recording).event_time) <= 12
    # Periodicity tells them: where none is asked for, they are steps.
    careless = steps.StepParameters().override({"detection": {"periodic": 0, "periodic_rate": 0, "stride_periodic": 0}})
    assert seed == 0 or len(steps.analyse(recording, careless).event_time) > without


def test_a_gap_begins_anew():
    recording, _ = walk()
    rows = np.delete(recording.samples(), slice(1500, 1700), 0)
    out, events = in_pieces(rows, [len(rows)])
    first, second = (in_pieces(part, [10000]) for part in (rows[:1500], rows[1500:]))
    np.testing.assert_array_equal(events[:, at.EVENT_TIME], np.concatenate([e[:, at.EVENT_TIME] for _, e in (first, second)]))
    assert out[1500, at.OUT_FREQUENCY] == 0 < out[1499, at.OUT_FREQUENCY]


def test_missing_values_and_short_gaps_are_bridged():
    recording, _ = walk()
    whole = steps.analyse(recording)
    holes = recording.specific_force.copy()
    holes[np.random.default_rng(1).uniform(size=len(holes)) < 0.1] = np.nan
    keep = np.ones(len(holes), bool)
    keep[1000:1020] = keep[2000:2020] = False
    patchy = Recording(time=recording.time[keep], specific_force=holes[keep], angular_rate=recording.angular_rate[keep])
    found = steps.analyse(patchy)
    assert abs(len(found.event_time) - len(whole.event_time)) <= 1
    assert np.isfinite(found.features).all()
    nothing = steps.analyse(recording.replace(specific_force=np.full_like(holes, np.nan)))
    assert not len(nothing.event_time) and not nothing.count.any()


def test_events_rise_and_are_counted_in_time():
    made = simulated()
    found = steps.analyse(made.recording)
    assert (np.diff(found.event_time) > 1 / 6).all()
    delay = found.event_confirmed - found.event_time
    first = found.count[np.searchsorted(found.time, found.event_confirmed)] > 1
    assert delay.min() > 0 and np.percentile(delay[~first], 99) < steps.StepParameters().latency_s
    assert found.count.max() <= at.MAX_NEW
    assert found.count.sum() == len(found.event_time)


HAND = Path(__file__).parents[2] / "shared" / "data" / "hand"


@pytest.mark.skipif(not HAND.exists(), reason="needs ../shared/data/hand")
@pytest.mark.parametrize(
    ("name", "carry", "count", "tolerance"),
    [
        ("ms_indoor20/site1_B1_5dda149f9191710006b57212.txt", "texting", 62, 2),
        ("ms_indoor20/site2_F2_5dd3793144333f00067aa1c7.txt", "texting", 56, 1),
        ("nexus5_mocap/Thibaud_Nexus5_NoDist_Swinging", "swinging", 210, 6),
        # A slow walk in a small room, three to eight steps at a time between turns on the spot.
        ("nexus5_mocap/Guillaume_Nexus5_NoDist_Texting", "texting", 111, 15),
        ("nexus5_mocap/calib_mag_Nexus5_d1", "", 0, 0),
    ],
)
def test_real_devices(name, carry, count, tolerance):
    """Counts are the peaks of the specific force without delay, or those of the height in the motion capture: see docs/steps.md."""
    found = steps.analyse(bm.read(HAND / name))
    assert abs(len(found.event_time) - count) <= tolerance
    if carry:
        assert (found.event_carrying == steps.CARRYING.index(carry)).mean() > 0.93
