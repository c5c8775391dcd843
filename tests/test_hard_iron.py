"""Hard iron while walking: against its twin, on sensors whose hard iron is known, and where there is none."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import bematist as bm
import handheld
from bematist.hand import HAND, HandAttitude
from bematist.hard_iron import begin, set_parameters
from bematist.kernels import hard_iron as kernel
from bematist.kernels import hard_iron_layout as at
from bematist.kernels.jit import kernel as compiled
from bematist.recording import Recording
from bematist.simulate import simulate_walk
from bematist.simulate.parameters import SENSORS
from bematist.updates import HardIronParameters
from twin_hard_iron import Twin
from walks import shaken

B = np.array([8.0, -12.0, 6.0])


@compiled
def follow(S, prm, rows, moving, out):
    """Rows t, w, m of (N,7), through the kernel; each row's diagnostics."""
    for k in range(rows.shape[0]):
        t, w0, w1, w2, m0, m1, m2 = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4], rows[k, 5], rows[k, 6]
        dt = t - rows[k - 1, 0] if k else 0.0
        closed = kernel.step(S, 0, prm, 0, t, dt, w0, w1, w2, m0, m1, m2, moving[k], False, False)
        kernel.tell(S, 0, closed, out, k, 0)


def followed(p, rows, moving=None):
    """Diagnostics (N,12) of rows (N,7), and the covariance (3,3) of the hard iron at the end."""
    S, prm, out = np.zeros(at.SIZE), np.zeros(at.PARAMETERS), np.empty((len(rows), at.COLUMNS))
    set_parameters(prm, 0, p, np.zeros((3, 3)))
    begin(S, 0, p, rows[0, 0])
    follow(S, prm, rows, np.ones(len(rows), bool) if moving is None else moving, out)
    return out, S[at.P : at.P + 36].reshape(6, 6)[3:, 3:]


