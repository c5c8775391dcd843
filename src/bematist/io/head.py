"""The beginning of a file, decoded: what every `sniff` looks at."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bematist.errors import DataError

HEAD_BYTES = 65536


@dataclass(frozen=True)
class Head:
    """First bytes of a file, and its first lines where it is text.

    Attributes
    ----------
    path : the file or folder.
    raw : up to 64 KiB; empty for a folder.
    encoding : "utf-8-sig", "utf-16" … or None where the file is not text.
    lines : the decoded lines of `raw` (`split_lines`); the last may be cut.
    content : all bytes of a member of a zip; None for a file, which `data` reads.
    """

    path: Path
    raw: bytes
    encoding: str | None
    lines: tuple[str, ...]
    content: bytes | None = None

    @property
    def is_folder(self) -> bool:
        return self.path.is_dir()

    @property
    def is_zip(self) -> bool:
        return self.raw[:4] == b"PK\x03\x04"

    @property
    def is_utf8(self) -> bool:
        return self.encoding == "utf-8-sig"

    @property
    def has_line_feeds(self) -> bool:
        """Whether lines end as usual; those of some old programs end in carriage returns alone."""
        return b"\n" in self.raw or b"\r" not in self.raw

    def data(self) -> bytes:
        """All bytes of the file."""
        return self.path.read_bytes() if self.content is None else self.content

    def text(self) -> str:
        """The whole file, decoded."""
        return self.data().decode(self.encoding or "utf-8-sig", errors="replace")

    def header(self, comment: str = "#") -> tuple[int, str]:
        """Index and text of the first line that is neither blank nor a comment; (-1, "") without one."""
        for i, line in enumerate(self.lines):
            if line.strip() and not line.lstrip().startswith(comment):
                return i, line
        return -1, ""


def open_head(path: str | Path) -> Head:
    """Read the beginning of a file.

    Raises
    ------
    DataError
        The path does not exist, cannot be read, or is an empty file.
    """
    path = Path(path)
    try:
        if path.is_dir():
            return Head(path, b"", None, ())
        if path.exists() and not path.is_file():
            raise DataError(f"{path}: this is no file but a pipe or a device, which cannot be read twice. Save it as a file.")
        with path.open("rb") as file:
            raw = file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise DataError(f"{path}: there is no such file or folder. Check the name and the folder you are in.") from None
    except OSError as error:
        reason = error.strerror or error
        raise DataError(f"{path}: the file cannot be opened ({reason}). Check its permissions.") from None
    return head_of(path, raw)


def head_of(path: Path, raw: bytes, content: bytes | None = None) -> Head:
    """The head of a file whose first bytes are `raw`; `content` where all of it is at hand. Raises DataError where it is empty."""
    if not raw.strip(b"\xef\xbb\xbf\r\n\t \x00"):
        raise DataError(f"{path}: the file is empty. Export the recording again.")
    encoding = _encoding(raw)
    lines = tuple(split_lines(raw.decode(encoding, errors="replace"))) if encoding else ()
    return Head(path, raw, encoding, lines, content)


def split_lines(text: str) -> list[str]:
    """Lines without their ends, as those count them who read tables: by line feeds, and where there is none by carriage returns.

    `str.splitlines` would also end a line at form feeds and at separators of other alphabets.
    """
    lines = [line.rstrip("\r") for line in text.split("\n")] if "\n" in text else text.split("\r")
    return lines if lines[-1] else lines[:-1]


def _encoding(raw: bytes) -> str | None:
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    if b"\x00" in raw:
        # Text of few letters as UTF-16 without its mark has a zero at every other byte.
        odd, even = raw[1::2].count(0), raw[0::2].count(0)
        if odd > 0.4 * len(raw) and even == 0:
            return "utf-16-le"
        return "utf-16-be" if even > 0.4 * len(raw) and odd == 0 else None
    try:
        raw[:-4].decode("utf-8-sig")
        return "utf-8-sig"
    except UnicodeDecodeError as error:
        if error.start > len(raw) - 8:
            return "utf-8-sig"
    control = sum(byte < 9 or 13 < byte < 32 for byte in raw)
    high = sum(byte > 127 for byte in raw)
    # Loggers on Windows write µ and ° in Latin-1; a file full of such bytes is no text.
    return "latin-1" if control == 0 and high < 0.05 * len(raw) else None
