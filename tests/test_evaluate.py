"""Evaluation against cases whose answer is known by hand, and properties of the alignment."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bematist.attitudes import Attitude
from bematist.errors import DataError, UsageError
from bematist.evaluate import align_path, evaluate, evaluate_attitude, footfalls, match_footfalls, nees, nees_bounds
from bematist.evaluate.metrics import attitude_error, distance_along, relative_error, rotate_packed
from bematist.evaluate.pairing import _assign
from bematist.frames import matrix_from_quaternion, multiply, quaternion_from_euler, quaternion_from_rotation_vector
from bematist.recording import Reference
from bematist.trajectory import Trajectory

RNG = np.random.default_rng(5)


def path(n=400, seed=0):
    """A wandering path (n,3), m."""
    return np.random.default_rng(seed).normal(0, [0.3, 0.3, 0.03], (n, 3)).cumsum(0)


def trajectory(position, **changes):
    n = len(position)
    given_ = {
        "time": np.arange(n) * 0.1,
        "position": position,
        "velocity": np.gradient(position, 0.1, axis=0),
        "attitude": np.tile([1.0, 0, 0, 0], (n, 1)),
        "stance": np.zeros(n, np.uint8),
        "packed_covariance": np.full((n, 18), np.nan),
    }
    return Trajectory(**{**given_, **changes})


def reference(position, **changes):
    return Reference(**{"time": np.arange(len(position)) * 0.1, "position": position, **changes})


def yaw_matrix(angle):
    return matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, angle))


angles = st.floats(-np.pi, np.pi)
shifts = st.tuples(*[st.floats(-100, 100)] * 3)


@given(angles, shifts, st.booleans())
@settings(max_examples=50, deadline=None)
def test_yaw_alignment_recovers_the_motion(angle, shift, mirror):
    p, R = path(), yaw_matrix(angle)
    r = (p @ R.T + shift) * ([1, -1, 1] if mirror else [1, 1, 1])
    found = align_path(p, r, "yaw", mirrored=True)
    assert found.mirrored == mirror
    np.testing.assert_allclose(found.rotation, R, atol=1e-9)
    np.testing.assert_allclose(found.path(p), found.reference(r), atol=1e-9)
    np.testing.assert_allclose(found.onto_trajectory(r), p, atol=1e-8)
    r[3, :2], r[5, 2] = np.nan, np.nan
    assert np.isnan(found.onto_trajectory(r)[3]).all()
    np.testing.assert_array_equal(np.isnan(found.onto_trajectory(r)[5]), [False, False, True])


@given(st.tuples(*[st.floats(-1.8, 1.8)] * 3), shifts, st.booleans())
@settings(max_examples=50, deadline=None)
def test_se3_alignment_recovers_the_motion(turn, shift, mirror):
    p, R = path() * [1, 1, 5], matrix_from_quaternion(quaternion_from_rotation_vector(np.array(turn)))
    r = (p @ R.T + shift) * ([1, -1, 1] if mirror else [1, 1, 1])
    found = align_path(p, r, "se3", mirrored=True)
    assert found.mirrored == mirror
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    np.testing.assert_allclose(found.rotation, R, atol=1e-9)
    np.testing.assert_allclose(found.path(p), found.reference(r), atol=1e-8)


def test_a_mirror_image_is_not_taken_where_it_is_not_allowed():
    p = path()
    found = align_path(p, p * [1, -1, 1], "yaw", mirrored=False)
    assert not found.mirrored
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    assert np.abs(found.path(p) - p * [1, -1, 1]).max() > 0.5


def test_yaw_alignment_is_the_least():
    p, r = path(seed=1), path(seed=2)
    found = align_path(p, r)
    best = ((found.path(p) - r) ** 2).sum()
    for turn, shift in ((1e-3, 0), (-1e-3, 0), (0, 1e-2), (0, -1e-2)):
        other = ((found.path(p) @ yaw_matrix(turn).T + shift - r) ** 2).sum()
        assert other > best


def test_origin_and_none():
    p, r = path(), path(seed=3)
    np.testing.assert_allclose(align_path(p, r, "origin").path(p)[0], r[0])
    np.testing.assert_array_equal(align_path(p, r, "none").path(p), p)
    np.testing.assert_array_equal(align_path(p, r, "origin").rotation, np.eye(3))


def test_a_reference_without_height():
    p = path()
    r = p @ yaw_matrix(1.0).T + [3, 4, 5]
    r[:, 2] = np.nan
    e = evaluate(trajectory(p), reference(r))
    assert e.ate_plan_m < 1e-9
    assert np.isnan(e.ate_height_m)
    assert np.isnan(e.ate_m)
    assert e.end_point_m < 1e-9
    assert e.to_dict()["ate_rmse_3d_m"] is None
    assert any("no height" in n for n in e.notes)
    with pytest.raises(DataError, match="yaw"):
        evaluate(trajectory(p), reference(r), align="se3")
    with pytest.raises(UsageError, match="choose one"):
        evaluate(trajectory(p), reference(r), align="sim3")  # pyright: ignore[reportArgumentType]


def test_numbers_worked_out_by_hand():
    # Ten metres East at 1 m/s; the estimate starts right, is 2 % long, ends 0.3 m to the North and 0.1 m high.
    t = np.arange(101) * 0.1
    true = np.column_stack([t, np.zeros(101), np.zeros(101)])
    guess = np.column_stack([1.02 * t, 0.03 * t, 0.01 * t])
    e = evaluate(trajectory(guess), reference(true), align="none", windows_s=(5.0,), windows_m=(5.0, 20.0))
    assert e.end_point_m == pytest.approx(np.hypot(np.hypot(0.2, 0.3), 0.1))
    assert e.reference_distance_m == pytest.approx(10)
    assert e.end_point_percent == pytest.approx(10 * e.end_point_m)
    assert e.ate_height_m == pytest.approx(np.sqrt((0.01 * t) @ (0.01 * t) / 101))
    assert e.ate_m == pytest.approx(np.hypot(e.ate_plan_m, e.ate_height_m))
    assert e.length_ratio == pytest.approx(np.linalg.norm([1.02, 0.03, 0.01]), abs=1e-9)
    assert e.closure_m == pytest.approx(10 * e.length_ratio)
    assert e.reference_closure_m == pytest.approx(10)
    assert np.degrees(e.course_rms) == pytest.approx(np.degrees(np.arctan2(0.03, 1.02)))
    five_s, five_m, twenty_m = e.relative
    half = 5 * np.linalg.norm([0.02, 0.03, 0.01])
    assert (five_s.rms_m, five_s.pairs) == (pytest.approx(half), 51)
    assert five_m.percent == pytest.approx(20 * half, rel=0.02)
    assert twenty_m.pairs == 0
    assert np.isnan(twenty_m.rms_m)
    assert e.velocity_rms != e.velocity_rms
    json.dumps(e.to_dict(), allow_nan=False)


def test_relative_error_does_not_see_a_constant():
    error = np.tile([5.0, -3, 1], (50, 1))
    assert relative_error(error, np.arange(50.0), 10.0, "s").rms_m == 0
    assert relative_error(error + np.arange(50)[:, None] * [1, 0, 0], np.arange(50.0), 10.0, "s").rms_m == 10


def test_distance_along_ignores_wavering():
    rest = np.zeros((3000, 3)) + RNG.normal(0, 0.01, (3000, 3))
    walk = np.column_stack([np.linspace(0, 20, 2000), np.zeros(2000), np.zeros(2000)])
    gone = distance_along(np.concatenate([rest, walk, walk[-1] + rest]))
    assert gone[-1] == pytest.approx(20, abs=0.6)
    assert gone[2999] < 0.3
    assert (np.diff(gone) >= 0).all()


def test_a_reference_on_its_own_clock():
    t = np.arange(0, 10, 0.1)
    moving = np.column_stack([np.sin(t), np.cos(t), 0.1 * t])
    turning = quaternion_from_euler(0.2, 1.4 * np.sin(t), t)
    at = np.array([-1.0, 0.033, 1.234, 5.0, np.nan, 9.89, 11.0])
    r = Reference(
        time=at,
        position=np.column_stack([np.sin(at), np.cos(at), 0.1 * at]),
        attitude=quaternion_from_euler(0.2, 1.4 * np.sin(at), at),
    )
    e = evaluate(trajectory(moving, time=t, attitude=turning), r, align="none")
    assert e.rows == 4
    np.testing.assert_array_equal(e.rows_used, [1, 2, 3, 5])
    assert e.ate_m < 2e-3  # the sagitta of 0.1 s of a unit circle
    assert e.attitude is not None
    assert e.attitude.total < 3e-3
    assert any("2 rows of the reference lie outside" in n for n in e.notes)
    assert any("1 rows of the reference have no time" in n for n in e.notes)


@pytest.mark.parametrize("angle", [0.0, 2.5])
def test_attitude_errors_do_not_see_the_alignment(angle):
    # Truth and estimate in frames that differ by a yaw; the estimate's heading is 3 degrees off and its roll 1 degree.
    p = path()
    true = quaternion_from_euler(0.1, RNG.uniform(-1.5, 1.5, len(p)), RNG.uniform(-3, 3, len(p)))
    psi = np.radians([1.0, 0.0, 3.0])
    wrong = multiply(quaternion_from_rotation_vector(psi), true)
    frame = quaternion_from_euler(0.0, 0.0, angle)
    e = evaluate(trajectory(p, attitude=wrong), reference(p @ yaw_matrix(angle).T, attitude=multiply(frame, true)))
    assert e.attitude is not None
    assert np.degrees(e.attitude.heading) == pytest.approx(3, abs=1e-3)
    assert np.degrees(e.attitude.tilt) == pytest.approx(1, abs=1e-3)
    assert np.degrees(e.attitude.total) == pytest.approx(np.sqrt(10), abs=1e-9)


def test_heading_error_of_a_foot_that_points_down():
    true = quaternion_from_euler(0.0, np.radians(90.0), 0.0)[None]
    wrong = multiply(quaternion_from_euler(0.0, 0.0, np.radians(2.0)), true)
    assert np.degrees(attitude_error(wrong, true).heading) == pytest.approx(2)


def packed(P):
    return P[..., [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]


def test_nees_is_the_quadratic_form():
    A = RNG.normal(size=(500, 3, 3))
    P, e = A @ A.transpose(0, 2, 1) + 0.01 * np.eye(3), RNG.normal(size=(500, 3))
    np.testing.assert_allclose(nees(e, packed(P)), np.einsum("ni,nij,nj->n", e, np.linalg.inv(P), e), rtol=1e-6)
    R = matrix_from_quaternion(quaternion_from_rotation_vector(np.array([0.3, -1.0, 0.7])))
    np.testing.assert_allclose(nees(e @ R.T, rotate_packed(R, packed(P))), nees(e, packed(P)), rtol=1e-6)
    singular = np.diag([1.0, 1.0, 0.0])[None]
    assert np.isnan(nees(e[:1], packed(singular))[0])
    assert np.isnan(nees(e[:1], np.full((1, 6), np.nan))[0])


def test_nees_bounds_are_those_of_the_tables():
    assert nees_bounds(1, 3) == pytest.approx((0.2158, 9.3484), abs=1e-4)
    assert nees_bounds(20, 3) == pytest.approx((40.482 / 20, 83.298 / 20), abs=1e-3)


def test_an_honest_covariance_passes_and_a_vain_one_does_not():
    n, A = 4000, RNG.normal(size=(3, 3))
    P = A @ A.T + np.eye(3) * 0.1
    L = np.linalg.cholesky(P)
    p, angle = path(n), 1.1
    q = quaternion_from_euler(*RNG.uniform(-1, 1, (3, n)))
    noise = [RNG.normal(size=(n, 3)) @ L.T * s for s in (1.0, 0.1, 0.01)]
    noise[0][0] = 0.0  # NEES counts from where the filter started
    truth = trajectory(p, attitude=q, velocity=path(n, 7))
    made = trajectory(
        p + noise[0],
        velocity=truth.velocity + noise[1],
        attitude=multiply(quaternion_from_rotation_vector(noise[2]), q),
        packed_covariance=np.tile(np.concatenate([packed(P) * s**2 for s in (1.0, 0.1, 0.01)]), (n, 1)),
    )
    for align in ("none", "yaw"):
        e = evaluate(made, truth, align=align)
        for found in (e.nees_position, e.nees_velocity, e.nees_attitude):
            assert found is not None
            assert found.mean == pytest.approx(3, abs=0.2)
            assert found.inside == pytest.approx(0.95, abs=0.015)
    vain = evaluate(trajectory(p + noise[0], packed_covariance=made.packed_covariance / 9), truth, align="none")
    assert vain.nees_position is not None
    assert vain.nees_position.mean > 20
    # In a turned frame the covariance must turn too.
    R = yaw_matrix(angle)
    turned = evaluate(made, reference(p @ R.T), align="yaw")
    assert turned.nees_position is not None
    assert turned.nees_position.mean == pytest.approx(3, abs=0.2)


def steps(places, still=8, swing=5):
    """Positions and stance of a shoe that stands on `places` in turn."""
    at, down = [], []
    for k, place in enumerate(places):
        if k:
            for u in np.linspace(0, 1, swing + 2)[1:-1]:
                at.append(places[k - 1] + u * (place - places[k - 1]) + [0, 0, 0.1])
                down.append(0)
        at += [place] * still
        down += [1] * still
    return np.array(at, float), np.array(down, np.uint8)


def walk_of_footfalls(n=30, seed=0):
    rng = np.random.default_rng(seed)
    heading = rng.normal(0, 0.4, n).cumsum()
    step = np.column_stack([np.cos(heading), np.sin(heading), np.zeros(n)]) * rng.uniform(1.1, 1.4, (n, 1))
    return np.concatenate([np.zeros((1, 3)), step.cumsum(0)])


def footfall_reference(places, rows=None):
    rows = np.arange(len(places)) if rows is None else rows
    plan = np.column_stack([places[rows, :2], np.full(len(rows), np.nan)])
    return Reference(time=np.full(len(rows), np.nan), position=plan, footfall=rows, mirrored=True)


def test_footfalls_in_order():
    places = walk_of_footfalls()
    at, down = steps(places)
    r = places @ yaw_matrix(2.0).T * [1, -1, 1]
    e = evaluate(trajectory(at, stance=down), footfall_reference(r))
    assert (e.matched, e.rows, e.alignment.mirrored) == ("footfalls", 31, True)
    assert e.ate_plan_m < 1e-9
    assert e.length_ratio == pytest.approx(1)
    assert e.reference_distance_m == pytest.approx(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def test_a_broken_stance_is_one_footfall():
    places = walk_of_footfalls()
    at, down = steps(places, still=20)
    down[5:9] = 0  # 0.4 s, but at one place
    down[30] = 0
    middle, found = footfalls(trajectory(at, stance=down))
    assert len(middle) == 31
    np.testing.assert_allclose(found, places, atol=1e-12)
    assert abs(middle[0] - 10) <= 1


@pytest.mark.parametrize(("missed", "false"), [((4, 17), 0), ((), 3), ((30,), 0), ((0,), 0)])
def test_footfalls_that_the_detector_missed_or_made_up(missed, false):
    places = walk_of_footfalls()
    at, down = steps(places)
    for k in missed:
        down[k * 13 : k * 13 + 8] = 0
    for k in (3, 11, 20)[:false]:
        down[k * 13 + 10] = 1  # in the middle of a swing
    r = places @ yaw_matrix(-2.8).T + [5, 6, 0]
    e = evaluate(trajectory(at, stance=down), footfall_reference(r))
    assert e.rows == 31 - len(missed)
    assert e.ate_plan_m < 1e-9
    assert any("leaving out" in n for n in e.notes)
    assert set(e.rows_used) == set(range(31)) - set(missed)


def test_assignment_is_the_least_of_all():
    from itertools import combinations

    for seed in range(5):
        cost = np.random.default_rng(seed).uniform(size=(4, 8))
        columns, total = _assign(cost)
        least = min(cost[np.arange(4), list(c)].sum() for c in combinations(range(8), 4))
        assert (np.diff(columns) > 0).all()
        assert total == pytest.approx(least)
        assert cost[np.arange(4), columns].sum() == pytest.approx(least)


def test_counts_decide_where_they_agree():
    places = walk_of_footfalls(10)
    mine, theirs = match_footfalls(places, places[[0, 3, 10]], np.array([0, 3, 10]), False)
    np.testing.assert_array_equal(mine, [0, 3, 10])
    np.testing.assert_array_equal(theirs, [0, 1, 2])


@pytest.mark.parametrize("rests", [True, False])
def test_the_length_of_a_dense_reference_is_that_of_its_footfalls(rests):
    # 100 Hz, 4 mm of noise: every sample counted, the path would be half as long again. A body that never rests is
    # measured from half metre to half metre.
    places = walk_of_footfalls()
    at, down = steps(places, still=30 if rests else 1, swing=70)
    clock = {"time": np.arange(len(at)) * 0.01}
    noisy = at + RNG.normal(0, 0.004, at.shape)
    true = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    e = evaluate(trajectory(at * 1.05, stance=0 * down, **clock), reference(noisy, **clock))
    assert np.linalg.norm(np.diff(noisy, axis=0), axis=1).sum() > 1.2 * true
    assert e.reference_distance_m == pytest.approx(true, rel=0.005 if rests else 0.03)
    assert e.length_ratio == pytest.approx(1.05, abs=0.005)


def test_the_length_does_not_depend_on_the_trajectory():
    places = walk_of_footfalls()
    at, down = steps(places, still=30, swing=70)
    clock = {"time": np.arange(len(at)) * 0.01}
    half = down * (np.arange(len(down)) < len(down) // 2)
    found = [evaluate(trajectory(at, stance=s, **clock), reference(at, **clock)).reference_distance_m for s in (down, half)]
    assert found[0] == found[1]


def test_nees_in_the_plan_has_two_degrees_of_freedom():
    n = 4000
    A = RNG.normal(size=(3, 3))
    P = A @ A.T + np.eye(3) * 0.1
    noise = RNG.normal(size=(n, 3)) @ np.linalg.cholesky(P).T
    r = path(n)
    guess = r + noise
    r[:, 2] = np.nan
    covariance = np.tile(packed(P), (n, 3))
    e = evaluate(trajectory(guess, packed_covariance=covariance), reference(r), align="none")
    assert e.nees_position is not None
    assert e.nees_position.dof == 2
    assert e.nees_position.mean == pytest.approx(2, abs=0.15)
    assert e.nees_position.inside == pytest.approx(0.95, abs=0.015)


def test_nees_counts_from_where_the_filter_started():
    # A reference in a frame far away: the distance between the frames is no error of the filter.
    n = 500
    sd = np.linspace(0.0, 1.0, n)
    p = path(n)
    covariance = np.zeros((n, 18))
    covariance[:, [0, 3, 5]] = sd[:, None] ** 2
    error = RNG.normal(size=(n, 3)) * sd[:, None]
    e = evaluate(trajectory(p + error, packed_covariance=covariance), reference(p + np.array([50.0, 30.0, 7.0])), align="origin")
    assert e.nees_position is not None
    assert e.nees_position.mean == pytest.approx(3, abs=0.35)
    assert e.nees_position.rows < n  # the first row has no uncertainty


def test_nothing_in_common():
    p = path()
    with pytest.raises(DataError, match="do not overlap"):
        evaluate(trajectory(p), reference(p, time=np.arange(len(p)) + 1e6))
    with pytest.raises(DataError, match="no row that has time"):
        evaluate(trajectory(p), reference(np.full_like(p, np.nan)))
    with pytest.raises(DataError, match="no stance"):
        evaluate(trajectory(p), footfall_reference(walk_of_footfalls()))


def test_the_table_names_the_alignment():
    p = path()
    rows = evaluate(trajectory(p), reference(p), align="origin").table()
    assert ("Alignment", "origin", "") in rows
    names = [name for name, _, _ in rows]
    assert "ATE RMSE, plan [origin]" in names
    assert not any(value is None or value != value for _, value, _ in rows)


def test_the_module_can_be_called():
    import bematist

    p = path()
    assert bematist.evaluate(trajectory(p), reference(p)).ate_m < 1e-9
    assert bematist.evaluate(trajectory(p), reference(p)).ate_m < 1e-9


def test_a_straight_path_leaves_roll_free_and_se3_says_so():
    p = np.linspace([0, 0, 0], [50, 20, 1], 300) + RNG.normal(0, 0.01, (300, 3))
    with pytest.raises(DataError, match="align with yaw"):
        evaluate(trajectory(p), reference(p), align="se3")
    assert evaluate(trajectory(p), reference(p), align="yaw").to_dict()["ate_rmse_3d_m"] < 1e-9


def test_a_reference_of_another_walk_is_doubted():
    p = path(400) * 3
    assert not evaluate(trajectory(p), reference(p)).doubts
    longer = evaluate(trajectory(p), reference(2.5 * p))
    assert "0.4 times as long" in longer.doubts[0] and longer.doubts[0] in longer.notes
    # As long, but back and forth.
    there_and_back = np.column_stack([np.abs(np.arange(400) % 20 - 10.0), np.zeros(400), np.zeros(400)])
    straight = np.column_stack([np.arange(400.0), np.zeros(400), np.zeros(400)])
    assert "reaches over" in evaluate(trajectory(there_and_back), reference(straight)).doubts[0]
    late = evaluate(trajectory(p), reference(p, time=np.arange(400) * 0.1 + 30))
    assert any("Only 100 of 400 points" in d for d in late.doubts)
    tiny = path(400) * 1e-3
    assert not evaluate(trajectory(tiny), reference(2.5 * tiny)).doubts


def test_no_percentages_of_a_path_of_a_hand_width():
    p = np.column_stack([np.linspace(0, 0.2, 50), np.zeros(50), np.zeros(50)])
    e = evaluate(trajectory(p), reference(p))
    assert e.closure_percent is None and e.end_point_percent is None and e.closure_m == pytest.approx(0.2)
    assert not any("%" in unit and "distance" in unit for _, _, unit in e.table())
    assert trajectory(p).summary()["closure_percent"] is None
    assert evaluate(trajectory(50 * p), reference(50 * p)).closure_percent == pytest.approx(100)


def test_a_constant_rotation_on_either_side_is_taken_out():
    rng = np.random.default_rng(3)
    t = np.arange(2000) * 0.01
    q = quaternion_from_euler(np.sin(t), 0.6 * np.sin(1.3 * t + 1), 0.4 * t)
    left, right = quaternion_from_euler(0.02, -0.03, 2.5), quaternion_from_euler(2.0, 0.8, -1.0)
    noise = np.radians(1.0) * rng.standard_normal((2000, 3))
    true = multiply(multiply(left, multiply(quaternion_from_rotation_vector(noise), q)), right)
    estimate = Attitude(time=t, attitude=q, gyro_bias=np.zeros((2000, 3)))
    known = Reference(time=t, position=np.full((2000, 3), np.nan), attitude=true)
    assert np.degrees(evaluate_attitude(estimate, known, "yaw").error.total) > 20
    found = evaluate_attitude(estimate, known, "frames")
    assert np.degrees(found.error.total) == pytest.approx(3**0.5, rel=0.05) and np.degrees(found.error.heading) == pytest.approx(1, rel=0.1)