def turned(seed, seconds=60.0, b=B, field_walk=1.0, sd=0.5, jumps=(), rate=50.0):
    """Rows t, w, m of a sensor that turns as it likes, in a field that walks as the filter has it, and jumps at times (s)."""
    rng = np.random.default_rng(seed)
    n = int(seconds * rate)
    t = np.arange(n) / rate
    phase, speed = rng.uniform(0, 6, (2, 3))
    w = 0.6 * np.sin(t[:, None] * (0.3 + 0.1 * speed) + phase) + rng.normal(0, 0.2, 3)
    F = np.array([3.0, 20.0, -42.0]) + np.cumsum(rng.normal(0, np.sqrt((field_walk**2 + 0.1**2) / rate), (n, 3)), axis=0)
    for when in jumps:
        F[t >= when] += rng.normal(0, 15, 3)
    A, m = np.eye(3), np.empty((n, 3))
    noise = rng.normal(0, sd, (int(seconds * 10) + 1, 3))
    for k, turn in enumerate(Rotation.from_rotvec(w / rate).as_matrix()):
        if k:
            A = A @ turn
        # The error is that of a measurement: one for the five samples of a block.
        m[k] = A.T @ F[k] + b + A.T @ noise[k // 5]
    return np.column_stack([t, w, m])


EXACT = HardIronParameters(use="watch", block_s=0.0999, delay_s=0.0, turn_error=0.0, walk=0.0)


@pytest.mark.parametrize("p", [EXACT, HardIronParameters(use="watch"), HardIronParameters(use="watch", walk=0.5, field_walk=0.1)])
def test_against_the_plain_twin(p):
    rows = turned(1, seconds=30.0, jumps=(10.0, 21.0))
    moving = (rows[:, 0] % 7) > 2
    rows[::3, 4:] = np.nan
    out, P = followed(p, rows, moving)
    twin, closed = Twin(p.model_dump(), rows[0, 0]), []
    for k, r in enumerate(rows):
        closed.append(twin.sample(r[0], r[0] - rows[k - 1, 0] if k else 0.0, r[1:4], r[4:], moving[k]))
        if closed[-1]:
            np.testing.assert_allclose(out[k, :3], twin.x[3:], rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(out[k, 3:6], np.sqrt(np.diag(twin.P)[3:]), rtol=1e-9)
            np.testing.assert_allclose(out[k, 6:9], [twin.chi2, twin.ln_evidence, twin.nis], rtol=1e-7, atol=1e-9)
    assert np.array_equal(np.isfinite(out[:, 8]), np.array(closed) & np.isfinite(out[:, 8]))
    np.testing.assert_allclose(P, twin.P[3:, 3:], rtol=1e-8, atol=1e-10)
    assert out[-1, 10] >= 3, "the field began, and jumped twice at least"


def test_evidence_is_the_ratio_of_the_likelihoods():
    """Of all innovations, with hard iron and without, for a hard iron that stays (Savage and Dickey)."""
    p = EXACT.override({"field_walk": 1.0, "memory_s": 1e9, "jump": 1e9})
    rows = turned(2, seconds=20.0, b=np.array([0.6, -0.4, 0.2]))
    found = []
    for prior in (p.prior_sd, 1e-9):
        twin = Twin(p.model_dump() | {"prior_sd": prior}, 0.0)
        for k, r in enumerate(rows):
            if k == 1:
                twin.excess, twin.over = 1e9, 1e9  # nothing is learned, in either
            twin.sample(r[0], r[0] - rows[k - 1, 0] if k else 0.0, r[1:4], r[4:])
        found.append((twin.log_likelihood, twin.ln_evidence))
    assert found[0][1] == pytest.approx(found[0][0] - found[1][0], abs=1e-6)
    assert abs(found[0][1]) > 1


SEEDS = 40


def test_errors_are_as_large_as_it_says():
    """On fields that walk as it takes them to: NEES of hard iron and NIS, by chi-square with 95 %."""
    nees, nis = [], []
    for seed in range(SEEDS):
        out, P = followed(EXACT, turned(seed))
        e = out[-1, :3] - B
        nees.append(e @ np.linalg.solve(P, e))
        nis.append(np.nanmean(out[:, 8]))
    low, high = chi2.ppf([0.025, 0.975], 3 * SEEDS) / SEEDS
    assert low < np.mean(nees) < high, np.round(nees, 1)
    assert 2.8 < np.mean(nis) < 3.2, np.round(nis, 2)


# ---- in the hand -----------------------------------------------------------------------------------------------------


def using(use, **more):
    return {"attitude": {"magnetic": {"hard_iron": {"use": use, **more}}}}


def in_hand(seed=0, b=B, **options):
    r = handheld.walk(seed=seed, **{"duration_s": 120.0, **options})
    return r.replace(magnetic_flux_density=r.magnetic_flux_density + b)


def last(x):
    d = x.diagnostics
    return d["hard_iron"][-1], d["hard_iron_sd"][-1], d["hard_iron_evidence"][-1]


def heading_rmse(attitude, reference):
    return bm.evaluate_attitude(attitude, reference, "yaw").to_dict()["heading_rmse_deg"]


@pytest.mark.parametrize("seed", range(4))
def test_a_hand_finds_it_and_its_heading_is_better(seed):
    r = in_hand(seed, disturbed=False)
    off, on = (bm.attitude(r, filter="hand", **using(use)) for use in ("off", "correct"))
    b, sd, ln = last(on)
    assert ln > 100 and (np.abs(b - B) < 4 * sd + 0.3).all(), (b, sd)
    assert heading_rmse(on, r.reference) < heading_rmse(off, r.reference)
    assert any("a field of its own of 1" in w and "taken out from" in w for w in on.warnings)


def test_fields_of_a_building_are_no_hard_iron():
    """Of twenty disturbed walks with a sensor without hard iron, none shows any."""
    for seed in range(20):
        a = bm.attitude(in_hand(seed, 0 * B, duration_s=60.0), filter="hand", **using("correct"))
        b, sd, ln = last(a)
        assert ln < HardIronParameters().evidence, (seed, b, sd)
        assert not (a.diagnostics["hard_iron_applied"] > 0).any()
        assert not any("field of its own" in w for w in a.warnings)


def same_path(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("position", "attitude", "packed_covariance"))


def test_to_watch_changes_no_bit():
    r = in_hand(duration_s=40.0)
    off, watched, on = (bm.track(r, "hand", **using(use)) for use in ("off", "watch", "correct"))
    assert same_path(off, watched) and not same_path(off, on)
    assert not [name for name in off.diagnostics if "hard_iron" in name] and "hard_iron" not in off.summary()
    assert watched.summary()["hard_iron"]["blocks"] > 100
    shoe = shaken()
    off, watched = (bm.track(shoe, "foot", magnetic={"hard_iron": {"use": use}}) for use in ("off", "watch"))
    assert same_path(off, watched) and "hard_iron" in watched.diagnostics


# ---- on a shoe -------------------------------------------------------------------------------------------------------

IRON = (12.0, -20.0, 8.0)


def on_shoe(seed=1, iron=IRON, **changes):
    sensor = SENSORS["lsm9ds1"].override({"magnetic_bias": iron})
    return simulate_walk("campus", sensor, seed=seed, **{"length_m": 300, "disturbed": False, **changes})


def test_a_shoe_finds_what_its_turns_show_and_its_path_is_better():
    """The axis about which a walker turns shows nothing of itself: its uncertainty says so."""
    walk = on_shoe()
    off, on = (bm.track(walk.recording, "foot", magnetic={"hard_iron": {"use": use}}) for use in ("off", "correct"))
    b, sd, ln = last(on)
    assert ln > 100 and on.diagnostics["hard_iron_applied"][-1] == 1
    up = bm.frames.matrix_from_quaternion(walk.truth.attitude[0])[2]
    across = np.linalg.svd(up[None])[2][1:]
    assert np.abs(across @ (b - IRON)).max() < 1.5 and sd.max() > 10
    errors = [bm.evaluate(t, walk.truth, align="yaw").to_dict()["ate_rmse_2d_m"] for t in (off, on)]
    assert errors[1] < 0.7 * errors[0], errors


def test_a_disturbed_campus_is_no_hard_iron():
    for seed in range(3):
        t = bm.track(on_shoe(seed, (0.0, 0.0, 0.0), disturbed=True).recording, "foot", magnetic={"hard_iron": {"use": "correct"}})
        assert last(t)[2] < HardIronParameters().evidence
        assert not (t.diagnostics["hard_iron_applied"] > 0).any()


# ---- contract --------------------------------------------------------------------------------------------------------

SHAKEN = shaken(2400)
EAGER = {"use": "correct", "evidence": 0.01, "least": 0.0, "field_walk": 0.1}


@pytest.mark.parametrize(
    ("make", "recording"),
    [
        (lambda: bm.FootIns(bm.METHODS["foot"].parameters.override({"magnetic": {"hard_iron": EAGER}})), SHAKEN),
        (lambda: bm.FootIns(bm.METHODS["maginav"].parameters.override({"magnetic": {"hard_iron": EAGER}})), SHAKEN),
        (lambda: HandAttitude(HAND.override(using(**EAGER))), in_hand(duration_s=40.0)),
    ],
    ids=["foot", "maginav", "hand"],
)
def test_pieces_give_the_same_bits_and_a_saved_state_goes_on(make, recording):
    whole = make().run(recording)
    assert (whole.diagnostics["hard_iron_applied"] > 0).any()
    rows = recording.samples()
    for size in (1, 7, 250):
        live = make()
        check(whole, [*(live.update(piece) for piece in recording.chunks(size)), live.finish()])
    for cut in (100, len(rows) // 2):
        one = make()
        first = one.update(rows[:cut])
        other = type(one).restore(one.save())
        one.update(rows[cut : cut + 50])
        check(whole, [first, other.update(rows[cut:]), other.finish()])


def check(whole, pieces):
    for name in ("attitude", "packed_covariance"):
        assert np.array_equal(getattr(whole, name), np.concatenate([getattr(p, name) for p in pieces]))
    for name in ("hard_iron", "hard_iron_sd", "hard_iron_nis", "hard_iron_evidence"):
        got = np.concatenate([p.diagnostics[name] for p in pieces])
        assert np.array_equal(whole.diagnostics[name], got, equal_nan=True)


def test_nothing_to_find_in():
    """No magnetometer, one of zeros, and a single sample."""
    r = SHAKEN
    bare = r.replace(magnetic_time=np.empty(0), magnetic_flux_density=np.empty((0, 3)))
    dead = r.replace(magnetic_flux_density=np.zeros_like(r.magnetic_flux_density))
    one = Recording(
        time=r.time[:400],
        specific_force=r.specific_force[:400],
        angular_rate=r.angular_rate[:400],
        magnetic_time=r.magnetic_time[:1],
        magnetic_flux_density=r.magnetic_flux_density[:1],
    )
    for recording in (bare, dead, one):
        t = bm.track(recording, "foot", magnetic={"hard_iron": {"use": "correct"}})
        assert np.isfinite(t.position).all() and np.isfinite(t.diagnostics["hard_iron"]).all()
        assert not (t.diagnostics["hard_iron_applied"] > 0).any()
