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
from typing import TYPE_CHECKING, Any, TypeVar, get_args

from bematist.errors import DataError, UsageError

if TYPE_CHECKING:
    from pathlib import Path

    from pydantic import BaseModel

    from bematist.parameters import Parameters

Model = TypeVar("Model", bound="Parameters")
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
    """The entry of that name of a table in which names are known by what they do.

    Raises
    ------
    UsageError
        There is none; the message names the nearest and all of them.
    """
    if name not in table:
        near = difflib.get_close_matches(name, table, n=1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise UsageError(f"There is no {what} {name!r}. {hint}Known are: {', '.join(table)}.")
    return table[name]


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


def changed(parameters: Model, changes: Mapping[str, Any], called: Mapping[str, str] | None = None) -> Model:
    """A copy of the parameters with the changes laid over it; the word "none" stands for no value where there may be none.

    called : what messages call a parameter, where a user knows it by another name.

    Raises
    ------
    UsageError
        A name is unknown (the message gives the nearest), or a value is refused (the message says why).
    """
    return parameters.override(_prepared(type(parameters), changes), called)


def _prepared(model: type[BaseModel], changes: Mapping[str, Any], prefix: str = "") -> Table:
    """The changes with None for "none", and what pydantic would tell in its own words, or let pass, refused."""
    result: Table = {}
    for key, value in changes.items():
        annotation = model.model_fields[key].annotation if key in model.model_fields else None
        inner = annotation if isinstance(annotation, type) and hasattr(annotation, "model_fields") else None
        if inner is not None and not isinstance(value, Mapping):
            names = ", ".join(f"{prefix}{key}.{name}" for name in inner.model_fields)
            raise UsageError(f"{prefix}{key} is a group of parameters. Set one of: {names}.")
        if isinstance(value, bool) and annotation not in (bool, None) and bool not in get_args(annotation):
            raise UsageError(f"Parameter {prefix}{key} = {str(value).lower()}: it is not of the kind true or false.")
        if inner is not None and isinstance(value, Mapping):
            result[key] = _prepared(inner, value, f"{prefix}{key}.")
        else:
            result[key] = None if value == NONE and type(None) in get_args(annotation) else value
    return result
