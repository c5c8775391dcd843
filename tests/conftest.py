"""Fixtures shared by the tests."""

import os
from pathlib import Path

import pytest

SHARED = Path(os.environ.get("BEMATIST_SHARED", Path(__file__).parents[2] / "shared" / "data"))


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the real recordings; the test skips where it is missing."""
    if not SHARED.is_dir():
        pytest.skip(f"the real recordings are not at {SHARED} (set BEMATIST_SHARED)")
    return SHARED
