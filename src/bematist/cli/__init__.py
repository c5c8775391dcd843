"""The command line: `bematist COMMAND`. Commands read, call the rooms, and show; nothing is computed here."""

from bematist.cli.app import app, load, main

__all__ = ["app", "load", "main"]
