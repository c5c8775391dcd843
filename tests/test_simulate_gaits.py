"""How the simulated foot moves: re-integration, running, stairs, paces, strides that differ, and real shoes beside it."""

import numpy as np
import pytest

from bematist.errors import UsageError
from bematist.frames import conjugate, matrix_from_quaternion, multiply, quaternion_from_euler, rotate, rotation_vector_from_quaternion
from bematist.simulate import GAITS, SCENARIOS, Scenario, simulate, simulate_walk
from bematist.simulate.path import scaled, with_stairs
from strapdown import reintegrated


@pytest.mark.parametrize("sampling", ["average", "instant"])
@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("short", {}),
        ("short", {"rocking_deg": 5.0}),
        ("straight", {"gait": "run"}),
        ("stairs", {"rest_s": 2.0}),
        ("ellipse", {"length_m": 60}),
    ],
)
def test_reintegration_returns_to_the_truth(scenario, changes, sampling):
    made = simulate_walk(scenario, "ideal", rate_hz=1000.0, magnetometer_rate_hz=0.0, sampling=sampling, **changes)
    q, v, p = reintegrated(made)
    assert np.abs(p - made.truth.position).max() < 0.005 * made.motion.along[-1] / 1000  # 5 mm in 1 km
    assert np.abs(v - made.truth.velocity).max() < 3e-5
    assert np.abs(rotation_vector_from_quaternion(multiply(q, conjugate(made.truth.attitude)))).max() < 1e-7


def test_reintegration_can_tell():
    made = simulate_walk("short", "ideal", rate_hz=1000.0, magnetometer_rate_hz=0.0)
    made.recording.angular_rate[:] += 1e-7
    _, _, p = reintegrated(made)
    assert np.abs(p - made.truth.position).max() > 0.0003


@pytest.mark.parametrize("gait", GAITS)
def test_nothing_jumps(gait):
    """C2: position, velocity, acceleration, attitude and rate are continuous through heel strikes and footprints."""
    motion = simulate_walk("straight", "ideal", gait=gait, length_m=12, rate_hz=10.0, rest_s=1.0).motion
    largest = {"position": 1e-4, "velocity": 2e-3, "acceleration": 0.35, "attitude": 1e-4, "angular_rate": 8e-3}
    fine, finer = (motion.at(np.arange(0.9, 3.2, step)) for step in (1e-5, 2.5e-6))
    for name, most in largest.items():
        jump, smaller = (np.abs(np.diff(getattr(s, name), axis=0)).max() for s in (fine, finer))
        assert jump < most, name
        assert smaller < 0.3 * jump, name  # what is continuous has a quarter of the step in a quarter of the time


@pytest.mark.parametrize("gait", [name for name in GAITS if GAITS[name].rocking_deg == 0])
def test_a_foot_that_does_not_rock_is_still_to_the_last_digit(gait):
    made = simulate_walk("straight", "ideal", gait=gait, length_m=30, sampling="average")
    # The mean over an interval that lies within one stance.
    still = made.motion.still(made.truth.time - 1 / made.sensor.rate_hz, made.truth.time)
    assert 0.25 < still.mean() < 0.9
    assert not made.recording.angular_rate[still].any()
    assert not made.truth.velocity[still].any()
    force = made.recording.specific_force[still]
    assert (force == force[0]).all()


def test_running_is_a_gait_of_its_own():
    walk, run = (simulate_walk("straight", "ideal", gait=g, rate_hz=200.0) for g in ("walk", "run"))
    speed = [m.motion.along[-1] / (m.motion.edges[-2] - m.motion.edges[1]) for m in (walk, run)]
    assert speed[0] < 1.3 and 2.6 < speed[1] < 3.6
    times = np.diff(run.motion.edges)[1:-1]
    share = times[1::2].sum() / times.sum()
    assert 0.15 < share < 0.3
    peaks = [np.linalg.norm(m.recording.specific_force, axis=1).max() for m in (walk, run)]
    assert peaks[1] > 2 * peaks[0]
    # It rocks as its gait says, and stands still when asked to.
    standing = run.truth.stance == 1
    assert np.abs(run.truth.velocity[standing]).max() > 0.05
    asked = simulate_walk("straight", "ideal", gait="run", rocking_deg=0.0).truth
    assert not asked.velocity[asked.stance == 1].any()


