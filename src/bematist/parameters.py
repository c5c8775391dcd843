"""What all parameter models share: frozen, strict about names, and changed by nested overrides."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from bematist.errors import UsageError


class Parameters(BaseModel):
    """Base of the parameter models. Every field states its unit, its meaning and what a smaller or larger value does."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def override(self, changes: Mapping[str, Any]) -> Self:
        """A validated copy with some values changed; nested models take nested mappings.

        Raises
        ------
        UsageError
            A name is unknown or a value does not fit; says which and why.
        """
        try:
            return type(self).model_validate(_merged(self.model_dump(), changes))
        except ValidationError as error:
            raise UsageError(explain(error, type(self))) from None


def _merged(base: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    out = dict(base)
    for key, value in changes.items():
        if isinstance(value, Mapping) and isinstance(out.get(key), dict):
            out[key] = _merged(out[key], value)
        else:
            out[key] = value
    return out


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """A pydantic error in plain words, with the nearest known name for an unknown one."""
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
            parts.append(f"Parameter {where} = {e['input']!r}: {e['msg']}.")
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


def _models(model: type[BaseModel], group: str = "") -> list[tuple[str, type[BaseModel]]]:
    found = [(group, model)]
    for name, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            found += _models(field.annotation, f"{group}{name}.")
    return found


def _shown(value: Any, description: str) -> str:
    """A default as it is written on the command line; an angle in degrees too."""
    if value is None:
        return "none"
    if isinstance(value, float):
        degrees = f" ({math.degrees(value):.4g}°)" if re.search(r"\brad\b", description) and value else ""
        return f"{value:.6g}{degrees}"
    return str(value)


def table(model: type[BaseModel], group: str = "") -> list[str]:
    """Markdown lines of the parameters of one model; nested models are left out."""
    lines = ["| name | meaning, unit, what more or less of it does | default |", "|---|---|---|"]
    for name, field in model.model_fields.items():
        if not (isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel)):
            text = (field.description or "").replace("|", "\\|")
            lines.append(f"| `{group}{name}` | {text} | {_shown(field.default, text)} |")
    return lines


def main() -> None:
    """Print docs/parameters.md."""
    from bematist.foot import FootParameters
    from bematist.methods import METHODS

    lines = [
        "# Parameters",
        "",
        "Written by `python -m bematist.parameters`. Names are those of `--set NAME=VALUE`, of `config.toml` and, nested, of",
        '`track(recording, method, stance={"threshold": 200})`. Angles are in radians; degrees stand in brackets.',
        "",
        "Defaults are those of the filter. What a method changes stands in the last table.",
    ]
    for group, model in _models(FootParameters):
        lines += ["", f"## {group.rstrip('.') or 'The filter'}", "", *(model.__doc__ or "").strip().splitlines(), "", *table(model, group)]
    lines += ["", "## What the methods change", "", "| method | parameter | value |", "|---|---|---|"]
    for method in METHODS.values():
        changed = _changed(FootParameters(), method.parameters)
        lines += [f"| `{method.name}` | `{name}` | {value} |" for name, value in changed] or [f"| `{method.name}` | nothing | |"]
    print("\n".join(lines))


def _changed(default: BaseModel, chosen: BaseModel, group: str = "") -> list[tuple[str, str]]:
    """Names and values that differ between two sets of parameters."""
    found = []
    for name, field in type(default).model_fields.items():
        a, b = getattr(default, name), getattr(chosen, name)
        if isinstance(a, BaseModel):
            found += _changed(a, b, f"{group}{name}.")
        elif a != b:
            found.append((group + name, _shown(b, field.description or "")))
    return found


if __name__ == "__main__":
    main()
