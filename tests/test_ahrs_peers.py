"""The attitude filters against the packages ahrs and imufusion, and against what BROAD's rule says of all, on real recordings."""

import ahrs
import imufusion
import numpy as np
import pytest

import bematist as bm
import twin_ahrs
from bematist import frames
from bematist.ahrs import Ahrs
from test_ahrs import apart

TRIALS = ("12_undisturbed_slow_translation_C", "33_disturbed_attached_magnet_2cm")
NWU_FROM_ENU = np.array([np.cos(np.pi / 4), 0, 0, -np.sin(np.pi / 4)])
"""Turns an attitude in ENU into one in a frame whose x axis points North."""

PUBLISHED = {"mahony": {"kp": 0.74, "ki": 0.0012}, "madgwick": {"beta": 0.12}}
AS_PRINTED = {"integration": "first-order", "initial": {"gyro_bias_sd": 0.0}}


@pytest.fixture(scope="module")
def sample(shared_data):
    """Part of VQF's example. ahrs does nothing where the rate is exactly zero, as in some quantised samples: these are moved."""
    r = bm.read(shared_data / "attitude/vqf/imu_data.npz")
    r = part(r, slice(1000, 6000))
    still = (r.angular_rate == 0).all(1)
    return r.replace(angular_rate=np.where(still[:, None], 1e-12, r.angular_rate))


def part(recording, rows):
    """Some rows of a recording whose sensors share their instants."""
    names = ("time", "specific_force", "angular_rate", "magnetic_time", "magnetic_flux_density")
    return recording.replace(**{name: getattr(recording, name)[rows] for name in names})


def theirs(recording, start, name, gains, magnetometer):
    """Attitudes (N,4) of the package ahrs, in ENU. Its Madgwick answers with x North, its Mahony with y North."""
    dt = 1 / recording.rate_hz
    if name == "madgwick":
        peer, frame = ahrs.filters.Madgwick(gain=gains["beta"], Dt=dt), NWU_FROM_ENU
    else:
        peer, frame = ahrs.filters.Mahony(k_P=gains["kp"], k_I=gains["ki"], Dt=dt), np.array([1.0, 0, 0, 0])
    q = frames.multiply(frame, start)
    out = [q]
    for f, w, m in zip(recording.specific_force[1:], recording.angular_rate[1:], recording.magnetic_flux_density[1:], strict=True):
        q = peer.updateMARG(q, w, f, m) if magnetometer else peer.updateIMU(q, w, f)
        out.append(q)
    return frames.multiply(frames.conjugate(frame), np.array(out))


@pytest.mark.parametrize("magnetometer", [True, False])
@pytest.mark.parametrize("name", ["mahony", "madgwick"])
def test_the_package_ahrs_agrees(sample, name, magnetometer):
    estimator = Ahrs(bm.FILTERS[name].parameters.override({**PUBLISHED[name], **AS_PRINTED, "magnetometer": magnetometer}))
    mine = estimator.run(sample).attitude
    other = theirs(sample, estimator.alignment.attitude, name, PUBLISHED[name], magnetometer)
    assert apart(mine, other).max() < 1e-10
    assert apart(mine, mine[:1]).max() > 1


def fused(recording, start, gain, magnetometer):
    """Attitudes (N,4) of the package imufusion with x North, its rejections off."""
    peer = imufusion.Ahrs()
    settings = {"gyroscope_range": 0, "acceleration_rejection": 0, "magnetic_rejection": 0, "rejection_timeout": 0}
    peer.set_settings(imufusion.AhrsSettings(sample_rate=recording.rate_hz, convention=imufusion.CONVENTION_NWU, gain=gain, **settings))
    peer.skip_startup()
    peer.set_quaternion(start)
    out = [start]
    for f, w, m in zip(recording.specific_force[1:], recording.angular_rate[1:], recording.magnetic_flux_density[1:], strict=True):
        if magnetometer:
            peer.update(np.degrees(w), f / 9.80665, m)
        else:
            peer.update_no_magnetometer(np.degrees(w), f / 9.80665)
        out.append(peer.get_quaternion())
    return np.array(out)


