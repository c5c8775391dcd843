"""The command line: `bematist COMMAND`. Commands read, call the rooms, and show; nothing is computed here."""

from bematist.cli import files, judge, look, navigate
from bematist.cli.app import app, main

__all__ = ["app", "files", "judge", "look", "main", "navigate"]