def test_the_gait_changes_along_the_path():
    made = simulate_walk("laps", "ideal", magnetometer_rate_hz=0)
    motion = made.motion
    lap = motion.along[-1] / 3
    stride, when = np.diff(motion.along), (motion.along[:-1] + 1e-6) // lap
    assert [round(float(np.median(stride[when == k])), 1) for k in range(3)] == [1.3, 1.6, 1.3]
    seconds = np.diff(np.interp([0, lap, 2 * lap, 3 * lap], motion.along, motion.edges[0::2]))
    assert seconds[1] < 0.6 * seconds[0]
    # A footprint stands exactly where the gait changes, all of them on the path, and the course is closed.
    assert np.abs(motion.along - 182.0).min() < 1e-9
    np.testing.assert_allclose(motion.footprint[-1], 0, atol=1e-6)
    with pytest.raises(UsageError, match="farther"):
        simulate("straight", gaits=((0, "walk"), (30, "run"), (20, "walk")))
    with pytest.raises(UsageError, match="sprint"):
        simulate("straight", gait="sprint")


def test_strides_differ_and_footprints_stay_on_the_path():
    made = simulate_walk("rectangle", "ideal", seed=4)
    s = made.motion.strides
    for values in (s.pitch, s.clearance, s.sway, s.impact, np.diff(made.motion.edges)[1::2]):
        assert len(np.unique(values)) == len(values)
    path = scaled(made.scenario.waypoints, made.scenario.corner_radius_m, None)
    np.testing.assert_allclose(made.motion.footprint, path.at(made.motion.along)[0], atol=1e-9)
    again, other = (simulate_walk("rectangle", "ideal", seed=k) for k in (4, 5))
    np.testing.assert_array_equal(again.truth.position, made.truth.position)
    assert np.abs(other.motion.edges[:50] - made.motion.edges[:50]).max() > 0
    clones = simulate_walk("straight", "ideal", variation=0, direction_sd_deg=0, sway_m=0).motion
    assert np.ptp(np.diff(clones.along)[1:-1]) < 1e-9
    assert not np.diff(clones.yaw).any()