def test_imufusion_without_a_field_is_mahonys_filter(sample):
    """Named Madgwick's, it is the revision of his thesis: a proportional correction, so Kp is its gain. It computes in single precision."""
    p = bm.FILTERS["mahony"].parameters.override({"kp": 0.74, "ki": 0.0, **AS_PRINTED, "magnetometer": False})
    estimator = Ahrs(p)
    mine = estimator.run(sample).attitude
    other = fused(sample, frames.multiply(NWU_FROM_ENU, estimator.alignment.attitude), 0.74, False)
    error = frames.multiply(frames.multiply(frames.conjugate(NWU_FROM_ENU), other), frames.conjugate(mine))
    vectors = np.abs(frames.rotation_vector_from_quaternion(error))
    assert vectors[:, :2].max() < 2e-6
    assert vectors[:, 2].max() < 1e-5  # nothing holds the heading, so its rounding adds up


def test_imufusion_takes_from_the_field_its_horizontal_direction_only(sample):
    """One step of it: the error of the direction across field and gravity. Mahony's is m × w with the whole field."""
    two = part(sample, slice(3000, 3002))
    start = frames.multiply(NWU_FROM_ENU, bm.attitude(sample).attitude[3000])
    start = frames.multiply(frames.quaternion_from_rotation_vector([0.02, -0.03, 0.1]), start)
    f, w, m, dt = two.specific_force[1], two.angular_rate[1], two.magnetic_flux_density[1], 1 / two.rate_hz
    got = fused(two, start, 0.74, True)[1]
    C = frames.matrix_from_quaternion(start)
    west = np.cross(C[2], m)
    e = np.cross(f / np.linalg.norm(f), C[2]) + np.cross(west / np.linalg.norm(west), C[1])
    want = twin_ahrs.turn(start, w + 0.74 * e, dt, False)
    np.testing.assert_allclose(got, want / np.linalg.norm(want), atol=2e-7)
    whole = twin_ahrs.turn(start, w + 0.74 * twin_ahrs.error(start, f, m, (1, 0)), dt, False)
    assert np.abs(got - whole / np.linalg.norm(whole)).max() > 1e-5


@pytest.mark.parametrize("name", ["mahony", "madgwick"])
@pytest.mark.parametrize("trial", TRIALS)
def test_errors_on_broad_are_those_of_the_peers(shared_data, trial, name):
    """With the published gains, from the same start, by the data set's own rule; every eighth sample, since ahrs is slow."""
    r = bm.read(shared_data / f"attitude/broad/{trial}.mat")
    thin = part(r, slice(None, None, 8))
    estimator = Ahrs(bm.FILTERS[name].parameters.override({**PUBLISHED[name], **AS_PRINTED}))
    mine = estimator.run(thin)
    other = theirs(thin, estimator.alignment.attitude, name, PUBLISHED[name], True)
    for a, b in zip(errors(mine.time, mine.attitude, r), errors(mine.time, other, r), strict=True):
        assert abs(a - b) < 0.2
    own = errors(r.time, bm.attitude(r, name).attitude, r)
    assert own[0] < {"12": 4.0, "33": 12.0}[trial[:2]], own


def errors(time, attitude, recording):
    """Total, heading and tilt rms, degrees."""
    found = bm.Attitude(time=time, attitude=attitude, gyro_bias=np.zeros((len(time), 3)))
    d = bm.evaluate_attitude(found, recording.reference).to_dict()
    return d["attitude_rmse_deg"], d["heading_rmse_deg"], d["tilt_rmse_deg"]


def test_broads_rule(shared_data):
    """The numbers of `evaluate_attitude` from the formulas of the data set's authors."""
    r = bm.read(shared_data / f"attitude/broad/{TRIALS[0]}.mat")
    truth = r.reference
    mine = bm.attitude(r, "madgwick")
    w, _, _, z = frames.multiply(mine.attitude, frames.conjugate(truth.attitude))[truth.judged].T
    want = [2 * np.arccos(np.clip(np.abs(w), 0, 1)), 2 * np.arctan(np.abs(z / w)), 2 * np.arccos(np.sqrt(w**2 + z**2).clip(0, 1))]
    rms = [np.degrees(np.sqrt(np.nanmean(e**2))) for e in want]
    np.testing.assert_allclose(errors(mine.time, mine.attitude, r), rms, rtol=1e-9)
    assert np.isnan(truth.attitude).any() and not truth.judged.all()
