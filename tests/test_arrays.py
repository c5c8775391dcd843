"""The quick forms give what NumPy gives."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bematist.arrays import complete, median

value = st.one_of(st.floats(), st.sampled_from([0.0, 1.0, math.nan]))


@given(arrays(float, st.integers(1, 9), elements=value))
def test_median_to_the_bit(x):
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(median(x), np.nanmedian(x) if not np.isnan(x).all() else math.nan)


def test_median_of_nothing_and_of_a_table():
    assert math.isnan(median(np.empty(0)))
    assert median(np.array([[1.0, 5.0], [2.0, 9.0]])) == 3.5


@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (50, 3)])
def test_complete(shape):
    x = np.random.default_rng(0).normal(size=shape)
    x[x > 1] = np.nan
    x[x < -1.5] = np.inf
    np.testing.assert_array_equal(complete(x), np.isfinite(x).all(1))
