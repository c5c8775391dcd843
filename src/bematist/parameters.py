"""What all parameter models share: frozen, strict about names, and changed by nested overrides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError

from bematist.config import NONE
from bematist.errors import UsageError

NEAR = 0.6
"""Likeness, 0 to 1, from which on a known name is offered for an unknown one."""


class Parameters(BaseModel):
    """Base of the parameter models. Every field states its unit, its meaning and what a smaller or larger value does."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def override(self, changes: Mapping[str, Any], called: Mapping[str, str] | None = None) -> Self:
        """A validated copy with some values changed; nested models take nested mappings, the word "none" stands for no value where
        there may be none. `called`: what messages call a parameter, where a user knows it by another name.

        Raises
        ------
        UsageError
            A name is unknown or a value does not fit; says which and why.
        """
        try:
            return type(self).model_validate(_merged(self.model_dump(), _prepared(type(self), changes)))
        except ValidationError as error:
            raise UsageError(_explained(error, type(self), called or {})) from None

    @classmethod
    def places(cls, values: Mapping[str, Any]) -> dict[str, Any]:
        """Nested changes that give values to the parameters of these names, in whichever group they stand; other names are left out."""
        found: dict[str, Any] = {}
        for name, field in cls.model_fields.items():
            inner = field.annotation
            if isinstance(inner, type) and issubclass(inner, Parameters):
                if below := inner.places(values):
                    found[name] = below
            elif name in values:
                found[name] = values[name]
        return found


def _merged(base: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    out = dict(base)
    for key, value in changes.items():
        if isinstance(value, Mapping) and isinstance(out.get(key), dict):
            out[key] = _merged(out[key], value)
        else:
            out[key] = value
    return out


def _prepared(model: type[BaseModel], changes: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """The changes with None for "none", and what pydantic would tell in its own words, or let pass, refused."""
    result: dict[str, Any] = {}
    for key, value in changes.items():
        annotation = model.model_fields[key].annotation if key in model.model_fields else None
        group = _group(annotation)
        if group is not None and isinstance(value, Mapping):
            result[key] = _prepared(group, value, f"{prefix}{key}.")
            continue
        if group is not None and not isinstance(value, group):
            raise UsageError(f"{prefix}{key} is a group of parameters. Set one of: {', '.join(_names(group, f'{prefix}{key}.'))}.")
        if isinstance(value, bool) and annotation not in (bool, None) and get_origin(annotation) is not Literal:
            raise UsageError(f"Parameter {prefix}{key} = {str(value).lower()}: it is not of the kind true or false.")
        result[key] = None if isinstance(value, str) and value == NONE and type(None) in get_args(annotation) else value
    return result


def _explained(error: ValidationError, model: type[BaseModel], called: Mapping[str, str]) -> str:
    """A pydantic error in plain words, with the nearest known name for an unknown one."""
    parts = []
    for e in error.errors():
        where = ".".join(str(p) for p in e["loc"])
        if e["type"] == "extra_forbidden":
            parts += [_unknown(name, model) for name in _leaves(where, e["input"])]
        else:
            parts.append(f"{called.get(where, f'Parameter {where}')} = {e['input']!r}: {e['msg']}.")
    return " ".join(parts)


def _unknown(name: str, model: type[BaseModel]) -> str:
    """What to say of a name that is none: the known ones whose last parts are most like it, those first that end in the same word."""
    from difflib import SequenceMatcher

    def likeness(known: str) -> float:
        parts = known.split(".")
        same = parts[-1] == name.rsplit(".", 1)[-1]
        return same + SequenceMatcher(None, name, ".".join(parts[-len(name.split(".")) :])).ratio()

    found = sorted(((likeness(known), known) for known in _names(model)), key=lambda pair: -pair[0])
    near = [known for like, known in found if like > max(NEAR, found[0][0] - 0.1)][:3]
    if near:
        return f"There is no parameter {name}. Did you mean {' or '.join(near)}?"
    top = [f"{key}.…" if _group(field.annotation) else key for key, field in model.model_fields.items()]
    return f"There is no parameter {name}. There are {', '.join(top)}; docs/parameters.md tells them all."


def _leaves(name: str, value: Any) -> Iterator[str]:
    """The full names of what was to be set by a nested mapping."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from _leaves(f"{name}.{key}", inner)
    else:
        yield name


def _group(annotation: Any) -> type[BaseModel] | None:
    """The model of a group of parameters; None for a single one."""
    return annotation if isinstance(annotation, type) and issubclass(annotation, BaseModel) else None


def _names(model: type[BaseModel], prefix: str = "") -> list[str]:
    names = []
    for name, field in model.model_fields.items():
        group = _group(field.annotation)
        names += [prefix + name] if group is None else _names(group, f"{prefix}{name}.")
    return names
