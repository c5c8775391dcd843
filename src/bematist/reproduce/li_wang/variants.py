"""What is compared: the paper's methods, yardsticks, and pairs that differ in one choice only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bematist.stance import DEFAULTS

_OFFSET_KEPT = {"initial": {"average": False}}
_NO_Z = {"zaru": {"use": "off"}}
_NO_H = {"hdr": {"use": "off"}}
_ADAPTIVE = {"stance": {"rule": "adaptive", "threshold": None}}
_PRINTED = {"zaru": {"use": "stance", "sd": 0.1, "correlation_s": 0.0}, "hdr": {"use": "sample", "sd": 0.1}}

GYRO = DEFAULTS["gyro"]
_WIDE = {"stance": {"threshold": GYRO.running}}

PAPER: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    name: (name, {}) for name in ("common-9", "mahony-9", "madgwick-9", "15m", "15zh", "15mzh", "15mzha")
}
"""The paper's methods by their names: method and changes."""

YARDSTICKS: Mapping[str, tuple[str, Mapping[str, Any]]] = {name: (name, {}) for name in ("zupt", "foot")}
"""What bematist offers besides."""

APART: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "common-9 raw": ("common-9", _OFFSET_KEPT),
    "mahony-9 raw": ("mahony-9", _OFFSET_KEPT),
    "madgwick-9 raw": ("madgwick-9", _OFFSET_KEPT),
    "15": ("15zh", {**_NO_Z, **_NO_H}),
    "15z": ("15zh", _NO_H),
    "15h": ("15zh", _NO_Z),
    "15zha": ("15zh", _ADAPTIVE),
    "15mz": ("15mzh", _NO_H),
    "15mh": ("15mzh", _NO_Z),
    "15zh literal": ("15zh", _PRINTED),
    "15mzh literal": ("15mzh", _PRINTED),
    "15zh wide": ("15zh", _WIDE),
    "15mzh wide": ("15mzh", _WIDE),
}
"""Methods that differ from one of the paper's in one choice."""

VARIANTS = {**PAPER, **YARDSTICKS, **APART}

MEANING = {
    "common-9, mahony-9, madgwick-9": "nine states; attitude by the gyroscope alone, by Mahony, by Madgwick",
    "… raw": "the same without eqs 5-6: the gyroscope's offset is not taken from the rest at the start",
    "15, 15m": "fifteen states; attitude by the gyroscope alone, by Madgwick",
    "15z, 15h, 15zh, 15mz, 15mh, 15mzh": "with ZARU at rest (σ 0.01 rad/s), with HDR once a stance (σ 1°), with both",
    "… literal": "ZARU and HDR at every sample of a stance with σ 0.1 rad/s and 0.1 rad, as reference 23 (Jiménez et al. 2010) is said to",
    "15zha, 15mzha": f"with the thresholds of eq 36: {GYRO.slow}, {GYRO.threshold} and {GYRO.running} rad/s for slow, walking and running",
    "… wide": f"with the one threshold of {GYRO.running} rad/s",
    "zupt, foot": "bematist's own, as yardsticks",
}
"""What the names mean, for the report."""


@dataclass(frozen=True)
class Pair:
    """Two variants that differ in one choice: `changed` has it, `base` has not."""

    what: str
    changed: str
    base: str


PAIRS = (
    Pair("Mahony for Common, 9 states", "mahony-9", "common-9"),
    Pair("Madgwick for Common, 9 states", "madgwick-9", "common-9"),
    Pair("Madgwick for Mahony, 9 states", "madgwick-9", "mahony-9"),
    Pair("offset taken out, Common", "common-9", "common-9 raw"),
    Pair("offset taken out, Mahony", "mahony-9", "mahony-9 raw"),
    Pair("offset taken out, Madgwick", "madgwick-9", "madgwick-9 raw"),
    Pair("Madgwick raw for Common raw", "madgwick-9 raw", "common-9 raw"),
    Pair("Madgwick raw for Common", "madgwick-9 raw", "common-9"),
    Pair("15 for 9 states, Common", "15", "common-9"),
    Pair("15 for 9 states, Madgwick", "15m", "madgwick-9"),
    Pair("Madgwick for Common, 15 states", "15m", "15"),
    Pair("Madgwick for Common, 15 states with ZARU and HDR", "15mzh", "15zh"),
    Pair("ZARU, Common", "15z", "15"),
    Pair("HDR, Common", "15h", "15"),
    Pair("ZARU and HDR, Common", "15zh", "15"),
    Pair("ZARU, Madgwick", "15mz", "15m"),
    Pair("HDR, Madgwick", "15mh", "15m"),
    Pair("ZARU and HDR, Madgwick", "15mzh", "15m"),
    Pair("literal ZARU and HDR, Common", "15zh literal", "15"),
    Pair("literal ZARU and HDR, Madgwick", "15mzh literal", "15m"),
    Pair("adaptive threshold, Common", "15zha", "15zh"),
    Pair("adaptive threshold, Madgwick", "15mzha", "15mzh"),
    Pair("wide threshold, Common", "15zh wide", "15zh"),
    Pair("wide threshold, Madgwick", "15mzh wide", "15mzh"),
)
