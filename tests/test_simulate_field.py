"""The simulated magnetic field: Maxwell, what stands around, and turns that keep the norm."""

import numpy as np
import pytest

from bematist.frames import rotate
from bematist.simulate import SCENARIOS, Dipole, Facade, FieldTurn, Scenario, simulate_walk
from bematist.simulate.field import REACH_M, dipole_field, earth_field, field_at
from bematist.simulate.footprints import walk

STRAIGHT = Scenario(waypoints=((0, 0, 0), (60, 0, 0)))


def test_magnetometer_reads_the_field_in_its_own_axes():
    made = simulate_walk("campus", "ideal", length_m=600.0)
    t = made.recording.magnetic_time
    state = made.motion.at(t)
    seen = rotate(state.attitude, made.recording.magnetic_flux_density)
    earth = earth_field(made.scenario)
    assert np.linalg.norm(earth) == pytest.approx(46)
    assert np.degrees(np.arctan2(-earth[2], earth[1])) == pytest.approx(53)
    far = t < 90
    np.testing.assert_allclose(seen[far], np.tile(earth, (far.sum(), 1)), atol=0.03)
    assert np.abs(seen - earth).max() > 2


def test_dipole_has_no_divergence_and_no_curl():
    # Maxwell, by finite differences; and the textbook value on the axis, 2 µ0/4π m/r³.
    place, moment = np.array([1.0, 2.0, 0.5]), np.array([30.0, -80.0, 120.0])
    at, h = np.array([2.0, 0.5, 1.5]), 1e-4
    J = np.array([(dipole_field((at + d)[None], place, moment) - dipole_field((at - d)[None], place, moment))[0] / (2 * h)
                  for d in np.eye(3) * h])  # fmt: skip
    assert abs(np.trace(J)) < 1e-6 * np.abs(J).max()
    np.testing.assert_allclose(J, J.T, atol=1e-6 * np.abs(J).max())
    on_axis = dipole_field(np.array([[0.0, 0.0, 2.0]]), np.zeros(3), np.array([0.0, 0.0, 100.0]))
    np.testing.assert_allclose(on_axis, [[0, 0, 2 * 0.1 * 100 / 8]])


def test_a_cut_off_dipole_is_no_loss():
    motion = walk(SCENARIOS["campus"], np.random.default_rng(0))
    t = np.arange(0, motion.duration_s, 0.5)
    p = motion.at(t).position
    bent = np.linalg.norm(field_at(motion, p, motion.travelled(t), np.random.default_rng(1)) - earth_field(motion.scenario), axis=1)
    assert bent.max() > 3
    assert (bent[np.linalg.norm(p[:, :2], axis=1) < 50] == 0).all()
    assert np.linalg.norm(dipole_field(np.array([[REACH_M, 0, 0]]), np.zeros(3), np.array([300.0, 0, 0]))) < 0.01


def field_along(**changes):
    made = simulate_walk(STRAIGHT.override(changes), "ideal", seed=2)
    return made.field, made.motion.travelled(made.recording.magnetic_time), earth_field(made.scenario)


@pytest.mark.parametrize("axis", ["up", "east", "north"])
def test_a_turned_field_keeps_its_norm(axis):
    field, s, earth = field_along(field_turns=(FieldTurn(from_m=20, to_m=40, angle_deg=15, axis=axis),))
    np.testing.assert_allclose(np.linalg.norm(field, axis=1), 46, rtol=1e-12)
    inside, outside = (s > 23) & (s < 37), (s < 20) | (s > 40)
    np.testing.assert_array_equal(field[outside], np.tile(earth, (outside.sum(), 1)))
    along = np.array([axis == name for name in ("east", "north", "up")], float)
    flat, turned = (v - np.outer(v @ along, along) for v in (np.tile(earth, (inside.sum(), 1)), field[inside]))
    angle = np.arctan2(np.cross(flat, turned) @ along, (flat * turned).sum(1))
    if axis != "north":  # the whole of the field stands at right angles to nothing but East
        np.testing.assert_allclose(np.degrees(angle), 15, atol=1e-9)
    assert np.abs(np.diff(field, axis=0)).max() < 2  # no jump


def test_a_facade_is_felt_for_metres_and_a_manhole_for_less():
    wall = [Facade(from_m=20, to_m=40, away_m=away) for away in (2.0, 4.0, 8.0)]
    peaks = [np.linalg.norm(field - earth, axis=1).max() for field, _, earth in (field_along(facades=(w,)) for w in wall)]
    assert peaks[0] > 4
    assert 2.5 < peaks[0] / peaks[1] < 12 and 3 < peaks[1] / peaks[2] < 12  # a wall decays slower than a single dipole
    field, s, earth = field_along(dipoles=(Dipole(at_m=30),))
    bent = np.linalg.norm(field - earth, axis=1)
    assert bent.max() > 5 and bent[np.abs(s - 30) > 4].max() < 0.2


def test_disturbances_can_be_switched_off():
    made = simulate_walk("campus", "ideal", disturbed=False, rate_hz=20)
    np.testing.assert_array_equal(made.field, np.tile(earth_field(made.scenario), (len(made.field), 1)))
    bent = simulate_walk("campus", "ideal", rate_hz=20)
    np.testing.assert_array_equal(bent.truth.position, made.truth.position)
    # A test of the norm sees the cars; it does not see where the field is only turned.
    norm, heading = np.linalg.norm(bent.field, axis=1), np.degrees(np.arctan2(bent.field[:, 0], bent.field[:, 1]))
    assert (np.abs(norm - 46) > 0.05 * 46).mean() > 0.02
    assert ((np.abs(norm - 46) < 0.01 * 46) & (np.abs(heading) > 10)).mean() > 0.01
