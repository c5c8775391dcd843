"""Files that belong to one recording: in a folder, in a zip, or beside one another."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bematist.errors import DataError
from bematist.io.head import HEAD_BYTES, Head, head_of, open_head
from bematist.io.table import split_header


@dataclass(frozen=True)
class Bundle:
    """The files of a folder or of a zip, by their name within it (`Gyroscope.csv`, `meta/time.csv`)."""

    path: Path
    names: dict[str, str]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: str) -> bool:
        return name in self.names

    def header(self, name: str) -> list[str]:
        """Columns that the first line of one file names; none where it is missing, empty or no text."""
        try:
            return split_header(self.open(name, whole=False).header()[1])[0] if name in self.names else []
        except DataError:
            return []

    def open(self, name: str, *, whole: bool = True) -> Head:
        """One file, or its first lines only. Raises DataError where it cannot be read or is empty."""
        if self.path.is_dir():
            return open_head(self.path / self.names[name])
        try:
            with zipfile.ZipFile(self.path) as archive, archive.open(self.names[name]) as member:
                content = member.read(-1 if whole else HEAD_BYTES)
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, NotImplementedError) as error:
            raise DataError(f"{self.path}: {name} cannot be unpacked ({error}). Export or copy the zip again.") from None
        return head_of(self.path / name, content[:HEAD_BYTES], content)


def bundle(head: Head) -> Bundle | None:
    """What a folder or a zip holds; None for any other file. Raises DataError where a zip is cut short."""
    if head.is_folder:
        return _folder(head.path)
    return _zip(head.path) if head.is_zip else None


def beside(head: Head) -> Bundle:
    """The files of the folder in which a file lies."""
    return _folder(head.path.parent)


def _folder(path: Path) -> Bundle:
    try:
        found = sorted(p for p in (*path.glob("*"), *path.glob("meta/*")) if p.is_file())
    except OSError as error:
        raise DataError(f"{path}: the folder cannot be opened ({error.strerror}). Check its permissions.") from None
    names = (p.relative_to(path).as_posix() for p in found)
    return Bundle(path, {name: name for name in names if not name.startswith(".")})


def _zip(path: Path) -> Bundle:
    try:
        with zipfile.ZipFile(path) as archive:
            found = [i.filename for i in archive.infolist() if not i.is_dir()]
    except (zipfile.BadZipFile, EOFError, OSError) as error:
        raise DataError(f"{path}: the zip cannot be read ({error}): it may be cut short. Export or copy it again.") from None
    found = [n for n in found if not n.startswith("__MACOSX/") and not n.rsplit("/", 1)[-1].startswith(".")]
    tops = {n.split("/")[0] if "/" in n else "" for n in found}
    # A folder that was zipped stands before every name.
    top = f"{tops.pop()}/" if len(tops) == 1 and "" not in tops else ""
    return Bundle(path, {n[len(top) :]: n for n in found})
