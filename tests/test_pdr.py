"""The path of a hand: against its plain twin, on walks whose truth is known, and with bad input."""

import numpy as np
import pytest

import bematist as bm
import twin_pdr
from bematist.frames import multiply, quaternion_from_euler, quaternion_from_rotation_vector, rotate
from bematist.hand import HandAttitude, HandPdr, HandPdrParameters
from bematist.hand.path_setup import kernel_parameters, workspace
from bematist.kernels import barometer, pdr, pdr_ahead
from bematist.kernels import pdr_layout as at
from bematist.kernels import steps_layout as detector
from bematist.simulate import simulate_hand
from bematist.steps import CARRYING
from bematist.steps import kernel_parameters as detector_parameters
from bematist.steps import workspace as detector_workspace
from handheld import held

HELD = held(6000)
P = bm.METHODS["hand"].parameters
PRM = {
    **{name: getattr(P.step_length, name) for name in ("height", "a", "b", "c", "running_factor", "tread", "sd", "scale_sd")},
    "direction_sd": P.direction.sd,
    "direction_s": P.direction.time_s,
    "step_sd": P.direction.step_sd,
    "heading_s": P.direction.heading_time_s,
}


# -- against the twin ----------------------------------------------------------------------------------------------------


def test_the_path_of_the_kernel_is_the_twins():
    t = bm.track(HELD, "hand", step_length={"pendulum": 0.0})
    twin = twin_pdr.Path(PRM)
    variance = heading_variance(t)
    assert len(t.steps) > 30
    for k in range(len(t.steps)):
        s = twin_pdr.step_length(PRM, t.steps.frequency[k], t.steps.motion[k])
        assert s == pytest.approx(t.steps.length[k], rel=1e-12)
        twin.step(t.steps.time[k], s, t.steps.direction[k], variance(t.steps.time[k]))
    np.testing.assert_allclose(t.position[-1, :2], twin.p, rtol=1e-9)
    P = t.covariance[-1, :2, :2].copy()
    u = np.array([np.cos(t.steps.direction[-1]), np.sin(t.steps.direction[-1])])
    P -= t.steps.length[-1] ** 2 * (pdr.LAG * np.outer(u, u) if t.diagnostics["step_frequency"][-1] > 0 else np.eye(2) / 12)
    sds = np.sqrt(np.diag(P))
    # The heading's variance is kept every 40 ms only; the mixed element, a difference of what the legs add, to that of the variances.
    np.testing.assert_allclose(P / np.outer(sds, sds), twin.P[:2, :2] / np.outer(sds, sds), atol=2e-3)


def heading_variance(t):
    """Variance of the heading of the y axis (levelled) over time."""
    d = rotate(t.attitude, np.tile([0.0, 1.0, 0.0], (len(t), 1)))
    k = d[:, 2] / (d[:, 0] ** 2 + d[:, 1] ** 2)
    J = np.stack([-k * d[:, 0], -k * d[:, 1], np.ones(len(t))], 1)
    v = np.einsum("ni,nij,nj->n", J, t.attitude_covariance, J)
    return lambda when: np.interp(when, t.time, v)


def test_the_gradient_of_the_heading_is_its_derivative():
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = quaternion_from_euler(*rng.uniform(-1, 1, 3))
        d = rotate(q, np.array([0.0, 1.0, 0.0]))
        g = np.array(pdr_ahead.heading_gradient(*d))
        for i in range(3):
            psi = np.zeros(3)
            psi[i] = 1e-6
            turned = rotate(multiply(quaternion_from_rotation_vector(psi), q), np.array([0.0, 1.0, 0.0]))
            change = np.arctan2(turned[1], turned[0]) - np.arctan2(d[1], d[0])
            assert change / 1e-6 == pytest.approx(g[i], abs=1e-5)


