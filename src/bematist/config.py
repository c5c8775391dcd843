"""Parameters as nested tables: TOML in and out, `--set a.b=value`, and mistakes told in plain words.

A configuration file holds what `bematist track` wrote as `config.toml`:

    method = "maginav"
    [reading]            # how the recording was read: format, columns, axes, units, clock
    [parameters.stance]  # parameters that differ from the method's own (or all of them)
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from bematist.errors import DataError, UsageError

if TYPE_CHECKING:
    from pathlib import Path

Entry = TypeVar("Entry")
Table = dict[str, Any]

NONE = "none"
"""How a parameter without a value is written: TOML has no null."""

_BARE_WORD = re.compile(r"[A-Za-z_][\w./+-]*")


def closest(name: str, known: Iterable[str]) -> str:
    """ " Did you mean "…"?" with the known name nearest to `name`, or an empty string where none is near."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f' Did you mean "{near[0]}"?' if near else ""


def choose(what: str, name: str, known: Iterable[str]) -> str:
    """`name`, when it is one of the known names.

    Raises
    ------
    UsageError
        It is not; the message names the nearest and all of them.
    """
    known = list(known)
    if name in known:
        return name
    raise UsageError(f'There is no {what} "{name}".{closest(name, known)} Known: {", ".join(known)}.')


def look_up(what: str, name: str, table: Mapping[str, Entry]) -> Entry:
    """The entry of that name of a table. UsageError as `choose` where there is none."""
    return table[choose(what, name, table)]


def with_rule(changes: Mapping[str, Any]) -> Mapping[str, Any]:
    """Changes to a method's parameters in which a stance threshold, given without a rule, means the absolute rule."""
    stance = changes.get("stance")
    if isinstance(stance, Mapping) and stance.get("threshold") is not None and "rule" not in stance:
        return {**changes, "stance": {**stance, "rule": "absolute"}}
    return changes


def read_toml(path: Path) -> Table:
    """The tables of a TOML file.

    Raises
    ------
    DataError
        The file cannot be opened.
    UsageError
        It is not TOML; the message gives the line.
    """
    try:
        return tomllib.loads(path.read_text("utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: this is not TOML: {error}. Correct the file.") from None
    except OSError as error:
        raise DataError(f"{path}: the configuration cannot be opened ({error.strerror}). Check the name.") from None


def to_toml(table: Mapping[str, Any]) -> str:
    """TOML text of nested tables; a value None is written as "none"."""
    import tomli_w

    return tomli_w.dumps(_writable(table))


def _writable(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _writable(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_writable(v) for v in value]
    return NONE if value is None else value


def assignment(text: str) -> Table:
    """Nested table of one `--set` argument: "stance.window_s=0.1" → {"stance": {"window_s": 0.1}}.

    The value is written as in TOML; a bare word is taken as text.

    Raises
    ------
    UsageError
        There is no "=", a part of the name is empty, or the value cannot be read.
    """
    name, equals, value = (part.strip() for part in text.partition("="))
    keys = name.split(".")
    if not equals or not all(re.fullmatch(r"[\w-]+", key) for key in keys):
        raise UsageError(f'--set {text}: write it as name=value, such as "--set stance.threshold=2e5".')
    table: Table = {keys[-1]: _value(text, value)}
    for key in reversed(keys[:-1]):
        table = {key: table}
    return table


def _value(text: str, value: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {value}")
        if parsed.keys() == {"value"} and parsed["value"] == parsed["value"]:  # NaN is no value
            return parsed["value"]
    except tomllib.TOMLDecodeError:
        if _BARE_WORD.fullmatch(value):
            return value
    raise UsageError(
        f"--set {text}: the value is neither a number, true, false, a word nor a list. Lists are written [1, 2], "
        "text with blanks in quotes: \"'like this'\"."
    ) from None


def merge(*tables: Mapping[str, Any]) -> Table:
    """Nested tables laid over each other; the later one wins."""
    result: Table = {}
    for table in tables:
        for key, value in table.items():
            old = result.get(key)
            if isinstance(value, Mapping):
                result[key] = merge(old, value) if isinstance(old, Mapping) else merge(value)
            else:
                result[key] = value
    return result


def assignments(texts: Sequence[str]) -> Table:
    """All `--set` arguments as one nested table."""
    return merge(*(assignment(text) for text in texts))
