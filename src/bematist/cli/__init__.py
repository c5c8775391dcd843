"""The command line: `bematist COMMAND`. Commands read, call the rooms, and show; nothing is computed here."""

from bematist.cli import (
    allan,
    attitude,
    calibrate,
    compare,
    earth,
    evaluate,
    files,
    look,
    reproduce,
    simulate,
    step_length,
    steps,
    sync,
    track,
)
from bematist.cli.app import app, main

__all__ = [
    "allan",
    "app",
    "attitude",
    "calibrate",
    "compare",
    "earth",
    "evaluate",
    "files",
    "look",
    "main",
    "reproduce",
    "simulate",
    "step_length",
    "steps",
    "sync",
    "track",
]