def test_the_jacobian_of_a_step_is_its_derivative():
    """The covariance that a step makes of a unit matrix is J Jᵀ, with J by finite differences of the plain step."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        s, theta = rng.uniform(0.3, 1.0), rng.uniform(-3, 3)
        J = np.stack([(twin_pdr.moved(h, s, theta) - twin_pdr.moved(-h, s, theta)) / 2e-6 for h in 1e-6 * np.eye(5)], 1)
        W = workspace(P)
        W[: at.WIDTH**2] = np.eye(at.WIDTH).ravel()
        prm = np.zeros(at.PARAMETERS)
        pdr.add_step(W, prm, s, np.cos(theta), np.sin(theta))
        np.testing.assert_allclose(W[: at.WIDTH**2].reshape(5, 5), J @ J.T, atol=1e-8)


def test_the_height_of_the_kernel_is_the_twins():
    keep = np.isfinite(HELD.pressure)
    a = P.altitude
    twin = twin_pdr.heights(HELD.pressure_time[keep], HELD.pressure[keep], a.sd, a.walk, a.climb, a.temperature_c + 273.15)
    W, prm = workspace(P), kernel_parameters(P, 0.1)
    for k, (t, pressure) in enumerate(zip(HELD.pressure_time, HELD.pressure, strict=True)):
        barometer.measure_height(W, prm, t, pressure)
        assert (W[at.UP], W[at.P_HEIGHT]) == pytest.approx(tuple(twin[k]), rel=1e-9, abs=1e-12)


def test_the_barometric_formula_is_the_standard_atmosphere():
    assert barometer.height_of(89874.6, 101325.0, 288.15) == pytest.approx(1000.0, abs=0.3)


def test_a_heading_that_an_offset_turns_grows_as_one_error():
    """Heading error b t at steps one second apart: across the way the position's error is b times the sum of the times."""
    prm = kernel_parameters(P.override({"direction": {"sd": 0.0, "step_sd": 0.0, "heading_time_s": np.inf}}), 0.1)
    W, b = workspace(P), 1e-3
    W[: at.WIDTH**2] = 0.0
    for k in range(1, 61):
        pdr.correlated(W, prm, 1.0, (b * k) ** 2, 0.0)
        pdr.add_step(W, prm, 1.0, 1.0, 0.0)
    across = W[at.P + (at.WIDTH + 1) * at.E_NORTH]
    assert np.sqrt(across) == pytest.approx(b * 60 * 61 / 2, rel=1e-9)


def test_on_stairs_the_vertical_speed_is_unsure():
    W, S, nav = workspace(P), detector_workspace(), np.zeros((2, at.NAV))
    for k, motion in enumerate((detector.WALKING, detector.STAIRS)):
        S[detector.MOTION] = motion
        pdr.write(W, kernel_parameters(P, 0.1), S, detector_parameters(P.steps), 1.0, np.zeros((2, 11)), nav, k)
    assert np.sqrt(nav[0, 22]) == pytest.approx(P.sway_speed) and 0.3 < np.sqrt(nav[1, 22]) < 0.4


def ahead_of(q, carrying="texting"):
    """Direction ahead (rad) of the kernel at an attitude."""
    W = workspace(P)
    W[at.NOW + at.R_Q : at.NOW + at.R_Q + 4] = q
    e, n, _ = pdr_ahead.look_ahead(W, kernel_parameters(P, 0.1), at.NOW, CARRYING.index(carrying))
    return np.arctan2(n, e)


def test_ahead_of_a_raised_phone_is_its_back():
    for pitch, yaw in ((0.0, 0.3), (60.0, 1.0), (89.0, -2.0), (91.0, 2.0), (-85.0, 0.5)):
        q = multiply(quaternion_from_euler(0.0, 0.0, yaw - np.pi / 2), quaternion_from_euler(np.radians(pitch), 0.0, 0.0))
        assert ahead_of(q) == pytest.approx(yaw, abs=1e-9)


