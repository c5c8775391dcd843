"""A method with its changed parameters, run on a recording and judged against its reference."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from bematist import config
from bematist.cli.console import progress
from bematist.cli.options import ALIGNMENTS
from bematist.cli.site import Site
from bematist.errors import DataError, UsageError

if TYPE_CHECKING:
    from bematist.evaluate import Evaluation
    from bematist.parameters import Parameters
    from bematist.recording import Recording, Reference
    from bematist.trajectory import Trajectory

    Model = TypeVar("Model", bound=Parameters)

PLACING = ("start", "map")
"""Tables of a configuration that say where a path lies."""

Judged = TypeVar("Judged")


@dataclass(frozen=True)
class Changes:
    """Parameters that differ from a method's own: of a configuration file, and given on the command line."""

    stored: Mapping[str, Any] = field(default_factory=dict)
    given: Mapping[str, Any] = field(default_factory=dict)
    site: Site = field(default_factory=Site)

    @classmethod
    def of(cls, stored: Mapping[str, Any], sets: list[str] | None, heading: float | None, site: Site) -> Changes:
        """From a configuration file, `--set`, `--heading`, `--origin` and `--date`."""
        if heading is not None and not math.isfinite(heading):
            raise UsageError(f"--heading {heading}: give degrees clockwise from North.")
        north = {} if heading is None else {"initial": {"heading_deg": heading}}
        return cls(stored, config.merge(config.with_rule(config.assignments(sets or [])), north), site)

    def check(self, own: Model) -> Model:
        """A method's own parameters, changed by all but what only a recording tells."""
        return own.override(config.merge(self.stored, self.given))

    def on(self, own: Model, recording: Recording) -> Model:
        """A method's own parameters, changed: by what the recording tells of the Earth, the configuration, `--origin`, and the rest."""
        from bematist.earth import earth_of

        told = earth_of(recording) if self.site.told else None
        asked = self.site.earth(recording)
        layers = ({} if earth is None else own.places(earth.values()) for earth in (told, asked))
        return own.override(config.merge(next(layers), self.stored, next(layers), self.given))


@dataclass(frozen=True)
class Job:
    """What is to be run: a method and the parameters that differ from its own."""

    method: str
    changes: Changes = field(default_factory=Changes)

    def check(self) -> Job:
        """This job, when method and parameters exist and fit; a recording is only read after that."""
        from bematist.methods import find_method

        self.changes.check(find_method(self.method).parameters)
        return self

    def run(self, recording: Recording, *, chunk: int | None = None, quiet: bool = False) -> Trajectory:
        """The trajectory of a recording."""
        from bematist.methods import find_method, track

        parameters = self.changes.on(find_method(self.method).parameters, recording)
        with progress(f"tracking with {self.method}", quiet=quiet) as tell:
            found = track(
                recording,
                self.method,
                config=parameters.model_dump(),
                earth=None,
                chunk=chunk,
                progress=lambda done, total: tell(done / max(total, 1)),
            )
        _check(found)
        return replace(found, warnings=tuple(dict.fromkeys([*recording.warnings, *found.warnings])))


def _check(trajectory: Trajectory) -> None:
    """Raise DataError where the filter did not end in numbers: nobody should be handed such a path."""
    import numpy as np

    from bematist.arrays import complete

    lost = np.flatnonzero(~complete(trajectory.position))
    if len(lost):
        raise DataError(
            f"{trajectory.source}: the filter diverged, the position is no number from {trajectory.time[lost[0]]:.2f} s on. "
            "Look at the recording there with `bematist stance`, and check units and parameters."
        )


def configured(path: Path | None, what: str, wanted: str | None, default: str) -> tuple[dict[str, Any], str]:
    """A configuration file, and the name of the `what` ("method" or "filter") to run: its own, the one wanted, or the default.

    Raises
    ------
    UsageError
        The file has an unknown key or one of the wrong kind, or was written for another one than is wanted.
    """
    stored = config.read_toml(path) if path is not None else {}
    keys = ("version", "recording", what, "reading", "parameters", *(PLACING if what == "method" else ()))
    for key in stored:
        if key not in keys:
            raise UsageError(
                f'{path}: there is no key "{key}".{config.closest(key, keys)} A configuration holds {what}, [reading] '
                "and [parameters.…], as config.toml of any result does."
            )
    tables = {key: stored[key] for key in ("reading", "parameters", *PLACING) if key in stored}
    if isinstance(tables.get("reading"), Mapping) and "units" in tables["reading"]:
        tables["reading.units"] = tables["reading"]["units"]
    for key, table in tables.items():
        if not isinstance(table, Mapping):
            raise UsageError(f"{path}: {key} is a table. Write its entries under [{key}], as config.toml of any result does.")
    name = str(stored.get(what, wanted or default))
    if wanted and wanted != name:
        raise UsageError(
            f'{path} was written for the {what} "{name}", not "{wanted}". Leave out --{what}, or remove "{what}" and the '
            "parameters that are not yours from the file."
        )
    return stored, name


def judge(trajectory: Trajectory, truth: Reference | None, *, align: str = "yaw", required: bool = False) -> Evaluation | str | None:
    """The evaluation against the reference, None without one; why not, where a reference that came along does not fit."""
    if truth is None:
        return None
    from bematist.evaluate import evaluate

    kind = config.choose("alignment", align, ALIGNMENTS)
    return judged_by(lambda: evaluate(trajectory, truth, align=kind), required=required)  # pyright: ignore[reportArgumentType]


def judged_by(evaluation: Callable[[], Judged], *, required: bool) -> Judged | str:
    """What an evaluation tells; why not, where a reference that only came along does not fit."""
    try:
        return evaluation()
    except DataError as error:
        if required:
            raise
        return f"The reference that came with the recording was left out: {error}"


def found_in(evaluation: Evaluation | str | None) -> Evaluation | None:
    return None if isinstance(evaluation, str) else evaluation


def noted(trajectory: Trajectory, evaluation: Evaluation | str | None) -> Trajectory:
    """The trajectory with what the comparison with its reference gives to doubt among its warnings."""
    doubts = (evaluation,) if isinstance(evaluation, str) else () if evaluation is None else evaluation.doubts
    return replace(trajectory, warnings=(*trajectory.warnings, *doubts)) if doubts else trajectory


def known_as(truth: Reference, given: bool) -> str:
    """What the reference is, where it was read from, and that it was not asked for."""
    if not truth.source:
        return f"in the recording itself: {truth.note}"
    name = Path(truth.source).name
    note = "" if truth.note.endswith(name) else f": {truth.note}"
    return f"{name}{'' if given else ', found with the recording'}{note}"
