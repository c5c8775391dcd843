"""What all parameter models share: frozen, strict about names, and changed by nested overrides."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from bematist.errors import UsageError


class Parameters(BaseModel):
    """Base of the parameter models. Every field states its unit, its meaning and what a smaller or larger value does."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def override(self, changes: Mapping[str, Any], called: Mapping[str, str] | None = None) -> Self:
        """A validated copy with some values changed; nested models take nested mappings. `called`: what a caller calls a parameter.

        Raises
        ------
        UsageError
            A name is unknown or a value does not fit; says which and why.
        """
        try:
            return type(self).model_validate(_merged(self.model_dump(), changes))
        except ValidationError as error:
            raise UsageError(explain(error, type(self), called or {})) from None

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


def explain(error: ValidationError, model: type[BaseModel], called: Mapping[str, str]) -> str:
    """A pydantic error in plain words, with the nearest known name for an unknown one; `called`: other words for a parameter."""
    import difflib

    parts = []
    for e in error.errors():
        where = ".".join(str(p) for p in e["loc"])
        if e["type"] == "extra_forbidden":
            known = _names(model)
            near = difflib.get_close_matches(where, known, n=1)
            near = near or [k for k in known if k.rsplit(".", 1)[-1] == where.rsplit(".", 1)[-1]][:1]
            hint = f"Did you mean {near[0]}?" if near else f"Known are: {', '.join(known)}."
            parts.append(f"There is no parameter {where}. {hint}")
        else:
            parts.append(f"{called.get(where, f'Parameter {where}')} = {e['input']!r}: {e['msg']}.")
    return " ".join(parts)


def _names(model: type[BaseModel], prefix: str = "") -> list[str]:
    names = []
    for name, field in model.model_fields.items():
        annotation = field.annotation
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            names += _names(annotation, f"{prefix}{name}.")
        else:
            names.append(prefix + name)
    return names
