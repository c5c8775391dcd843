"""The application: exit status, errors as one paragraph, interrupts."""

from __future__ import annotations

import errno
import gc
import importlib
import io
import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from bematist import __version__
from bematist.cli.console import complain
from bematist.errors import BematistError

_UsageProblem: Any = typer.BadParameter.__mro__[2]  # click's ClickException, in whichever package typer keeps it

COMMANDS = {
    "demo": "files",
    "track": "track",
    "compare": "compare",
    "attitude": "attitude",
    "evaluate": "evaluate",
    "info": "look",
    "stance": "look",
    "steps": "steps",
    "sync": "sync",
    "allan": "allan",
    "calibrate": "calibrate",
    "earth": "earth",
    "step-length": "step_length",
    "methods": "look",
    "convert": "files",
    "export": "files",
    "simulate": "simulate",
    "reproduce": "reproduce",
}
"""The commands in the order of the help, and the module of each."""


class Guarded(TyperGroup):
    """A group of commands that ends in 0, 1 (data), 2 (usage) or 130 (interrupted), and never in a traceback."""

    def main(self, args: Sequence[str] | None = None, *rest: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        if not standalone_mode:
            return super().main(args, *rest, standalone_mode=False, **extra)
        sys.exit(self.status(args, **extra))

    def status(self, args: Sequence[str] | None = None, **extra: Any) -> int:
        """Run the command line and return its exit status."""
        try:
            result = super().main(args, standalone_mode=False, **{"prog_name": "bematist", **extra})
        except _UsageProblem as problem:
            problem.show()
            return problem.exit_code
        except typer.Abort:
            return 130
        return result if isinstance(result, int) else 0

    def list_commands(self, ctx: Any) -> list[str]:
        return [name for name in COMMANDS if name in self.commands]

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except BematistError as error:
            complain(str(error))
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            complain("interrupted; no result was written.")
            raise typer.Exit(130) from None
        except MemoryError:
            complain("there is not enough memory for this recording. Cut it into parts, or close other programs.")
            raise typer.Exit(1) from None
        except OSError as error:
            _os_error(error)
        except (typer.Exit, typer.Abort, _UsageProblem):
            raise
        except Exception as error:
            _unexpected(error)
        except BaseException as error:
            if type(error).__name__ == "PanicException":  # of a library in Rust, such as polars
                _unexpected(error)
            raise


def _os_error(error: OSError) -> NoReturn:
    if error.errno == errno.EPIPE:
        # The reader of our output has gone (`bematist methods | head -1`): that is its good right.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(0) from None
    where = f"{error.filename}: " if error.filename else ""
    complain(f"{where}{error.strerror or error}. Check the name, the permissions and the space on the disk.")
    raise typer.Exit(1) from None


def _unexpected(error: BaseException) -> NoReturn:
    if os.environ.get("BEMATIST_DEBUG"):
        raise error
    text = " ".join(str(error).split())[:300]
    complain(
        f"an unexpected {type(error).__name__} ({text}). This is a fault of bematist {__version__}: please report it with the "
        "command you gave and, if you can, the recording; with BEMATIST_DEBUG=1 in the environment it shows where it happened."
    )
    raise typer.Exit(1) from None


app = typer.Typer(
    cls=Guarded,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help and usage errors: half the time, and nothing in boxes
    context_settings={"help_option_names": ["--help", "-h"], "max_content_width": 110},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"bematist {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")] = False,
) -> None:
    """From a recording of a body-worn inertial sensor to the path its wearer walked, and how sure it is.

    Try "bematist demo", or "bematist track recording.csv".
    """


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line (`sys.argv` without `args`) and return its exit status."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without "µ" is no reason to fail
    _settle()
    load(sys.argv[1:2] if args is None else args[:1])
    command = typer.main.get_group(app)
    assert isinstance(command, Guarded)
    with _ended_by_sigterm(), _numerical_noise_held():
        status = command.status(args)
    gc.freeze()  # or the interpreter, on its way out, looks for cycles in all that was imported: half a second
    return status


def load(names: Sequence[str] = ()) -> None:
    """Import the modules of these commands, or of all where none is among them: each registers its commands, which takes a while."""
    for module in {COMMANDS[name] for name in names if name in COMMANDS} or set(COMMANDS.values()):
        importlib.import_module(f"bematist.cli.{module}")


def _settle() -> None:
    """What a short process is better off with; set before numpy is imported."""
    # No matrix here is large, and the idle workers of a BLAS spin.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Looking for plugins of pydantic means to read the metadata of every installed package.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # A look for cyclic garbage after every few hundred new objects takes a tenth of the time of the imports.
    gc.set_threshold(100_000)


@contextmanager
def _ended_by_sigterm() -> Iterator[None]:
    """SIGTERM ends the command like Ctrl-C, so that no temporary file is left."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    old = signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, old)


@contextmanager
def _numerical_noise_held() -> Iterator[None]:
    """Lines such as "RuntimeWarning: overflow" are for developers; what a user must know is said in words."""
    show = warnings.showwarning
    if not os.environ.get("BEMATIST_DEBUG"):
        warnings.showwarning = lambda *_, **__: None
    try:
        yield
    finally:
        warnings.showwarning = show
