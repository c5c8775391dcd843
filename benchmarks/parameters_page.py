"""docs/parameters.md from the models: `make docs`."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from bematist.ahrs import FILTERS, AhrsParameters
from bematist.foot import FootParameters
from bematist.hand import HandParameters, HandPdrParameters
from bematist.methods import METHODS


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


def page() -> str:
    """The content of docs/parameters.md."""
    lines = [
        "# Parameters",
        "",
        "Written by `make docs`. Names are those of `--set NAME=VALUE`, of `config.toml` and, nested, of",
        '`track(recording, method, stance={"threshold": 200})`. Angles are in radians; degrees stand in brackets.',
        "",
        "Defaults are those of the filter. What a method changes stands in the last table.",
    ]
    for group, model in _models(FootParameters):
        lines += ["", f"## {group.rstrip('.') or 'The filter'}", "", *(model.__doc__ or "").strip().splitlines(), "", *table(model, group)]
    shared = set(AhrsParameters.model_fields)
    lines += ["", "## Attitude filters", "", "`initial` and `gap` as above, without what only a path needs. All filters have", ""]
    lines += table(AhrsParameters)
    for f in FILTERS.values():
        own = [line for line in table(type(f.parameters)) if not any(line.startswith(f"| `{name}`") for name in shared)]
        if len(own) > 2 and issubclass(type(f.parameters), AhrsParameters):
            lines += ["", f"`{f.name}`:", "", *own]
    lines += ["", "## Handheld attitude filter", "", "`initial` and `gap` as for the shoe.", ""]
    for group, model in _models(HandParameters):
        if group not in ("initial.", "gap."):
            lines += [
                *([f"### {group.rstrip('.')}", ""] if group else []),
                *(model.__doc__ or "").strip().splitlines(),
                "",
                *table(model, group),
                "",
            ]
    lines += ["| filter | parameter | value |", "|---|---|---|"]
    for f in FILTERS.values():
        if isinstance(f.parameters, HandParameters):
            changed = _changed(HandParameters(), f.parameters)
            lines += [f"| `{f.name}` | `{name}` | {value} |" for name, value in changed] or [f"| `{f.name}` | nothing | |"]
    lines += [
        "",
        "## Handheld path",
        "",
        (HandPdrParameters.__doc__ or "").strip(),
        "The first groups are those of the attitude filter.",
        "",
    ]
    shared = set(HandParameters.model_fields)
    for group, model in _models(HandPdrParameters):
        if group.split(".")[0] not in shared:
            own = [line for line in table(model, group) if not any(line.startswith(f"| `{name}`") for name in shared)]
            lines += [f"### {group.rstrip('.')}", "", *(model.__doc__ or "").strip().splitlines(), "", *own, ""] if group else [*own, ""]
    lines += ["## What the methods change", "", "| method | parameter | value |", "|---|---|---|"]
    for method in METHODS.values():
        changed = _changed(type(method.parameters)(), method.parameters)
        lines += [f"| `{method.name}` | `{name}` | {value} |" for name, value in changed] or [f"| `{method.name}` | nothing | |"]
    return "\n".join(lines) + "\n"


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
    (Path(__file__).resolve().parents[1] / "docs" / "parameters.md").write_text(page())
