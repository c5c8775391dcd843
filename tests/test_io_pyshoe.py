"""The Vicon reference of a PyShoe trial: where the marker was lost, there is none."""

import numpy as np

from bematist.io.pyshoe import reference_of


def test_positions_between_two_jumps_are_left_out():
    t = np.arange(400) / 200
    gt = np.stack([t, 0.1 * t, np.zeros(400)], 1)
    gt[100:130] += [0.8, 0, 0]  # the marker was taken for another
    gt[300:, 2] += 0.01  # a step that a foot can make
    reference = reference_of({"gt": gt, "ts": t[None]})
    assert reference is not None
    lost = np.isnan(reference.position).all(1)
    np.testing.assert_array_equal(np.flatnonzero(lost), np.arange(100, 130))
    assert "30 of 400" in reference.note