def test_stairs():
    made = simulate_walk("stairs", "ideal", mounting_deg=(0, 0, 0), magnetometer_rate_hz=0)
    motion, scenario = made.motion, made.scenario
    climbs = motion.strides.climbs
    rise = np.diff(motion.footprint[:, 2])
    # Two treads of 0.17 m a stride, 16 m up and down in 16 flights; level elsewhere, and the foot flat on every tread.
    np.testing.assert_allclose(rise, 0.34 * climbs, atol=1e-12)
    assert (climbs == 1).sum() == (climbs == -1).sum() == 4 * 2 * 5
    assert motion.footprint[:, 2].max() == pytest.approx(13.6)
    np.testing.assert_allclose(motion.footprint[-1], 0, atol=1e-9)
    up = matrix_from_quaternion(made.truth.attitude[made.truth.stance == 1])[:, 2, 2]
    np.testing.assert_allclose(up, 1, atol=1e-12)
    # On the way up neither the sole's toes nor its heel go through a tread.
    path, flights = with_stairs(scaled(scenario.waypoints, scenario.corner_radius_m, None), scenario.stairs, 0.17, scenario.tread_m)
    start = path.at(np.zeros(1))[0][0]
    for flight in flights[: len(flights) // 2]:
        (first, last), _ = path.at(flight.treads[[0, -1]])
        run, n = last[:2] - first[:2], len(flight.treads) - 1
        along = motion.travelled(made.truth.time)
        rows = (along >= flight.treads[0]) & (along <= flight.treads[-1])
        for forward in (-0.13, 0.1):
            sole = made.truth.position[rows] + start + rotate(made.truth.attitude[rows], np.array([forward, 0, -0.08]))
            tread = np.clip(np.round((sole[:, :2] - first[:2]) @ run / (run @ run) * n), 0, n)
            above = sole[:, 2] + 0.08 - first[2] - tread * (last[2] - first[2]) / n
            assert above.min() > -0.005


def test_stairs_that_cannot_be():
    corners = ((0, 0, 0), (3, 0, 2), (9, 0, 2))
    with pytest.raises(UsageError, match="smaller tread_m"):
        simulate(Scenario(waypoints=corners, stairs=(0,)))
    with pytest.raises(UsageError, match="leg 7"):
        simulate(Scenario(waypoints=corners, stairs=(7,)))
    with pytest.raises(UsageError, match="it climbs 0"):
        simulate(Scenario(waypoints=corners, stairs=(1,)))
    # An odd number of steps begins with a single one; a ramp needs no stairs.
    odd = simulate_walk(Scenario(waypoints=((0, 0, 0), (8, 0, 0.51)), stairs=(0,))).motion
    np.testing.assert_allclose(np.unique(np.diff(odd.footprint[:, 2]).round(9)), [0, 0.17, 0.34])
    ramp = simulate_walk(Scenario(waypoints=((0, 0, 0), (8, 0, 0.51)))).motion
    np.testing.assert_allclose(ramp.footprint[:, 2], ramp.footprint[:, 0] * 0.51 / 8, atol=1e-12)


def test_rocking_runs_rock_by_their_angle():
    made = simulate_walk("straight", "ideal", gait="run", rocking_deg=6.0, rate_hz=1000.0, magnetometer_rate_hz=0)
    flat = multiply(quaternion_from_euler(0, 0, 0), quaternion_from_euler(*np.radians(made.scenario.mounting_deg)))
    standing = made.motion.standing(made.truth.time)
    up = rotate(multiply(made.truth.attitude[standing], conjugate(flat)), np.array([0.0, 0, 1]))
    assert np.degrees(np.arccos(np.clip(up[:, 2], -1, 1))).max() == pytest.approx(6, abs=0.01)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario(name):
    made = simulate_walk(name, "ideal", rate_hz=50.0, magnetometer_rate_hz=10.0)
    t = made.truth
    assert np.isfinite(made.recording.specific_force).all() and np.isfinite(made.recording.magnetic_flux_density).all()
    assert (np.diff(made.motion.edges) > 0).all() or name == "still"
    np.testing.assert_allclose(t.position[0], 0, atol=1e-12)
    if name != "straight":
        np.testing.assert_allclose(made.motion.footprint[-1], 0, atol=1e-6)  # closed
    assert made.scenario.name == name


def test_it_moves_like_a_real_shoe(shared_data):
    """Rates, forces and rest of a simulated stride against a walk with a GX5 on the shoe (gsu_gx5 32)."""
    from bematist.io import read

    real = read(shared_data / "foot" / "gsu_gx5" / "SensorConnectData_32.csv")
    walking = (real.time > 10) & (real.time < 60)
    made = simulate("straight", seed=1)
    walked = (made.time > 12) & (made.time < made.time[-1] - 7)
    rate = [np.linalg.norm(r.angular_rate[k], axis=1) for r, k in ((real, walking), (made, walked))]
    force = [np.linalg.norm(r.specific_force[k], axis=1) for r, k in ((real, walking), (made, walked))]
    for q, least, most in ((50, 0.6, 1.4), (90, 0.7, 1.3), (99, 0.8, 1.25)):
        assert least < np.percentile(rate[1], q) / np.percentile(rate[0], q) < most, q
    for q, least, most in ((50, 0.8, 1.2), (90, 0.6, 1.2), (99, 0.5, 1.2)):
        assert least < np.percentile(force[1], q) / np.percentile(force[0], q) < most, q
    assert abs((rate[0] < 0.6).mean() - (rate[1] < 0.6).mean()) < 0.12


def test_it_runs_like_a_real_runner(shared_data):
    """Rates and forces of a simulated jog between two recordings of runners with a GX5 on the shoe, with some room."""
    from bematist.io import read

    files = ("2017-11-27-11-18-11", "2017-12-15-18-01-18")
    recordings = [read(shared_data / "foot" / "pyshoe_vicon" / f"{name}.mat") for name in files]
    recordings.append(simulate("straight", gait="jog", rate_hz=200))
    rates, forces = [], []
    for r in recordings:
        w, f = np.linalg.norm(r.angular_rate, axis=1), np.linalg.norm(r.specific_force, axis=1)
        running = np.convolve(w > 2, np.ones(300) / 300, "same") > 0.5
        rates.append(np.percentile(w[running], [50, 90, 99]))
        forces.append(np.percentile(f[running], [50, 90, 99]))
    for values, least, most in ((rates, 0.7, 1.25), (forces, 0.7, 1.25)):
        assert (values[2] > least * np.minimum(*values[:2])).all() and (values[2] < most * np.maximum(*values[:2])).all()
