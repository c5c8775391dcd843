"""The table of named methods: each a documented set of parameters of one estimator."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any, Literal

from bematist.config import look_up, with_rule
from bematist.earth import Earth, on_earth
from bematist.errors import UsageError
from bematist.recording import Recording
from bematist.trajectory import Trajectory

if TYPE_CHECKING:
    from bematist.foot import FootIns, FootParameters
    from bematist.hand import HandPdr, HandPdrParameters


@dataclass(frozen=True)
class Method:
    """A method: what it is called, where it comes from, what it is good for, what makes its parameters, and where the sensor is worn."""

    name: str
    summary: str
    paper: str
    equations: str
    settings: Callable[[], FootParameters | HandPdrParameters]
    worn: Literal["shoe", "hand"] = "shoe"

    @cached_property
    def parameters(self) -> FootParameters | HandPdrParameters:
        """Its parameters; a command imports the models of the method alone that it runs."""
        return self.settings()

    @property
    def make(self) -> type[FootIns | HandPdr]:
        """The estimator that takes the parameters, with its kernels: imported when it is asked for."""
        if self.worn == "hand":
            from bematist.hand import HandPdr

            return HandPdr
        from bematist.foot import FootIns

        return FootIns


def _foot(*changes: Mapping[str, Any], **more: Any) -> Callable[[], FootParameters]:
    """Makes the parameters of the shoe's filter with the changes laid over one another."""

    def make() -> FootParameters:
        from bematist.foot import FootParameters

        return reduce(FootParameters.override, (*changes, more), FootParameters())

    return make


LI_WANG = {
    "states": 9,
    "gravity": 9.8,
    "stance": {"detector": "gyro", "threshold": 0.6, "window_s": 0.05},
    "zero_velocity": {"sd": 0.01},
    "noise": {"angle_random_walk": 1e-3, "velocity_random_walk": 1e-3},
    "initial": {"tilt_sd": math.radians(0.5)},
}
"""Li & Wang Table 1. Its 0.01 m/s² and 0.01 rad/s are per sample at 100 Hz (erratum): times √0.01 s they are densities."""

OFFSETS = {"states": 15, "noise": {"gyro_bias_walk": 1e-6, "accel_bias_walk": 1e-5}, "initial": {"accel_bias_sd": 0.02}}
"""The offsets as states, and what Table 1 leaves open: their random walks, and the accelerometer's uncertainty at first.

The gyroscope's is as uncertain as the rest at the start leaves it, about 5e-4 rad/s after 3 s.
"""


def _hand(name: str, summary: str, paper: str, equations: str, attitude: str, pendulum: float = 0.0, **direction: float) -> Method:
    """A method for the hand: the path's parameters with those of an attitude filter, a constant of `bematist.hand`."""

    def make() -> HandPdrParameters:
        from bematist import hand

        changes = {"direction": direction, "step_length": {"pendulum": pendulum}}
        return hand.pdr_parameters(getattr(hand, attitude)).override(changes)

    return Method(name, summary, paper, equations, make, "hand")


_ZH = {"zaru": {"use": "rest"}, "hdr": {"use": "stance"}}

