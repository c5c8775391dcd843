"""MATLAB files: against scipy, which writes and reads them too, and damaged ones."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from bematist.errors import DataError
from bematist.io.mat import load

ARRAYS = {
    "double": np.arange(12.0).reshape(4, 3) - np.pi,
    "single": np.arange(6, dtype=np.float32).reshape(2, 3),
    "small": np.array([[7]], np.uint8),
    "bytes": np.arange(-3, 10, dtype=np.int8),
    "long": np.array([[-(2**40), 2**40]]),
    "empty": np.empty((0, 3)),
    "cube": np.arange(24.0).reshape(2, 3, 4),
    "nan": np.array([[np.nan, np.inf, -0.0]]),
}


@pytest.mark.parametrize("compressed", [False, True])
def test_arrays_as_scipy_writes_them(tmp_path, compressed):
    path = tmp_path / "a.mat"
    others = {"text": "word", "many": np.zeros(2, [("a", float)]), "cell": np.array([1, "a"], object), "complex": np.array([[1j]])}
    tree = {"a": 1.0, "name": "word", "inner": {"longer_name": ARRAYS["cube"], "b": ARRAYS["empty"]}}
    savemat(path, ARRAYS | others | {"tree": tree}, do_compression=compressed)
    found = load(path)
    nested = found.pop("tree")
    assert set(nested) == {"a", "inner"} and nested["a"].item() == 1 and set(nested["inner"]) == {"longer_name", "b"}
    np.testing.assert_array_equal(nested["inner"]["longer_name"], ARRAYS["cube"])
    assert set(found) == set(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(found[name], np.atleast_2d(array))


def test_real_files_agree_with_scipy(shared_data):
    for path in [*shared_data.glob("foot/*/*.mat"), *shared_data.glob("attitude/broad/*.mat")]:
        theirs = {k: v for k, v in loadmat(path).items() if isinstance(v, np.ndarray) and v.dtype.kind in "iuf"}
        mine = load(path)
        assert set(mine) == set(theirs) and mine
        for name, array in theirs.items():
            np.testing.assert_array_equal(mine[name], array)


def test_damaged_files_are_refused_in_words_or_read(tmp_path):
    path = tmp_path / "a.mat"
    savemat(path, ARRAYS)
    whole = path.read_bytes()
    rng = np.random.default_rng(5)
    refused = 0
    for n in range(600):
        damaged = bytearray(whole[: rng.integers(130, len(whole))] if n % 2 else whole)
        for at in rng.integers(128, len(damaged), 1 + n % 7):
            damaged[at] = rng.integers(256)
        path.write_bytes(damaged)
        try:
            load(path)
        except DataError as error:
            refused += 1
            assert "\n" not in str(error)
    assert refused > 100


@pytest.mark.parametrize("content", [b"MATLAB", b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM", b"MATLAB".ljust(200)])
def test_other_levels_are_refused(tmp_path, content):
    path = tmp_path / "a.mat"
    path.write_bytes(content)
    with pytest.raises(DataError, match="-v7"):
        load(path)
