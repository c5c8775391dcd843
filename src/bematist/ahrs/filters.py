"""The table of named attitude filters, and `attitude`, which runs one by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from bematist.ahrs.estimator import Ahrs
from bematist.ahrs.parameters import GyroParameters, MadgwickParameters, MahonyParameters
from bematist.attitudes import Attitude
from bematist.config import look_up
from bematist.earth import Earth, on_earth
from bematist.errors import UsageError
from bematist.estimator import Estimator
from bematist.hand import GYINT, HAND, MAGYQ, MAGYQ_ESTIMATED, QUEST, HandAttitude
from bematist.parameters import Parameters
from bematist.recording import Recording


@dataclass(frozen=True)
class Filter:
    """A filter: what it is called, where it comes from, what it is good for, its parameters, and how it is made from them."""

    name: str
    summary: str
    paper: str
    equations: str
    parameters: Parameters
    make: Callable[..., Estimator[Any, Attitude]]


FILTERS: dict[str, Filter] = {
    f.name: f
    for f in (
        Filter(
            "gyro",
            "The gyroscope integrated from a levelled start: exact over seconds, drifting with the gyroscope's offset over minutes.",
            "Li & Wang 2019 (Common)",
            "3, 10, 16-23, corrected",
            GyroParameters(),
            Ahrs,
        ),
        Filter(
            "mahony",
            "Gyroscope corrected in proportion to the misfit of gravity and field; estimates the gyroscope's offset. The fastest.",
            "Mahony et al. 2008; Li & Wang 2019",
            "16-23, 29-34, corrected",
            MahonyParameters(),
            Ahrs,
        ),
        Filter(
            "madgwick",
            "Gyroscope corrected by a step of fixed length against the misfit of gravity and field: robust where accelerations are large "
            "and short.",
            "Madgwick 2010; Li & Wang 2019",
            "16-28, corrected",
            MadgwickParameters(),
            Ahrs,
        ),
        Filter(
            "gyint",
            "MAGYQ's baseline: the gyroscope alone, less its offset in the rest at the start.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-19, section 8.2.1",
            GYINT,
            HandAttitude,
        ),
        Filter(
            "quest",
            "MAGYQ's other baseline: the attitude replaced wherever gravity or the Earth's field is detected by its norm.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-19, 33-34, section 8.2.1",
            QUEST,
            HandAttitude,
        ),
        Filter(
            "magyq",
            "Kalman filter on fields that stay: any static field, the Earth's or not, holds the heading. For fields that are really "
            "constant; overconfident.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-46, corrected",
            MAGYQ,
            HandAttitude,
        ),
        Filter(
            "magyq-estimated",
            "magyq with the reference as a part of the state: several times better where the field is constant by regions.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-38, corrected; estimated reference",
            MAGYQ_ESTIMATED,
            HandAttitude,
        ),
        Filter(
            "hand",
            "The default for a hand: gravity also in motion, heading from what looks like the Earth's field or stays in a rest.",
            "bematist",
            "MAGYQ 17-36; gravity and heading in motion",
            HAND,
            HandAttitude,
        ),
    )
}


def find_filter(name: str) -> Filter:
    """The filter of that name; UsageError names the nearest ones."""
    return look_up("filter", name, FILTERS)


def attitude(
    recording: Recording,
    filter: str = "madgwick",
    *,
    config: Mapping[str, Any] | None = None,
    earth: Earth | Literal["recording"] | None = "recording",
    chunk: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    **overrides: Any,
) -> Attitude:
    """The attitudes of a recording by a named filter of `FILTERS`.

    config and overrides change parameters of the filter, nested: `attitude(r, "mahony", kp=1.0, initial={"heading_deg": 0.0})`. chunk feeds
    that many samples at a time (the result is the same to the bit). progress is called with samples done and of all. earth as for `track`.

    Raises
    ------
    UsageError
        The filter or a parameter is unknown.
    DataError
        The recording cannot be processed.
    """
    if not isinstance(recording, Recording):
        raise UsageError(f"attitude takes a Recording, not {type(recording).__name__}: read the file first, attitude(read(path)).")
    f = find_filter(filter)
    parameters = on_earth(f.parameters, recording, earth).override(config or {}).override(overrides)
    return f.make(parameters, name=f.name).run(recording, chunk=chunk, progress=progress)