METHODS: dict[str, Method] = {
    m.name: m
    for m in (
        Method(
            "foot",
            "The default for a shoe: zero velocity believed by how quiet the stance is, walking and running alike, and heading from the "
            "magnetic field where it is undisturbed.",
            "bematist",
            "MAGINAV 1-7, 14-24, with invariant errors; noise following the stance statistic; heading as a measurement",
            _foot(
                linearisation="invariant",
                stance={"rule": "relative", "window_s": 0.05},
                magnetic={"use": "heading"},
                noise={"angle_random_walk": math.radians(0.2), "velocity_random_walk": 0.1},
            ),
        ),
        Method(
            "zupt",
            "Zero-velocity updates only, one threshold for walking: what most of the field runs.",
            "Papafotis & Sotiriadis 2023 (MAGINAV), Skog et al. 2010",
            "1-3, 6-9, 14-24",
            _foot(),
        ),
        Method(
            "maginav",
            "Zero-velocity updates, and the attitude replaced by TRIAD in stance where the magnetic field is undisturbed: outdoors.",
            "Papafotis & Sotiriadis 2023 (MAGINAV)",
            "1-25 and Table 2, corrected",
            _foot(magnetic={"use": "reset"}),
        ),
        Method(
            "maginav-printed",
            "MAGINAV with every equation as it is printed, as far as that runs: to see what each correction is worth. Not for use.",
            "Papafotis & Sotiriadis 2023 (MAGINAV)",
            "1-24 and Table 2, as printed; 8-9 made orthogonal; 16-17, 22 and 25 corrected, for they cannot run",
            _foot(
                attitude={"integration": "first-order-matrix", "force_at": "end"},
                stance={"placement": "forward"},
                magnetic={
                    "use": "reset",
                    "triad": "printed",
                    "covariance": "untouched",
                    "inclination_tolerance": math.pi,
                    "still_fraction": 1.0,
                },
                noise={"growth": "per-sample"},
                initial={"average": False},
            ),
        ),
        Method(
            "madgwick-zupt",
            "Zero-velocity updates with Madgwick's attitude, drawn by gravity and the magnetic field: a rival of MAGINAV.",
            "Papafotis & Sotiriadis 2023 (MAGINAV) section III-B; Li & Wang 2019",
            "MAGINAV 1-3, 14-25; Li & Wang 19-21, 24-28",
            _foot(attitude={"propagation": "madgwick", "magnetometer": "all"}),
        ),
        Method(
            "mahony-zupt",
            "Zero-velocity updates with Mahony's attitude, drawn by gravity and the magnetic field: a rival of MAGINAV.",
            "Papafotis & Sotiriadis 2023 (MAGINAV) section III-B; Li & Wang 2019",
            "MAGINAV 1-3, 14-25; Li & Wang 19-21, 29-34",
            _foot(attitude={"propagation": "mahony", "magnetometer": "all"}),
        ),
        Method(
            "common-9",
            "Nine states, no offsets, attitude by the gyroscope alone, stance by the angular rate.",
            "Li & Wang 2019",
            "1-15, 35, corrected",
            _foot(LI_WANG),
        ),
        Method(
            "mahony-9",
            "Nine states with Mahony's attitude, without magnetometer; stance by the angular rate.",
            "Li & Wang 2019",
            "1-15, 29-35, corrected",
            _foot(LI_WANG, attitude={"propagation": "mahony"}),
        ),
        Method(
            "madgwick-9",
            "Nine states with Madgwick's attitude, without magnetometer; stance by the angular rate.",
            "Li & Wang 2019",
            "1-15, 24-28, 35, corrected",
            _foot(LI_WANG, attitude={"propagation": "madgwick"}),
        ),
        Method(
            "15m",
            "Fifteen states with Madgwick's attitude, without magnetometer; stance by the angular rate.",
            "Li & Wang 2019",
            "1-15, 24-28, 35, corrected",
            _foot(LI_WANG, OFFSETS, attitude={"propagation": "madgwick"}),
        ),
        Method(
            "15zh",
            "Fifteen states; the angular rate at rest is zero (ZARU) and straight walking stays straight (HDR). Not for curves.",
            "Li & Wang 2019, Jiménez et al. 2010",
            "1-15, 35, section 4.2, corrected",
            _foot(LI_WANG, OFFSETS, _ZH),
        ),
        Method(
            "15mzh",
            "15zh with Madgwick's attitude. Not for curves.",
            "Li & Wang 2019, Jiménez et al. 2010",
            "1-15, 24-28, 35, section 4.2, corrected",
            _foot(LI_WANG, OFFSETS, _ZH, attitude={"propagation": "madgwick"}),
        ),
        Method(
            "15mzha",
            "15mzh with a stance threshold that follows the speed: slow, walking, running. Not for curves.",
            "Li & Wang 2019, Jiménez et al. 2010",
            "1-15, 24-28, 35, 36, section 4.2, corrected",
            _foot(LI_WANG, OFFSETS, _ZH, attitude={"propagation": "madgwick"}, stance={"threshold": None, "rule": "adaptive"}),
        ),
        _hand(
            "hand",
            "The default for a hand: steps, their length by frequency and bounce, and headings of the filter hand: gravity also in motion, "
            "and the magnetic field where it looks like the Earth's, or stays in a rest.",
            "bematist",
            "MAGYQ 17-36, 47; gravity and heading in motion",
            "HAND",
            pendulum=0.5,
        ),
        _hand(
            "gyint",
            "The same steps, length by frequency alone, and MAGYQ's baseline for the heading: the gyroscope less its offset at rest.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-19, 47, section 8.2.1",
            "GYINT",
            heading_time_s=math.inf,
        ),
        _hand(
            "quest",
            "As gyint with the other baseline: attitude replaced wherever gravity or the Earth's field is detected by its norm.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-19, 33-34, 47, section 8.2.1",
            "QUEST",
        ),
        _hand(
            "magyq",
            "As gyint with MAGYQ's filter: any static field, the Earth's or not, holds the heading. For fields that are really constant.",
            "Renaudin & Combettes 2014 (MAGYQ)",
            "17-47, corrected",
            "MAGYQ",
        ),
    )
}


def worn(place: str) -> dict[str, Method]:
    """The methods for a sensor that is worn there: shoe or hand."""
    return {name: m for name, m in METHODS.items() if m.worn == place}


def find_method(name: str) -> Method:
    """The method of that name; UsageError names the nearest ones."""
    return look_up("method", name, METHODS)


def track(
    recording: Recording,
    method: str = "foot",
    *,
    config: Mapping[str, Any] | None = None,
    earth: Earth | Literal["recording"] | None = "recording",
    chunk: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    **overrides: Any,
) -> Trajectory:
    """The path of a recording by a named method.

    config and overrides change parameters of the method, nested: `track(r, "zupt", stance={"threshold": 200})`,
    `track(r, "hand", step_length={"height": 1.7})`; a threshold makes the stance rule
    absolute unless a rule is given with it. chunk feeds that many
    samples at a time (the result is the same to the bit). progress is called with samples done and of all.
    earth (`earth_at(latitude, longitude, height, date)`) sets gravity, magnetic field and the Earth's rotation, unless config or overrides
    do; by default it is that of the satellite fix that came with the recording, if one did; None: none.

    Raises
    ------
    UsageError
        The method or a parameter is unknown.
    DataError
        The recording cannot be processed.
    """
    if not isinstance(recording, Recording):
        raise UsageError(f"track takes a Recording, not {type(recording).__name__}: read the file first, track(read(path)).")
    m = find_method(method)
    parameters = on_earth(m.parameters, recording, earth).override(with_rule(config or {})).override(with_rule(overrides))
    return m.make(parameters, method=m.name).run(recording, chunk=chunk, progress=progress)  # pyright: ignore[reportArgumentType]