@pytest.mark.parametrize("carry", ["phoning", "bag"])
def test_ahead_of_a_device_on_its_edge_goes_on(carry):
    """-x ahead and y up, tilted about the axis to the right, -z, until -x is steep: ahead stays West."""
    upright = quaternion_from_euler(np.pi / 2, 0.0, 0.0)  # y up, x East, z South
    np.testing.assert_allclose(rotate(upright, np.eye(3)), [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-12)
    for tilt in np.radians([0.0, 40.0, 65.0, 80.0, -65.0, -80.0]):
        q = multiply(quaternion_from_rotation_vector(np.array([0.0, tilt, 0.0])), upright)
        assert abs(ahead_of(q, carry)) == pytest.approx(np.pi, abs=1e-9)


def test_the_attitude_is_that_of_the_filter():
    """Bit for bit: steps and path change nothing in it."""
    alone = HandAttitude(bm.FILTERS["hand"].parameters).run(HELD)
    np.testing.assert_array_equal(alone.attitude, bm.track(HELD, "hand").attitude)


# -- walks whose truth is known ------------------------------------------------------------------------------------------


def walks(n, **changes):
    """Simulated walkers whose steps and hands differ from the published ones as the parameters say."""
    rng = np.random.default_rng(7)
    for seed in range(n):
        k = 1 + P.step_length.scale_sd * rng.standard_normal()
        own = {"step_a": P.step_length.a * k, "step_b": P.step_length.b * k, "step_c": P.step_length.c * k}
        turned = {"misalignment_sd_deg": np.degrees(P.direction.sd)}
        yield simulate_hand("short", "texting", "phone", seed=seed, **{**own, **turned, "length_m": 120.0, **changes})


def test_the_position_is_as_sure_as_it_says():
    """NEES in the plan at four times of 24 walks; the simulated hand keeps its angle, so that the direction's error is a constant."""
    nees, height = [], []
    for made in walks(24):
        t = bm.track(made.recording, "hand", direction={"time_s": np.inf})
        error = t.position - made.recording.reference.position
        for share in (0.25, 0.5, 0.75, 0.999):
            k = int(share * len(t))
            nees.append(error[k, :2] @ np.linalg.solve(t.covariance[k, :2, :2], error[k, :2]))
        height.append(error[-1, 2] / t.position_sd[-1, 2])
    assert 0.8 < np.mean(nees) < 3.5  # 2 expected
    assert np.mean(np.array(nees) > 13.8) < 0.03  # a thousandth expected
    assert np.sqrt(np.mean(np.square(height))) < 1.5


def test_a_walker_of_the_model_arrives():
    made = simulate_hand("short", "texting", "phone", seed=3, length_m=200.0)
    t = bm.track(made.recording, "hand")
    assert abs(len(t.steps) - len(made.steps.time)) <= 2
    assert t.distance_m == pytest.approx(200, rel=0.02)
    assert bm.evaluate(t, made.recording.reference, align="origin").ate_plan_m < 6
    assert t.summary()["steps"] == len(t.steps) == int(t.diagnostics["steps_counted"].sum())
    turns = np.angle(np.exp(1j * (t.steps.direction - made.direction_at(t.steps.time))))
    assert np.abs(np.median(turns)) < np.radians(6)


@pytest.mark.parametrize(("carry", "axis"), [("phoning", "-x"), ("swinging", "y"), ("pocket", "z"), ("bag", "-x")])
def test_each_way_of_carrying_has_its_axis(carry, axis):
    made = simulate_hand("short", carry, "phone", seed=1, length_m=60.0)
    t = bm.track(made.recording, "hand")
    assert getattr(P.direction, carry) == axis
    assert (t.steps.carrying == carry).mean() > 0.9
    turns = np.angle(np.exp(1j * (t.steps.direction - made.direction_at(t.steps.time))))
    assert np.abs(np.median(turns)) < np.radians(12)
    assert np.abs(turns[:4]).max() < np.radians(35)  # the first steps are counted when it is known how the device is carried


def test_before_the_first_walk_is_recognised_the_position_is_unsure():
    """The body is metres away while its first steps wait to be counted, at every beginning of a walk."""
    worst = []
    for made in walks(6):
        t = bm.track(made.recording, "hand")
        waits = t.time < t.steps.counted[0]
        error = (t.position - made.recording.reference.position)[waits, :2]
        assert np.linalg.norm(error[-1]) > 1 and not t.position[waits, :2].any()
        nees = (error * np.linalg.solve(t.covariance[waits, :2, :2], error[..., None])[..., 0]).sum(1)
        worst.append(nees.max())
        assert t.position_sd[0, 0] < 0.3
    assert np.mean(worst) < 5 and max(worst) < 13.8


def test_the_position_between_steps_is_as_far_off_as_it_says():
    """How far the body is ahead of where it was at the last counted step: what is added for it is no less, and not twice as much."""
    lag = []
    for seed in range(6):
        made = simulate_hand("straight", "texting", "phone", seed=seed, length_m=40.0)
        t = bm.track(made.recording, "hand")
        k = np.searchsorted(t.time, np.linspace(t.steps.counted[4], t.steps.counted[-1], 400)[:-1])
        last = np.searchsorted(t.steps.counted, t.time[k], side="right") - 1
        true = made.recording.reference.position
        at_step = np.stack([np.interp(t.steps.time, made.recording.reference.time, p) for p in true.T], 1)
        lag.append(np.mean(np.square(np.linalg.norm(true[k, :2] - at_step[last, :2], axis=1) / t.steps.length[last])))
    assert 0.5 * pdr.LAG < np.mean(lag) < pdr.LAG


def test_stairs_and_a_slope_have_their_height():
    slope = held(6000)
    t = bm.track(slope, "hand")
    assert t.position[-1, 2] == pytest.approx(0.1 * (t.time[-1] - 6), abs=0.4)
    flat = bm.track(slope.replace(pressure_time=[], pressure=[]), "hand")
    assert not flat.position[:, 2].any() and flat.position_sd[-1, 2] > 0.3
    without = bm.track(slope, "hand", altitude={"barometer": False})  # the pressure still tells stairs from level ground
    assert not without.position[:, 2].any()


# -- choices -------------------------------------------------------------------------------------------------------------


def test_without_north_the_path_starts_along_east():
    made = simulate_hand("straight", "texting", "phone", seed=0)
    blind = made.recording.replace(magnetic_time=[], magnetic_flux_density=np.empty((0, 3)))
    t = bm.track(blind, "hand")
    assert np.abs(t.steps.direction[:10]).max() < np.radians(15)
    south = bm.track(blind, "hand", initial={"heading_deg": 180.0})
    assert np.abs(np.angle(np.exp(1j * (south.steps.direction[:10] + np.pi / 2)))).max() < np.radians(15)


def test_a_heading_is_that_of_the_way_of_carrying():
    """Without saying how the device is carried the whole path is turned, and that is said; with it the path goes where it should."""
    made = simulate_hand("straight", "pocket", "phone", seed=0, length_m=40.0)
    blind = made.recording.replace(magnetic_time=[], magnetic_flux_density=np.empty((0, 3)))
    east = bm.track(blind, "hand", direction={"first": "pocket"}, initial={"heading_deg": 90.0})
    assert np.abs(east.steps.direction[:10]).max() < np.radians(25)
    assert not any("direction.first" in w for w in east.warnings)
    unsaid = bm.track(blind, "hand", initial={"heading_deg": 90.0})
    assert np.abs(unsaid.steps.direction[:10]).max() > np.radians(60)
    assert any('direction.first = "pocket"' in w for w in unsaid.warnings)


def test_a_taller_walker_and_an_offset():
    t = bm.track(HELD, "magyq")
    tall = bm.track(HELD, "magyq", step_length={"height": 1.95})
    level = t.steps.motion == "walking"  # the slope is now and then taken for stairs, whose treads are the same for all
    longer = np.where(level, 0.2 * (P.step_length.a * t.steps.frequency + P.step_length.b), 0.0)
    assert level.mean() > 0.7
    np.testing.assert_allclose(tall.steps.length - t.steps.length, longer, rtol=1e-9)
    left = bm.track(HELD, "magyq", direction={"offset": 0.5})
    np.testing.assert_allclose(np.angle(np.exp(1j * (left.steps.direction - t.steps.direction))), 0.5, atol=1e-9)


def test_the_bounce_tells_the_length_of_a_pendulum():
    """A step of the amplitude that an inverted pendulum has at its length comes out at that length, whatever eq 47 says."""
    prm = kernel_parameters(P.override({"step_length": {"pendulum": 1.0}}), 0.1)
    leg = 0.53 * P.step_length.height
    for s, f in ((0.3, 1.2), (0.7, 1.8), (0.9, 2.1)):
        size = (2 * np.pi * f) ** 2 * s**2 / (16 * leg)
        assert pdr.step_length(prm, f, size, 1.0, 0.0) == pytest.approx(s)
    half = kernel_parameters(P, 0.1)
    eq47 = twin_pdr.step_length(PRM, 1.8, "walking")
    size = (2 * np.pi * 1.8) ** 2 * 0.5**2 / (16 * leg)
    assert pdr.step_length(half, 1.8, size, 1.0, 0.0) == pytest.approx(np.sqrt(0.5 * eq47))
    assert pdr.step_length(half, 1.8, size, 1.0, 2.0) == pytest.approx(eq47)  # swinging


def test_rows_may_leave_out_the_pressure():
    own, ten = HandPdr(P), HandPdr(P)
    a = own.update(HELD.replace(pressure_time=[], pressure=[]).samples(pressure=True))
    b = ten.update(HELD.samples())
    np.testing.assert_array_equal(a.position, b.position)
    with pytest.raises(bm.UsageError, match=r"\(n,10\)"):
        ten.update(np.zeros((3, 12)))


# -- bad input -----------------------------------------------------------------------------------------------------------


def test_no_steps_are_said():
    n = 3000
    rng = np.random.default_rng(0)
    still = bm.Recording(
        time=np.arange(n) / 100,
        specific_force=np.tile([0, 0, 9.8], (n, 1)) + rng.normal(0, 0.02, (n, 3)),
        angular_rate=rng.normal(0, 1e-3, (n, 3)),
    )
    t = bm.track(still, "hand")
    assert not t.position[:, :2].any() and t.distance_m == 0 and t.summary()["steps"] == 0
    assert any("No step" in w for w in t.warnings)
    assert t.steps.to_polars().is_empty()


def test_a_shoe_is_no_hand():
    force, rate = HELD.specific_force.copy(), HELD.angular_rate.copy()
    force[50::120, 2], rate[80::120, 0] = 45.0, 8.0
    shoe = HELD.replace(specific_force=force, angular_rate=rate)
    assert any("-m foot" in w for w in bm.track(shoe, "hand").warnings)
    assert not any("-m foot" in w for w in bm.track(HELD, "hand").warnings)


@pytest.mark.parametrize("method", ["quest", "magyq", "hand"])
def test_a_missing_magnetometer_is_said(method):
    without = HELD.replace(magnetic_time=[], magnetic_flux_density=np.empty((0, 3)))
    assert any("no magnetometer" in w for w in bm.track(without, method).warnings)
    assert not any("no magnetometer" in w for w in bm.track(without, "gyint").warnings)


@pytest.mark.parametrize("n", [2, 3, 20, 200])
def test_a_very_short_recording(n):
    r = HELD.replace(time=HELD.time[:n], specific_force=HELD.specific_force[:n], angular_rate=HELD.angular_rate[:n], reference=None)
    t = bm.track(r, "hand")
    assert len(t) == n and np.isfinite(t.position).all() and np.isfinite(t.packed_covariance).all()


def test_gaps_end_no_path():
    keep = np.ones(6000, bool)
    keep[3000:3400] = False
    r = HELD.replace(time=HELD.time[keep], specific_force=HELD.specific_force[keep], angular_rate=HELD.angular_rate[keep], reference=None)
    t = bm.track(r, "hand")
    assert np.isfinite(t.position).all()
    assert any("gap" in w and "path" in w for w in t.warnings)
    assert len(bm.track(HELD, "hand").steps) - len(t.steps) in range(2, 10)


def test_parameters_are_those_of_the_method():
    changed = {"attitude": P.attitude.model_dump(), "heading_sd": P.heading_sd, "step_length": {"pendulum": 0.5}}
    assert HandPdrParameters().override(changed) == P


def test_a_height_that_nothing_told_is_left_out(tmp_path):
    from bematist.cli.track import summary_facts
    from bematist.report import still_path

    flat = bm.track(HELD.replace(pressure_time=[], pressure=[]), "hand")
    climbing = bm.track(HELD, "hand")
    assert climbing.has_height and not flat.has_height and not flat.placed((1.0, 2.0, 3.0)).has_height
    told = [dict(summary_facts(t.summary(), t)) for t in (climbing, flat)]
    assert "height change" in told[0] and " up at" in told[0]["sure to"]
    assert "height change" not in told[1] and "barometer" in told[1]["height"] and " up at" not in told[1]["sure to"]
    pages = []
    for k, t in enumerate((climbing, flat)):
        t.report(tmp_path / f"{k}.html")
        still_path([t], tmp_path / f"{k}.png")
        pages.append((tmp_path / f"{k}.html").read_text())
    late = (flat.steps.counted - flat.steps.time).max()
    assert late > 1.5 and all(f"up to {late:.1f} s late: until then the path stands still" in page for page in pages)
    assert "height (m)" in pages[0] and "height (m)" not in pages[1]
    assert "no barometer told it" not in pages[0] and "no barometer told it" in pages[1]
