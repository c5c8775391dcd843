"""The attitude filters: against their twin, in pieces, over gaps, without sensors, and on turns whose truth is known."""

import pickle

import numpy as np
import pytest

import bematist as bm
import twin_ahrs as twin
from bematist import frames
from bematist.ahrs import FILTERS, Ahrs, find_filter
from bematist.kernels import attitude as kernel
from walks import FIELD, shaken

CASES = {
    "gyro": {},
    "mahony": {"kp": 0.9, "ki": 0.05},
    "madgwick": {"beta": 0.1},
    "madgwick with offset": {"beta": 0.1, "zeta": 0.02},
}

OWN = [name for name, f in FILTERS.items() if f.make is Ahrs]
"""The handheld filters have tests of their own."""


def made(case, **changes):
    return find_filter(case.split()[0]).parameters.override(CASES[case]).override(changes)


def turning(n=6000, rate=100.0, seed=0, gyro_bias=(0.01, -0.02, 0.015), noise=0.01):
    """A sensor that rests for 5 s and then turns about changing axes, in place; recording and true attitudes (n,4)."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) / rate
    w = np.sin(t[:, None] * [0.7, 1.1, 0.5] + np.array([0.3, 1.0, 2.0])) * [1.2, 0.9, 1.5]
    w[t < 5] = 0
    q = [frames.quaternion_from_euler(0.2, -0.1, 0.8)]
    for k in range(1, n):
        q.append(frames.multiply(q[-1], frames.quaternion_from_rotation_vector(w[k] / rate)))
    q = np.array(q)
    C = frames.matrix_from_quaternion(q)
    f = np.einsum("kji,j->ki", C, [0, 0, 9.80665]) + rng.normal(0, noise, (n, 3))
    m = np.einsum("kji,j->ki", C, [0.0, 20.0, -45.0]) + rng.normal(0, 10 * noise, (n, 3))
    return bm.Recording(time=t, specific_force=f, angular_rate=w + gyro_bias, magnetic_time=t, magnetic_flux_density=m), q


def apart(p, q):
    """Angles between attitudes, rad."""
    return np.linalg.norm(frames.rotation_vector_from_quaternion(frames.multiply(p, frames.conjugate(q))), axis=1)


@pytest.mark.parametrize("integration", ["exact", "first-order"])
@pytest.mark.parametrize("magnetometer", [True, False])
@pytest.mark.parametrize("case", CASES)
def test_filters_equal_their_twin(case, magnetometer, integration):
    p = made(case, magnetometer=magnetometer, integration=integration)
    r = shaken(2500)
    ahrs = Ahrs(p)
    got = ahrs.run(r)
    q, b = twin.run(
        r, ahrs.alignment.attitude, ahrs.alignment.gyro_bias, case.split()[0], *p.gains, integration == "exact", (0, 1), magnetometer
    )
    np.testing.assert_allclose(got.attitude, q, atol=1e-11)
    np.testing.assert_allclose(got.gyro_bias, b, atol=1e-11)
    assert apart(got.attitude, q[:1]).max() > 0.3
    assert (np.ptp(got.gyro_bias, 0).max() > 1e-3) == (p.gains[1] > 0)


def test_mahonys_pull_does_not_depend_on_the_magnetometers_rate():
    """An offset of the gyroscope is held off by the field; by how much, is the same with a sample in every row and in every twelfth."""
    r, truth = turning(n=9000, rate=240, noise=0)
    w = r.angular_rate.copy()
    w[2000:] += [0, 0, 0.02]
    off = {}
    for every in (1, 3, 12):
        few = r.replace(angular_rate=w, magnetic_time=r.time[::every], magnetic_flux_density=r.magnetic_flux_density[::every])
        off[every] = apart(bm.attitude(few, filter="mahony", kp=1.0, ki=0.0).attitude[-4000:], truth[-4000:]).mean()
    assert off[3] == pytest.approx(off[1], rel=0.1) and off[12] == pytest.approx(off[1], rel=0.3), off


@pytest.mark.parametrize("case", CASES)
def test_every_cutting_gives_the_same_bits(case):
    r = shaken(2600)
    lost = r.specific_force.copy(), r.angular_rate.copy()
    lost[0][2300:2310] = np.nan
    lost[1][2200:2203] = np.nan
    lost[1][2400:2420] = np.nan
    r = r.replace(specific_force=lost[0], angular_rate=lost[1], time=r.time + 0.2 * (np.arange(len(r)) > 2500))
    p = made(case)
    whole = Ahrs(p).run(r)
    for size in (1, 7, 1000):
        live = Ahrs(p)
        pieces = []
        for rows in r.chunks(size):
            pieces.append(live.update(rows))
            if live.alignment is not None and size == 7:
                live = Ahrs.restore(pickle.loads(pickle.dumps(live.save())))
        pieces.append(live.finish())
        np.testing.assert_array_equal(np.concatenate([x.attitude for x in pieces]), whole.attitude)
        np.testing.assert_array_equal(np.concatenate([x.gyro_bias for x in pieces]), whole.gyro_bias)
        np.testing.assert_array_equal(np.concatenate([x.time for x in pieces]), whole.time)
    again = Ahrs(p).run(r, chunk=13)
    np.testing.assert_array_equal(again.attitude, whole.attitude)


@pytest.mark.parametrize("name", FILTERS)
def test_a_known_turning_is_recovered(name):
    r, true = turning()
    found = bm.attitude(r, name)
    error = bm.evaluate_attitude(found, bm.Reference(time=r.time, position=np.full((len(r), 3), np.nan), attitude=true)).error
    assert np.degrees(error.total) < 1.0, error
    assert found.north == "magnetic" and not found.warnings


@pytest.mark.parametrize(("name", "gains"), [("mahony", {"kp": 0.5, "ki": 0.05}), ("madgwick", {"zeta": 0.01})])
def test_the_gyroscopes_offset_is_found(name, gains):
    """Without the rest telling it. A filter that does not estimate it is off by a lasting error."""
    r, true = turning(20_000, gyro_bias=(0.02, -0.03, 0.025))
    blind = {"initial": {"gyro_bias_sd": 0.0}}
    found = bm.attitude(r, name, **gains, **blind)
    np.testing.assert_allclose(found.gyro_bias[-1], [0.02, -0.03, 0.025], atol=0.004)
    without = bm.attitude(r, name, **dict.fromkeys(["ki" if name == "mahony" else "zeta"], 0.0), **blind)
    assert not without.gyro_bias.any()
    if name == "mahony":  # Madgwick's step is longer than this offset turns between two samples
        late = r.time > 150
        assert np.median(apart(found.attitude, true)[late]) < 0.5 * np.median(apart(without.attitude, true)[late])


def test_fast_turns_need_the_exact_integration():
    n = 3000
    t = np.arange(n) / 100
    w = np.where(t[:, None] > 5, [0, 0, 15.0], 0.0)
    f = np.tile([0, 0, 9.8], (n, 1))
    r = bm.Recording(time=t, specific_force=f, angular_rate=w)
    lost = {}
    for integration in ("exact", "first-order"):
        q = bm.attitude(r, "gyro", integration=integration, gravity=9.8).attitude
        turned = np.unwrap(frames.euler_from_quaternion(q)[:, 2])[-1] - w[:, 2].sum() / 100
        lost[integration] = turned / (w[:, 2].sum() / 100)
    assert abs(lost["exact"]) < 1e-12
    np.testing.assert_allclose(lost["first-order"], 2 * np.arctan(0.075) / 0.15 - 1, rtol=1e-6)


@pytest.mark.parametrize("name", OWN)
def test_a_long_gap_holds_and_a_short_one_is_turned_over(name):
    r, true = turning()
    cut = np.r_[0:3000, 3020:5000]  # 0.2 s
    part = r.replace(
        time=r.time[cut],
        specific_force=r.specific_force[cut],
        angular_rate=r.angular_rate[cut],
        magnetic_time=r.time[cut],
        magnetic_flux_density=r.magnetic_flux_density[cut],
    )
    short = bm.attitude(part, name)
    assert "1 gap(s)" in short.warnings[0]
    assert short.diagnostics["bridged"][3000] == kernel.BRIDGED
    assert apart(short.attitude, true[cut])[3000:].max() < np.radians(3)
    cut = np.r_[0:3000, 3050:6000]
    part = part.replace(
        time=r.time[cut],
        specific_force=r.specific_force[cut],
        angular_rate=r.angular_rate[cut],
        magnetic_time=r.time[cut],
        magnetic_flux_density=r.magnetic_flux_density[cut],
    )
    long = bm.attitude(part, name)
    np.testing.assert_allclose(long.attitude[3000], long.attitude[2999], atol=1e-15)
    if name != "gyro":  # gravity and field bring it back
        assert apart(long.attitude, true[cut])[-500:].max() < 0.3 * apart(long.attitude, true[cut])[3000]


@pytest.mark.parametrize("name", OWN)
def test_missing_values_are_ordinary(name):
    r, true = turning()
    f, w, m = r.specific_force.copy(), r.angular_rate.copy(), r.magnetic_flux_density.copy()
    f[::3] = np.nan
    w[2000:2002] = np.nan
    m[1000:4000] = np.nan
    found = bm.attitude(r.replace(specific_force=f, angular_rate=w, magnetic_flux_density=m), name)
    assert np.isfinite(found.attitude).all()
    assert any("2 of 6000 samples had no angular rate: the last one was held" in x for x in found.warnings)
    assert apart(found.attitude, true).max() < np.radians(4)
    w[2100:2300] = np.nan
    found = bm.attitude(r.replace(angular_rate=w), name)
    assert any("nothing was turned" in x for x in found.warnings)
    # Of 200 samples the first ones are held for the time of a gap.
    assert (found.diagnostics["bridged"] == kernel.MISSING).sum() == 200 - round(max(0.02, 3.5 / 100) * 100 - 0.5)


def test_without_a_magnetometer_x_starts_along_east_and_heading_is_in_doubt():
    r, _ = turning()
    r = r.replace(magnetic_time=np.empty(0), magnetic_flux_density=np.empty((0, 3)))
    found = bm.attitude(r)
    assert found.north == "none" and abs(found.heading_deg[0] - 90) < 0.1
    assert any("no magnetometer" in x for x in found.warnings)


def test_a_given_heading_tells_where_the_field_points():
    """With the heading given, the field at the start is the direction that is held."""
    r, true = turning()
    turned = frames.multiply(frames.quaternion_from_rotation_vector([0, 0, np.radians(-25.0)]), true)
    heading = float(frames.heading_deg_from_yaw(frames.euler_from_quaternion(turned[0])[2]))
    found = bm.attitude(r, "mahony", initial={"heading_deg": heading})
    assert found.north == "given"
    assert apart(found.attitude, turned).max() < np.radians(2)
    c, s = np.cos(np.radians(25)), np.sin(np.radians(25))
    field = (20.0 * s, 20.0 * c, -45.0)
    found = bm.attitude(r, "mahony", initial={"earth_field": field})
    assert apart(found.attitude, turned).max() < np.radians(2)


def test_rows_out_of_order_are_dropped_and_counted():
    r = shaken(2500)
    rows = r.samples()
    rows[2100, 0] = rows[2000, 0]
    ahrs = Ahrs()
    found = ahrs.update(rows)
    assert len(found) == 2499 and any("1 sample(s)" in x for x in ahrs.warnings)
    with pytest.raises(bm.UsageError, match="ten numbers"):
        ahrs.update(rows[:, :9])
    ahrs.finish()
    with pytest.raises(bm.UsageError, match="a new Ahrs"):
        ahrs.update(rows)


def test_result_describes_itself():
    r = shaken(2500)
    found = bm.attitude(r, "madgwick", beta=0.2, initial={"longest_s": 5.0})
    assert found.parameters["beta"] == 0.2 and found.parameters["initial"]["longest_s"] == 5
    table = found.to_polars()
    assert table.columns[:5] == ["time", "qw", "qx", "qy", "qz"] and len(table) == len(r)
    np.testing.assert_allclose(np.radians(table["pitch_deg"].to_numpy()), found.pitch)
    assert found.summary()["filter"] == "madgwick" and abs(FIELD @ [0, 1, 0]) > 0
    assert "madgwick" in repr(found)


def test_unknown_names_and_nothing():
    with pytest.raises(bm.UsageError, match='Did you mean "madgwick"'):
        bm.attitude(shaken(300), "madgwik")
    with pytest.raises(bm.UsageError, match="beta"):
        bm.attitude(shaken(300), "madgwick", betta=1)
    with pytest.raises(bm.UsageError, match="takes a Recording"):
        bm.attitude("walk.csv")
    empty = bm.Recording(time=np.empty(0), specific_force=np.empty((0, 3)), angular_rate=np.empty((0, 3)))
    with pytest.raises(bm.DataError, match="0 sample"):
        bm.attitude(empty)


def test_a_page_from_python(tmp_path):
    r, truth = turning(1500)
    reference = bm.Reference(time=r.time, position=np.full((len(r), 3), np.nan), attitude=truth)
    found = bm.attitude(r, "mahony")
    found.report(tmp_path / "a.html")
    plain = (tmp_path / "a.html").read_text("utf-8")
    found.report(tmp_path / "b.html", reference, align="yaw")
    judged = (tmp_path / "b.html").read_text("utf-8")
    assert "Heading" in plain and "rms [yaw]" not in plain and "rms [yaw]" in judged


def test_compiling_is_no_processing():
    import time

    from bematist.kernels.jit import kernel, stopwatch

    def fresh(x):
        return x + 1.0

    made_now = kernel(fresh)
    made_now.enable_caching = False
    with stopwatch() as seconds:
        started = time.perf_counter()
        assert made_now(1.0) == 2.0
        compiled = time.perf_counter() - started
        time.sleep(0.05)
        assert 0.04 < seconds() < 0.05 + 0.5 * compiled
