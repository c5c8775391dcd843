"""Finished cases on disk: a line of JSON each, written at once, so that nothing that was computed is lost."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import bematist
from bematist.errors import DataError
from bematist.outputs import to_json, whole_file
from bematist.reproduce.study import Case, Found, Part, Result

SHOWING = {"cli", "io", "report", "reproduce"}
"""Rooms of the package on which no number depends, but for `COUNTED` and the module of the case's own function."""

COUNTED = ("reproduce/numbers.py", "report/decimate.py")
"""Modules of those rooms that cases compute with."""


@cache
def code(module: Path) -> str:
    """Digest of the version and of the sources that the numbers of a case, computed in the file `module`, depend on."""
    package = Path(bematist.__file__).parent
    rooms = [p for p in package.rglob("*.py") if p.relative_to(package).parts[0] not in SHOWING]
    digest = hashlib.sha256(bematist.__version__.encode())
    for path in [*sorted(rooms), *(package / name for name in COUNTED), module]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def made_by(part: Part) -> str:
    """Digest of the code that computes a part."""
    return code(Path(inspect.getfile(part.compute)))


def stamp(case: Case) -> str:
    """The name under which a case is stored; other code and other settings have another."""
    made_of = {"part": case.part.name, "settings": case.settings, "code": made_by(case.part)}
    return hashlib.sha256(json.dumps(made_of, sort_keys=True).encode()).hexdigest()[:16]


class Store:
    """The stored cases of one folder, a file `PART.jsonl` for each part, and an .npz for each case with arrays."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._known: dict[str, dict[str, Any]] = {}

    def open(self, parts: Iterable[Part]) -> None:
        """Make the folder, and read what is in it.

        Raises
        ------
        DataError
            The folder cannot be made or read.
        """
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for part in parts:
                self._known |= _read(self._file(part))
        except OSError as error:
            raise DataError(f"{self.folder}: the cases cannot be kept there ({error.strerror}). Choose another folder with -o.") from None

    def forget(self, parts: Iterable[Part], *, everything: bool = False) -> int:
        """Remove the cases of these parts that other code made, or everything; returns how many."""
        gone = 0
        for part in parts:
            mine = {s: r for s, r in self._known.items() if r["part"] == part.name}
            old = [s for s, r in mine.items() if everything or r["code"] != made_by(part)]
            gone += len(old)
            for s in old:
                (self.folder / f"{part.name}-{s}.npz").unlink(missing_ok=True)
                del self._known[s]
            if old:
                _write(self._file(part), [r for s, r in mine.items() if s in self._known])
        return gone

    def get(self, case: Case) -> Result | None:
        """A stored case, or None."""
        key = stamp(case)
        record = self._known.get(key)
        if record is None:
            return None
        file = self.folder / f"{case.part.name}-{key}.npz" if record["arrays"] else None
        if file is not None and not file.exists():
            return None
        return Result(case.settings, record["rows"], record["seconds"], file)

    def put(self, case: Case, found: Found, seconds: float) -> None:
        """Store a case."""
        key = stamp(case)
        if found.arrays:
            with whole_file(self.folder / f"{case.part.name}-{key}.npz") as place:
                np.savez_compressed(place, **dict(found.arrays))  # pyright: ignore[reportArgumentType]
        record = {"stamp": key, "part": case.part.name, "code": made_by(case.part), "settings": case.settings}
        record |= {"seconds": seconds, "arrays": bool(found.arrays), "rows": found.rows}
        # What is shown is what was stored: a result that was just computed differs in nothing from one of yesterday.
        self._known[key] = json.loads(to_json(record))
        with self._file(case.part).open("a", encoding="utf-8") as file:
            file.write(_line(self._known[key]))

    def _file(self, part: Part) -> Path:
        return self.folder / f"{part.name}.jsonl"


def _line(record: dict[str, Any]) -> str:
    return json.dumps(record, ensure_ascii=False) + "\n"


def _read(path: Path) -> dict[str, dict[str, Any]]:
    """Records by their stamps. A line that was cut off, by a full disk or a lost process, is taken out of the file."""
    if not path.exists():
        return {}
    records, bad = {}, False
    for line in path.read_text("utf-8", errors="replace").splitlines(keepends=True):
        try:
            record = json.loads(line)
            records[record["stamp"]] = record
            bad |= not line.endswith("\n")
        except (json.JSONDecodeError, KeyError, TypeError):
            bad = True
    if bad:
        _write(path, records.values())
    return records


def _write(path: Path, records: Iterable[dict[str, Any]]) -> None:
    with whole_file(path) as place:
        place.write_text("".join(map(_line, records)), "utf-8")
