"""Results on disk: a folder or a file is written under another name and stands under its own only when it is complete."""

from __future__ import annotations

import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bematist.errors import DataError


@contextmanager
def results_folder(folder: Path) -> Iterator[Path]:
    """A temporary folder to write into; when the block ends well its files stand in `folder`, else nothing is left.

    A new folder appears at once, with all its files. In a folder that was there only the files of the same name are
    replaced, each in one step.

    Raises
    ------
    DataError
        The folder cannot be made or written.
    """
    new = not folder.exists()
    made = _make_parents(folder)
    try:
        temporary = Path(tempfile.mkdtemp(prefix=".bematist-", dir=folder.parent if new else folder))
    except OSError as error:
        _remove(made)
        raise _refused(folder, error) from None
    try:
        yield temporary
        temporary.chmod(0o777 & ~_umask())
        if new and not folder.exists():
            temporary.rename(folder)
        else:
            _move(temporary, folder)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        _remove(made)
        raise
    shutil.rmtree(temporary, ignore_errors=True)


def _make_parents(folder: Path) -> list[Path]:
    """Make the folders above; returns the ones that were not there, innermost first."""
    if folder.exists() and not folder.is_dir():
        raise DataError(f"{folder}: the results go into a folder, but there is a file of this name. Choose another with -o.")
    missing = [path for path in folder.parents if not path.exists()]
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _remove(missing)
        raise _refused(folder, error) from None
    return missing


def _remove(folders: list[Path]) -> None:
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return  # someone else put something there


def _move(source: Path, target: Path) -> None:
    for path in sorted(source.rglob("*")):
        place = target / path.relative_to(source)
        if path.is_dir():
            place.mkdir(exist_ok=True)
        else:
            path.replace(place)


def _refused(folder: Path, error: OSError) -> DataError:
    return DataError(f"{folder}: the results cannot be written there ({error.strerror}). Choose another folder with -o.")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A temporary name of the same suffix to write to; when the block ends well the file stands as `path`.

    Raises
    ------
    DataError
        The folder cannot be written.
    """
    if path.is_dir():
        raise DataError(f"{path}: a file is to be written here, but there is a folder of this name. Choose another name.")
    try:
        handle, name = tempfile.mkstemp(prefix=".bematist-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise DataError(f"{path}: the file cannot be written there ({error.strerror}). Choose another place.") from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def to_json(value: Any) -> str:
    """JSON text; a number that is not finite becomes null, arrays become lists."""
    return json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, (str, int, bool, type(None))) else str(value)
